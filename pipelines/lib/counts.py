# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts what is in finished files, so that a run can prove what it wrote."""

import pathlib
import threading
import time
from collections.abc import Callable
from typing import Any

from pipelines.lib.failure import Failure, one_line

STALLED = 10  # seconds without a packet, after which reading a file is given up

DEMUXERS = {".mkv": "matroskademux", ".mp4": "qtdemux"}


def packets_in(Gst: Any, path: pathlib.Path,
               interrupted: Callable[[], bool] = lambda: False) -> int:
    """How many pictures a demuxer finds in this video, whatever its muxer said. 0 if it finds no
    video, or there is no file.

    Raises Failure, with the reason, if that can't be found out: the disk has an error, gives no
    packet for STALLED seconds, or takes so long that the user has `interrupted`.
    """
    pipeline, (source, demuxer, sink) = Gst.Pipeline.new(), (
        Gst.ElementFactory.make(name) for name in ("filesrc", DEMUXERS[path.suffix], "fakesink"))
    source.set_property("location", str(path))
    for element in source, demuxer, sink:
        pipeline.add(element)
    source.link(demuxer)
    sink.set_property("sync", False)
    sink.set_property("async", False)

    def on_pad(_demuxer: Any, pad: Any) -> None:
        target = sink.get_static_pad("sink")
        if pad.get_name().startswith("video") and not target.is_linked():
            pad.link(target)

    demuxer.connect("pad-added", on_pad)

    def change_to(state: Any, seconds: float = 0) -> None:
        """In a thread, as a disk that stands still holds it up for ever."""
        thread = threading.Thread(target=pipeline.set_state, args=(state,), daemon=True)
        thread.start()
        thread.join(seconds)

    def count() -> int:
        return sink.get_property("stats").get_value("rendered")

    change_to(Gst.State.PLAYING)
    ends = Gst.MessageType.EOS | Gst.MessageType.ERROR
    found, moved = 0, time.monotonic()
    try:
        while not (message := pipeline.get_bus().timed_pop_filtered(Gst.SECOND // 5, ends)):
            before, found = found, count()
            if found != before:
                moved = time.monotonic()
            if interrupted():
                raise Failure("it was interrupted")
            if time.monotonic() - moved > STALLED:
                raise Failure(f"no packet came from its disk for {STALLED} s")
        found = count()
    finally:
        change_to(Gst.State.NULL, 1)
    if message.type == Gst.MessageType.ERROR and message.src == source:
        error, _ = message.parse_error()
        if not error.matches(Gst.ResourceError.quark(), Gst.ResourceError.NOT_FOUND):
            raise Failure(one_line(error.message).rstrip("."))
    return found


def lines_in(path: pathlib.Path) -> int:
    """How many whole lines are in this file; 0 if there is none."""
    try:
        with open(path, "rb") as file:
            return sum(block.count(b"\n") for block in iter(lambda: file.read(1 << 20), b""))
    except OSError:
        return 0


def plural(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def missing_lines(path: pathlib.Path, frames: int, in_flight: int = 0) -> str:
    """In some words, if not each of so many frames has its line in this file; else "".

    `in_flight`: so many lines were on their way as the pipeline was stopped, and may be missing.
    """
    if not path.is_file():  # nobody can count what went into a pipe or a device
        return "" if path.exists() else f"'{path}' is gone"
    lines = lines_in(path)
    if frames - in_flight <= lines <= frames:
        return ""
    return f"'{path}' holds {plural(lines, 'line')} of {plural(frames, 'frame')}"
