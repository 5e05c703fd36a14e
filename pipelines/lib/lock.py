# SPDX-License-Identifier: LGPL-2.1-or-later
"""A folder of results belongs to one run at a time."""

import contextlib
import fcntl
import glob
import os
import pathlib
import time
from collections.abc import Iterator

from pipelines.lib.failure import Failure


def take(path: pathlib.Path, out: pathlib.Path) -> int:
    """Locks the folder `out` through the file `path`, and returns the file's descriptor.

    The lock lasts until the last process that has the descriptor ends. If another run holds it,
    this raises a Failure that names that run, and changes nothing.
    """
    while True:
        try:
            lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise Failure(
                f"can't write into '{out}' ({error.strerror}): give another OUT") from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            since = time.strftime("%F %T", time.localtime(os.fstat(lock).st_mtime))
            written = os.read(lock, 1000).decode(errors="replace").split()
            os.close(lock)
            host, *processes = [os.uname().nodename, *holders(path)]
            if not processes:  # on another machine, or of another user
                host, *processes = written or ["?", "?"]
            raise Failure(f"another run works on '{out}' since {since}: wait for it, "
                          f"or end it with 'kill {' '.join(processes)}' on {host}") from error
        except OSError:
            return lock  # a file system without locks
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(lock), os.stat(path)):
                break
        os.close(lock)  # its last holder removed the file after it was opened here
    with contextlib.suppress(OSError):  # on a full disk: the lock holds without the text
        os.ftruncate(lock, os.pwrite(lock, f"{os.uname().nodename} {os.getpid()}\n".encode(), 0))
    return lock


@contextlib.contextmanager
def held(folder: pathlib.Path) -> Iterator[None]:
    """Locks a folder while the context lasts. A killed run leaves the file, but no lock."""
    path = folder / ".csdtrack-lock"
    lock = take(path, folder)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            path.unlink()  # while it is locked: afterwards it may be another run's
        os.close(lock)


def holders(path: pathlib.Path) -> list[str]:
    """The ids of the processes on this machine that have a file open, without their children.

    That is the run itself or, if it was killed, the processes that it left.
    """
    parents: dict[str, str] = {}
    for link in glob.iglob("/proc/[0-9]*/fd/*"):
        with contextlib.suppress(OSError):
            process = link.split("/")[2]
            if os.readlink(link) == os.path.realpath(path):
                stat = pathlib.Path(f"/proc/{process}/stat").read_text()
                parents[process] = stat.rpartition(")")[2].split()[1]
    return [process for process, parent in parents.items() if parent not in parents]
