# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sound that goes into an mp4 as it is."""

from collections.abc import Sequence

import gi

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402

# Encoded sound that mp4mux takes: its caps, and the parser that brings it into mp4's form.
COPIED: Sequence[tuple[str, str | None]] = (
    ("audio/mpeg, mpegversion=(int)4", "aacparse"),
    ("audio/mpeg, mpegversion=(int)1, layer=(int)3", "mpegaudioparse"),
    ("audio/x-ac3", "ac3parse"),
    ("audio/x-opus, channel-mapping-family=(int)0", "opusparse"),
    ("audio/x-alac", None),
)


def copied(caps: Gst.Caps) -> tuple[str, str | None] | None:
    """The entry of COPIED for these caps."""
    for entry in COPIED:
        if caps.can_intersect(Gst.Caps.from_string(entry[0])):
            return entry
    return None
