# SPDX-License-Identifier: LGPL-2.1-or-later
"""The exceptions that end a command, with their exit codes and messages."""

import errno
import os
from typing import Any


def one_line(text: str) -> str:
    return " ".join(text.split())


class Failure(Exception):
    """The command can't do its work. The text is one line that says what to change."""

    code = 1  # the program's exit code


class Misuse(Failure):
    """The user gave a value, property or name that is wrong on any machine."""

    code = 2


class Full(Failure):
    """The disk or the user's quota is full, so there is no point in going on."""

    def __init__(self, place: object) -> None:
        super().__init__(
            f"can't write into '{place}' (the disk is full): make room or give another place")


def no_video(error: Any) -> bool:
    """Whether this GLib.Error means that the input is not a video."""
    from gi.repository import Gst  # the caller has loaded GStreamer already
    return any(
        error.matches(Gst.StreamError.quark(), code)
        for code in (Gst.StreamError.TYPE_NOT_FOUND, Gst.StreamError.WRONG_TYPE))


# A message, to follow the name of the input.
NO_VIDEO = "isn't a video that GStreamer knows: give a video file"


def of_filesink(place: object, error: Any, debug: str | None) -> Failure:
    """The exception for a filesink's error. `place`: the user's name for what it writes to."""
    from gi.repository import Gst

    # filesink reports NO_SPACE_LEFT only while it writes. If it can't create the file, or if the
    # quota is used up, only the system's message tells.
    messages = (os.strerror(errno.ENOSPC), os.strerror(errno.EDQUOT))
    if error.matches(Gst.ResourceError.quark(), Gst.ResourceError.NO_SPACE_LEFT) or any(
            text in (debug or "") for text in messages):
        return Full(place)
    reason = one_line(error.message).rstrip(".")
    return Failure(f"can't write into '{place}' ({reason}): give another place")
