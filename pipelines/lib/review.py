# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shows a recording with its recorded tracks; nothing is tracked: see --help.

    filesrc ! decodebin ! csdtrackdec location=TRACKS overlay=draw ! videoconvert ! SINK
"""

import argparse
import pathlib
import re

import command

EPILOG = """
TRACKS is what csdtrackenc, pipelines/record or pipelines/quickstart wrote as .jsonl; without it, the file of VIDEO's name that ends with
.jsonl. A frame has the line whose stream_time is its own (docs/elements.md).

Exit code: 0 if it was shown, 1 if not (one line says why), 2 for wrong use.
"""


def parse(arguments):
    parser = argparse.ArgumentParser(prog="pipelines/review", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
                                     description="Shows a recording with the tracks that were made with it.")
    parser.add_argument("video", type=pathlib.Path, metavar="VIDEO", help="a file that GStreamer can decode")
    parser.add_argument("tracks", type=pathlib.Path, nargs="?", metavar="TRACKS", help="its tracks (VIDEO's name with .jsonl)")
    parser.add_argument("--sink", default="autovideosink", metavar="NAME", help="GStreamer's element for the window (autovideosink)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    parser.add_argument("--no-install", action="store_true", help="install nothing; fail if something is missing")
    options = parser.parse_args(arguments)
    if not re.fullmatch(r"[a-z0-9]+", options.sink):
        parser.error(f"--sink: '{options.sink}' is no name of an element")
    options.tracks = options.tracks or options.video.with_suffix(".jsonl")
    return options


def main():
    options = command.options(parse)
    for file, what in ((options.video, "the path of a video"), (options.tracks, "the path of its tracks")):
        if not file.is_file():
            raise command.Failure(f"there is no file '{file}': give {what}")
    command.check_window(options.sink, "--sink")
    import runner
    run = runner.Run("review", f"filesrc location={command.quoted(str(options.video))} ! decodebin ! csdtrackdec name=csdtrack overlay=draw "
                               f"location={command.quoted(str(options.tracks))} ! videoconvert ! {options.sink}")
    run.play(options.video, options.seconds, harmless=("window was closed",))
    print(f"{run.frames} frames")


command.run("review", main)
