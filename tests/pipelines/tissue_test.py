#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/beyond --tissue on two generated pictures, and its errors about wrong
folders. tissue_test.py ROOT BUILD"""

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
import numpy as np

from pipelines.experiments import tissue

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])


def beyond(*arguments):
    return subprocess.run(
        [ROOT / "pipelines" / "experiments" / "beyond", "--no-install", *map(str, arguments)],
        capture_output=True, text=True, env={**os.environ, "CSDTRACK_BUILD": str(BUILD)})


def picture(seed, contrast):
    noise = cv2.GaussianBlur(
        np.random.default_rng(seed).normal(size=(400, 400, 3)).astype(np.float32), (0, 0), 3)
    return np.clip(120 + contrast * noise / noise.std(), 0, 255).astype(np.uint8)


class Tissue(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-tissue-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.pictures = cls.folder / "pictures"
        cls.pictures.mkdir()
        cv2.imwrite(str(cls.pictures / "rich.png"), picture(1, 30))
        cv2.imwrite(str(cls.pictures / "poor.png"), picture(2, 14))
        cls.out = cls.folder / "out"
        cls.done = beyond("--tissue", cls.pictures, "--quick", "--out", cls.out)
        assert cls.done.returncode == 0, cls.done.stderr
        cls.page = (cls.out / "tissue.md").read_text()

    def test_each_scene_has_its_row(self):
        table = self.page.split("\nThe worst of all")[0].split("| scene |")[1]
        rows = [line.split(" | ") for line in table.splitlines() if line.startswith("| ")]
        self.assertEqual([row[0].strip("| ") for row in rows],
                         [kind["title"] for kind in tissue.KINDS.values()])
        for row in rows:
            self.assertEqual(row[1], "2")
            self.assertRegex(row[3], r"^[01]\.\d{4} / [01]\.\d{4}$")
            self.assertRegex(row[6], r"^[01]\.\d{4} / [01]\.\d{4}, (rich|poor)$")

    def test_progress_is_printed(self):
        said = re.findall(r"^(\d+) of 16: (\w+)/(rich|poor) ", self.done.stderr, re.M)
        self.assertEqual([int(number) for number, *_ in said], list(range(1, 17)))
        self.assertEqual({kind for _, kind, _ in said}, set(tissue.KINDS))

    def test_the_worst_come_first(self):
        rows = re.findall(r"([01]\.\d{4}) / ([01]\.\d{4}) \|",
                          self.page.split("\nThe worst of all")[1])
        self.assertEqual(len(rows), 12)
        quality = [float(sensitivity) - float(k) for sensitivity, k in rows]
        self.assertEqual(quality, sorted(quality))

    def test_resumes(self):
        results = self.out / "results.json"
        before = json.loads(results.read_text())
        results.write_text(json.dumps({key: text for key, text in before.items()
                                       if "beat/rich" not in key}))
        again = beyond("--tissue", self.pictures, "--quick", "--out", self.out)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(set(json.loads(results.read_text())), set(before))
        again, before = ([line for line in text.splitlines() if not line.startswith("| csdtrack |")]
                         for text in ((self.out / "tissue.md").read_text(), self.page))
        self.assertEqual(again, before)

    def test_wrong_folders_are_refused(self):
        empty, broken = self.folder / "empty", self.folder / "broken"
        empty.mkdir()
        broken.mkdir()
        (broken / "torn.png").write_bytes(b"no picture")
        for folder, words in ((self.folder / "nowhere", "is no folder"),
                              (empty, "holds no picture or video"), (broken, "no picture in ")):
            done = beyond("--tissue", folder, "--quick", "--out", self.folder / "other")
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(words, done.stderr)
            self.assertIn(folder.name, done.stderr)
            self.assertNotIn("Traceback", done.stderr)
        self.assertEqual(beyond("--tissue").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
