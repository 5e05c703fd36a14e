# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd on pictures of real tissue as textures: pipelines/experiments/beyond --tissue."""

import argparse
import collections
import concurrent.futures
import json
import pathlib
import re
import statistics
import subprocess
import sys
import typing
from collections.abc import Callable, Iterable, Sequence

from pipelines.experiments import builds, page
from pipelines.experiments.experiment import add_runs, exit_code, places
from pipelines.lib.failure import Failure

# Title and goals of each kind of scene.
KINDS = json.loads(pathlib.Path(__file__).with_name("tissue.json").read_text())
SUFFIXES = (".png", ".jpg", ".mkv", ".mp4")  # that csd-accuracy takes
SEED, FRAMES, FEATURES = 101, 200, 80
ROW = re.compile(r"^(\w+)/(\S+) +\d+ +(\S+) +(\S+) +(\S+)(?: +\S+){4} +(\S+)", re.M)
BOUND = re.compile(r"from the truth: within 2 px ([\d.]+), within 5 px ([\d.]+)")
WORST = 12  # scenes in the table of the worst

EPILOG = f"""
Each picture, and the first frame of each video, becomes the texture of each kind of scene. The
scene is compressed as recorders do (H.264, crf 23), and csd tracks {FEATURES} of its points. A
table has the mean over the tissues and the worst tissue, beside the goals (tissue.json). Rendered
scenes stay in DIR, half a megabyte a frame: 37 GB with fifty pictures. Those take an hour. After an
interruption the same command goes on where it was.
"""

Work = typing.TypeVar("Work")
Measured = typing.TypeVar("Measured")


class Result(typing.NamedTuple):
    kind: str
    tissue: str
    within_2: float
    sensitivity: float
    k: float
    ece: float
    bound: float


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/experiments/beyond --tissue",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Runs csd on pictures of real tissue, and says which goals it reaches.",
        epilog=EPILOG)
    parser.add_argument("--tissue", type=pathlib.Path, action="append", required=True,
                        metavar="DIR", help="a folder of pictures and videos; may be repeated")
    parser.add_argument("--quick", action="store_true",
                        help="20 frames of each; writes nothing into docs/")
    add_runs(parser, "tissue")
    return parser.parse_args(arguments)


def check(folders: Iterable[pathlib.Path]) -> None:
    for folder in folders:
        if not folder.is_dir():
            raise Failure(f"{folder} is no folder")
        if not any(file.suffix in SUFFIXES for file in folder.iterdir()):
            raise Failure(f"{folder} holds no picture or video ({', '.join(SUFFIXES)})")


def accuracy(*arguments: object) -> str:
    """The output of csd-accuracy."""
    done = subprocess.run([builds.program("csd-accuracy"), *map(str, arguments)],
                          capture_output=True, text=True)
    if done.returncode:
        messages = done.stderr.strip().splitlines()
        raise Failure(messages[-1] if messages else f"csd-accuracy ended with {done.returncode}")
    return done.stdout


def measure_all(work: Sequence[Work], measure: Callable[[Work], Measured],
                known: dict[str, typing.Any], kept: pathlib.Path, jobs: int,
                say: Callable[[int, Measured], None]) -> list[Measured]:
    """Measures each piece of work, `jobs` at a time.

    measure() adds to `known`, which is written to `kept` after each piece, whole or not at all.
    say() gets the number of finished pieces and the result of the last.
    """
    results = []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        try:
            for done, result in enumerate(pool.map(measure, work), 1):
                results.append(result)
                say(done, result)
                page.replace(kept, json.dumps(known))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return results


