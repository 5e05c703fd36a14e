# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the commands of this folder share before GStreamer is there: arguments, failures, exit codes."""

import argparse
import contextlib
import os
import signal
import sys

from pipelines.lib import lock
from pipelines.lib.failure import Failure, Full, Misuse, of_filesink  # noqa: F401


# options that may stand alone: what they mean then
BARE = {"--display": "autovideosink", "--web": "8080"}


def positive(text):
    try:
        value = float(text)
    except ValueError:
        value = 0
    if not 0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of seconds above 0")
    return value


def setting(text):
    name, equals, value = text.partition("=")
    if not name or not equals:
        raise argparse.ArgumentTypeError(f"'{text}' is not PROPERTY=VALUE")
    return name, value


def refuse_written(path):
    """A file of tracks is emptied when it is opened, before it is known whether a picture comes: an earlier run's must not be lost so."""
    if os.path.isdir(path):
        raise Misuse(f"'{path}' is a folder: name a file for the tracks")
    if os.path.isfile(path) and os.path.getsize(path):
        raise Misuse(f"'{path}' is there already: name another file for the tracks, or remove it")


def check_unwritten(parser, path):
    try:
        refuse_written(path)
    except Misuse as misuse:
        parser.error(str(misuse))


def add_common(parser):
    parser.add_argument("--set", action="append", default=[], type=setting,
                        metavar="PROPERTY=VALUE",
                        help="any property of csdtrack, more than once if you like")
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")


def plain(path):
    """A path for text: what is no UTF-8 in it is written \\xNN."""
    return path.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")


def check_name(text):
    """Raises Misuse of a name that GStreamer can't be given from here: PyGObject takes no text but UTF-8."""
    if plain(text) != text:
        raise Misuse(
            f"'{plain(text)}' is no UTF-8, and from Python GStreamer takes no other names: rename it"
        )


# after what was to be read, more than once or out of order
PIPE = "is no file but a pipe or a device: save it as a file first"


def is_pipe(path):
    """Or a device."""
    return os.path.exists(path) and not os.path.isfile(path) and not os.path.isdir(path)


def heard(*numbers):
    """Those of these signals that are not ignored: after nohup SIGHUP is."""
    return [number for number in numbers if signal.getsignal(number) != signal.SIG_IGN]


def options(parse):
    """The arguments as `parse` reads them. With --check first, that is all: the program ends."""
    for word in sys.argv[1:]:
        check_name(word)
    # argparse would take the next word for its value, whatever that is.
    arguments = [f"{word}={BARE[word]}" if word in BARE else word for word in sys.argv[1:]]
    checked = arguments[:1] == ["--check"]
    found = parse(arguments[checked:])
    if checked:
        sys.exit(0)
    return found


@contextlib.contextmanager
def folders(*wanted):
    """Makes them, and no other run may work on them meanwhile. After a Failure those that were made and hold nothing are gone again."""
    # os.path: what can't be looked at isn't there, and making it says why. pathlib's raises.
    made = [
        path for folder in wanted for path in (folder, *folder.parents) if not os.path.exists(path)
    ]
    try:
        for folder in wanted:
            try:
                folder.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise Failure(f"can't write into '{folder}' ({error.strerror}): give another folder"
                              ) from error
            if not os.access(folder, os.W_OK):
                raise Failure(f"can't write into '{folder}': give a folder where you may write")
        with contextlib.ExitStack() as locks:
            found = {(state.st_dev, state.st_ino): folder for folder in reversed(wanted)
                     for state in [os.stat(folder)]}
            for folder in found.values():  # each once
                locks.enter_context(lock.held(folder))
            yield
    except Failure:
        for folder in made:
            # not empty: an empty file may be another command's, just opened
            with contextlib.suppress(OSError):
                folder.rmdir()
        raise


def check_window(sink, option):
    """autovideosink without a display ends the whole process in some versions of GStreamer."""
    if sink == "autovideosink" and not (os.environ.get("DISPLAY") or
                                        os.environ.get("WAYLAND_DISPLAY")):
        raise Failure(
            f"there is no display for a window (DISPLAY and WAYLAND_DISPLAY are empty): give a sink that needs none with {option}"
        )


def quoted(text):
    """A value in the text of a pipeline."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


# Of raw video: three frames, not one, as a decoder may give two at once. Of lines, which are small:
# ten seconds, for a disk that stands still.
FRAMES = "queue max-size-buffers=3 max-size-bytes=0 max-size-time=0"
LINES = "queue max-size-time=10000000000 max-size-buffers=0 max-size-bytes=0"


def lines_file(path):
    """The sink of a file of lines, each there as soon as it is made."""
    return f"filesink location={quoted(str(path))} buffer-mode=unbuffered async=false"


def told(text, file, end="\n"):
    """Prints it, at once. Returns whether anybody can read it; if not (| head, a terminal that was closed), nothing more is said there."""
    try:
        print(text, file=file, end=end, flush=True)
        return True
    except OSError:
        # What is not yet written would be tried once more at the end of the process, and its exit
        # code be 120.
        os.dup2(os.open(os.devnull, os.O_WRONLY), file.fileno())
        return False


def run(name, main):
    try:
        main()
    except Failure as failure:
        told(f"{name}: {failure}", sys.stderr)
        sys.exit(failure.code)
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)
