# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures what each optimisation brought: csd's time a frame at commits of the past, and which
functions it is spent in, then and now."""

import argparse
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import typing
from collections.abc import Sequence

from pipelines.experiments import builds, page
from pipelines.experiments.builds import ROOT

ABOUT = """Each step and the commit before it, run in turns on one simulated sequence (640×480, 100
features): median times, and the median change between neighbouring runs. One step cost time and was
kept for those that build on it. Then the functions in which the whole program spends its time (it
also reads frames and scores), at the first and the last of these commits."""
FIRST = "289f8dc"  # csd, whole, in plain C++
# What was done; the commit with it; the one before.
STEPS = (
    ("alignment on SIMD, a tile of the picture for each pass", "2794d10", "879d4d6"),
    ("pyramid and highlights' weights on SIMD", "977d0ce", "2794d10"),
    ("sums of the normal matrix four at a time; masked patches at nearly the price of clear ones",
     "af24242", "8ccb29f"),
    ("a new anchor's medians in 16 bit, compared when they are sampled", "aed4380", "aed4380^"),
    ("a patch's tile filled in one go", "b12e468", "b12e468^"),
    ("a coarse pass ends when a tenth of a sample is left to go", "0af3178", "0af3178^"),
    ("no coarse level for what moves as it did, maps that end when settled; "
     "with it twice the supporting points", "9055a89", "9055a89^"),
    ("new supporting points ask only those near them for their distance", "5b5b3de", "5b5b3de^"),
    ("half of the calm supporting points rest", "bc329dd", "bc329dd^"),
)
SEQUENCE, FRAMES, ROUNDS, SYMBOLS = "deformation-heart", 300, 5, 12

Command = Sequence[object]


def refuse(message: object) -> typing.NoReturn:
    sys.exit(f"history: {message}")


def run(command: Command) -> str:
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        refuse(f"{' '.join(map(str, command[:3]))} failed:\n{(done.stdout + done.stderr)[-2000:]}")
    return done.stdout


def sha(commit: str) -> str:
    found = subprocess.run(
        ["git", "rev-parse", "--short=10", "--verify", "--quiet", f"{commit}^{{commit}}"], cwd=ROOT,
        capture_output=True, text=True)
    if found.returncode:
        refuse(f"there is no commit {commit} here: this needs the whole history, "
               "not a shallow clone (git fetch --unshallow)")
    return found.stdout.strip()


def program(commit: str, folder: pathlib.Path) -> pathlib.Path:
    """csd-accuracy, built at this commit."""
    source, build = folder / commit, folder / commit / "build"
    path = build / "tests" / "bench" / "csd-accuracy"
    if not path.exists():
        shutil.rmtree(source, ignore_errors=True)
        source.mkdir(parents=True)
        archive = subprocess.run(["git", "archive", commit], cwd=ROOT, capture_output=True,
                                 check=True).stdout
        subprocess.run(["tar", "-x", "-C", source], input=archive, check=True)
        run([
            "meson", "setup", build, source, "-Dtests=disabled", "-Dbenchmarks=enabled",
            "-Dwerror=false"
        ])
        run(["ninja", "-C", build, "tests/bench/csd-accuracy"])
    return path


def command(path: pathlib.Path, keep: pathlib.Path) -> Command:
    return [
        path, "--algorithm", "csd", "--frames", FRAMES, "--seeds", "1", "--keep", keep, SEQUENCE
    ]


def milliseconds(path: pathlib.Path, keep: pathlib.Path) -> float:
    return float(run(command(path, keep)).splitlines()[-1].split()[-1])


def beside(before: pathlib.Path, after: pathlib.Path,
           keep: pathlib.Path) -> tuple[float, float, float]:
    """Median ms a frame of two programs, run in turns, and the median ratio of neighbouring
    runs."""
    pairs = [(milliseconds(before, keep), milliseconds(after, keep)) for _ in range(ROUNDS)]
    return (statistics.median(a for a, _ in pairs), statistics.median(b for _, b in pairs),
            statistics.median(b / a for a, b in pairs))


def profile(path: pathlib.Path, keep: pathlib.Path,
            folder: pathlib.Path) -> list[tuple[float, str]]:
    """The functions with the largest shares of the program's time; [] without perf."""
    if not shutil.which("perf"):
        return []
    data = folder / "perf.data"
    run(["perf", "record", "-q", "-F", "1997", "-o", data, "--", *command(path, keep)])
    rows = run(
        ["perf", "report", "-i", data, "--stdio", "-F", "overhead,sym", "--percent-limit", "0.3"])
    found = re.findall(r"^\s*([\d.]+)%\s+\[\.\]\s+(.+?)\s*$", rows, re.M)
    if not found:
        refuse(f"perf saw nothing: see 'perf report -i {data}'")
    return [(float(share) / 100, plain(name)) for share, name in found[:SYMBOLS]]


