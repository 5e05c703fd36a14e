# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts what is in finished files, so that a run can prove what it wrote."""

import pathlib
from typing import Any

STALLED = 10  # seconds without a packet, after which a file can't be read back

DEMUXERS = {".mkv": "matroskademux", ".mp4": "qtdemux"}


def packets_in(Gst: Any, path: pathlib.Path) -> int:
    """How many pictures a demuxer finds in this video, whatever its muxer said. 0 if it finds no
    video."""
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
    pipeline.set_state(Gst.State.PLAYING)
    ends = Gst.MessageType.EOS | Gst.MessageType.ERROR
    found, still = 0, 0
    while still < STALLED:
        message = pipeline.get_bus().timed_pop_filtered(Gst.SECOND, ends)
        count = sink.get_property("stats").get_value("rendered")
        found, still = count, 0 if count != found else still + 1
        if message:
            break
    pipeline.set_state(Gst.State.NULL)
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


def missing_lines(path: pathlib.Path, frames: int) -> str:
    """In some words, if not each of so many frames has its line in this file; else ""."""
    if not path.is_file():  # nobody can count what went into a pipe or a device
        return "" if path.exists() else f"'{path}' is gone"
    lines = lines_in(path)
    return "" if lines == frames else f"'{path}' holds {plural(lines, 'line')} of {frames} frames"
