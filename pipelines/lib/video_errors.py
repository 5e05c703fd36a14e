# SPDX-License-Identifier: LGPL-2.1-or-later
"""Messages about video files that can't be read, or not to their end."""

import pathlib
from collections.abc import Sequence
from typing import Any

import gi

from pipelines.lib.failure import NO_VIDEO, no_video, of_filesink

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402


def lacks_index(path: pathlib.Path) -> bool:
    """Whether this is an mp4 (or mov) without its moov box, as a recording that was cut off."""
    boxes: list[bytes] = []
    try:
        with open(path, "rb") as file:
            end = file.seek(0, 2)
            at = 0
            while at + 8 <= end and len(boxes) < 1000:
                file.seek(at)
                head = file.read(16)
                size, kind = int.from_bytes(head[:4], "big"), head[4:8]
                if not boxes and kind != b"ftyp":
                    return False
                boxes.append(kind)
                if size == 1 and len(head) == 16:
                    size = int.from_bytes(head[8:16], "big")
                if size < 8:  # 0: to the end of the file
                    break
                at += size
    except OSError:
        return False  # filesrc has the better message
    return bool(boxes) and b"moov" not in boxes


def no_index(video: object) -> str:
    return (f"'{video}' has no index, its recording was cut off: repair it with a tool such as "
            "untrunc, and record to .mkv or fragmented mp4")


# Of files that state their length. Of others, such as program streams, GStreamer guesses it.
STATING = ("matroskademux", "qtdemux", "avidemux", "asfdemux", "flvdemux", "oggdemux", "mxfdemux")


class StatedLength:
    """Notes whether a pipeline reads a file that states its length. Make it before that plays."""

    def __init__(self, pipeline: Gst.Pipeline) -> None:
        self.known = False
        pipeline.connect("deep-element-added", self._on_element)

    def _on_element(self, _pipeline: Gst.Bin, _bin: Gst.Bin, element: Gst.Element) -> None:
        self.known = self.known or factory_name(element) in STATING


def breaks_off(video: object, position: int, duration: int) -> str:
    """A message if the picture ends (at `position` ns) well before the file says; else ""."""
    if not position or duration - position <= max(Gst.SECOND, duration // 50):
        return ""
    return (f"'{video}' has a picture up to {position / Gst.SECOND:.1f} s only, and says that it "
            f"lasts {duration / Gst.SECOND:.1f} s: is the file complete?")


def no_frame(video: object) -> str:
    return f"'{video}' has no frame that could be decoded: is the file complete?"


def missing_decoder(video: object, decoder: str) -> str:
    return (f"'{video}' needs a {decoder} that this machine does not have: "
            "install it, or convert the video to H.264")


def factory_name(element: Any) -> str:
    """The name of an element's factory; "" for a bin or another object."""
    factory = element.get_factory() if isinstance(element, Gst.Element) else None
    return factory.get_name() if factory else ""


def explain(video: object, out: object, tracker: str, element: str, error: Any, debug: str,
            missing: Sequence[str]) -> str:
    """One line for the user, from GStreamer's error.

    `tracker`, `element`: factories, of csdtrack and of the element with the error. `missing`: the
    decoders that GStreamer missed.
    """
    reason = error.message.rstrip(".")
    if element == "filesink":
        return str(of_filesink(out, error, debug))
    if element == "filesrc":
        return f"'{video}' can't be read ({reason}): check the file and its disk"
    if element in (tracker, "csdsimsrc", "csdtrackenc"):
        return f"{element}: {error.message}"
    if element == "qtdemux" and ("moov" in debug or "incomplete" in error.message):
        return no_index(video)
    # GStreamer 1.26. With 1.22 such a file ends normally.
    if element == "decodebin" and "without buffers" in debug:
        return no_frame(video)
    if missing:
        return missing_decoder(video, missing[0])
    if "no playable streams" in error.message:
        return f"'{video}' is only a part of a stream: give the whole, or its playlist"
    if no_video(error):
        return f"'{video}' {NO_VIDEO}"
    return f"'{video}' can't be decoded ({reason}): check that it plays, or convert it to H.264"
