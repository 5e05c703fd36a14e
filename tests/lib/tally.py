#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Counts the results of `meson test`, from its log files: tally.py LOGS [NAME]

LOGS is the build's meson-logs folder; NAME is the set-up's name, if one was used. Prints "passed
failed skipped" in one line and the name of each failed test in the lines after it.

A test program that reports its cases (GoogleTest, TAP) counts by cases, any other as one. A program
that failed without naming a failed case (a crash, a time-out) counts as one failure.
"""

import json
import pathlib
import re
import sys
import xml.etree.ElementTree as xml


def cases(junit):
    """Suite name -> (passed, failed names, skipped) of each program that reported its cases."""
    found = {}
    if not junit.exists():
        return found
    # Meson copies a test's output unchanged, such as the colours of GStreamer's log. XML allows no
    # such characters.
    text = re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", "",
                  junit.read_text(encoding="utf-8", errors="replace"))
    for suite in xml.fromstring(text.encode()).iter("testsuite"):
        passed, failed, skipped = found.get(suite.get("name"), (0, [], 0))
        for case in suite.iter("testcase"):
            if case.find("failure") is not None or case.find("error") is not None:
                failed = failed + [case.get("name")]
            elif case.find("skipped") is not None or case.get("status") == "notrun":
                skipped += 1
            else:
                passed += 1
        found[suite.get("name")] = (passed, failed, skipped)
    return found


def count(logs, name=""):
    stem = "testlog" + ("-" + name if name else "")
    by_suite = cases(logs / (stem + ".junit.xml"))
    passed, failed, skipped = 0, [], 0
    for line in (logs / (stem + ".json")).read_text().splitlines():
        test = json.loads(line)
        title = test["name"].split(" / ")[-1]
        # Its name in the JUnit file. GoogleTest's suites follow another dot.
        key = f"csdtrack.{title}"
        reported = [v for k, v in by_suite.items() if k == key or k.startswith(key + ".")]
        bad = test["result"] in ("FAIL", "TIMEOUT", "ERROR", "INTERRUPT", "UNEXPECTEDPASS")
        if not reported:
            if bad:
                failed.append(f"{title} ({test['result'].lower()})")
            elif test["result"] == "SKIP":
                skipped += 1
            else:
                passed += 1
            continue
        bad_cases = [f"{title}: {case}" for r in reported for case in r[1]]
        passed += sum(r[0] for r in reported)
        skipped += sum(r[2] for r in reported)
        failed += bad_cases
        if bad and not bad_cases:
            failed.append(f"{title} ({test['result'].lower()})")
    return passed, failed, skipped


if __name__ == "__main__":
    passed, failed, skipped = count(pathlib.Path(sys.argv[1]), *sys.argv[2:3])
    print(passed, len(failed), skipped)
    print("\n".join(failed))
