# SPDX-License-Identifier: LGPL-2.1-or-later
"""A folder of results belongs to one run at a time."""

import contextlib
import fcntl
import glob
import os
import pathlib
import time

from pipelines.lib.failure import Failure


def take(path, out):
    """A lock on the folder `out`, through the file `path`: a descriptor, and the lock lasts until the last process that has it ends. Raises
    Failure, which says whose it is, and touches nothing then."""
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
            told = os.read(lock, 1000).decode(errors="replace").split()
            os.close(lock)
            host, *processes = [os.uname().nodename, *holders(path)]
            if not processes:  # of another machine, or another user
                host, *processes = told or ["?", "?"]
            raise Failure(
                f"another run works on '{out}' since {since}: wait for it, or end it with 'kill {' '.join(processes)}' on {host}"
            ) from error
        except OSError:
            return lock  # a file system without locks
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(lock), os.stat(path)):
                break
        os.close(lock)  # who had it removed it after it was opened here
    with contextlib.suppress(OSError):  # a full disk: then it says less, and holds all the same
        os.ftruncate(lock, os.pwrite(lock, f"{os.uname().nodename} {os.getpid()}\n".encode(), 0))
    return lock


@contextlib.contextmanager
def held(folder):
    """The lock on a folder, as long as this lasts. A killed run leaves the file, which is no lock then."""
    path = folder / ".csdtrack-lock"
    lock = take(path, folder)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            path.unlink()  # while it is locked: else it might be another's by now
        os.close(lock)


def holders(path):
    """The processes of this machine that have a file open, but not those that they started: the run, or what it left if it was killed."""
    parents = {}
    for link in glob.iglob("/proc/[0-9]*/fd/*"):
        with contextlib.suppress(OSError):
            process = link.split("/")[2]
            if os.readlink(link) == os.path.realpath(path):
                parents[process] = pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(
                    ")")[2].split()[1]
    return [process for process, parent in parents.items() if parent not in parents]
