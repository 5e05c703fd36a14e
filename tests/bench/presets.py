# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures what each preset costs, and how good it is on simulated tissue."""

import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from pipelines.experiments import builds, page
from pipelines.experiments.builds import ROOT
from pipelines.lib.failure import Failure

# GStreamer must know the build's own registry before it starts.
os.environ.update(builds.environment(), GST_PRESET_PATH=str(ROOT / "gst" / "presets"))
from tests.bench.playing import Gst, play, refuse  # noqa: E402

PAGE = ROOT / "docs" / "results" / "presets.md"
BEGIN, END = "<!-- written by tests/bench/presets --write -->", "<!-- end of presets -->"
SCENE = "scenario=mixed style=heart seed=101"
SIZES = ((1280, 720, 400), (1920, 1080, 200))  # width, height, frames; the first is scored
RATE = 25
FEATURES = 200  # in the truth


def render(folder: pathlib.Path, width: int, height: int, frames: int) -> pathlib.Path:
    """Renders the video, and its truth beside it."""
    video = folder / f"{height}.y4m"
    play(f"csdsimsrc {SCENE} num-buffers={frames} features={FEATURES} ! "
         f"video/x-raw,format=I420,width={width},height={height},framerate={RATE}/1 ! tee name=t "
         f't. ! queue ! y4menc ! filesink location="{video}" '
         "t. ! queue ! csdtrackenc role=truth ! "
         f'filesink location="{video}.truth.jsonl" async=false', 3600)
    return video


def follow(video: pathlib.Path, preset: str, points: str = "") -> tuple[str, Gst.Structure]:
    """Tracks the video at the pace of a camera, as a preset with a frame budget lets features wait.

    Returns the file of the tracks, and csdtrack's stats.
    """
    points = f'points="{points}"' if points else ""
    tracks = f"{video}.tracks.jsonl"
    stats = play(f'filesrc location="{video}" ! y4mdec ! queue ! clocksync ! '
                 f"csdtrack name=track {preset} {points} content-area=full ! csdtrackenc ! "
                 f'filesink location="{tracks}" async=false', 600)
    return tracks, stats


def milliseconds(stats: Gst.Structure) -> str:
    return " / ".join(f"{stats.get_value(f'time-{p}') / 1e6:.1f}" for p in ("p50", "p95"))


def csd_score(*arguments: str) -> str:
    """The output of csd-score."""
    done = subprocess.run([builds.program("csd-score"), *arguments], capture_output=True, text=True)
    if done.returncode:
        refuse(done.stderr.strip())
    return done.stdout


def score(truth: str, tracks: str, features: int) -> tuple[float, float]:
    """Sensitivity and K."""
    report = csd_score("--json", "--resamples", "0", "--ids", f"0-{features - 1}", truth, tracks)
    found = json.loads(report)["trackers"][0]
    return found["sensitivity"]["value"], found["k"]["value"]


def measure(preset: str, videos: list[pathlib.Path]) -> list[str]:
    """The row of a preset."""
    element = Gst.ElementFactory.make("csdtrack")
    if preset and not element.load_preset(preset):
        refuse(f"there is no preset {preset}")
    features, chosen = element.get_property("max-features"), f"@preset={preset}" if preset else ""
    cells = [f"`{preset}`" if preset else "none", str(features)]
    for video in videos:
        cells.append(milliseconds(follow(video, chosen)[1]))
    truth = f"{videos[0]}.truth.jsonl"
    some = ";".join(csd_score("--print-points", truth).strip().split(";")[:features])
    tracks, stats = follow(videos[0], chosen, some)
    sensitivity, k = score(truth, tracks, features)
    return [*cells, milliseconds(stats), f"{sensitivity:.3f} / {k:.3f}"]


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="tests/bench/presets", formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__, epilog=f"""
Renders csdsimsrc {SCENE} in two sizes, and plays it at {RATE} frames a
second through csdtrack without a preset and with each: once with its own detection, which shows
what it costs, and once with as many points of the truth, which shows how good it is. Nothing else
should run: presets with a frame budget do as much as time allows. Needs 2 GB in $TMPDIR and some
ten minutes.""")
    parser.add_argument("--write", action="store_true", help="write docs/results/presets.md")
    parser.add_argument("--frames", type=int, metavar="N",
                        help=f"of each size ({', '.join(str(size[2]) for size in SIZES)})")
    options = parser.parse_args()
    if options.write and options.frames:
        parser.error("--write is for the table of docs/results/presets.md: no --frames")
    return options


def main() -> None:
    options = parse()
    try:
        builds.make(False, ("plugin", "csd-score"), commands=())
    except Failure as failure:
        refuse(failure)
    Gst.init(None)  # reads the plugin that was just built
    presets = re.findall(r"^\[(?!_)(.+)\]$",
                         (ROOT / "gst" / "presets" / "GstCsdTrack.prs").read_text(), re.M)
    with tempfile.TemporaryDirectory(prefix="csdtrack-presets-") as folder:
        videos = []
        for width, height, frames in SIZES:
            print(f"rendering {width}×{height}", file=sys.stderr)
            videos.append(render(pathlib.Path(folder), width, height, options.frames or frames))
        rows = []
        for preset in ("", *presets):
            print(preset or "no preset", file=sys.stderr)
            rows.append(measure(preset, videos))
    table = page.table([
        "preset", "features", *(f"{w}×{h}: ms a frame, p50 / p95" for w, h, _ in SIZES),
        "with points given", "sensitivity / K"
    ], rows)
    versions = builds.versions()
    text = f"csdtrack {versions['csdtrack']}, {versions['processor']}:\n\n{table}"
    print(text, end="")
    if options.write:
        page.rewrite(PAGE, BEGIN, END, text)


if __name__ == "__main__":
    main()
