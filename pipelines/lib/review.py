# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shows a recording with its recorded tracks; nothing is tracked: see --help.

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

from pipelines.lib import command

EPILOG = """
TRACKS is what csdtrackenc, pipelines/record or pipelines/quickstart wrote as .jsonl; without it, the file of VIDEO's name that ends with
.jsonl. A frame has the line whose stream_time is its own (docs/elements.md). Tracks that don't fit the video's size or times are warned of.

Exit code: 0 if it was shown, 1 if not (one line says why), 2 for wrong use.
"""


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/review", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG, description="Shows a recording with the tracks that were made with it.")
    parser.add_argument("video", type=pathlib.Path, metavar="VIDEO",
                        help="a file that GStreamer can decode")
    parser.add_argument("tracks", type=pathlib.Path, nargs="?", metavar="TRACKS",
                        help="its tracks (VIDEO's name with .jsonl)")
    parser.add_argument("--sink", default="autovideosink", metavar="NAME",
                        help="GStreamer's element for the window (autovideosink)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")
    options = parser.parse_args(arguments)
    if not re.fullmatch(r"[a-z0-9]+", options.sink):
        parser.error(f"--sink: '{options.sink}' is no name of an element")
    options.tracks = options.tracks or options.video.with_suffix(".jsonl")
    return options


LONGEST = 8 << 20  # bytes, of a line: csdtrackdec refuses a longer one (docs/elements.md)
FEW = 50  # frames without tracks, after which it is said


class Fit:
    """Brings tracks and video together in time, and says once, in a line, that they seem to be of different videos."""

    def __init__(self, runner, run, tracks):
        self._runner, self._run, self._tracks = runner, run, tracks
        self._time, self._pts = begin_of(tracks)
        self._shown = array.array("q")  # ns: which time a line must have to be a frame's
        self._shift = 0  # ns, from a line's time to a frame's
        self._matched = False
        self._begin = 0  # ns, of the video in its file
        self._said = False
        kinds, dec = runner.Gst.PadProbeType, run.element("csdtrack")
        dec.get_static_pad("sink").add_probe(kinds.EVENT_DOWNSTREAM, self._event, dec)
        dec.get_static_pad("src").add_probe(kinds.BUFFER, self._frame)

    def _event(self, _pad, info, dec):
        event, Gst = info.get_event(), self._runner.Gst
        if event.type != Gst.EventType.SEGMENT:
            return Gst.PadProbeReturn.OK
        # After an exception PyGObject returns 0, which drops the event. Nothing here raises: times
        # are whole and fit 63 bits.
        segment = event.parse_segment()
        self._begin = segment.start
        # Files of a recording begin at their time in the whole, which matroskademux calls stream
        # time 0. Their lines keep that of the whole; those of a file that was tracked by itself
        # have the stream time.
        shift = segment.time - segment.start
        if self._time is not None and segment.time not in (segment.start, Gst.CLOCK_TIME_NONE):
            if abs(self._time - segment.start) < abs(self._time - segment.time):
                dec.set_property("ts-offset", shift)
                return Gst.PadProbeReturn.REMOVE
            self._shift = shift
            if self._pts is not None and abs(self._pts - segment.start) > Gst.SECOND:
                self._say(
                    f"they begin at {self._pts / 1e9:.2f} s, the video at {segment.start / 1e9:.2f} s"
                )
        return Gst.PadProbeReturn.REMOVE

    def _frame(self, _pad, info):
        Gst, buffer = self._runner.Gst, info.get_buffer()
        if buffer.pts != Gst.CLOCK_TIME_NONE:
            self._shown.append(buffer.pts + self._shift)
        meta = buffer.get_custom_meta("GstCsdTrackMeta") or buffer.get_custom_meta(
            "GstCsdTruthMeta")
        if meta is None:
            if not self._matched and len(self._shown) == FEW:
                self._runner.GLib.idle_add(self._none)  # after what csdtrackdec warns of
            return Gst.PadProbeReturn.OK
        if not self._matched:
            self._matched = True
            found = meta.get_structure()
            tracked, shown = ("×".join(
                str(found.get_value(of + side))
                for side in ("width", "height"))
                              for of in ("tracked-", ""))
            if tracked != shown:
                self._say(f"they are of a picture of {tracked}, the video has {shown}")
        return Gst.PadProbeReturn.OK

    def end(self):
        """Of what was shown, no frame had tracks, or one had them that are not its own: csdtrackdec takes the nearest. A recorder under load
        leaves frames without a line, never lines without a frame: so lines are counted."""
        if not self._matched:
            self._none()
            return
        shown = sorted(self._shown)
        # As csd-report. Matroska rounds to a millisecond.
        near = max(1_500_000, 0.1 *
                   statistics.median(b - a
                                     for a, b in zip(shown, shown[1:]))) if len(shown) > 1 else 0
        hits = lines = 0
        for time in times_of(self._tracks):
            if time > shown[-1] + near:
                break
            if time >= shown[0] - near:
                at = bisect.bisect_left(shown, time - near)
                lines += 1
                hits += at < len(shown) and shown[at] <= time + near
        if 2 * hits < lines:
            self._say(f"of {lines} lines {hits} have the time of a frame")

    def _none(self):
        if os.path.getsize(self._tracks) == 0:
            if not self._said:
                self._said = True
                command.told(f"review: warning: '{self._tracks}' is empty", sys.stderr)
        elif not self._run.warnings:
            begin = "have no times" if self._time is None else f"begin at {self._time / 1e9:.2f} s"
            self._say(
                f"they {begin}, and none is of the first {min(len(self._shown), FEW)} frames, from {self._begin / 1e9:.2f} s on"
            )

    def _say(self, why):
        if not self._said:
            self._said = True
            command.told(
                f"review: warning: the tracks in '{self._tracks}' may be another video's: {why}",
                sys.stderr)


