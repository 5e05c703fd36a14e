#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/choices on a generated picture, and its errors about wrong folders.

choices_test.py ROOT BUILD"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import cv2
import harness

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])
PLAN = json.loads((ROOT / "pipelines" / "experiments" / "choices.json").read_text())
CELL = r"^[01]\.\d{3} / [01]\.\d{3}$"


def choices(*arguments):
    return subprocess.run(
        [ROOT / "pipelines" / "experiments" / "choices", "--no-install", *map(str, arguments)],
        capture_output=True, text=True, env={**os.environ, "CSDTRACK_BUILD": str(BUILD)})


class Choices(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-choices-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.pictures = cls.folder / "pictures"
        cls.pictures.mkdir()
        cv2.imwrite(str(cls.pictures / "rich.png"), harness.texture(400, 400, sigma=3))
        cls.out = cls.folder / "out"
        cls.done = choices("--tissue", cls.pictures, "--quick", "--out", cls.out)
        assert cls.done.returncode == 0, cls.done.stderr
        cls.page = (cls.out / "choices.md").read_text()

    def rows(self):
        return [line.strip("| ").split(" | ") for line in self.page.splitlines()
                if line.startswith("| ")]

    def test_each_reading_and_each_choice_has_its_row(self):
        rows = self.rows()[-len(PLAN["rows"]):]
        self.assertEqual([row[0] for row in rows], [row["title"] for row in PLAN["rows"]])
        for row in rows:
            for cell in row[1:4]:
                self.assertRegex(cell.rstrip("| "), CELL)
        for row in rows[1:]:
            middle, low, high = map(float, re.fullmatch(r"(\S+) \[(\S+), (\S+)\]",
                                                        row[4].replace("−", "-")).groups())
            self.assertLessEqual(low, middle)
            self.assertLessEqual(middle, high)

    def test_a_change_is_compared_with_its_base(self):
        scores = {row[0]: [tuple(map(float, cell.split(" / "))) for cell in row[1:4]]
                  for row in self.rows()[-len(PLAN["rows"]):]}
        difference = {row[0]: float(row[4].split()[0].replace("−", "-"))
                      for row in self.rows()[-len(PLAN["rows"]) + 1:]}

        def quality(title):
            return sum(sensitivity - k for sensitivity, k in scores[title]) / 3

        for title, base in (("csd-forest with one tree", "**csd-forest**"),
                            ("lk", PLAN["rows"][0]["title"]),
                            ("patches are smoothed, σ = 2 px", PLAN["rows"][0]["title"])):
            self.assertAlmostEqual(difference[title], quality(title) - quality(base), delta=0.0025)

    def test_choices_make_a_difference(self):
        rows = {row[0]: row[1:4] for row in self.rows()[-len(PLAN["rows"]):]}
        literal = rows[PLAN["rows"][0]["title"]]
        for title in ("the colour space is chosen by differences of pixels, not by pixels",
                      "a patch of less than .05 of the probability is no feature",
                      "a node becomes a leaf at depth 16 and below 4 samples, too"):
            self.assertNotEqual(rows[title], literal, title)
        self.assertNotEqual(rows["csd-forest with coded copies, too"], rows["**csd-forest**"])

    def test_resumes(self):
        """Known scores are not measured again: a wrong one stays, a missing one comes back."""
        out = self.folder / "again"
        shutil.copytree(self.out, out)
        before = json.loads((out / "results.json").read_text())
        self.assertEqual(len(before), 3 * len(PLAN["rows"]))
        wrong = next(key for key in before if key.endswith("beat/rich --algorithm lk"))
        missing = next(key for key in before if key.endswith("tools/rich --algorithm lk"))
        (out / "results.json").write_text(json.dumps({key: [0.125, 0.5] if key == wrong else scores
                                                      for key, scores in before.items()
                                                      if key != missing}))
        again = choices("--tissue", self.pictures, "--quick", "--out", out)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(json.loads((out / "results.json").read_text()),
                         {**before, wrong: [0.125, 0.5]})
        self.assertIn("| lk | 0.125 / 0.500 |", (out / "choices.md").read_text())

    def test_wrong_folders_and_options_are_refused(self):
        done = choices("--tissue", self.folder / "nowhere", "--quick", "--out",
                       self.folder / "other")
        self.assertEqual(done.returncode, 1)
        self.assertIn("is no folder", done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(choices("--quick").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
