#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/latency: what it prints, and that csdtrack's time is in it."""

import os
import pathlib
import re
import subprocess
import sys

import harness

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
LATENCY = SOURCE / "pipelines" / "latency"


def run(*arguments):
    return subprocess.run([LATENCY, "--no-install", *map(str, arguments)], capture_output=True,
                          text=True, stdin=subprocess.DEVNULL, timeout=180,
                          env={**os.environ, "CSDTRACK_BUILD": str(BUILD)})


class Latency(harness.Case):
    def test_each_row_is_about_its_own_pipeline(self):
        """Without csdtrack it is the latency of a queue. With csdtrack it also contains the time of
        tracking, which is far longer."""
        done = run("--rounds", 2, "--seconds", 4, "test:UYVY")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        rows = done.stdout.splitlines()
        self.assertEqual(rows[0].split(), ["p50", "p95", "p99", "ms"])
        without, with_it = (
            re.fullmatch(rf"{kind} csdtrack +([\d.]+) +([\d.]+) +([\d.]+) +(\d+) frames", row)
            for kind, row in (("without", rows[1]), ("with", rows[2])))
        for row in without, with_it:
            p50, p95, p99 = (float(row[n]) for n in (1, 2, 3))
            self.assertTrue(0 < p50 <= p95 <= p99, row[0])
            self.assertGreater(int(row[4]), 10)
            self.assertLessEqual(int(row[4]), 2 * 25 * 4)  # both rounds, no frame twice
        self.assertGreater(float(with_it[1]), float(without[1]))

    def test_errors_are_one_line(self):
        for arguments, code, words in (
                (("/dev/video99",), 1, "no device"), (("in.mkv",), 2, "no live source"),
                (("rtsp://x/y",), 2, "no live source"), (("test:x",), 2, "test:v210"),
                (("--rounds", "0"), 2, "--rounds"), (("--seconds", "1"), 2, "--seconds"),
                (("--rounds", "1", "--seconds", "2", "--preset", "fast", "test:UYVY"), 2,
                 "live-low-latency")):
            with self.subTest(arguments=arguments):
                self.check_refused(run(*arguments), code, words)


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
