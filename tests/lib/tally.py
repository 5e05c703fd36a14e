#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts what `meson test` did, from the files that it leaves.

usage: tally.py LOGS [NAME]

LOGS is the build's meson-logs folder; NAME is the name of the test setup, if one was used. Prints
"passed failed skipped" in one line, and the name of each failed test in the lines after it.

A test program that reports its cases (GoogleTest, TAP) counts by cases, any other as one. A program
that failed without naming a failed case (a crash, a time-out) counts as one failure.
"""

import json
import pathlib
import re
import sys
import typing
import xml.etree.ElementTree as xml

BAD = ("FAIL", "TIMEOUT", "ERROR", "INTERRUPT", "UNEXPECTEDPASS")


class Cases(typing.NamedTuple):
    passed: int
    failed: list[str]  # their names
    skipped: int


def cases(junit: pathlib.Path) -> dict[str, Cases]:
    """The cases of each program that reported its own, by the name of the test suite."""
    found: dict[str, Cases] = {}
    if not junit.exists():
        return found
    # Meson writes what a test printed as it came, such as the colours of GStreamer's log; XML
    # allows no such characters.
    text = re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", "",
                  junit.read_text(encoding="utf-8", errors="replace"))
    for suite in xml.fromstring(text.encode()).iter("testsuite"):
        suite_name = suite.get("name", "")
        passed, failed, skipped = found.get(suite_name, Cases(0, [], 0))
        for case in suite.iter("testcase"):
            if case.find("failure") is not None or case.find("error") is not None:
                failed = [*failed, case.get("name", "")]
            elif case.find("skipped") is not None or case.get("status") == "notrun":
                skipped += 1
            else:
                passed += 1
        found[suite_name] = Cases(passed, failed, skipped)
    return found


def count_test(title: str, result: str, reported: list[Cases]) -> Cases:
    """The cases of one test program."""
    failure = f"{title} ({result.lower()})"
    bad = result in BAD
    if not reported:
        if bad:
            return Cases(0, [failure], 0)
        return Cases(0, [], 1) if result == "SKIP" else Cases(1, [], 0)
    failed = [f"{title}: {case}" for program in reported for case in program.failed]
    if bad and not failed:
        failed = [failure]
    return Cases(sum(program.passed for program in reported), failed,
                 sum(program.skipped for program in reported))


def count(logs: pathlib.Path, name: str = "") -> tuple[int, list[str], int]:
    stem = "testlog" + ("-" + name if name else "")
    by_suite = cases(logs / (stem + ".junit.xml"))
    counted = []
    for line in (logs / (stem + ".json")).read_text().splitlines():
        test = json.loads(line)
        title = test["name"].split(" / ")[-1]
        # The test's name in the JUnit file; GoogleTest's suites come behind a further dot.
        key = f"csdtrack.{title}"
        reported = [program for suite, program in by_suite.items()
                    if suite == key or suite.startswith(key + ".")]
        counted.append(count_test(title, test["result"], reported))
    return (sum(test.passed for test in counted),
            [failure for test in counted for failure in test.failed],
            sum(test.skipped for test in counted))


def main() -> None:
    passed, failed, skipped = count(pathlib.Path(sys.argv[1]), *sys.argv[2:3])
    print(passed, len(failed), skipped)
    print("\n".join(failed))


if __name__ == "__main__":
    main()
