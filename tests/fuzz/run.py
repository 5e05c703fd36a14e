# SPDX-License-Identifier: LGPL-2.1-or-later
"""Fuzzes what csdtrack reads, with libFuzzer under the address and undefined-behaviour sanitizers.

Without options, for tests/more: runs every seed and regression, then some thousand more inputs for
each target. Prints what each target did. A finding ends with exit code 1, and its input is in the
build folder's findings/.
"""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import typing
from collections.abc import Iterable

HERE = pathlib.Path(__file__).resolve().parent

# What each target reads, and the dictionary it is mutated with.
PARSERS = {
    "points": "numbers",
    "region": "numbers",
    "effects": "effects",
    "line": "line",
    "lines": "line",
    "truth": "table",
    "score": "table",
    "motion": "table",
}
ELEMENTS = {
    "csdtrackenc": "",
    "csdtrackdec": "line",
    "csdtrack_frames": "",
    "csdtrack_sequence": "",
    "texture": "",
    "csdsimsrc": "",
}
# The faults that can be planted (CSDTRACK_FUZZ_PLANT), and the message of each when it is found.
FAULTS = {
    "read": "AddressSanitizer: heap-buffer-overflow", "critical": "csdtrack-CRITICAL",
    "leak": "LeakSanitizer: detected"
}
TARGETS = PARSERS | ELEMENTS

# Executions of a parser (True) or an element, and seconds after which a target ends anyway.
SHORT = {True: (20000, 4), False: (300, 4)}
LONG = {True: (1000000, 21600), False: (100000, 21600)}


class Row(typing.NamedTuple):
    """What a target did."""

    target: str
    executions: int
    seconds: int
    findings: int
    covered: str
    kept: int


def program(build: pathlib.Path, target: str) -> pathlib.Path:
    return build / "tests" / "fuzz" / f"fuzz-{target}"


def command(build: pathlib.Path, target: str, folders: Iterable[pathlib.Path], runs: int,
            seconds: int, seed: int) -> list[str]:
    findings = build / "findings"
    findings.mkdir(exist_ok=True)
    arguments = [
        str(program(build, target)), f"-runs={runs}", f"-max_total_time={seconds}", f"-seed={seed}",
        f"-artifact_prefix={findings}/{target}-", "-print_final_stats=1", "-timeout=20",
        "-verbosity=1"
    ]
    if target in ELEMENTS:
        # Long from the beginning: a short input is a frame at most. -entropic=0: counting rare
        # features takes a third of the time with so many edges.
        arguments += ["-len_control=0", "-max_len=800", "-entropic=0"]
    if TARGETS[target]:
        arguments.append(f"-dict={HERE / 'dictionaries' / TARGETS[target]}.dict")
    return arguments + [str(folder) for folder in folders]


def number(pattern: str, text: str) -> int:
    """The last number that the pattern finds; 0 if there is none."""
    found = re.findall(pattern, text)
    return int(found[-1]) if found else 0


def fuzz(build: pathlib.Path, target: str,
         options: argparse.Namespace) -> tuple[Row, str | None]:
    """Runs a target. Returns its row of the table, and its output if there is a finding."""
    runs, seconds = (LONG if options.long else SHORT)[target in PARSERS]
    # A long run begins with what the last one found. A short one is the same each time.
    found = build / ("corpus" if options.long else "short") / target
    if not options.long:
        shutil.rmtree(found, ignore_errors=True)
    found.mkdir(parents=True, exist_ok=True)
    begun = time.monotonic()
    done = subprocess.run(
        command(build, target, [found, HERE / "corpus" / target], runs,
                options.seconds or seconds, options.seed),
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    text = done.stdout.decode(errors="replace")
    edges, covered = number(r"\((\d+) inline 8-bit counters\)", text), number(r" cov: (\d+)", text)
    row = Row(target, number(r"number_of_executed_units: *(\d+)", text),
              round(time.monotonic() - begun), int(done.returncode != 0), f"{covered} of {edges}",
              number(r" corp: (\d+)/", text))
    return row, text if done.returncode else None


def plant(build: pathlib.Path, target: str, fault: str) -> bool:
    """Whether a fault that is planted into a target is found."""
    seeds = sorted((HERE / "corpus" / target).iterdir())
    findings = build / "planted"
    findings.mkdir(exist_ok=True)
    done = subprocess.run(
        [str(program(build, target)), f"-artifact_prefix={findings}/", *map(str, seeds)],
        env=os.environ | {"CSDTRACK_FUZZ_PLANT": fault}, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, check=False)
    text = done.stdout.decode(errors="replace")
    good = done.returncode != 0 and FAULTS[fault] in text
    if not good:
        print(f"error: {target}: the planted fault '{fault}' is no finding:\n{text[-2000:]}")
    return good


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="tests/fuzz/run", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--long", action="store_true",
                        help="10^6 executions of a parser, 10^5 of an element: hours")
    parser.add_argument("--seconds", type=int,
                        help="end each target after so many, even with fewer executions")
    parser.add_argument("--planted", action="store_true",
                        help="only show that planted faults are found")
    parser.add_argument("--build", type=pathlib.Path, default=HERE.parent.parent / "build-asan",
                        help="built by tests/more fuzz")
    parser.add_argument("--seed", type=int, default=1, help="of the mutations (1)")
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=" ".join(TARGETS))
    options = parser.parse_args()
    unknown = set(options.targets) - set(TARGETS)
    if unknown:
        parser.error("no target " + " ".join(sorted(unknown)))
    return options


def plant_all(build: pathlib.Path, targets: Iterable[str]) -> bool:
    """Whether each fault that can be planted into these targets is found."""
    faults = [(target, fault) for target in targets for fault in FAULTS
              if target in ELEMENTS or fault == "read"]
    # texture ignores the decoders' criticals.
    faults = [each for each in faults if each != ("texture", "critical")]
    found = [plant(build, *each) for each in faults]
    print(f"{sum(found)} of {len(found)} planted faults found")
    return all(found)


def show_finding(build: pathlib.Path, target: str, report: str) -> None:
    """Keeps the report and prints the lines of it that name our code."""
    path = build / "findings" / f"{target}.log"
    path.write_text(report)
    ours = [
        line for line in report.splitlines()
        if re.search(r"ERROR|SUMMARY|runtime error|CRITICAL|^ *#\d+ .*\.\./(core|gst|tests/fuzz)/",
                     line)
    ]
    print("\n".join([f"error: {target}: {path}", *ours[:20]]), flush=True)


def main() -> int:
    options = parse()
    targets = options.targets or list(TARGETS)
    missing = [target for target in targets if not program(options.build, target).exists()]
    if missing:
        sys.exit(f"error: not built: {' '.join(missing)}; tests/more fuzz builds them")

    if options.planted:
        return 0 if plant_all(options.build, targets) else 1

    bad = 0
    print("| target | executions | seconds | findings | edges covered | inputs kept |\n"
          "|---|---|---|---|---|---|", flush=True)
    for target in targets:
        row, report = fuzz(options.build, target, options)
        print(f"| {' | '.join(map(str, row))} |", flush=True)
        if report is not None:
            bad += 1
            show_finding(options.build, target, report)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
