# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd-report's command line. The script csd-report starts this."""

import argparse
import io
import pathlib
import signal
import subprocess
import sys
from typing import Any

from report import motion, page
from report.messages import ReportError

EPILOG = """
VIDEO is what was tracked. TRACKS.jsonl is what csdtrackenc wrote of it. OUT/index.html opens in a
browser from disk, without any network. It shows the video with the tracks over it, the features
with state, lifetime and motion, and of a feature that you click the displacement over time and the
rhythms (from csd-motion). An earlier report in OUT is replaced; a folder with anything else in it
is not. The page's path is printed. If the tracks don't fit the video's size or times, there is a
warning.

The video is copied if browsers play it (H.264, VP9 or AV1 in mp4 or webm), put into mp4 if only the
container is wrong, and otherwise converted to H.264 by ffmpeg.

Exit code: 0 made, 1 not (one line says why), 2 for wrong use.
"""


class Version(argparse.Action):
    """Prints csd-motion's version: this program is installed with it, and has none of its own."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        try:
            version = subprocess.run([motion.program(), "--version"], capture_output=True,
                                     text=True, check=True).stdout
        except (ReportError, subprocess.CalledProcessError) as error:
            parser.exit(1, f"csd-report: {error}\n")
        print(version.replace("csd-motion", "csd-report"), end="")
        parser.exit()


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="csd-report", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
        description="Makes a page that shows a video with its tracks, and how the tissue moves.")
    parser.add_argument("video", type=pathlib.Path, metavar="VIDEO", help="a video file")
    parser.add_argument("tracks", type=pathlib.Path, metavar="TRACKS.jsonl", help="its tracks")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT", nargs="?",
                        default=pathlib.Path("csdtrack-report"),
                        help="the folder that is made (csdtrack-report)")
    parser.add_argument("--title", help="the page's title (VIDEO's name)")
    parser.add_argument("-P", "--progress", action="store_true", default=sys.stderr.isatty(),
                        help="print the progress on stderr; the default on a terminal, "
                        "and while a video is converted")
    parser.add_argument("--version", action=Version, nargs=0, help="print the version")
    return parser.parse_args()


def fail(text: str) -> None:
    print(f"csd-report: {text}", file=sys.stderr)
    sys.exit(1)


def main() -> None:
    options = parse()
    assert isinstance(sys.stdout, io.TextIOWrapper)
    sys.stdout.reconfigure(errors="surrogateescape")  # prints a path that isn't UTF-8 as it is
    # As Ctrl-C does: the unfinished folder is removed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        for note in page.make(options.video, options.tracks, options.out, options.title or
                              options.video.name, options.progress):
            print(f"csd-report: {note}", file=sys.stderr)
        print(options.out / "index.html")
    except ReportError as error:
        fail(str(error))
    except MemoryError:
        fail("out of memory")
    except OSError as error:
        where = f"'{error.filename}': " if error.filename else ""
        fail(f"{where}{error.strerror}")
    except KeyboardInterrupt:
        sys.exit(128 + signal.SIGINT)


main()
