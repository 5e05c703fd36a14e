# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads a file of tracks line by line and leaves it as chunks of a few seconds, quantised."""

import array
import json
import math

import script
from failure import Failure

STATES = ("learning", "tracked", "occluded", "lost", "out", "ended")
CLAIMS = 2  # the first two of STATES claim a position
ABSENT = 255
FRAMES = 250  # a chunk; with 100 features 200 kB
SECONDS = 3600  # and no longer: its times are µs in 32 bits
BINS = 60  # of a feature's strip of states
MARGIN = 0.125  # of the picture, around it, that positions can have
# What csd-motion's parser takes, too (core/text/read_line.h).
MOST_LINE_BYTES = 8 << 20
MOST_PIXELS = 1 << 20
MOST_ID = (1 << 32) - 2


def whole(value, least=0, most=(1 << 63) - 1):
    """The value, if it is such a number. Raises ValueError."""
    if type(value) is not int or not least <= value <= most:  # a bool is an int
        raise ValueError(f"no whole number from {least} to {most}")
    return value


class Feature:
    def __init__(self):
        self.first = self.last = None  # stream time, s
        self.counts = [0] * len(STATES)
        self.bins = {}  # bin: frames by state

    def strip(self):
        """A digit for the state that a bin was in most, a dot where the feature wasn't."""
        return "".join(str(max(range(len(STATES)), key=self.bins[b].__getitem__)) if b in self.bins else "." for b in range(BINS))


class Tracks:
    """What there is in the file. Times are stream times in seconds; those of the page are less `origin`, which the caller knows.

    Scalars of each frame and a few of each feature are kept, so an hour is some megabytes; positions are in the chunks alone.
    """

    def __init__(self, path, folder, seconds, progress):
        """folder: of the chunks; seconds: how long the video is; progress(share). Raises Failure."""
        self.path, self._folder, self._seconds = path, folder, max(seconds, 1e-3)
        self.width = self.height = 0
        self.algorithm, self.role = "", ""
        self.times = array.array("d")
        self.by_pts = {}  # µs: index of times
        self.chunks = []  # index of each one's first frame
        self.features = {}
        self.untimed = 0
        self._rows = []
        size = max(1, path.stat().st_size)
        read = 0
        with open(path, "rb") as file:
            for number, line in enumerate(iter(lambda: file.readline(MOST_LINE_BYTES + 1), b""), 1):
                read += len(line)
                if len(line.removesuffix(b"\n")) > MOST_LINE_BYTES:
                    raise self._refuse(number, "this is longer than 8 MiB")
                if not line.endswith(b"\n"):
                    break  # torn: the recorder was killed
                self._line(line, number)
                if number % 1000 == 0:
                    progress(read / size)
        if self._rows:
            self._write()
        if not self.times:
            raise Failure(f"'{path}' has no line with a stream_time" if self.untimed else f"'{path}' is empty: give the tracks of the video")

    def _refuse(self, number, why):
        return Failure(f"{self.path}:{number}: {why}: give what csdtrackenc wrote as .jsonl")

    def _line(self, line, number):
        try:
            told = json.loads(line)
        except (ValueError, RecursionError):  # or brackets nested without end
            raise self._refuse(number, "this is no JSON") from None
        try:
            if told["schema"] != 1:
                raise self._refuse(number, f"schema {told['schema']!r}, and 1 is known")
            time, pts, frame = told["stream_time"], told["pts"], told["frame"]
            if frame is None:  # a frame without metadata: nothing is known
                return
            whole(frame)
            if pts is not None:
                whole(pts)
            if time is None:
                self.untimed += 1
                return
            if not self.width:
                self.width, self.height = whole(told["width"], 1, MOST_PIXELS), whole(told["height"], 1, MOST_PIXELS)
                self.algorithm, self.role = str(told["algorithm"]), str(told["role"])
                self._quantise()
            elif (told["width"], told["height"]) != (self.width, self.height):
                raise self._refuse(number, f"the picture's size changes from {self.width}×{self.height} to {told['width']}×{told['height']}")
            seconds = whole(time) / 1e9
            if self.times and not seconds > self.times[-1]:
                raise self._refuse(number, "the time doesn't go on; was the stream seeked?")
            row = [(whole(f["id"], most=MOST_ID), float(f["x"]), float(f["y"]), STATES.index(f["state"]), float(f["confidence"])) for f in told["features"]]
            if not all(abs(x) <= MOST_PIXELS and abs(y) <= MOST_PIXELS and 0 <= c <= 1 for _, x, y, _, c in row):
                raise self._refuse(number, "a number that can't be")
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError, IndexError) as error:
            raise self._refuse(number, f"this is no line of tracks ({type(error).__name__} {error})") from None
        if self._rows and seconds - self._rows[0][0] > SECONDS:
            self._write()
        if not self._rows:
            self.chunks.append(len(self.times))
        if pts is not None:
            self.by_pts[round(pts / 1000)] = len(self.times)
        self.times.append(seconds)
        self._rows.append((seconds, frame, row))
        self._remember(seconds, row)
        if len(self._rows) == FRAMES:
            self._write()

    def _remember(self, seconds, row):
        at = min(BINS - 1, int((seconds - self.times[0]) / self._seconds * BINS))
        for number, _, _, state, _ in row:
            feature = self.features.get(number)
            if feature is None:
                feature = self.features[number] = Feature()
                feature.first = seconds
            feature.last = seconds
            feature.counts[state] += 1
            if at not in feature.bins:
                feature.bins[at] = [0] * len(STATES)
            feature.bins[at][state] += 1

    def _quantise(self):
        """Steps of a power of two that 16 bits are enough for; 1/32 px at 1080p."""
        most = max(self.width, self.height)
        self.left = self.top = -math.ceil(most * MARGIN)
        self.step = 2.0 ** math.ceil(math.log2(most * (1 + 2 * MARGIN) / 65000))

    def _write(self):
        ids = sorted({number for _, _, row in self._rows for number, *_ in row})
        column = {number: i for i, number in enumerate(ids)}
        cells = len(ids) * len(self._rows)
        x, y = array.array("H", bytes(2 * cells)), array.array("H", bytes(2 * cells))
        state, confidence = array.array("B", [ABSENT]) * cells, array.array("B", bytes(cells))
        start = self._rows[0][0]
        for i, (_, _, row) in enumerate(self._rows):
            for number, px, py, s, c in row:
                cell = i * len(ids) + column[number]
                x[cell] = min(max(round((px - self.left) / self.step), 0), 65535)
                y[cell] = min(max(round((py - self.top) / self.step), 0), 65535)
                state[cell], confidence[cell] = s, round(255 * c)
        number = len(self.chunks) - 1
        script.write(self._folder / f"tracks-{number:05}.js", "tracks", number, {
            "ids": ids,
            # µs from the chunk's first frame
            "times": script.packed(array.array("I", (round(1e6 * (t - start)) for t, _, _ in self._rows))),
            "frames": script.packed(array.array("I", (f & 0xffffffff for _, f, _ in self._rows))),
            "x": script.packed(x), "y": script.packed(y), "state": script.packed(state), "confidence": script.packed(confidence)})
        self._rows = []
