# SPDX-License-Identifier: LGPL-2.1-or-later
"""The program's errors and its progress."""

import os
import sys
import time
from typing import Any, TextIO


class ReportError(Exception):
    """The report can't be made. The text is one line that says what to change."""


def memory_file() -> TextIO:
    """A file for another program's stderr.

    It is in memory, as the disk may be full, and there may be no folder for temporary files.
    """
    return os.fdopen(os.memfd_create("stderr"), "w+", errors="replace")


class Progress:
    """A line on a terminal; otherwise a line for each quarter. Prints nothing unless `wanted`."""

    def __init__(self, what: str, wanted: bool) -> None:
        self._what, self._wanted = what, wanted
        self._terminal = sys.stderr.isatty()
        self._quarter = 0
        self._shown = 0.0

    def show(self, share: float) -> None:
        """share: of the work, 0…1."""
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

    def __enter__(self) -> "Progress":
        return self

    def __exit__(self, *_: Any) -> None:
        if self._wanted and self._terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)
