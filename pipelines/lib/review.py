# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shows a recording with its recorded tracks, and tracks nothing: see --help.

    filesrc ! decodebin ! csdtrackdec location=TRACKS overlay=draw ! videoconvert ! SINK
"""

import argparse
import array
import bisect
import os
import pathlib
import re
import statistics
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pipelines.lib import command, counts

if TYPE_CHECKING:
    from pipelines.lib.runner import Run

EPILOG = """
TRACKS is what csdtrackenc, pipelines/record or pipelines/quickstart wrote as .jsonl. Without it,
the file with VIDEO's name that ends with .jsonl is used. A frame gets the line with its stream_time
(docs/elements.md). If the tracks don't fit the video's size or times, there is a warning.

Exit code: 0 if it was shown, 1 if not (one line says why), 2 for wrong use.
"""


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/review", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG, description="Shows a recording with the tracks that were made with it.")
    parser.add_argument("video", type=pathlib.Path, metavar="VIDEO",
                        help="a file that GStreamer can decode")
    parser.add_argument("tracks", type=pathlib.Path, nargs="?", metavar="TRACKS",
                        help="its tracks (VIDEO's name with .jsonl)")
    parser.add_argument("--sink", default="autovideosink", metavar="NAME",
                        help="GStreamer's element for the window (autovideosink)")
    parser.add_argument("--seconds", type=command.positive, metavar="N",
                        help="end after this time")
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")
    options = parser.parse_args(arguments)
    command.check_sink(parser, "--sink", options.sink)
    options.tracks = options.tracks or options.video.with_suffix(".jsonl")
    return options


LONGEST_LINE = 8 << 20  # bytes: csdtrackdec refuses a longer one (docs/elements.md)
UNMATCHED = 50  # frames without tracks from the start, after which there is a warning


class TimeMatch:
    """Aligns the tracks with the video in time.

    Warns once if tracks and video seem to belong to different videos.
    """

    def __init__(self, runner: ModuleType, run: "Run", tracks: pathlib.Path) -> None:
        self._runner, self._run, self._tracks = runner, run, tracks
        self._time, self._pts = first_times(tracks)
        # The frames' times as lines must have them, ns.
        self._shown: "array.array[int]" = array.array("q")
        self._shift = 0  # ns, from a frame's time to its line's
        self._matched = False
        self._begin = 0  # ns, of the video in its file
        self._warned = False
        kinds, decoder = runner.Gst.PadProbeType, run.element("csdtrack")
        decoder.get_static_pad("sink").add_probe(kinds.EVENT_DOWNSTREAM, self._on_event, decoder)
        decoder.get_static_pad("src").add_probe(kinds.BUFFER, self._on_frame)

    def _on_event(self, _pad: Any, info: Any, decoder: Any) -> Any:
        event, Gst = info.get_event(), self._runner.Gst
        if event.type != Gst.EventType.SEGMENT:
            return Gst.PadProbeReturn.OK
        # After an exception PyGObject returns 0, which drops the event. Nothing here raises: times
        # are integers of at most 63 bits.
        segment = event.parse_segment()
        self._begin = segment.start
        # The files of a recording begin at their time in the whole recording. matroskademux calls
        # that stream time 0. The recording's own lines have the time in the whole recording; lines
        # of a file that was tracked by itself have the stream time.
        shift = segment.time - segment.start
        if self._time is not None and segment.time not in (segment.start, Gst.CLOCK_TIME_NONE):
            if abs(self._time - segment.start) < abs(self._time - segment.time):
                decoder.set_property("ts-offset", shift)
                return Gst.PadProbeReturn.REMOVE
            self._shift = shift
            if self._pts is not None and abs(self._pts - segment.start) > Gst.SECOND:
                self._warn(f"they begin at {self._pts / 1e9:.2f} s, "
                           f"the video at {segment.start / 1e9:.2f} s")
        return Gst.PadProbeReturn.REMOVE

    def _on_frame(self, _pad: Any, info: Any) -> Any:
        Gst, buffer = self._runner.Gst, info.get_buffer()
        if buffer.pts != Gst.CLOCK_TIME_NONE:
            self._shown.append(buffer.pts + self._shift)
        meta = buffer.get_custom_meta("GstCsdTrackMeta") or buffer.get_custom_meta(
            "GstCsdTruthMeta")
        if meta is None:
            if not self._matched and len(self._shown) == UNMATCHED:
                # Later, so that csdtrackdec's own warning comes first.
                self._runner.GLib.idle_add(self._warn_no_match)
        elif not self._matched:
            self._matched = True
            structure = meta.get_structure()
            tracked, shown = (f"{structure.get_value(prefix + 'width')}×"
                              f"{structure.get_value(prefix + 'height')}"
                              for prefix in ("tracked-", ""))
            if tracked != shown:
                self._warn(f"they are of a picture of {tracked}, the video has {shown}")
        return Gst.PadProbeReturn.OK

    def end(self) -> None:
        """Warns if no frame had tracks, or if most tracks don't have the time of a frame.

        csdtrackdec takes the nearest line, so this counts lines: a recorder under load leaves
        frames without a line, but never a line without a frame.
        """
        if not self._matched:
            self._warn_no_match()
            return
        shown = sorted(self._shown)
        near = 0.0
        if len(shown) > 1:
            # As in csd-report. Matroska rounds to a millisecond.
            interval = statistics.median(b - a for a, b in zip(shown, shown[1:]))
            near = max(1_500_000, 0.1 * interval)
        hits = lines = 0
        for time in times(self._tracks):
            if time > shown[-1] + near:
                break
            if time >= shown[0] - near:
                at = bisect.bisect_left(shown, time - near)
                lines += 1
                hits += at < len(shown) and shown[at] <= time + near
        if 2 * hits < lines:
            self._warn(f"of {lines} lines {hits} have the time of a frame")

    def _warn_no_match(self) -> None:
        if os.path.getsize(self._tracks) == 0:
            if not self._warned:
                self._warned = True
                command.print_line(f"review: warning: '{self._tracks}' is empty", sys.stderr)
        elif not self._run.warnings:
            begin = "have no times" if self._time is None else f"begin at {self._time / 1e9:.2f} s"
            count = min(len(self._shown), UNMATCHED)
            self._warn(f"they {begin}, and none is of the first {count} frames, "
                       f"from {self._begin / 1e9:.2f} s on")

    def _warn(self, why: str) -> None:
        if not self._warned:
            self._warned = True
            command.print_line(
                f"review: warning: the tracks in '{self._tracks}' may be another video's: {why}",
                sys.stderr)


def read_lines(tracks: pathlib.Path) -> Iterator[bytes]:
    """The file's lines. A line longer than LONGEST_LINE comes in pieces."""
    with open(tracks, "rb") as file:
        yield from iter(lambda: file.readline(LONGEST_LINE), b"")


