# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads a file of tracks line by line, and writes it as quantised chunks of a few seconds.

csd-motion has read the file before and found it good.
"""

import array
import json
import math
import pathlib
from collections.abc import Callable
from typing import Any

from report import script
from report.messages import ReportError
from report.motion import REMEDY

STATES = ("learning", "tracked", "occluded", "lost", "out", "ended")
CLAIMS = 2  # the first two of STATES claim a position
ABSENT = 255
CHUNK_FRAMES = 250  # with 100 features 200 kB
CHUNK_SECONDS = 3600  # at most: a chunk's times are µs in 32 bits
BINS = 60  # of a feature's strip of states
MARGIN = 0.125  # of the picture, around it, in which positions can be
BLANKS = b" \t\r\n\0"  # a line of only these is skipped (line_text() of core/text/read_line.h)

# Id, x, y, index of the state, confidence.
Position = tuple[int, float, float, int, float]


class Feature:
    """Where a feature is in time, and in which states."""

    def __init__(self, first: float) -> None:
        self.first = self.last = first  # stream time, s
        self.counts = [0] * len(STATES)
        self.bins: dict[int, list[int]] = {}  # bin: frames by state

    def strip(self) -> str:
        """For each bin the digit of its most frequent state, or a dot without the feature."""
        return "".join(
            str(max(range(len(STATES)), key=self.bins[b].__getitem__)) if b in self.bins else "."
            for b in range(BINS))


class Tracks:
    """The content of the file.

    Times are stream times in seconds. The page's times are less by `origin`, which the caller
    knows. A few numbers of each frame and feature are kept, some megabytes for an hour; positions
    are only in the chunks.
    """

    def __init__(self, path: pathlib.Path, folder: pathlib.Path, seconds: float,
                 progress: Callable[[float], None]) -> None:
        """Reads it all. Raises ReportError.

        `folder`: of the chunks; `seconds`: the video's length; `progress`: is called with the share
        that has been read.
        """
        self.path, self._folder, self._seconds = path, folder, max(seconds, 1e-3)
        self.width = self.height = 0
        self.algorithm, self.role = "", ""
        self.times = array.array("d")
        self.by_pts: dict[int, int] = {}  # µs: index of times
        self.chunks: list[int] = []  # index of each one's first frame
        self.features: dict[int, Feature] = {}
        self.untimed = 0
        self._last = 0  # stream time, ns
        self._rows: list[tuple[float, int, list[Position]]] = []
        size = max(1, path.stat().st_size)
        read = 0
        with open(path, "rb") as file:
            for number, line in enumerate(file, 1):
                read += len(line)
                if not line.endswith(b"\n"):
                    break  # incomplete: the recorder was killed
                line = line.removeprefix(b"\xef\xbb\xbf").rstrip(BLANKS)
                if line:
                    self._read_line(line, number)
                if number % 1000 == 0:
                    progress(read / size)
        if self._rows:
            self._write_chunk()
        if not self.times:
            raise ReportError(f"'{path}' has no line with a stream_time")

    def _error(self, number: int, why: str) -> ReportError:
        return ReportError(f"{self.path}:{number}: {why}: {REMEDY}")

    def _read_line(self, text: bytes, number: int) -> None:
        try:
            line = json.loads(text)
        except ValueError:  # csd-motion takes CSV, too
            raise self._error(number, "is no JSON") from None
        time, pts, frame = line.get("stream_time"), line.get("pts"), line.get("frame")
        if frame is None:  # a frame without metadata
            return
        if time is None:
            self.untimed += 1
            return
        if not self.width:
            self.width, self.height = line["width"], line["height"]
            self.algorithm, self.role = line.get("algorithm") or "", line["role"]
            self._choose_step()
        if time < self._last:
            raise self._error(
                number, f"`stream_time` {time} after {self._last}: lines must be sorted by it")
        self._last = time
        seconds = time / 1e9
        row = [(f["id"], f["x"], f["y"], STATES.index(f["state"]), f["confidence"])
               for f in line["features"]]
        if self._rows and seconds - self._rows[0][0] > CHUNK_SECONDS:
            self._write_chunk()
        if not self._rows:
            self.chunks.append(len(self.times))
        if pts is not None:
            self.by_pts[round(pts / 1000)] = len(self.times)
        self.times.append(seconds)
        self._rows.append((seconds, frame, row))
        self._count(seconds, row)
        if len(self._rows) == CHUNK_FRAMES:
            self._write_chunk()

    def _count(self, seconds: float, row: list[Position]) -> None:
        at = min(BINS - 1, int((seconds - self.times[0]) / self._seconds * BINS))
        for number, _, _, state, _ in row:
            feature = self.features.get(number)
            if feature is None:
                feature = self.features[number] = Feature(seconds)
            feature.last = seconds
            feature.counts[state] += 1
            if at not in feature.bins:
                feature.bins[at] = [0] * len(STATES)
            feature.bins[at][state] += 1

    def _choose_step(self) -> None:
        """The smallest power of two with which positions fit 16 bits: 1/32 px at 1080p."""
        most = max(self.width, self.height)
        self.left = self.top = -math.ceil(most * MARGIN)
        self.step = 2.0**math.ceil(math.log2(most * (1 + 2 * MARGIN) / 65000))

    def _write_chunk(self) -> None:
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
        # µs from the chunk's first frame
        times = array.array("I", (round(1e6 * (t - start)) for t, _, _ in self._rows))
        frames = array.array("I", (frame & 0xffffffff for _, frame, _ in self._rows))
        number = len(self.chunks) - 1
        content: dict[str, Any] = {
            "ids": ids, "times": script.packed(times), "frames": script.packed(frames),
            "x": script.packed(x), "y": script.packed(y), "state": script.packed(state),
            "confidence": script.packed(confidence)
        }
        script.write(self._folder / f"tracks-{number:05}.js", "tracks", number, content)
        self._rows = []
