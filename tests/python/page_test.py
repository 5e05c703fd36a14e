#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The programs and commands of docs/python.md, unchanged, on a made-up video with known motion."""

import importlib.util
import json
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

import cv2

import harness
from harness import CLAIMS, FRAME, TIMEOUT, STATES

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "python.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
LINES = {n: line for n in ("csv", "jsonl")
         for line in re.findall(rf"^    (gst-launch.*tracks\.{n})$", PAGE, re.MULTILINE)}
FRAMES = 30


def needs(name):
    return unittest.skipUnless(importlib.util.find_spec(name), f"python3-{name} is not installed")


class Page(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = harness.Scene()
        cls.video = harness.scene_video(cls.tmp / "in.mp4", FRAMES)

    def run_block(self, mark, *arguments):
        """Runs the one block of code that has `mark` in it, and returns the lines it prints."""
        block, = (b for b in BLOCKS if mark in b)
        done = subprocess.run([sys.executable, "-c", block, *arguments], cwd=self.tmp,
                              capture_output=True, text=True, timeout=TIMEOUT)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.splitlines()

    def run_line(self, name):
        harness.launch(*LINES[name].split()[1:], cwd=self.tmp).check_returncode()

    def test_all_blocks_are_tested(self):
        self.assertEqual(len(BLOCKS), 7)

    @needs("pandas")
    def test_every_frame_of_a_video(self):
        lines = self.run_block("max_features=30", self.video)
        self.assertEqual(lines[0].split(), ["frame", "x", "y", "confidence"])
        rows = [[float(word) for word in line.split()] for line in lines[2:]]
        self.assertGreaterEqual(len(rows), 20)
        for _id, count, x, y, confidence in rows:
            self.assertTrue(1 <= count <= FRAMES and 0 <= x < 320 and 0 <= y < 240 and
                            0.5 <= confidence <= 1)

    def test_points_that_the_user_gives(self):
        *rows, last = self.run_block("add_point(200, 60)", self.video)
        self.assertEqual(last, "2 ['learning']")
        at = [self.scene.motion(i) for i in range(FRAMES)]
        self.assertEqual(len(rows), 2 * 20 + 9)
        for row in rows:
            number, i, x, y = (float(word) for word in row.split())
            n = int(number)
            x0, y0 = [(160, 120), (100.5, 80), (200 - at[11][0], 60 - at[11][1])][int(i)]
            self.assertLess(abs(x - x0 - at[n][0]), 0.3, row)
            self.assertLess(abs(y - y0 - at[n][1]), 0.3, row)

    def test_the_shortest_program(self):
        block, = (b for b in BLOCKS if "signal-handoffs" in b)
        self.assertLessEqual(len(block.splitlines()), 14)
        rows = [line.split() for line in self.run_block("signal-handoffs", self.video)]
        self.assertEqual({int(row[0]) for row in rows}, set(range(FRAMES)))
        for _frame, _id, x, y, state, confidence in rows:
            self.assertTrue(-0.5 <= float(x) < 319.5 and -0.5 <= float(y) < 239.5)
            self.assertEqual(float(confidence) >= 0.5, state in CLAIMS)

    def test_metadata(self):
        rows = [line.split() for line in self.run_block("pull-sample", self.video)]
        first = int(rows[0][0])  # mp4 begins where its first frame is shown
        self.assertEqual(sorted({int(row[0]) - first for row in rows}),
                         [i * FRAME for i in range(FRAMES)])
        start = {row[1]: (float(row[2]), float(row[3])) for row in rows if int(row[0]) == first}
        self.assertEqual(len(start), 20)
        at = [self.scene.motion(i) for i in range(FRAMES)]
        for pts, i, x, y, confidence in rows:
            self.assertGreaterEqual(float(confidence), 0.5)
            if i in start:
                dx, dy = at[(int(pts) - first) // FRAME]
                self.assertLess(abs(float(x) - start[i][0] - dx) + abs(float(y) - start[i][1] - dy),
                                1, i)

    def test_messages(self):
        new, *rows, last = self.run_block("add_signal_watch", self.video)
        self.assertRegex(new, r"^the new point is \d+$")
        self.assertEqual(last, f"{FRAMES} frames")
        self.assertGreaterEqual(len(rows), 2)
        for row in rows:
            time, *features = row.split()
            self.assertEqual(int(time) % FRAME, 0)
            self.assertLessEqual({f.split(":")[1] for f in features}, set(STATES))
        self.assertIn(new.split()[-1], {f.split(":")[0] for row in rows for f in row.split()[1:]})

    def test_any_video_whatever_its_rate_says(self):
        for rate, video in harness.odd_rates(self.tmp, FRAMES).items():
            with self.subTest(rate):
                caps = harness.launch("-v", "filesrc", f"location={video}", "!", "decodebin", "!",
                                      "fakesink").stdout
                self.assertIn(f"framerate=(fraction){rate}/1", caps)
                rows = [line.split() for line in self.run_block("max_features=30", video)[2:]]
                # A point is learned for half a second, by the frames' times.
                self.assertLessEqual(max(int(row[1]) for row in rows), FRAMES - 12)
                self.assertGreater(len(rows), 10)
                self.assertEqual(self.run_block("add_point(200, 60)", video)[-1],
                                 "2 ['learning']")
                times = {int(row.split()[0]) for row in self.run_block("pull-sample", video)}
                self.assertEqual(sorted(times), [i * FRAME for i in range(FRAMES)])
                frames = {int(row.split()[0]) for row in self.run_block("signal-handoffs", video)}
                self.assertEqual(frames, set(range(FRAMES)))
                self.assertEqual(self.run_block("add_signal_watch", video)[-1], f"{FRAMES} frames")
                shutil.copy(video, self.tmp / "in.mp4")
                for name, mark in (("csv", "read_csv"), ("jsonl", "json_normalize")):
                    self.run_line(name)
                    self.assertGreater(len(self.run_block(mark)), 2)
        harness.scene_video(self.video, FRAMES)

    def test_an_error_is_printed_in_one_line(self):
        for block in (b for b in BLOCKS if "VideoCapture" in b):
            done = subprocess.run([sys.executable, "-c", block, "missing.mkv"], capture_output=True,
                                  text=True, timeout=TIMEOUT)
            self.assertEqual(done.returncode, 1)
            # OpenCV prints warnings before it.
            self.assertRegex(done.stderr.splitlines()[-1], "^can't read .*missing.mkv$")
        for mark in ("signal-handoffs", "pull-sample", "add_signal_watch"):
            block, = (b for b in BLOCKS if mark in b)
            done = subprocess.run([sys.executable, "-c", block, __file__], capture_output=True,
                                  text=True, timeout=TIMEOUT)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, rf"^{re.escape(__file__)}: \S.*text file\s*$")

    @needs("pandas")
    def test_csv(self):
        self.run_line("csv")
        lines = self.run_block("read_csv")
        self.assertEqual(lines[0].split(), ["count", "min", "max"])
        rows = [[float(word) for word in line.split()] for line in lines[2:] if line != "..."]
        self.assertGreaterEqual(len(rows), 10)
        moved = [x for x, _ in (self.scene.motion(t) for t in range(FRAMES))]
        for _id, count, lowest, highest in rows:
            if count == FRAMES:
                self.assertAlmostEqual(highest - lowest, max(moved) - min(moved), delta=1)

    @needs("pandas")
    def test_json_lines(self):
        self.run_line("jsonl")
        lines = self.run_block("json_normalize")
        states = dict(line.split() for line in lines[1:] if not line.startswith("Name:"))
        ids = {}
        for line in (self.tmp / "tracks.jsonl").read_text().splitlines():
            for feature in json.loads(line)["features"]:
                ids.setdefault(feature["state"], set()).add(feature["id"])
        self.assertTrue(set(CLAIMS) <= set(ids))
        self.assertEqual(states, {state: str(len(found)) for state, found in ids.items()})

    @needs("matplotlib")
    def test_the_beating_heart(self):
        command, = re.findall(r"^    /usr/bin/python3 docs/(python/\S+\.py) (\S+)$", PAGE,
                              re.MULTILINE)
        done = subprocess.run([sys.executable, DOCS / command[0], command[1], "6"], cwd=self.tmp,
                              capture_output=True, text=True, timeout=5 * TIMEOUT)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        points, frames, error = re.match(r"(\d+) points, (\d+) frames, median error (\S+) px",
                                         done.stdout).groups()
        self.assertGreaterEqual(int(points), 50)
        self.assertEqual(int(frames), 150)
        self.assertLess(float(error), 0.5)
        moved, rate = re.search(r"([\d.]+) px in [xy], heart rate (\d+)/min", done.stdout).groups()
        self.assertGreater(float(moved), 10)
        self.assertAlmostEqual(int(rate), 75, delta=3)
        picture = cv2.imread(str(self.tmp / command[1]))
        self.assertEqual(picture.shape, (600, 900, 3))
        blue, _, red = (picture[..., k].astype(int) for k in range(3))
        self.assertGreater((blue - red > 60).sum(), 1000, "no blue lines")
        self.assertGreater((red - blue > 60).sum(), 1000, "no orange lines")


if __name__ == "__main__":
    harness.main()
