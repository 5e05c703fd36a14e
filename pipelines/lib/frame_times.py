# SPDX-License-Identifier: LGPL-2.1-or-later
"""Gives each frame a time of its own, before anything else sees it."""

import sys
import time
from collections.abc import Callable
from typing import Any

from pipelines.lib import command
from pipelines.lib.caps import first_structure

USUAL_RATE = 25  # frames a second, of a file that says neither times nor a rate
SECOND = 10**9  # ns
JUMP = 1  # seconds back, from which on a source's times begin anew
SHORTEST = SECOND // 1000  # ns, between two frames: Matroska's times are whole milliseconds
LIVE_JUMP = 10  # seconds between a live source's times and the clock, from which on they do


class FrameTimes:
    """Counts a source's frames, and sees to it that their times rise.

    Muxers drop frames without a time, or write two of the same time in an order of their own, and
    readers can't tell which line belongs to which. So

    - a frame without a time gets one: of a live source by its arrival, else by the frame rate;
    - a frame that isn't later than the one before gets a time between that and the next;
    - times that go back by more than a second, or that leave the clock of a live source by more
      than ten, continue where the last frame ended: from there on all are moved.

    All other frames pass as they are. Call it on the source pad of `identity single-segment=true`,
    so times are running times. That pad sends no list of buffers.
    """

    def __init__(self, Gst: Any, pad: Any, name: str, source: str,
                 live: Callable[[], bool] = lambda: False, rising: bool = True) -> None:
        """`name`, `source`: for messages. `live`: whether the source is, asked for each frame.
        `rising`: False to change no time that a frame has, only to give it one."""
        self._rising = rising
        self._gst, self._name, self._source, self._live = Gst, name, source, live
        self.frames = 0
        self._last: int | None = None  # time of the newest frame, ns
        self._own: int | None = None  # the time that it came with
        self._repeated = 0  # how many frames before it had the same
        self._arrival = 0  # of the newest frame, ns
        self._moved = 0  # ns, by which times are moved
        self._said: set[str] = set()
        pad.add_probe(Gst.PadProbeType.BUFFER, self._on_frame)

    def _on_frame(self, pad: Any, info: Any) -> Any:
        Gst = self._gst
        buffer, arrival = info.get_buffer(), time.monotonic_ns()
        own = None if buffer.pts == Gst.CLOCK_TIME_NONE else buffer.pts
        due = self._due(pad, buffer, own, arrival)
        self.frames += 1
        self._last, self._arrival = due, arrival
        if due == own:
            return Gst.PadProbeReturn.OK
        # Others may hold this buffer, so its times can't be changed. The new one has its memory.
        moved, copied = Gst.Buffer.new(), Gst.BufferCopyFlags
        moved.pts = due
        # Without a duration, mp4mux leaves the last frame out of its edit list.
        moved.duration = buffer.duration if self._live() else self._period(pad, buffer)
        moved.copy_into(buffer, copied.FLAGS | copied.META | copied.MEMORY, 0, buffer.get_size())
        moved.add_parent_buffer_meta(buffer)
        pad.get_peer().chain(moved)
        return Gst.PadProbeReturn.DROP

    def _due(self, pad: Any, buffer: Any, own: int | None, arrival: int) -> int:
        last, before, waited = self._last, self._own, arrival - self._arrival
        self._own = own
        if own is None:
            if last is None:
                return self._running_time(pad) if self._live() else 0
            return last + self._step(pad, buffer, waited)
        due = own + self._moved
        if last is None or not self._rising:
            return due
        # By the source's own times: after a pause, `last` may be far from them for a while.
        step = own - before if before is not None else due - last
        jumps = step <= -JUMP * SECOND
        if self._live():
            jumps = jumps or min(abs(step), abs(step - waited)) >= LIVE_JUMP * SECOND
        if jumps:
            self._say(f"the times jump by {step / SECOND:+.1f} s: they go on from the frame before")
            after = last + self._step(pad, buffer, waited)
            self._moved += after - due
            return after
        if due <= last:
            # One that repeats a time lies between its neighbours. More are a frame apart.
            self._repeated = self._repeated + 1 if step <= 0 else 0
            part = 1 if self._repeated > 1 else 2
            return last + max(SHORTEST, self._period(pad, buffer) // part)
        self._repeated = 0
        return due

    def _step(self, pad: Any, buffer: Any, waited: int) -> int:
        return max(waited, SHORTEST) if self._live() else self._period(pad, buffer)

    def _running_time(self, pad: Any) -> int:
        now = pad.get_parent_element().get_current_running_time()
        return 0 if now == self._gst.CLOCK_TIME_NONE else now

    def _period(self, pad: Any, buffer: Any) -> int:
        """From a frame to the next, ns."""
        if buffer.duration not in (0, self._gst.CLOCK_TIME_NONE):
            return buffer.duration
        _, over, under = first_structure(pad.get_current_caps()).get_fraction("framerate")
        if over > 0:
            return SECOND * under // over
        if buffer.pts == self._gst.CLOCK_TIME_NONE:
            self._say(f"it says neither its frames' times nor their rate: {USUAL_RATE} a second "
                      "are taken")
        return SECOND // USUAL_RATE

    def _say(self, text: str) -> None:
        if text not in self._said:
            self._said.add(text)
            command.print_line(f"{self._name}: {self._source}: {text}", sys.stderr)