def field(line: bytes, name: bytes) -> int | None:
    """An integer of a line; None if it has none that fits 63 bits."""
    found = re.search(rb'"%s":\s*(\d{1,19})\b' % name, line)
    return int(found[1]) if found and int(found[1]) < 1 << 63 else None


def times(tracks: pathlib.Path) -> Iterator[int]:
    """The lines' stream times. Skips invalid lines, which csdtrackdec reports."""
    for line in read_lines(tracks):
        time = field(line, b"stream_time")
        if time is not None:
            yield time


def first_times(tracks: pathlib.Path) -> tuple[int | None, int | None]:
    """Stream time and PTS of the first line. If it is invalid, csdtrackdec reports it."""
    try:
        first = next(filter(lambda line: line.strip(b" \t\r\n\0"), read_lines(tracks)), b"")
    except OSError:
        return None, None
    return field(first, b"stream_time"), field(first, b"pts")


def main() -> None:
    options = command.parse_options(parse)
    for file, what in ((options.video, "the path of a video"),
                       (options.tracks, "the path of its tracks")):
        if command.is_pipe_or_device(file):
            raise command.Failure(f"'{file}' {command.NOT_A_FILE}")
        if not os.path.isfile(file):
            raise command.Failure(f"there is no file '{file}': give {what}")
    command.check_window(options.sink, "--sink")
    from pipelines.lib import runner
    run = runner.Run(
        "review", f"filesrc location={command.quoted(str(options.video))} ! decodebin ! "
        "csdtrackdec name=csdtrack overlay=draw "
        f"location={command.quoted(str(options.tracks))} ! videoconvert ! {options.sink}")
    match = TimeMatch(runner, run, options.tracks)
    run.play(options.video, options.seconds, harmless=("window was closed",))
    match.end()
    command.print_line(counts.plural(run.frames, "frame"), sys.stdout)


if __name__ == "__main__":
    command.run("review", main)
