# SPDX-License-Identifier: LGPL-2.1-or-later
"""Proves a recording: counts what came, what the muxer got, and what is in the files."""

import pathlib
import queue
import signal
import threading
from collections.abc import Iterator
from typing import Any

from pipelines.lib import counts, supervisor
from pipelines.lib.failure import Failure
from pipelines.lib.sidecar import Sidecar, tracks_name


class Recorded:
    """Counts the packets of a splitmuxsink's files, on their way and then in each finished file.

    A muxer may drop a packet and say nothing, and a disk may, so files are read back. A thread does
    this, as each file takes some seconds and the recording goes on meanwhile.
    """

    def __init__(self, Gst: Any, files: Any) -> None:
        """`files`: the splitmuxsink."""
        self._gst = Gst
        self.muxed: dict[pathlib.Path, int] = {}  # packets that the muxer got for each file
        self.packets: dict[pathlib.Path, int] = {}  # that are in each file that could be read back
        self.unread: dict[pathlib.Path, str] = {}  # in some words, of each other file
        self._interrupted = threading.Event()
        self._newest: pathlib.Path | None = None
        self._finished: queue.Queue[pathlib.Path | None] = queue.Queue()
        self._thread = threading.Thread(target=self._read_back, daemon=True)
        self._thread.start()
        kinds = Gst.PadProbeType.BUFFER | Gst.PadProbeType.BUFFER_LIST
        files.iterate_all_by_element_factory_name("matroskamux").foreach(
            lambda muxer: [pad.add_probe(kinds, self._on_packet) for pad in muxer.sinkpads])

    def _on_packet(self, _pad: Any, info: Any) -> Any:
        if self._newest:
            several = info.type & self._gst.PadProbeType.BUFFER_LIST
            self.muxed[self._newest] += info.get_buffer_list().length() if several else 1
        return self._gst.PadProbeReturn.OK

    def begin_file(self, name: str) -> None:
        self._newest = pathlib.Path(name)
        self.muxed.setdefault(self._newest, 0)

    def end_file(self, name: str) -> None:
        self._finished.put(pathlib.Path(name))

    def _read_back(self) -> None:
        while path := self._finished.get():
            self._read(path)
        for path in self.muxed:
            if path not in self.packets and path not in self.unread:
                self._read(path)

    def _read(self, path: pathlib.Path) -> None:
        try:
            self.packets[path] = counts.packets_in(self._gst, path, self._interrupted.is_set)
        except Failure as failure:
            self.unread[path] = f"'{path}' could not be read back: {failure}"

    def end(self) -> None:
        """Reads the files back that were not finished before. A signal interrupts that."""
        self._finished.put(None)
        before = {number: signal.signal(number, lambda *_: self._interrupted.set())
                  for number in (signal.SIGINT, signal.SIGTERM)}
        supervisor.wait_for(self._thread)
        for number, handler in before.items():
            signal.signal(number, handler)

    def differences(self, frames: int, sidecar: Sidecar, tracks: pathlib.Path,
                    all_tracked: bool) -> Iterator[str]:
        """What is not as it should be, each in some words. Call it after end().

        `frames`: how many came. `tracks`: the folder of the lines. `all_tracked`: each frame must
        have a line, as the source waits for the tracker.
        """
        muxed = sum(self.muxed.values())
        if muxed != frames:
            yield f"{frames} frames came, and {muxed} left the encoder"
        for path, expected in self.muxed.items():
            if path in self.unread:
                yield self.unread[path]
            elif self.packets[path] != expected:
                yield (f"'{path}' holds {self.packets[path]} of the {expected} packets that its "
                       "muxer got")
        if sidecar.failed:
            yield f"{sum(sidecar.lines.values())} of {frames} frames have a line"
            return
        for path in self.muxed:
            text = tracks / tracks_name(str(path))
            lines = sidecar.lines[text.name]
            packets = self.packets.get(path, lines)  # an unread one proves nothing
            special = text.exists() and not text.is_file()  # nobody can count what went into a pipe
            there = lines if special else counts.lines_in(text)
            if there != lines:
                yield f"'{text}' holds {there} of the {lines} lines that were written"
            elif lines > packets or all_tracked and lines < packets:
                yield (f"'{text}' holds {counts.plural(lines, 'line')}, and '{path}' "
                       f"{counts.plural(packets, 'packet')}")

    def summary(self, frames: int, sidecar: Sidecar) -> str:
        """How much there is after an error; "" if it is all."""
        if self.unread:
            return "; ".join(self.unread.values())
        packets, lines = sum(self.packets.values()), sum(sidecar.lines.values())
        if packets == frames == lines:
            return ""
        beside = counts.plural(lines, "line")
        return f"{packets} of {frames} frames are in the files, {beside} beside"
