# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the lines of tracks beside the files of a recording."""

import collections
import errno
import os
import pathlib
import queue
import stat
import sys
import threading
from collections.abc import Callable
from typing import Any

from pipelines.lib import command

MAX_WAITING = 3000  # lines that may wait for a busy disk: two minutes of a camera, some 10 MB
PATIENCE = 10  # seconds with such a disk, after all else has been written


def tracks_name(video: str) -> str:
    return pathlib.Path(video).with_suffix(".jsonl").name


class Sidecar:
    """Writes each line into the file beside the one that holds its frame.

    It writes a line at once, into the newest file, so that a killed recorder leaves a line for each
    frame that it recorded. But the encoder delays frames: lines arrive before it is known where the
    next file begins. When it begins, its lines are moved into the new file. A file holds whole
    groups of pictures, and when a group begins, splitmuxsink has assigned all groups but the last:
    lines from before that stay.

    A thread does this, as a disk may stand still and the recording must not wait for it. If the
    recorder is killed just when a file begins, that file's lines may be in the one before.
    """

    def __init__(self, folder: pathlib.Path, first: str) -> None:
        """`first`: the first video, whose name the first file of tracks has."""
        self._folder = folder
        self._name = tracks_name(first)  # of the newest file
        self._file: int | None = None
        self.lines: collections.Counter[str] = collections.Counter()  # by the file they belong to
        # (running time, offset, line) of lines that may belong to the next file
        self._movable: collections.deque[tuple[int, int, bytes]] = collections.deque()
        self._size = 0
        self._group = 0  # running time of the last group of pictures
        self._jobs: queue.Queue[tuple[Callable[..., None] | None, tuple[Any, ...]]] = queue.Queue(
            MAX_WAITING)
        self._lock = threading.Lock()
        self.failed = False
        # A daemon, so that a disk that never answers can't keep the program running.
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def add_line(self, time: int, text: bytes) -> None:
        self._hand_over(self._write, time, text)

    def begin_file(self, time: int, name: str) -> None:
        """A file of the recording begins with the frame of this running time."""
        self._hand_over(self._begin_file, time, tracks_name(name))

    def begin_group(self, time: int) -> None:
        """A group of pictures begins."""
        self._hand_over(self._begin_group, time)

    def end(self) -> None:
        """Waits until all lines are written, or the disk takes too long."""
        self._hand_over(None)
        if not self.failed:
            self._thread.join(PATIENCE)
            if self._thread.is_alive():
                self._fail(f"'{self._folder}': its disk stands still")

    def _hand_over(self, job: Callable[..., None] | None, *arguments: Any) -> None:
        if self.failed:
            return
        try:
            self._jobs.put_nowait((job, arguments))
        except queue.Full:
            self._fail(f"'{self._folder}': its disk stands still, {MAX_WAITING} lines wait for it")

    def _fail(self, why: str) -> None:
        """After an error the tracks end, and nothing else does."""
        with self._lock:
            failed, self.failed = self.failed, True
        if not failed:
            command.print_line(
                f"record: warning: the tracks end here, the recording goes on: {why}", sys.stderr)

    def _work(self) -> None:
        try:
            try:
                while True:
                    job, arguments = self._jobs.get()
                    if job is None or self.failed:
                        break
                    job(*arguments)
                if self._file is not None:
                    self._check(self._file, self._name)
            finally:
                if self._file is not None:
                    os.close(self._file)
        except OSError as error:
            self._fail(f"'{error.filename or self._folder}': {error.strerror}")

    def _write(self, time: int, text: bytes) -> None:
        self._append(self._open(self._name) if self._file is None else self._file, time, text)

    def _begin_file(self, time: int, name: str) -> None:
        if name == self._name:
            return
        name_before, self._name = self._name, name
        moved = [entry for entry in self._movable if entry[0] >= time]
        before = self._file
        if before is not None:
            self._check(before, name_before)
        self._movable.clear()
        file = self._open(name)
        self.lines[name_before] -= len(moved)
        for begin, _, text in moved:
            self._append(file, begin, text)
        if before is not None:
            if moved:  # after they have been written: a line may be there twice, but never be lost
                os.ftruncate(before, moved[0][1])
            os.close(before)

    def _check(self, file: int, name: str) -> None:
        """A disk may take a line, say nothing, and not keep it."""
        status = os.fstat(file)
        if stat.S_ISREG(status.st_mode) and status.st_size != self._size:
            raise OSError(errno.EIO, f"holds {status.st_size} of the {self._size} bytes that were "
                          "written", str(self._folder / name))

    def _begin_group(self, time: int) -> None:
        while self._movable and self._movable[0][0] < self._group:
            self._movable.popleft()
        self._group = time

    def _open(self, name: str) -> int:
        path = self._folder / name
        try:
            file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            if path.is_file():  # another recorder's
                raise
            file = os.open(path, os.O_WRONLY)  # a pipe or a device
        self._file, self._size = file, 0
        return file

    def _append(self, file: int, time: int, text: bytes) -> None:
        self._movable.append((time, self._size, text))
        self.lines[self._name] += 1
        while text:  # unbuffered, so that a killed recorder leaves what it wrote
            written = os.write(file, text)
            self._size += written
            text = text[written:]
