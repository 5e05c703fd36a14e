# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shows a live picture with the tracked points in it: see --help.

    SOURCE ! queue (leaky) ! csdtrack overlay=draw navigation=true ! tee ─ queue ! videoconvert ! SINK
                                                                     tee ─ queue ! csdtrackenc ! TRACKS

Of a live source the first queue drops old frames where the machine is too slow: a window must not lag behind the operation. A recorder
must not drop any: that is pipelines/record. A file waits for the window.
"""

import argparse
import pathlib
import re

from pipelines.lib import command, sources

EPILOG = sources.LISTED + """
In the window a click adds a point, a click with the right button removes the nearest, the key r begins anew. Close the window or press
Ctrl-C to end. What csdtrack is told: the preset live-low-latency (docs/pipelines.md), overlay=draw, navigation=true.

Exit code: 0 if a picture was shown, 1 if not (one line says why), 2 for wrong use.
"""


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/live", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
        description="Shows a live picture, with points on the tissue tracked in it.")
    parser.add_argument("source", nargs="?", default="simulate", metavar="SOURCE",
                        help="where the picture comes from (simulate)")
    parser.add_argument("--sink", default="autovideosink", metavar="NAME",
                        help="GStreamer's element for the window (autovideosink)")
    parser.add_argument(
        "--tracks", type=pathlib.Path, metavar="FILE",
        help="also write the tracks, a line of JSON a frame; one that holds some already is refused"
    )
    parser.add_argument("--preset", default="live-low-latency", metavar="NAME",
                        help="of csdtrack (live-low-latency)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if options.tracks:
        command.check_unwritten(parser, options.tracks)
    if not re.fullmatch(r"[a-z0-9]+", options.sink):
        parser.error(f"--sink: '{options.sink}' is no name of an element")
    return options


def main():
    options = command.options(parse)
    command.check_window(options.sink, "--sink")
    from pipelines.lib import runner
    begin = sources.begin(options.source)
    text = f"{begin} ! {command.FRAMES} name=in ! csdtrack name=csdtrack ! tee name=t " \
           f"t. ! queue max-size-buffers=2 max-size-bytes=0 max-size-time=0 ! videoconvert ! {options.sink} name=sink"
    if options.tracks:
        text += f" t. ! {command.LINES} leaky=downstream ! csdtrackenc ! {command.lines_file(options.tracks)}"
    run = runner.Run("live", text)
    track = run.element("csdtrack")
    runner.configure(track, options.preset, {"overlay": "draw", "navigation": "true"}, options.set)
    run.play(options.source, options.seconds, harmless=("window was closed",), leaky=("in",))
    runner.say_cost(track)


if __name__ == "__main__":
    command.run("live", main)
