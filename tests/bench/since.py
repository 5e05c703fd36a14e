# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shows what changed in the measured code since the figures in docs/ were measured."""

import argparse
import pathlib
import re
import signal
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]
# The code that each page measures.
CSD = ("core/csd/", "core/patch", "core/detect", "core/image", "core/content", "core/track",
       "core/base", "core/score", "core/sim")
PAPER = ("core/csd2012/", "core/baselines", *CSD)
PAGES = (("results/beyond.md", CSD), ("results/beyond-clips.md", CSD), ("results/tissue.md", CSD),
         ("results/choices.md", PAPER), ("results/paper.md", PAPER), ("results/clips.md", PAPER),
         ("results/ablation.md", CSD), ("results/benchmarks.md", PAPER), ("pipelines.md", CSD))
MOST = 6  # files that are named
COMMIT = re.compile(r"csdtrack(?: \|)? ([0-9a-f]{7,40})\b")


def git(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True)


def new_name(name: str) -> str:
    """The new name of a file that git writes as a/{old => new}/b."""
    return re.sub(r"\{.* => (.*)\}", r"\1", name).replace("//", "/").split(" => ")[-1]


def changed(commit: str, rooms: tuple[str, ...]) -> str:
    """The files that changed and how many of their lines, in words."""
    done = git("diff", "--numstat", "-M", commit, "--", "core")
    if done.returncode:
        return "this repository doesn't have that commit"
    found = []
    for line in done.stdout.splitlines():
        added, taken, name = line.split("\t")
        name, lines = new_name(name), int(added) + int(taken)
        if lines and name.startswith(rooms) and not name.endswith("meson.build"):
            found.append((lines, name))
    found.sort(reverse=True)
    named, others = found[:MOST], found[MOST:]
    text = "; ".join(f"{name} {lines}" for lines, name in named) or "nothing"
    if others:
        text += f"; and {sum(lines for lines, _ in others)} lines in {len(others)} others"
    return text


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="tests/bench/since", formatter_class=argparse.RawDescriptionHelpFormatter,
        description=__doc__, epilog="""
Prints a line for each page: the commit that it was measured at, and the files that differ now in
the rooms of core/ that it measures, with how many lines were added or taken out. How the change
affects the figures is for the reader to judge.""")
    parser.parse_args()
    for page, rooms in PAGES:
        found = COMMIT.search((ROOT / "docs" / page).read_text())
        change = f"{found[1]}: {changed(found[1], rooms)}" if found else "no commit is named"
        print(f"{page}: {change}")


if __name__ == "__main__":
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # for `since | head`
    main()
