#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""README's Python example, unchanged, on a made-up video."""

import pathlib
import re
import subprocess
import sys

from harness import CLAIMS, TIMEOUT, Case, main, odd_rates, scene_video

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"


class Readme(Case):
    def test_python_example_prints_a_row_for_each_point_and_frame(self):
        example = re.search(r"```python\n(.*?)```", README.read_text(), re.DOTALL).group(1)
        self.assertLessEqual(len(example.splitlines()), 14)
        video = self.tmp / "made up.mp4"
        scene_video(video, 30)
        done = subprocess.run([sys.executable, "-c", example, video], capture_output=True,
                              text=True, timeout=TIMEOUT)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split() for line in done.stdout.splitlines()]
        self.assertEqual({int(row[0]) for row in rows}, set(range(30)))
        for _frame, _id, x, y, state, confidence in rows:
            self.assertTrue(-0.5 <= float(x) < 319.5 and -0.5 <= float(y) < 239.5)
            self.assertEqual(float(confidence) >= 0.5, state in CLAIMS)

    def test_python_example_takes_any_rate(self):
        example = re.search(r"```python\n(.*?)```", README.read_text(), re.DOTALL).group(1)
        for rate, video in odd_rates(self.tmp, 30).items():
            with self.subTest(rate):
                done = subprocess.run([sys.executable, "-c", example, video], capture_output=True,
                                      text=True, timeout=TIMEOUT)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual({int(line.split()[0]) for line in done.stdout.splitlines()},
                                 set(range(30)))

    def test_python_example_prints_an_error(self):
        example = re.search(r"```python\n(.*?)```", README.read_text(), re.DOTALL).group(1)
        done = subprocess.run([sys.executable, "-c", example, README], capture_output=True,
                              text=True, timeout=TIMEOUT)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, rf"^{re.escape(str(README))}: \S.*text file\s*$")


if __name__ == "__main__":
    main()
