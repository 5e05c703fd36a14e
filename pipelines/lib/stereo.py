# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks the left and the right picture of a stereo endoscope, in one pipeline: see --help.

    LEFT  ! queue ! csdtrack ! tee ─ queue ! csdtrackenc ! OUT/left.jsonl
                               tee ─ queue ! videoconvert ! compositor ┐
    RIGHT ! queue ! csdtrack ! tee ─ queue ! videoconvert ! compositor ┴ videoconvert ! DISPLAY
                               tee ─ queue ! csdtrackenc ! OUT/right.jsonl

One pipeline has one clock and one base time: the same running_time in both files is the same moment.
"""

import argparse
import pathlib
import re
import sys

from pipelines.lib import command, sources
from pipelines.lib.caps import first_structure

EPILOG = sources.LISTED + """
LEFT and RIGHT are one SOURCE each: two cards, two cameras, two files. OUT is a folder; it gets left.jsonl and right.jsonl, a line of JSON
for each frame of either (docs/metadata.md); one where either holds lines already, or where another run is at work, is refused. Their
running_time is by one clock: what was taken at the same time has the same, and two cameras that nothing keeps in step differ by less than a frame. So match lines by the nearest running_time. The ids of the two are unrelated.

A live source that is too fast for the machine loses frames before they are tracked, each side by itself; files lose none.

What csdtrack is told, both: the preset live-low-latency (docs/pipelines.md).

Exit code: 0 if both were tracked, 1 if not (one line says why; the lines that were written until then are there), 2 for wrong use.
"""


SIDES = ("left", "right")


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/stereo", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        description="Tracks points on the tissue in the left and the right picture, by one clock.")
    parser.add_argument("left", metavar="LEFT", help="where the left picture comes from")
    parser.add_argument("right", metavar="RIGHT", help="where the right picture comes from")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT", help="the folder of the tracks")
    parser.add_argument("--display", metavar="SINK",
                        help="also a window, both side by side; without =SINK autovideosink")
    parser.add_argument("--preset", default="live-low-latency", metavar="NAME",
                        help="of csdtrack (live-low-latency)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if options.left == options.right and options.left.startswith(("/dev/", "decklink")):
        parser.error(f"'{options.left}' can't be left and right at once: name two devices")
    if options.display and not re.fullmatch(r"[a-z0-9]+", options.display):
        parser.error(f"--display: '{options.display}' is no name of an element")
    for side in SIDES:
        command.check_unwritten(parser, file(options, side))
    return options


def file(options, side):
    return options.out / f"{side}.jsonl"


def main():
    options = command.options(parse)
    begins = {side: sources.begin(getattr(options, side)) for side in SIDES}
    command.check_window(options.display, "--display")
    with command.folders(options.out):
        for side in SIDES:
            # again: a run that ended just now may have written them
            command.refuse_written(file(options, side))
        stereo(options, begins)


def stereo(options, begins):
    from pipelines.lib import runner
    text = ""
    for side, begin in begins.items():
        # async=false: a side does not wait for the other to begin.
        text += f"{begin} ! {command.FRAMES} name={side}-in ! csdtrack name={side} ! tee name={side}-tee " \
                f"{side}-tee. ! {command.LINES} ! csdtrackenc ! application/x-ndjson ! " \
                f"{command.lines_file(file(options, side))} "
        if options.display:
            text += f"{side}-tee. ! {command.FRAMES} name={side}-show ! videoconvert ! both.sink_{'01'[side == 'right']} "
    if options.display:
        text += f"compositor name=both ! videoconvert ! {options.display}"
    run = runner.Run("stereo", text, counted=tuple(begins))
    for side in begins:
        runner.configure(run.element(side), options.preset,
                         {"overlay": "draw" if options.display else "none"}, options.set)

    def lay_out(pad, _spec):
        if pad.get_current_caps():
            run.element("both").get_static_pad("sink_1").set_property(
                "xpos",
                first_structure(pad.get_current_caps()).get_int("width").value)

    if options.display:
        run.element("left").get_static_pad("src").connect("notify::caps", lay_out)
    # -show: a side whose picture waits for the other's in the window is tracked on.
    leaky = [
        f"{side}-{queue}" for side in begins
        for queue in (["in", "show"] if options.display else ["in"])
    ]
    run.play(f"{options.left}, {options.right}", options.seconds, harmless=("window was closed", ),
             leaky=leaky)
    for side in begins:
        command.told(f"{side}: ", sys.stdout, end="")
        runner.say_cost(run.element(side))


if __name__ == "__main__":
    command.run("stereo", main)