def measure(options: argparse.Namespace, out: pathlib.Path, frames: int) -> list[Result]:
    """The result of each scene; those that this very program measured before are kept."""
    folders = [word for folder in options.tissue for word in ("--tissue", folder)]
    scenes = accuracy(*folders, "--list").split()
    kept = out / "results.json"
    known = json.loads(kept.read_text()) if kept.exists() else {}
    program = builds.fingerprint("csd-accuracy")

    def measure_scene(scene: str) -> Result:
        key = f"{program} {list(map(str, options.tissue))} {frames} {scene}"
        if key not in known:
            known[key] = accuracy(*folders, "--seeds", SEED, "--frames", frames, "--features",
                                  FEATURES, "--keep", out, "--bound", scene)
        row = ROW.search(known[key])
        assert row
        within_2, sensitivity, k, ece = map(float, row.groups()[2:])
        bound = BOUND.search(known[key], row.end())
        assert bound
        return Result(row[1], row[2], within_2, sensitivity, k, ece, float(bound[2]))

    def say(done: int, result: Result) -> None:
        print(f"{done} of {len(scenes)}: {result.kind}/{result.tissue} "
              f"{result.sensitivity:.4f} / {result.k:.4f}", file=sys.stderr)

    return measure_all(scenes, measure_scene, known, kept, options.jobs, say)


def mean(results: Sequence[Result], field: str) -> float:
    return statistics.fmean(getattr(result, field) for result in results)


def quality(result: Result) -> float:
    return result.sensitivity - result.k


ABOUT = """The textures of these simulated scenes are pictures of real tissue. None of `csd`'s
numbers was chosen on them, except those that [method.md](method.md) names. The scenes are
compressed as recorders do (H.264, crf 23): 640×480, {frames} frames, {features} features, seed
{seed}. The folders hold pictures, and clips of operations, whose first frames are used. They are
not part of this repository: any folder of pictures or videos will do. *From the truth* is no
tracker: it is the share of visible samples that a patch finds within 5 px if the search begins at
its true place, with its true shape (csd-accuracy --bound). Up to that share `csd` could find points
by their patches alone; to find more, it needs the neighbours."""


def row_of_kind(kind: str, results: Sequence[Result]) -> list[str]:
    goal = KINDS[kind]
    worst = min(results, key=quality)
    reached = (mean(results, "sensitivity") >= goal["sensitivity"] and
               mean(results, "k") <= goal["k"] and worst.sensitivity >= goal["worst"] and
               mean(results, "within_2") >= goal.get("within_2", 0))
    within_2 = f"; within 2 px ≥ {goal['within_2']}" if "within_2" in goal else ""
    return [
        goal["title"],
        str(len(results)),
        f"≥ {goal['sensitivity']} / ≤ {goal['k']}; worst ≥ {goal['worst']}{within_2}",
        f"{mean(results, 'sensitivity'):.4f} / {mean(results, 'k'):.4f}",
        f"{mean(results, 'within_2'):.4f}",
        f"{mean(results, 'ece'):.4f}",
        f"{worst.sensitivity:.4f} / {worst.k:.4f}, {worst.tissue}",
        f"{mean(results, 'bound'):.4f}",
        "**reached**" if reached else "not reached",
    ]


def tables(results: Sequence[Result]) -> str:
    by_kind = collections.defaultdict(list)
    for result in results:
        by_kind[result.kind].append(result)
    text = page.table([
        "scene", "tissues", "to reach: sensitivity / K", "sensitivity / K", "within 2 px", "ECE",
        "worst tissue", "from the truth", ""
    ], [row_of_kind(kind, of_kind) for kind, of_kind in by_kind.items()])
    text += "\nThe worst of all:\n\n" + page.table(
        ["scene", "tissue", "sensitivity / K", "within 2 px", "from the truth"],
        [[
            KINDS[r.kind]["title"], r.tissue, f"{r.sensitivity:.4f} / {r.k:.4f}",
            f"{r.within_2:.4f}", f"{r.bound:.4f}"
        ] for r in sorted(results, key=quality)[:WORST]])
    return text


def main(arguments: Sequence[str]) -> int:
    options = parse(arguments)
    _, out, path = places("tissue", options)
    frames = 20 if options.quick else FRAMES

    def write() -> pathlib.Path:
        check(options.tissue)
        builds.make(not options.no_install, ("csd-accuracy",), commands=("ffmpeg",))
        out.mkdir(parents=True, exist_ok=True)
        results = measure(options, out, frames)
        folders = " ".join(f"--tissue {folder.name}" for folder in options.tissue)
        page.write(path, "csd on real tissue as texture",
                   ABOUT.format(frames=frames, features=FEATURES, seed=SEED),
                   f"pipelines/experiments/beyond {folders}{' --quick' if options.quick else ''}",
                   builds.versions(), tables(results))
        return path

    return exit_code("beyond", out, write)
