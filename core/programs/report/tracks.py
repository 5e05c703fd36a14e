# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads a file of tracks line by line, and writes it as quantised chunks of a few seconds.

csd-motion judges whether the file is good.
"""

import array
import itertools
import json
import math
import operator
import pathlib
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from report import script
from report.messages import ReportError
from report.motion import REMEDY

STATES = ("learning", "tracked", "occluded", "lost", "out", "ended")
STATE_NUMBERS = {name: number for number, name in enumerate(STATES)}
CLAIMS = 2  # the first two of STATES claim a position
ABSENT = 255
CHUNK_FRAMES = 250  # with 100 features 200 kB
BINS = 60  # of a feature's strip of states
CLOCKS = ("stream_time", "running_time")  # the first that doesn't go back gives the times
MAX_LINE = (8 << 20) + 2  # bytes of a line that csd-motion takes, with its end
MARGIN = 0.125  # of the picture, around it, in which positions can be
BLANKS = b" \t\r\n\0"  # a line of only these is skipped (line_text() of core/text/read_line.h)


class GoesBack(ReportError):
    """The times of a clock go back."""


class Row(NamedTuple):
    """A frame: its time (s), its number, and of each feature the id and the quantised values."""
    seconds: float
    frame: int
    ids: list[int]
    x: list[int]
    y: list[int]
    states: list[int]
    confidences: list[int]


class Feature:
    """Where a feature is in time, and in which states."""

    def __init__(self, first: int) -> None:
        self.first = self.last = first  # indices of Tracks.times
        self.counts = [0] * len(STATES)
        self.bins: dict[int, list[int]] = {}  # bin: frames by state

    def strip(self) -> str:
        """For each bin the digit of its most frequent state, or a dot without the feature."""
        return "".join(
            str(max(range(len(STATES)), key=self.bins[b].__getitem__)) if b in self.bins else "."
            for b in range(BINS))


class Tracks:
    """The content of the file.

    A few numbers of each frame and feature are kept, some megabytes for an hour; positions are only
    in the chunks.
    """

    def __init__(self, path: pathlib.Path, folder: pathlib.Path, seconds: float,
                 progress: Callable[[float], None]) -> None:
        """Reads it all. Raises ReportError, and anything for a file that csd-motion refuses.

        `folder`: of the chunks; `seconds`: the video's length; `progress`: is called with the share
        that has been read.
        """
        self.path, self._folder, self._seconds = path, folder, max(seconds, 1e-3)
        try:
            self._read(CLOCKS[0], progress)
        except GoesBack as error:
            for chunk in folder.glob("tracks-*.js"):
                chunk.unlink()
            try:
                self._read(CLOCKS[1], progress)
            except ReportError:
                raise error from None

    def _read(self, clock: str, progress: Callable[[float], None]) -> None:
        self.clock = clock
        self.width = self.height = 0
        self.algorithm, self.role = "", ""
        self.times = array.array("d")  # of each line that has one, s, ascending
        self.chunks: list[int] = []  # index of each one's first frame
        self.features: dict[int, Feature] = {}
        self.untimed = self.other_size = 0  # lines that are left out
        self.until = 0.0  # s, the last time of another size
        self._numbers = array.array("Q")  # of all frames
        self._places = array.array("q")  # of each of these its index of times; -1: it has none
        self._last = 0  # time, ns
        self._rows: list[Row] = []
        size = max(1, self.path.stat().st_size)
        read = 0
        with open(self.path, "rb") as file:
            for number, line in enumerate(iter(lambda: file.readline(MAX_LINE), b""), 1):
                read += len(line)
                if len(line) == MAX_LINE:
                    raise self._error(number, "is too long")
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
            raise ReportError(f"'{self.path}' has no line with a {clock}")

    def places(self, numbers: Iterable[int]) -> Iterator[int]:
        """The indices of times of frames by their numbers; -1: has none.

        The frames come in the file's order, and some of the file's may be missing.
        """
        at = 0
        for number in numbers:
            at = self._numbers.index(number, at) + 1
            yield self._places[at - 1]

    def _text(self, number: int, why: str) -> str:
        return f"{self.path}:{number}: {why}: {REMEDY}"

    def _error(self, number: int, why: str) -> ReportError:
        return ReportError(self._text(number, why))

    def _read_line(self, text: bytes, number: int) -> None:
        try:
            line = json.loads(text)
        except ValueError:  # csd-motion takes CSV, too
            raise self._error(number, "is no JSON") from None
        time, frame = line.get(self.clock), line.get("frame")
        if frame is None:  # a frame without metadata
            return
        self._numbers.append(frame)
        if self.width and (line["width"], line["height"]) != (self.width, self.height):
            self._places.append(-1)
            self.other_size += 1
            self.until = max(self.until, (time or 0) / 1e9)
            return
        if time is None:
            self._places.append(-1)
            self.untimed += 1
            return
        self._places.append(len(self.times))
        if not self.width:
            self.width, self.height = line["width"], line["height"]
            self.algorithm, self.role = line.get("algorithm") or "", line["role"]
            self._choose_step()
        if time < self._last:
            raise GoesBack(self._text(
                number, f"`{self.clock}` {time} after {self._last}: lines must be sorted by it"))
        self._last = time
        seconds = time / 1e9
        if not self._rows:
            self.chunks.append(len(self.times))
        self.times.append(seconds)
        features, left, top, scale = line["features"], self.left, self.top, 1 / self.step
        self._rows.append(Row(
            seconds, frame, [f["id"] for f in features],
            [round((f["x"] - left) * scale) for f in features],
            [round((f["y"] - top) * scale) for f in features],
            [STATE_NUMBERS[f["state"]] for f in features],
            [round(255 * f["confidence"]) for f in features]))
        if len(self._rows) == CHUNK_FRAMES:
            self._write_chunk()

    def _choose_step(self) -> None:
        """The smallest power of two with which positions fit 16 bits: 1/32 px at 1080p."""
        most = max(self.width, self.height)
        self.left = self.top = -math.ceil(most * MARGIN)
        self.step = 2.0**math.ceil(math.log2(most * (1 + 2 * MARGIN) / 65000))

    def _write_chunk(self) -> None:
        rows = self._rows
        ids = sorted(set().union(*(row.ids for row in rows)))
        x, y, state, confidence = self._columns(ids)
        bins = [(at, len(list(group)))
                for at, group in itertools.groupby(self._bin(row.seconds) for row in rows)]
        for column, feature in enumerate(ids):
            self._count(feature, state[column::len(ids)].tobytes(), bins)
        frames = array.array("I", (row.frame & 0xffffffff for row in rows))
        number = len(self.chunks) - 1
        content: dict[str, Any] = {
            "ids": ids, "frames": script.packed(frames), "x": script.packed(x),
            "y": script.packed(y), "state": script.packed(state),
            "confidence": script.packed(confidence)
        }
        script.write(self._folder / f"tracks-{number:05}.js", "tracks", number, content)
        self._rows = []

    def _columns(self, ids: list[int]) -> tuple["array.array[int]", ...]:
        """x, y, state and confidence: for each frame of the chunk a value of each of these ids."""
        columns = tuple(array.array(code) for code in "HHBB")
        for row in self._rows:
            for side in row.x, row.y:
                if side and (min(side) < 0 or max(side) > 65535):
                    side[:] = [min(max(value, 0), 65535) for value in side]
            values: Iterable[Iterable[int]] = (row.x, row.y, row.states, row.confidences)
            if row.ids != ids:
                by_id = dict(zip(row.ids, zip(*values)))
                values = zip(*(by_id.get(number, (0, 0, ABSENT, 0)) for number in ids))
            for column, more in zip(columns, values):
                column.fromlist(list(more))  # a tenth of the time of extend()
        return columns

    def _count(self, number: int, states: bytes, bins: list[tuple[int, int]]) -> None:
        """Counts a feature's states in this chunk.

        `states`: one byte a frame; `bins`: which bins the frames are in, and how many in a row.
        """
        absent = bytes([ABSENT])
        feature = self.features.get(number)
        if feature is None:
            first = len(states) - len(states.lstrip(absent))
            feature = self.features[number] = Feature(self.chunks[-1] + first)
        feature.last = self.chunks[-1] + len(states.rstrip(absent)) - 1
        end = 0
        for at, frames in bins:
            begin, end = end, end + frames
            counts = [states.count(state, begin, end) for state in range(len(STATES))]
            if any(counts):
                before = feature.bins.get(at, [0] * len(STATES))
                feature.counts = list(map(operator.add, feature.counts, counts))
                feature.bins[at] = list(map(operator.add, before, counts))

    def _bin(self, seconds: float) -> int:
        return min(BINS - 1, int((seconds - self.times[0]) / self._seconds * BINS))
