# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures what a frame costs in formats that csdtrack reads in place, and in those it unpacks."""

import argparse
import os
import sys
import tempfile

from pipelines.experiments import builds, page
from pipelines.experiments.builds import ROOT
from pipelines.lib.failure import Failure

# GStreamer must know the build's own registry before it starts.
os.environ.update(builds.environment())
from tests.bench.playing import Gst, play, refuse  # noqa: E402

PAGE = ROOT / "docs" / "results" / "formats.md"
BEGIN, END = "<!-- written by tests/bench/formats --write -->", "<!-- end of formats -->"
SCENE = "scenario=mixed style=heart seed=101"
WIDTH, HEIGHT, FRAMES, TIMES = 1280, 720, 100, 3
# Format, how it is read, what has it.
FORMATS = (
    ("I420", "in place", "most decoders"),
    ("GBR", "in place", "OBS's lossless recordings"),
    ("Y41B", "in place", "NTSC DV"),
    ("v210", "in place", "capture cards"),
    ("AYUV", "unpacked", "8 bit, 4:4:4"),
    ("AYUV64", "unpacked", "16 bit, 4:4:4"),
    ("v216", "unpacked", "16 bit, 4:2:2"),
    ("BGRA64_LE", "unpacked", "16 bit, RGB"),
    ("RGB16", "unpacked", "5 and 6 bit, RGB"),
    ("NV12_64Z32", "unpacked", "tiles"),
    ("NV12_10LE32", "unpacked", "10 bit, three to a word"),
    ("UYVP", "unpacked", "10 bit, four to five bytes"),
)


def milliseconds(video: str, format_: str, properties: str) -> str:
    """The median of a frame's time: the lowest of some runs, as other programs only add to it."""
    text = (f'filesrc location="{video}" ! y4mdec ! videoconvert dither=none ! '
            f"video/x-raw,format={format_} ! csdtrack name=track {properties} ! fakesink")
    return f"{min(play(text, 600).get_value('time-p50') for _ in range(TIMES)) / 1e6:.1f}"


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="tests/bench/formats", formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__, epilog=f"""
Renders csdsimsrc {SCENE} in {WIDTH}×{HEIGHT}, and plays it
through csdtrack in each format. The times are those of csdtrack alone, without the conversion.
Each is the lowest median of {TIMES} runs. Needs 200 MB in $TMPDIR and some two minutes.""")
    parser.add_argument("--write", action="store_true",
                        help="put the table into docs/results/formats.md")
    parser.add_argument("--frames", type=int, metavar="N", help=f"instead of {FRAMES}")
    options = parser.parse_args()
    if options.write and options.frames:
        parser.error("--write is for the table of docs/results/formats.md: no --frames")
    return options


def main() -> None:
    options = parse()
    try:
        builds.make(False, ("plugin",), commands=())
    except Failure as failure:
        refuse(failure)
    Gst.init(None)  # reads the plugin that was just built
    rows = []
    with tempfile.TemporaryDirectory(prefix="csdtrack-formats-") as folder:
        video = f"{folder}/video.y4m"
        play(f"csdsimsrc {SCENE} num-buffers={options.frames or FRAMES} ! "
             f"video/x-raw,format=I420,width={WIDTH},height={HEIGHT},framerate=25/1 ! y4menc ! "
             f'filesink location="{video}"', 3600)
        for format_, way, of in FORMATS:
            print(format_, file=sys.stderr)
            rows.append([format_, of, way, milliseconds(video, format_, "algorithm=csd"),
                         milliseconds(video, format_, "algorithm=lk")])
    table = page.table(["format", "", "read", "`csd`: ms a frame", "`lk`"], rows)
    versions = builds.versions()
    text = (f"csdtrack, {WIDTH}×{HEIGHT}, {versions['processor']}:"
            f"\n\n{table}")
    print(text, end="")
    if options.write:
        page.rewrite(PAGE, BEGIN, END, text)


if __name__ == "__main__":
    main()