def plain(name: str) -> str:
    """A symbol without its arguments, templates and outer namespaces."""
    name = re.sub(r"\[clone [^]]*\]", "", name)
    while (shorter := re.sub(r"<[^<>]*>|\([^()]*\)", "", name)) != name:
        name = shorter
    if not name.split():
        return name
    parts = name.split()[-1].split("::")
    return "::".join([part for part in parts if part not in ("csd", "{anonymous}", "")][-2:])


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="tests/bench/history", formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__, epilog=f"""
Builds csd-accuracy at {1 + 2 * len(STEPS)} commits, in build/history (2 GB), and runs it on one
rendered sequence: each commit of an optimisation and the one before in turns, {ROUNDS} times. With
perf (Debian: linux-perf), also prints the shares of the functions. Takes some 15 minutes; nothing
else should run.""")
    parser.add_argument("--write", action="store_true", help="write docs/results/history.md")
    return parser.parse_args()


def measure(programs: dict[str, pathlib.Path], commits: dict[str, str],
            folder: pathlib.Path) -> str:
    """The tables. commits: the full names of those in STEPS; programs: by full name."""
    keep = folder / "sequence"
    keep.mkdir(exist_ok=True)
    milliseconds(programs[commits["HEAD"]], keep)  # renders the sequence
    rows = []

    def compare(what: str, before: str, after: str) -> tuple[float, float]:
        was, now, ratio = beside(programs[commits[before]], programs[commits[after]], keep)
        change = page.minus(f"{100 * (ratio - 1):+.0f} %")
        rows.append([what, f"`{commits[after]}`", f"{was:.2f}", f"{now:.2f}", change])
        return was, now

    for i, (what, after, before) in enumerate(STEPS, 1):
        print(f"{i} of {len(STEPS)}: {what}", file=sys.stderr)
        compare(what, before, after)
    was, now = compare("all, from plain C++ on", FIRST, "HEAD")
    text = page.table(["what", "commit", "ms a frame before", "after", "change"], rows)
    for title, commit, time in (("Before, in plain C++", FIRST, was), ("Now", "HEAD", now)):
        if shares := profile(programs[commits[commit]], keep, folder):
            functions = [[f"{100 * share:.0f} %", f"`{name}`"] for share, name in shares]
            text += f"\n{title} (`{commits[commit]}`, {time:.2f} ms a frame):\n\n"
            text += page.table(["share", "function"], functions)
    return text


def main() -> None:
    options = parse()
    folder = ROOT / "build" / "history"
    names = [FIRST, *(commit for _, *pair in STEPS for commit in pair), "HEAD"]
    commits = {name: sha(name) for name in names}
    programs = {}
    for i, commit in enumerate(dict.fromkeys(commits.values()), 1):
        print(f"building {i} of {len(set(commits.values()))}: {commit}", file=sys.stderr)
        programs[commit] = program(commit, folder)
    text = measure(programs, commits, folder)
    print(text, end="")
    if options.write:
        page.write(page.RESULTS / "history.md", "What made csd fast", ABOUT,
                   "tests/bench/history --write", builds.versions(), text)


if __name__ == "__main__":
    main()
