# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads lines of tracks from KLV packets (docs/metadata.md, KLV)."""

from collections.abc import Iterator

# Two bytes follow: the line's number, and how many of its pieces are still to come.
LABEL = b"\x06\x0e\x2b\x34\x01\x01\x01\x01\x0fcsdtr"


class Lines:
    """Joins the pieces of lines, from packets of tsdemux or rtpklvdepay.

    Skips packets that are not csdtrack's, and lines of which a piece is missing.
    """

    def __init__(self) -> None:
        self._pieces: bytes | None = b""  # of the line; None: its first piece is missing
        self._next: tuple[int, int] | None = None  # the two bytes that belong to the next piece

    def take(self, packets: bytes) -> Iterator[bytes]:
        """The lines that these packets complete, each with its newline."""
        at = packets.find(LABEL)
        while at >= 0:
            number, left, size = (packets + bytes(3))[at + 14:at + 17]
            at += 17
            if size > 127:
                size, at = int.from_bytes(packets[at:at + size - 128], "big"), at + size - 128
            piece = packets[at:at + size]
            if len(piece) < size:  # cut off
                self._pieces, self._next = None, None
                return
            if (number, left) != self._next:
                self._pieces = b"" if piece.startswith(b'{"schema":') else None
            self._next = (number, left - 1)
            if self._pieces is not None:
                self._pieces += piece
                if left == 0:
                    yield self._pieces + b"\n"
            at = packets.find(LABEL, at + size)
