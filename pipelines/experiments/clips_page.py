# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes docs/results/clips.md for pipelines/experiments/clips, which runs it with the page and the
folder of the tables."""

import pathlib
import sys

from pipelines.experiments import builds, page

ABOUT = """Clips of real tissue, which are not part of this repository. All trackers begin at the
same features, which detection found without any tracker's preferences. Where `csd` chooses them
itself, it claims more and fewer claims are apart ([benchmarks.md](results/benchmarks.md), `clips`).
What `csd-2012` reaches elsewhere is in
[method.md](method.md#what-csd-2012-reaches-and-what-not)."""


def main() -> None:
    path, folder = map(pathlib.Path, sys.argv[1:])
    page.write(path, "Real clips", ABOUT, "pipelines/experiments/clips CLIPS", builds.versions(),
               f"""## Beads, by their truth

{(folder / "beads.md").read_text()}
## Palindromes

Rows are files of tracks, `VIDEO/TRACKER.jsonl`.

{(folder / "palindromes.md").read_text()}""")


if __name__ == "__main__":
    main()
