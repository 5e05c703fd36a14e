# SPDX-License-Identifier: LGPL-2.1-or-later
"""What a run over an archive prints, how it gathers results, and how signals end it."""

import contextlib
import json
import os
import pathlib
import signal
import sys
import time
from collections.abc import Mapping, Sequence
from typing import Any

from pipelines.lib import archive_index, command

ESTIMATE_AFTER = 30  # seconds of work before the time left is estimated


def set_signal_handler(handler: Any) -> None:
    """For the signals that end the program."""
    for number in command.not_ignored(signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, handler)


def interrupt(*_: Any) -> None:
    # Only once: a second interrupt would abandon GNU parallel. A second signal may have arrived
    # already, and with SIG_IGN Python would print an error for that one.
    set_signal_handler(lambda *_: None)
    raise KeyboardInterrupt


def print_or_interrupt(text: str, end: str = "\n") -> None:
    """Prints to stdout. If its reader is gone, the program ends as after a signal."""
    if not command.print_line(text, sys.stdout, end):
        interrupt()


def warn(text: str) -> None:
    """Prints to stderr, and goes on if its reader is gone."""
    command.print_line(f"archive: {text}", sys.stderr)


class Progress:
    """Prints a line for each finished video; on a terminal also one line that it keeps current."""

    def __init__(self, jobs: Sequence[Mapping[str, Any]], folder: pathlib.Path) -> None:
        """`folder`: holds the jobs' progress files."""
        self._sizes = [max(job["size"], 1) for job in jobs]
        self._folder = folder
        # By job: the share that is done, 0 … 1, or why the job gave up.
        self._reports: dict[int, float | str] = {}
        self._started: float | None = None  # in a cluster work may begin hours later
        self._finished = 0
        self._bytes = 0
        self._clear = "\r\033[K" if sys.stdout.isatty() else ""

    def add(self, number: int, row: archive_index.Row) -> None:
        """A job is finished."""
        self._finished += 1
        self._bytes += self._sizes[number]
        self._reports.pop(number, None)
        if row["status"] == "done":
            fps = row["frames"] / max(row["seconds"], 1e-3)
            result = f"{row['frames']} frames, {fps:.1f} a second"
        else:
            result = f"{row['status']}: {archive_index.printable(row['error'])}"
        name = archive_index.printable(row["name"])
        print_or_interrupt(f"{self._clear}{self._state()}  {name}: {result}")

    def read(self) -> dict[int, str]:
        """Reads the jobs' progress files. Returns why jobs gave up, by their numbers."""
        self._reports = {}
        with contextlib.suppress(OSError):
            for name in os.listdir(self._folder):
                with contextlib.suppress(OSError, ValueError):
                    self._reports[int(name)] = json.loads((self._folder / name).read_text())
        if self._reports and self._started is None:
            self._started = time.monotonic()
        return {number: text for number, text in self._reports.items() if isinstance(text, str)}

    def show(self) -> None:
        if self._clear:
            text = f"{self._clear}{self._state()}, {len(self._shares())} under way"
            print_or_interrupt(text, end="")

    def end(self) -> None:
        print_or_interrupt(self._clear, end="")

    def _shares(self) -> dict[int, float]:
        return {
            number: share for number, share in self._reports.items() if isinstance(share, float)
        }

    def _state(self) -> str:
        """Estimates by the videos' bytes: their lengths are known only when they have been read."""
        done = self._bytes + sum(share * self._sizes[number]
                                 for number, share in self._shares().items())
        spent = time.monotonic() - self._started if self._started else 0
        left = ""
        if spent > ESTIMATE_AFTER and 0 < done < sum(self._sizes):
            left = f", {archive_index.clock(spent * (sum(self._sizes) / done - 1))} left"
        return f"{self._finished} of {len(self._sizes)}{left}"


class Gatherer:
    """Puts the jobs' results into the index."""

    def __init__(self, plan: Mapping[str, Any], index: archive_index.Index,
                 progress: Progress) -> None:
        self._plan, self._index, self._progress = plan, index, progress
        self._out = pathlib.Path(plan["out"])
        jobs = range(len(plan["jobs"]))
        self._before = [self._stamp(number) for number in jobs]
        self.open = set(jobs)  # jobs without a result

    def gather(self) -> None:
        rows: dict[int, archive_index.Row] = {}
        for number in sorted(self.open):
            if self._stamp(number) == self._before[number]:
                continue
            row = archive_index.read_result(self._out, self._plan["jobs"][number]["name"])
            if row and all(row[key] == self._plan[key] for key in ("version", "settings")):
                rows[number] = row
        self._index.put(rows.values())
        self.open -= rows.keys()
        for number, row in rows.items():  # last, as it may raise
            self._progress.add(number, row)

    def _stamp(self, number: int) -> tuple[int, int] | None:
        """Changes when the job's result has been written."""
        path = archive_index.result_path(self._out, self._plan["jobs"][number]["name"])
        try:
            with open(path, "rb") as file:  # over NFS stat() without open() may be a minute old
                found = os.fstat(file.fileno())
        except OSError:
            return None
        return found.st_ino, found.st_mtime_ns
