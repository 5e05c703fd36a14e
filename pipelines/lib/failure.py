# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands of this folder end with if they can't do what they were told."""

import errno
import os


def one_line(text):
    return " ".join(text.split())


class Failure(Exception):
    """Nothing could be done; the text is one line that says what to change."""

    code = 1  # the program's


class Misuse(Failure):
    """What the user wrote is no value, property or name that there is, whatever the machine."""

    code = 2


class Full(Failure):
    """There is no room left, or no more of it for this user: it makes no sense to go on."""

    def __init__(self, place):
        super().__init__(
            f"can't write into '{place}' (the disk is full): make room or give another place")


def no_video(error):
    """Whether a GLib.Error says that what was read is no video."""
    from gi.repository import Gst  # who has such an error has GStreamer
    return any(
        error.matches(Gst.StreamError.quark(), code)
        for code in (Gst.StreamError.TYPE_NOT_FOUND, Gst.StreamError.WRONG_TYPE))


NO_VIDEO = "isn't a video that GStreamer knows: give a video file"  # after what was read


def of_filesink(place, error, debug):
    """What to raise over a filesink's error; `place`: what the user calls where it writes."""
    from gi.repository import Gst
    # NO_SPACE_LEFT is what it says while it writes. Of a file that it can't even make, and of a
    # quota, the system's words tell.
    said = (os.strerror(errno.ENOSPC), os.strerror(errno.EDQUOT))
    if error.matches(Gst.ResourceError.quark(), Gst.ResourceError.NO_SPACE_LEFT) or any(
            text in (debug or "") for text in said):
        return Full(place)
    return Failure(
        f"can't write into '{place}' ({' '.join(error.message.split()).rstrip('.')}): give another place"
    )
