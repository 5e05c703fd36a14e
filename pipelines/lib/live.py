# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shows a live picture with the tracked points in it: see --help.

    SOURCE ! queue (leaky) ! csdtrack overlay=draw navigation=true ! tee
      tee ─ queue ! videoconvert ! SINK
      tee ─ queue ! csdtrackenc ! TRACKS

On a machine that is too slow, the first queue drops old frames of a live source: a window must not
lag behind the operation. A recorder must not drop any: that is pipelines/record. A file waits for
the window.
"""

import argparse
import pathlib

from pipelines.lib import command, sources

EPILOG = sources.HELP + """
In the window a click adds a point, a click with the right button removes the nearest, the key r
begins anew. Close the window or press Ctrl-C to end. csdtrack runs with the preset
live-low-latency (docs/pipelines.md), overlay=draw and navigation=true.

Exit code: 0 if a picture was shown and each tracked frame has its line in FILE, 1 if not (one
line says why), 2 for wrong use.
"""


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/live", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
        description="Shows a live picture, with points on the tissue tracked in it.")
    parser.add_argument("source", nargs="?", default="simulate", metavar="SOURCE",
                        help="where the picture comes from (simulate)")
    parser.add_argument("--sink", default="autovideosink", metavar="NAME",
                        help="GStreamer's element for the window (autovideosink)")
    parser.add_argument("--tracks", type=pathlib.Path, metavar="FILE",
                        help="also write the tracks, a line of JSON a frame; "
                        "a file that holds tracks already is refused")
    command.add_tracking(parser)
    options = parser.parse_args(arguments)
    if options.tracks:
        command.check_new_tracks(parser, options.tracks)
    command.check_sink(parser, "--sink", options.sink)
    return options


def main() -> None:
    options = command.parse_options(parse)
    command.check_window(options.sink, "--sink")
    from pipelines.lib import runner
    text = (f"{sources.launch(options.source)} ! {command.FRAME_QUEUE} name=in ! "
            "csdtrack name=csdtrack ! tee name=t "
            "t. ! queue max-size-buffers=2 max-size-bytes=0 max-size-time=0 ! "
            f"videoconvert ! {options.sink} name=sink")
    if options.tracks:
        text += (f" t. ! {command.LINE_QUEUE} leaky=downstream ! csdtrackenc ! "
                 f"{command.line_sink(options.tracks)}")
    run = runner.Run("live", text)
    track = run.element("csdtrack")
    runner.configure(track, options.preset, {"overlay": "draw", "navigation": "true"}, options.set)
    if options.tracks:
        run.watch_lines(run.element("file"), options.tracks)
    run.play(options.source, options.seconds, harmless=("window was closed",), leaky=("in",))
    runner.print_cost(track)
    if options.tracks and (lost := run.lost_lines("file", run.frames)):
        raise command.Failure(lost)


if __name__ == "__main__":
    command.run("live", main)
