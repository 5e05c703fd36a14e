# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd on pictures of real tissue as textures: pipelines/experiments/beyond --tissue."""

import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys

import builds
import page
from experiment import guarded, natural, places

# title, what is to be reached
KINDS = json.loads(pathlib.Path(__file__).with_name("tissue.json").read_text())
SUFFIXES = (".png", ".jpg", ".mkv", ".mp4")  # that csd-accuracy takes
SEED, FRAMES, FEATURES = 101, 200, 80
ROW = re.compile(r"^(\w+)/(\S+) +\d+ +(\S+) +(\S+) +(\S+)(?: +\S+){4} +(\S+)", re.M)
BOUND = re.compile(r"from the truth: within 2 px ([\d.]+), within 5 px ([\d.]+)")
Result = collections.namedtuple("Result", "kind tissue within_2 sensitivity k ece bound")

EPILOG = f"""
Each picture, and the first frame of each video, of the folders becomes the texture of each kind of scene, is compressed as a recorder does (H.264, crf
23), and csd tracks {FEATURES} of its points. A table says what is reached in the mean and on the worst tissue, beside what is to be reached (tissue.json).
Rendered scenes stay in DIR, half a megabyte a frame: with fifty pictures 37 GB. That takes an hour; interrupted, it goes on where it was.
"""


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/experiments/beyond --tissue",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Runs csd on pictures of real tissue, and says what is reached on the worst.",
        epilog=EPILOG)
    parser.add_argument("--tissue", type=pathlib.Path, action="append", required=True,
                        metavar="DIR", help="a folder of pictures and videos; more than once")
    parser.add_argument("--quick", action="store_true",
                        help="20 frames of each; writes nothing into docs/")
    parser.add_argument("--jobs", type=natural, metavar="N", default=os.cpu_count(),
                        help="scenes at a time (the processors)")
    parser.add_argument(
        "--out", type=pathlib.Path, metavar="DIR", help=
        "where scenes and results are kept (experiments/tissue or experiments/tissue-quick in the build folder)"
    )
    parser.add_argument("--no-install", action="store_true",
                        help="install nothing; fail if something is missing")
    return parser.parse_args(arguments)


def check(folders):
    for folder in folders:
        if not folder.is_dir():
            raise builds.Failure(f"{folder} is no folder")
        if not any(file.suffix in SUFFIXES for file in folder.iterdir()):
            raise builds.Failure(f"{folder} holds no picture or video ({', '.join(SUFFIXES)})")


def accuracy(*arguments):
    done = subprocess.run([builds.program("csd-accuracy"), *map(str, arguments)],
                          capture_output=True, text=True)
    if done.returncode:
        raise builds.Failure(done.stderr.strip().splitlines()[-1] if done.stderr.strip(
        ) else f"csd-accuracy ended with {done.returncode}")
    return done.stdout


def each(work, of, known, kept, jobs, say):
    """[of(w) for w in work], `jobs` at a time. After each, say(how many are done, its result), and `known`, to which of() adds, is written to `kept`,
    whole or not at all."""
    results = []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        try:
            for done, result in enumerate(pool.map(of, work), 1):
                results.append(result)
                say(done, result)
                os.replace(page.aside(kept, json.dumps(known)), kept)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return results


def measure(options, out, frames):
    """A Result for each scene, those of an earlier run of the same program among them."""
    folders = [word for folder in options.tissue for word in ("--tissue", folder)]
    scenes = accuracy(*folders, "--list").split()
    kept = out / "results.json"
    known = json.loads(kept.read_text()) if kept.exists() else {}
    program = builds.fingerprint("csd-accuracy")

    def of(scene):
        key = f"{program} {list(map(str, options.tissue))} {frames} {scene}"
        if key not in known:
            known[key] = accuracy(*folders, "--seeds", SEED, "--frames", frames, "--features",
                                  FEATURES, "--keep", out, "--bound", scene)
        # A scene's name may begin another's.
        row = next(row for row in ROW.finditer(known[key]) if f"{row[1]}/{row[2]}" == scene)
        bound = BOUND.search(known[key], row.end())
        return Result(row[1], row[2], *map(float, row.groups()[2:]), float(bound[2]))

    def say(done, result):
        print(
            f"{done} of {len(scenes)}: {result.kind}/{result.tissue} {result.sensitivity:.4f} / {result.k:.4f}",
            file=sys.stderr)
    return each(scenes, of, known, kept, options.jobs, say)


def mean(results, field):
    return sum(getattr(result, field) for result in results) / len(results)


ABOUT = """Pictures of real tissue, which no number of `csd`'s was chosen on but those that [method.md](method.md) names, are the textures of
simulated scenes, compressed as recorders do (H.264, crf 23): 640×480, {frames} frames, {features} features, seed {seed}. The folders are pictures and the first frames of clips of
operations, which are not part of this repository: any folder of pictures or videos will do. *From the truth* is no tracker: the share of visible samples that a patch finds within 5 px when it is looked for from its
true place, in its true shape (csd-accuracy --bound). What is below that is `csd`'s to find by patches alone; to find more, neighbours must know better."""


def tables(results):
    by_kind = collections.defaultdict(list)
    for result in results:
        by_kind[result.kind].append(result)
    rows = []
    for kind, of_kind in by_kind.items():
        goal = KINDS[kind]
        worst = min(of_kind, key=lambda result: result.sensitivity - result.k)
        reached = (mean(of_kind, "sensitivity") >= goal["sensitivity"] and
                   mean(of_kind, "k") <= goal["k"] and worst.sensitivity >= goal["worst"] and
                   mean(of_kind, "within_2") >= goal.get("within_2", 0))
        two = f"; within 2 px ≥ {goal['within_2']}" if "within_2" in goal else ""
        rows.append([
            goal["title"],
            str(len(of_kind)),
            f"≥ {goal['sensitivity']} / ≤ {goal['k']}; worst ≥ {goal['worst']}{two}",
            f"{mean(of_kind, 'sensitivity'):.4f} / {mean(of_kind, 'k'):.4f}",
            f"{mean(of_kind, 'within_2'):.4f}", f"{mean(of_kind, 'ece'):.4f}",
            f"{worst.sensitivity:.4f} / {worst.k:.4f}, {worst.tissue}",
            f"{mean(of_kind, 'bound'):.4f}", "**reached**" if reached else "not reached"
        ])
    worst = sorted(results, key=lambda result: result.sensitivity - result.k)[:12]
    text = page.table([
        "scene", "tissues", "to reach: sensitivity / K", "sensitivity / K", "within 2 px", "ECE",
        "worst tissue", "from the truth", ""
    ], rows)
    text += "\nThe worst of all:\n\n" + page.table(
        ["scene", "tissue", "sensitivity / K", "within 2 px", "from the truth"], [[
            KINDS[r.kind]["title"], r.tissue, f"{r.sensitivity:.4f} / {r.k:.4f}",
            f"{r.within_2:.4f}", f"{r.bound:.4f}"
        ] for r in worst])
    return text


def main(arguments):
    options = parse(arguments)
    _, out, path = places("tissue", options)
    frames = 20 if options.quick else FRAMES

    def work():
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
    return guarded("beyond", out, work)
