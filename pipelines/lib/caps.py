# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands ask of caps."""


def first_structure(caps):
    """Where python3-gst-1.0 is installed caps are a sequence of structures, and with its 1.26
    get_structure() gives what only `with` can open; where it isn't, get_structure() is all there is."""
    return caps[0] if hasattr(caps, "__getitem__") else caps.get_structure(0)
