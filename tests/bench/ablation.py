# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures what each part of csd contributes: csd-accuracy and the real clips with all parts, then
without each one."""

import argparse
import concurrent.futures
import hashlib
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys
import typing
from collections.abc import Callable, Mapping, Sequence

from pipelines.experiments import builds, page
from pipelines.experiments.builds import ROOT
from pipelines.experiments.sequences import PALINDROMES as CLIPS
from pipelines.lib.failure import Failure

TUNING = ROOT / "core" / "csd" / "tuning.h"
SEEDS, FRAMES = "101", 500  # of the page
ABOUT = """`csd` without one of its parts at a time, by setting numbers of `Tuning`, and with
designs that were tried and not kept. First sensitivity / K on csd-accuracy's sequences (500 frames,
100 features, seed 101, on which nothing was tuned). Then six real clips, played forward and
backward: the share of the frames in which a position is claimed, and of two claims on the same
image the share more than 5 px apart ([own-video.md](own-video.md#without-any-the-palindrome)). The
column *csd* is the tracker as it is; the others are the changes from it, and a · is a change of
less than .0005. Parts that change nothing here serve something else: the affine shape lowers the
median error on tissue that deforms; resting calm supporting points, and skipping every second
search for hidden ones, save time."""
NEVER, ALWAYS = 1e9, -1e9

Numbers = Mapping[str, float]  # of csd, by name
Pair = tuple[float, ...]  # sensitivity and K, or claimed and apart
Found = dict[str | None, dict[str, Pair]]  # by change (None: csd as it is), by sequence or clip

# What the table calls each part; the numbers of csd that turn it off.
PARTS: tuple[tuple[str, Numbers], ...] = (
    ("the neighbours' veto", {"gate_floor": NEVER, "max_distortion": NEVER}),
    ("distinctive patches, which need no support from their neighbours", {"distinctive_zncc": 2}),
    ("leaving out features that have a look-alike nearby", {"max_look_alike": 1}),
    ("weighing a patch's position against that of its neighbours", {"min_own_motion": NEVER}),
    ("the second search, where the neighbours point (with 6)", {"second_alignments": 0}),
    ("the search with the inner disc of a patch", {"second_alignments": 1}),
    ("offsets from the neighbours' motion", {"max_offset": 0}),
    ("three quarters of the supporting points (cells of 64 px)", {"cell_side": 64}),
    ("coarse levels", {"levels_first": 0, "levels_second": 0, "levels_inner": 0}),
    ("finer levels after a zoom", {"finer_scale": NEVER}),
    ("the anchor's median (instead: the first frame alone)", {"anchor_samples": 1}),
    ("the affine shape (instead: a similarity)", {"affine": 0}),
    ("the mask of highlights", {"highlight": 2}),
    ("the probability (instead: ZNCC of .6 and half the patch)", {"probability": 0}),
    ("hiding all features while the lens is wet", {"max_blur": NEVER}),
    ("finding the scene again by keypoints", {"settles": ALWAYS}),
    ("keeping supporting points off tools", {"avoid_tools": 0}),
    ("resting calm supporting points", {"rest_spread": ALWAYS}),
    ("skipping every second search for hidden supporting points", {"search_every": 1}),
    ("following a piece where the neighbours move apart", {"common_spread": NEVER}),
)
# The same for designs that were tried and not kept.
TRIED: tuple[tuple[str, Numbers], ...] = (
    ("a gate of half the neighbours' spread", {"gate_spreads": 0.5}),
    ("a gate of 1.5 deviations", {"gate_deviations": 1.5}),
    ("no gate for patches that fit very well (ZNCC of both levels above .85)",
     {"distinctive_zncc": 0.85, "distinctive_inliers": 0, "distinctive_margin": ALWAYS}),
    ("three times the weight of lost contrast against visibility (smoke, water)",
     {"weigh_dim": -1.83}),
    ("three times the weight of a covered middle against visibility (tools)",
     {"weigh_centre": 1.35, "weigh_one": 1.11}),
    ("twice the weight of the neighbours beside the patch (faint tissue)",
     {"min_own_motion": 0.1, "own_motion_of_deviation": 0.15}),
    ("half the weight of the coarser level's position (faint tissue)",
     {"coarse_information": 0.3}),
    ("half the brightness makes a highlight", {"highlight": 0.2}),
    ("searching for hidden supporting points in every fourth frame only", {"search_every": 4}),
)
# Not a tracker: the share that is right here limits what any decision about visibility could claim
# of the same positions.
BOUND: tuple[tuple[str, Numbers], ...] = (("every point claimed in every frame", {"claim_all": 1}),)


def refuse(message: object) -> typing.NoReturn:
    sys.exit(f"ablation: {message}")


def check() -> None:
    """Ends the command unless every number is csd's, and none is set to the value that it has."""
    defaults = dict(re.findall(r"^  double (\w+) =\s+([^;]+);", TUNING.read_text(), re.M))
    for name, numbers in PARTS + TRIED + BOUND:
        for number, value in numbers.items():
            if number not in defaults:
                refuse(f"{name}: {TUNING.relative_to(ROOT)} has no number {number}")
            if defaults[number] == str(value):
                refuse(f"{name}: {number} is {value} anyway")


def settings(numbers: Numbers) -> list[str]:
    return [word for number, value in numbers.items() for word in ("--set", f"{number}={value:g}")]


def run(command: Sequence[object]) -> str:
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        refuse(f"{command[0]} failed:\n{(done.stdout + done.stderr)[-2000:]}")
    return done.stdout


def scores(numbers: Numbers, options: argparse.Namespace,
           sequences: Sequence[str]) -> dict[str, Pair]:
    """Sensitivity and K of each sequence, means over the seeds."""
    def measure(sequence: str) -> tuple[str, Pair]:
        rows = run([
            builds.program("csd-accuracy"), *settings(numbers), "--seeds", options.seeds,
            "--frames", options.frames, "--keep", options.keep, sequence
        ]).splitlines()[1:]
        values = [tuple(map(float, row.split()[3:5])) for row in rows]
        if not values:
            refuse(f"csd-accuracy has no row for {sequence}")
        return sequence, tuple(statistics.fmean(column) for column in zip(*values))

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(pool.map(measure, sequences))


def palindromes(numbers: Numbers, clips: Sequence[pathlib.Path]) -> dict[str, Pair]:
    """The shares that are claimed and apart, of real clips played forward and backward."""
    text = run([builds.program("bench-clips"), *settings(numbers), *clips])
    rows = [row.split() for row in text.splitlines()[1:]]
    return {row[0]: tuple(map(float, row[4:6])) for row in rows}


def once(results: pathlib.Path, known: dict[str, dict[str, Pair]], program: str, key: str,
         measure: Callable[[], dict[str, Pair]]) -> dict[str, Pair]:
    """measure(), or its known result if this very program was measured before.

    `results`: the file of what is known. So an interrupted command goes on where it was.
    """
    key = f"{builds.fingerprint(program)} {key}"
    if key not in known:
        known[key] = measure()
        page.replace(results, json.dumps(known))
    return known[key]


def number(value: float, signed: bool = False) -> str:
    if math.isnan(value):
        return "–"
    text = f"{value:+.3f}" if signed else f"{value:.3f}"
    return page.minus(text.replace("0.", "."))


def cell(found: Pair, whole: Pair) -> str:
    differences = [a - b for a, b in zip(found, whole)]
    return " / ".join("·" if abs(d) < 0.0005 else number(d, True) for d in differences)


def legend() -> str:
    """The numbered parts; their names as columns would make the table too wide."""
    groups = (("Without", PARTS), ("Tried and not kept:", TRIED), ("A bound, no tracker:", BOUND))
    count, text = 0, ""
    for heading, changes in groups:
        text += f"{heading}\n\n"
        for name, _ in changes:
            count += 1
            text += f"{count}. {name}\n"
        text += "\n"
    return text


def table(what: str, found: Found, names: Sequence[str]) -> str:
    whole = found[None]
    changes = [change for change in found if change]
    rows = [[
        name, " / ".join(map(number, whole[name])),
        *(cell(found[change][name], whole[name]) for change in changes)
    ] for name in names]
    return page.table([what, "csd", *map(str, range(1, len(changes) + 1))], rows, keys=2)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="tests/bench/ablation", formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__, epilog="""
csd-accuracy and bench-clips run with csd's numbers (core/csd/tuning.h) set, part by part. Rendered
sequences stay in DIR, half a megabyte a frame: 5 GB. The tables go to standard output: sensitivity
/ K with all parts, and what changes without one of them, or with one of the designs that were tried
and not kept. With the clips ($CSDTRACK_CLIPS, else ../shared/clips) and ffmpeg there are sequences
with real tissue as texture too, and more tables: what is claimed of the clips played forward and
backward, and what of it is apart (docs/metrics.md). Takes some twenty minutes on two cores. After
an interruption the same command goes on where it was.""")
    parser.add_argument("--write", action="store_true", help="write docs/results/ablation.md")
    parser.add_argument("--check", action="store_true",
                        help="only check that csd has the numbers that this command sets")
    parser.add_argument("--seeds", default=SEEDS, metavar="A-B", help=f"of the scenes ({SEEDS})")
    parser.add_argument("--frames", type=int, default=FRAMES, metavar="N",
                        help=f"of each scene ({FRAMES})")
    parser.add_argument("--keep", type=pathlib.Path, metavar="DIR",
                        help="where rendered sequences are kept (a folder in build/ablation, "
                        "another for each state of core/sim)")
    parser.add_argument("sequences", nargs="*", metavar="SEQUENCE", help="of csd-accuracy (all)")
    return parser.parse_args()


def folder_of_sequences() -> pathlib.Path:
    """Where sequences are kept that the present simulator renders."""
    files = run(["git", "-C", ROOT, "ls-files", "-s", "core/sim"]).splitlines()
    simulator = "".join([*sorted(files), (ROOT / "tests/bench/sequences.cpp").read_text()])
    digest = hashlib.sha256(simulator.encode()).hexdigest()
    return ROOT / "build" / "ablation" / f"sequences-{digest[:12]}"


def main() -> None:
    options = parse()
    check()
    if options.check:
        return
    if options.write and (options.seeds, options.frames, options.sequences) != (SEEDS, FRAMES, []):
        refuse("--write is for the page as it describes itself: "
               "no other --seeds, --frames or SEQUENCE")
    try:
        builds.make(False, ("csd-accuracy", "bench-clips"), commands=())
    except Failure as failure:
        refuse(failure)
    os.environ.setdefault("CSDTRACK_CLIPS", str(ROOT.parent / "shared" / "clips"))
    if not pathlib.Path(os.environ["CSDTRACK_CLIPS"]).is_dir():
        del os.environ["CSDTRACK_CLIPS"]
    if not options.keep:
        options.keep = folder_of_sequences()
    options.keep.mkdir(parents=True, exist_ok=True)
    clips = [pathlib.Path(os.environ.get("CSDTRACK_CLIPS", "/nowhere")) / clip for clip in CLIPS]
    clips = [clip for clip in clips if clip.exists() and not options.sequences]
    if options.write and len(clips) < len(CLIPS):
        refuse(f"--write wants all clips ($CSDTRACK_CLIPS): {', '.join(CLIPS)}")
    sequences = run([builds.program("csd-accuracy"), "--list", *options.sequences]).split()
    results = ROOT / "build" / "ablation" / "results.json"
    results.parent.mkdir(parents=True, exist_ok=True)
    known = json.loads(results.read_text()) if results.exists() else {}
    found: Found = {}
    real: Found = {}
    unchanged: tuple[tuple[str | None, Numbers], ...] = ((None, {}),)
    changes = unchanged + PARTS + TRIED + BOUND
    for i, (name, numbers) in enumerate(changes):
        print(f"{i} of {len(changes) - 1}: {name or 'csd'}", file=sys.stderr)
        key = f"{options.keep} {options.seeds} {options.frames} {sequences} {numbers}"
        found[name] = once(results, known, "csd-accuracy", key,
                           lambda: scores(numbers, options, sequences))
        if clips:
            real[name] = once(results, known, "bench-clips", f"{clips} {numbers}",
                              lambda: palindromes(numbers, clips))
    text = legend() + table("sensitivity / K", found, sequences)
    if clips:
        text += "\n" + table("claimed / apart", real, [clip.stem for clip in clips])
    print(text, end="")
    if options.write:
        page.write(page.RESULTS / "ablation.md", "What each part of csd contributes", ABOUT,
                   "tests/bench/ablation --write", builds.versions(), text)


if __name__ == "__main__":
    main()