def texts_of(tracks):
    """Its lines; one that is longer than any may be comes in pieces."""
    with open(tracks, "rb") as file:
        yield from iter(lambda: file.readline(LONGEST), b"")


def time_in(text, name):
    found = re.search(rb'"%s":\s*(\d{1,19})\b' % name, text)
    return int(found[1]) if found and int(found[1]) < 1 << 63 else None


def times_of(tracks):
    """The stream times of its lines. All have been read by csdtrackdec, or will be: what is none is left out."""
    return filter(lambda time: time is not None,
                  (time_in(text, b"stream_time") for text in texts_of(tracks)))


def begin_of(tracks):
    """Stream time and PTS of the first line, None for what is no time. What is wrong with it csdtrackdec says."""
    try:
        first = next(filter(lambda text: text.strip(b" \t\r\n\0"), texts_of(tracks)), b"")
    except OSError:
        return None, None
    return time_in(first, b"stream_time"), time_in(first, b"pts")


def main():
    options = command.options(parse)
    for file, what in ((options.video, "the path of a video"), (options.tracks,
                                                                "the path of its tracks")):
        if command.is_pipe(file):
            raise command.Failure(f"'{file}' {command.PIPE}")
        if not os.path.isfile(file):
            raise command.Failure(f"there is no file '{file}': give {what}")
    command.check_window(options.sink, "--sink")
    from pipelines.lib import runner
    run = runner.Run(
        "review",
        f"filesrc location={command.quoted(str(options.video))} ! decodebin ! csdtrackdec name=csdtrack overlay=draw "
        f"location={command.quoted(str(options.tracks))} ! videoconvert ! {options.sink}")
    fit = Fit(runner, run, options.tracks)
    run.play(options.video, options.seconds, harmless=("window was closed",))
    fit.end()
    command.told(f"{run.frames} frames", sys.stdout)


if __name__ == "__main__":
    command.run("review", main)
