# SPDX-License-Identifier: LGPL-2.1-or-later
"""What goes wrong, and how far it is, as a user is told."""

import os
import sys
import time


class Failure(Exception):
    """Nothing could be made; the text is one line that says what to change."""


def log():
    """A file for what another program says: in memory, as the disk may be full, and there may be no folder for temporary files."""
    return os.fdopen(os.memfd_create("log"), "w+", errors="replace")


class Progress:
    """A line on a terminal, else a line for each quarter. If not `wanted`, nothing."""

    def __init__(self, what, wanted):
        self._what, self._wanted = what, wanted
        self._terminal = sys.stderr.isatty()
        self._quarter = 0
        self._shown = 0.0

    def show(self, share):
        """share: 0…1 of what there is to do."""
        if not self._wanted:
            return
        share = min(max(share, 0), 1)
        if self._terminal:
            if time.monotonic() - self._shown > 0.2:
                self._shown = time.monotonic()
                print(f"\r\033[K{self._what} {share:.0%}", end="", file=sys.stderr, flush=True)
        elif int(share * 4) > self._quarter:
            self._quarter = int(share * 4)
            print(f"{self._what} {share:.0%}", file=sys.stderr, flush=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._wanted and self._terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
