# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads caps alike with and without python3-gst-1.0."""

from typing import Any


def first_structure(caps: Any) -> Any:
    """The first structure of these caps.

    With python3-gst-1.0 caps are a sequence of structures, and from its version 1.26 on
    get_structure() returns one that only a `with` statement can open. Without it get_structure() is
    the only way.
    """
    return caps[0] if hasattr(caps, "__getitem__") else caps.get_structure(0)
