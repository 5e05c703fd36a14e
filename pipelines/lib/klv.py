# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lines of tracks out of KLV packets: docs/metadata.md, KLV."""

# two bytes follow: the line's number, and how many of its pieces are still to come
LABEL = b"\x06\x0e\x2b\x34\x01\x01\x01\x01\x0fcsdtr"


class Lines:
    """Of the packets that tsdemux and rtpklvdepay give. Those of others are passed over; a line of which something is missing is left out."""

    def __init__(self):
        # pieces of a line (None: its begin is missing), and what the label of the next one ends in
        self._begun, self._next = b"", None

    def take(self, packets):
        """The lines that end in these, each with a newline."""
        at = packets.find(LABEL)
        while at >= 0:
            number, left, size = (packets + bytes(3))[at + 14:at + 17]
            at += 17
            if size > 127:
                size, at = int.from_bytes(packets[at:at + size - 128], "big"), at + size - 128
            piece = packets[at:at + size]
            if len(piece) < size:  # torn
                self._begun, self._next = None, None
                return
            if (number, left) != self._next:
                self._begun = b"" if piece.startswith(b'{"schema":') else None
            self._next = (number, left - 1)
            if self._begun is not None:
                self._begun += piece
                if left == 0:
                    yield self._begun + b"\n"
            at = packets.find(LABEL, at + size)
