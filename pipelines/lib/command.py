# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands share before GStreamer is loaded: arguments, failures, exit codes."""

import argparse
import contextlib
import os
import pathlib
import re
import signal
import sys
from collections.abc import Callable, Iterator
from typing import TextIO

from pipelines.lib import lock
from pipelines.lib.failure import Failure, Full, Misuse, of_filesink  # noqa: F401

# Options that may stand without a value, and the value that they have then.
IMPLIED_VALUES = {"--display": "autovideosink", "--web": "8080"}


def positive(text: str) -> float:
    """The type of an argument in seconds."""
    try:
        value = float(text)
    except ValueError:
        value = 0
    if not 0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of seconds above 0")
    return value


def assignment(text: str) -> tuple[str, str]:
    """The type of an argument PROPERTY=VALUE."""
    name, equals, value = text.partition("=")
    if not name or not equals:
        raise argparse.ArgumentTypeError(f"'{text}' is not PROPERTY=VALUE")
    return name, value


def refuse_existing_tracks(path: pathlib.Path) -> None:
    """Raises Misuse if the file holds something.

    Opening a file of tracks empties it, before the first frame arrives. An earlier run's tracks
    must not be lost that way.
    """
    if os.path.isdir(path):
        raise Misuse(f"'{path}' is a folder: name a file for the tracks")
    if os.path.isfile(path) and os.path.getsize(path):
        raise Misuse(f"'{path}' is there already: name another file for the tracks, or remove it")


def check_new_tracks(parser: argparse.ArgumentParser, path: pathlib.Path) -> None:
    try:
        refuse_existing_tracks(path)
    except Misuse as misuse:
        parser.error(str(misuse))


def add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--set", action="append", default=[], type=assignment,
                        metavar="PROPERTY=VALUE",
                        help="any property of csdtrack, more than once if you like")
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")


def add_tracking(parser: argparse.ArgumentParser, preset: str = "live-low-latency") -> None:
    """The options of a command that tracks a source until it ends."""
    parser.add_argument("--preset", default=preset, metavar="NAME", help=f"of csdtrack ({preset})")
    parser.add_argument("--seconds", type=positive, metavar="N", help="end after this time")
    add_common(parser)


def check_sink(parser: argparse.ArgumentParser, option: str, name: str | None) -> None:
    """Refuses what can't be an element's name; it would be part of a pipeline's description."""
    if name and not re.fullmatch(r"[a-z0-9]+", name):
        parser.error(f"{option}: '{name}' is no name of an element")


def escaped(path: str) -> str:
    """A path as UTF-8. Bytes that are not UTF-8 become \\xNN."""
    return path.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")


def check_name(text: str) -> None:
    """Raises Misuse for a name that is not UTF-8: PyGObject can't pass it to GStreamer."""
    if escaped(text) != text:
        raise Misuse(f"'{escaped(text)}' is no UTF-8, and from Python GStreamer takes "
                     "no other names: rename it")


# A message, to follow the name of an input that is read more than once or out of order.
NOT_A_FILE = "is no file but a pipe or a device: save it as a file first"


def is_pipe_or_device(path: str | pathlib.Path) -> bool:
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def not_ignored(*numbers: signal.Signals) -> list[signal.Signals]:
    """Leaves out the signals that this process ignores, such as SIGHUP after nohup."""
    return [number for number in numbers if signal.getsignal(number) != signal.SIG_IGN]


def parse_options(parse: Callable[[list[str]], argparse.Namespace]) -> argparse.Namespace:
    """The options, by `parse`. With --check as the first word the program ends after that."""
    for word in sys.argv[1:]:
        check_name(word)
    # Otherwise argparse would take the next word as the option's value.
    arguments = [
        f"{word}={IMPLIED_VALUES[word]}" if word in IMPLIED_VALUES else word
        for word in sys.argv[1:]
    ]
    check_only = arguments[:1] == ["--check"]
    options = parse(arguments[check_only:])
    if check_only:
        sys.exit(0)
    return options


@contextlib.contextmanager
def locked_folders(*wanted: pathlib.Path) -> Iterator[None]:
    """Makes these folders, and keeps other runs out of them.

    After a Failure it removes the folders that it made and that are still empty.
    """
    # Not pathlib's exists(), which raises where a folder can't be looked into. os.path.exists()
    # says False, and making the folder gives the reason.
    made = [
        path for folder in wanted for path in (folder, *folder.parents) if not os.path.exists(path)
    ]
    try:
        for folder in wanted:
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise Failure(f"can't write into '{folder}' ({error.strerror}): "
                              "give another folder") from error
            if not os.access(folder, os.W_OK):
                raise Failure(f"can't write into '{folder}': give a folder where you may write")
        with contextlib.ExitStack() as locks:
            states = [(os.stat(folder), folder) for folder in reversed(wanted)]
            # Two names of one folder are locked once.
            different = {(state.st_dev, state.st_ino): folder for state, folder in states}
            for folder in different.values():
                locks.enter_context(lock.held(folder))
            yield
    except Failure:
        for folder in made:
            # Fails if it isn't empty: an empty file in it may be another command's.
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise


def check_window(sink: str | None, option: str) -> None:
    """Raises Failure without a display: some versions of autovideosink end the process then."""
    if sink == "autovideosink" and not (os.environ.get("DISPLAY") or
                                        os.environ.get("WAYLAND_DISPLAY")):
        raise Failure("there is no display for a window (DISPLAY and WAYLAND_DISPLAY are empty): "
                      f"give a sink that needs none with {option}")


def quoted(text: str) -> str:
    """A value in a pipeline's description."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


# Three frames, as a decoder may output two at once.
FRAME_QUEUE = "queue max-size-buffers=3 max-size-bytes=0 max-size-time=0"
# Lines of tracks are small, so ten seconds of them may wait for a disk.
LINE_QUEUE = "queue max-size-time=10000000000 max-size-buffers=0 max-size-bytes=0"


def line_sink(path: pathlib.Path, name: str = "file") -> str:
    """The sink of a pipeline's description that writes each line to a file at once."""
    return (f"filesink name={name} location={quoted(str(path))} buffer-mode=unbuffered "
            "async=false")


def print_line(text: str, file: TextIO, end: str = "\n") -> bool:
    """Prints text and flushes it. Returns False if the reader is gone (| head, a closed terminal).

    After that, nothing more is printed to this file.
    """
    try:
        print(text, file=file, end=end, flush=True)
        return True
    except OSError:
        # Python would try to write the rest when it exits, fail, and exit with 120.
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())
        return False


def run(name: str, main: Callable[[], None]) -> None:
    """Runs a command's main(). A Failure becomes a message and an exit code."""
    try:
        main()
    except Failure as failure:
        print_line(f"{name}: {failure}", sys.stderr)
        sys.exit(failure.code)
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)
