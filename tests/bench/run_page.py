# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes docs/results/benchmarks.md for tests/bench/run, which runs it with the file of its output
and its own options."""

import pathlib
import sys

from pipelines.experiments import builds, page

ABOUT = """What csdtrack costs on one machine with nothing else running. Nothing is asserted. Google
Benchmark's times are means. `bench-frames` and the pipelines print percentiles and medians of runs
in alternation. The picture is a swaying coloured texture, made before anything is timed. The speed
of a virtual machine varies by a third, between runs and within one: compare figures that stand
beside each other."""


def main() -> None:
    printed, options = sys.argv[1:]
    page.write(page.RESULTS / "benchmarks.md", "Benchmarks", ABOUT,
               f"tests/bench/run --write {options}".strip(), builds.versions(),
               f"```\n{pathlib.Path(printed).read_text().strip()}\n```")


if __name__ == "__main__":
    main()
