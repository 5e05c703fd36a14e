# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads a file of tracks that csd-motion has found good, line by line, and leaves it as chunks of a few seconds, quantised."""

import array
import json
import math

import script
from failure import Failure
from motion import REMEDY

STATES = ("learning", "tracked", "occluded", "lost", "out", "ended")
CLAIMS = 2  # the first two of STATES claim a position
ABSENT = 255
FRAMES = 250  # a chunk; with 100 features 200 kB
SECONDS = 3600  # and no longer: its times are µs in 32 bits
BINS = 60  # of a feature's strip of states
MARGIN = 0.125  # of the picture, around it, that positions can have
BLANKS = b" \t\r\n\0"  # of which a line that is none is made (line_text() of core/text/read_line.h)


class Feature:
    def __init__(self):
        self.first = self.last = None  # stream time, s
        self.counts = [0] * len(STATES)
        self.bins = {}  # bin: frames by state

    def strip(self):
        """A digit for the state that a bin was in most, a dot where the feature wasn't."""
        return "".join(
            str(max(range(len(STATES)), key=self.bins[b].__getitem__)) if b in self.bins else "."
            for b in range(BINS))


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
        self._last = 0  # stream time, ns
        self._rows = []
        size = max(1, path.stat().st_size)
        read = 0
        with open(path, "rb") as file:
            for number, line in enumerate(file, 1):
                read += len(line)
                if not line.endswith(b"\n"):
                    break  # torn: the recorder was killed
                line = line.removeprefix(b"\xef\xbb\xbf").rstrip(BLANKS)
                if line:
                    self._line(line, number)
                if number % 1000 == 0:
                    progress(read / size)
        if self._rows:
            self._write()
        if not self.times:
            raise Failure(f"'{path}' has no line with a stream_time")

    def _refuse(self, number, why):
        return Failure(f"{self.path}:{number}: {why}: {REMEDY}")

    def _line(self, line, number):
        try:
            told = json.loads(line)
        except ValueError:  # csd-motion takes CSV, too
            raise self._refuse(number, "is no JSON") from None
        time, pts, frame = told.get("stream_time"), told.get("pts"), told.get("frame")
        if frame is None:  # a frame without metadata: nothing is known
            return
        if time is None:
            self.untimed += 1
            return
        if not self.width:
            self.width, self.height = told["width"], told["height"]
            self.algorithm, self.role = told.get("algorithm") or "", told["role"]
            self._quantise()
        if time < self._last:
            raise self._refuse(
                number, f"`stream_time` {time} after {self._last}: lines must be sorted by it")
        self._last = time
        seconds = time / 1e9
        row = [(f["id"], f["x"], f["y"], STATES.index(f["state"]), f["confidence"])
               for f in told["features"]]
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
        script.write(
            self._folder / f"tracks-{number:05}.js",
            "tracks",
            number,
            {
                "ids": ids,
                # µs from the chunk's first frame
                "times": script.packed(
                    array.array("I", (round(1e6 * (t - start)) for t, _, _ in self._rows))),
                "frames": script.packed(array.array("I",
                                                    (f & 0xffffffff for _, f, _ in self._rows))),
                "x": script.packed(x),
                "y": script.packed(y),
                "state": script.packed(state),
                "confidence": script.packed(confidence)
            })
        self._rows = []
