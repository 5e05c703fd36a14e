# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks the left and the right picture of a stereo endoscope, in one pipeline: see --help.

    LEFT  ! queue ! csdtrack ! tee ─ queue ! csdtrackenc ! OUT/left.jsonl
                               tee ─ queue ! videoconvert ! compositor ┐
    RIGHT ! queue ! csdtrack ! tee ─ queue ! videoconvert ! compositor ┴ videoconvert ! DISPLAY
                               tee ─ queue ! csdtrackenc ! OUT/right.jsonl

One pipeline has one clock and one base time: the same running_time in both files is the same
moment.
"""

import argparse
import pathlib
import sys
from collections.abc import Mapping
from typing import Any

from pipelines.lib import command, sources
from pipelines.lib.caps import first_structure
from pipelines.lib.frame_times import FrameTimes

EPILOG = sources.HELP + """
LEFT and RIGHT are one SOURCE each: two cards, two cameras, two files. OUT is a folder; it gets
left.jsonl and right.jsonl, a line of JSON for each frame (docs/metadata.md). It is refused if
either file holds lines already, or if another run works there.

The running_time in both files is by one clock: pictures that were taken at the same time have the
same. Two cameras that nothing synchronises differ by less than a frame, so match lines by the
nearest running_time. The ids of left and right are unrelated.

If a live source is too fast for the machine, frames are dropped before they are tracked, on each
side separately. Files lose none.

csdtrack runs on both sides with the preset live-low-latency (docs/pipelines.md).

At the end the frames that came are compared with the lines in the files. If a frame that was
tracked has no line, one line says how many.

Exit code: 0 if both were tracked, 1 if not, or if a line is missing (one line says why; the lines
that were written before are there), 2 for wrong use.
"""

SIDES = ("left", "right")


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/stereo", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        description="Tracks points on the tissue in the left and the right picture, by one clock.")
    parser.add_argument("left", metavar="LEFT", help="where the left picture comes from")
    parser.add_argument("right", metavar="RIGHT", help="where the right picture comes from")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT", help="the folder of the tracks")
    parser.add_argument("--display", metavar="SINK",
                        help="also a window, both side by side; without =SINK autovideosink")
    command.add_tracking(parser)
    options = parser.parse_args(arguments)
    if options.left == options.right and options.left.startswith(("/dev/", "decklink")):
        parser.error(f"'{options.left}' can't be left and right at once: name two devices")
    command.check_sink(parser, "--display", options.display)
    for side in SIDES:
        command.check_new_tracks(parser, tracks_path(options, side))
    return options


def tracks_path(options: argparse.Namespace, side: str) -> pathlib.Path:
    return options.out / f"{side}.jsonl"


def main() -> None:
    options = command.parse_options(parse)
    launch = {side: sources.launch(getattr(options, side)) for side in SIDES}
    command.check_window(options.display, "--display")
    with command.locked_folders(options.out):
        for side in SIDES:
            # Again: a run that ended just now may have written them.
            command.refuse_existing_tracks(tracks_path(options, side))
        track_both(options, launch)


def track_both(options: argparse.Namespace, launch: Mapping[str, str]) -> None:
    """`launch`: the beginning of each side's pipeline."""
    from pipelines.lib import runner
    text = ""
    for side, source in launch.items():
        # async=false: neither side waits for the other to start.
        text += (f"{source} ! identity name={side}-single single-segment=true ! "
                 f"{command.FRAME_QUEUE} name={side}-in ! csdtrack name={side} ! "
                 f"tee name={side}-tee {side}-tee. ! {command.LINE_QUEUE} ! csdtrackenc ! "
                 "application/x-ndjson ! "
                 f"{command.line_sink(tracks_path(options, side), f'{side}-file')} ")
        if options.display:
            text += (f"{side}-tee. ! {command.FRAME_QUEUE} name={side}-show ! videoconvert ! "
                     f"both.sink_{SIDES.index(side)} ")
    if options.display:
        text += f"compositor name=both ! videoconvert ! {options.display}"
    run = runner.Run("stereo", text, counted=SIDES)
    times = {}
    for side in SIDES:
        source = getattr(options, side)
        times[side] = FrameTimes(
            runner.Gst, run.element(f"{side}-single").get_static_pad("src"), "stereo", source,
            lambda: run.live, rising=False)
        run.watch_lines(run.element(f"{side}-file"), tracks_path(options, side))
        runner.configure(run.element(side), options.preset,
                         {"overlay": "draw" if options.display else "none"}, options.set)

    def place_right(pad: Any, _spec: Any) -> None:
        caps = pad.get_current_caps()
        if caps:
            width = first_structure(caps).get_int("width").value
            run.element("both").get_static_pad("sink_1").set_property("xpos", width)

    if options.display:
        run.element("left").get_static_pad("src").connect("notify::caps", place_right)
    # -show is leaky, so that a side is tracked on while its picture waits for the other's.
    queues = ("in", "show") if options.display else ("in",)
    run.play(f"{options.left}, {options.right}", options.seconds, harmless=("window was closed",),
             leaky=[f"{side}-{queue}" for side in SIDES for queue in queues])
    lost = []
    for side in SIDES:
        came, tracked = times[side].frames, run.frames_of(side)
        command.print_line(f"{side}: ", sys.stdout, end="")
        runner.print_cost(run.element(side), came)
        if came != tracked and run.drained and not run.live:
            lost.append(f"{side}: {came} frames came, and {tracked} were tracked")
        lost.append(run.lost_lines(f"{side}-file", tracked))
    if any(lost):
        raise command.Failure("; ".join(filter(None, lost)))


if __name__ == "__main__":
    command.run("stereo", main)
