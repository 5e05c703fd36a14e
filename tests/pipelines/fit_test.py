#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""tests/bench/fit on evidence whose weights are known. fit_test.py ROOT"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(sys.argv[1])
TERMS = re.findall(r"^  double weigh_(\w+) = ", (ROOT / "core" / "csd" / "tuning.h").read_text(),
                   re.M)


def fit(*files):
    return subprocess.run([ROOT / "tests" / "bench" / "fit", *map(str, files)], capture_output=True,
                          text=True)


class Fit(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, rows, head=None):
        file = self.folder / name
        file.write_text("\n".join([",".join(head or ["tissue", "right", *TERMS]), *rows]) + "\n")
        return file

    def rows(self, tissue, weights, n, seed):
        """Rows of evidence. Each is right with the probability that the weights give."""
        random = np.random.default_rng(seed)
        values = random.normal(size=(n, len(TERMS)))
        values[:, 0] = 1
        right = random.random(n) < 1 / (1 + np.exp(-values @ weights))
        return [f"{tissue},{int(r)}," + ",".join(f"{v:.6f}" for v in row)
                for r, row in zip(right, values)]

    def test_finds_the_weights_and_the_tissue_that_differs(self):
        true = np.linspace(1, -1, len(TERMS))
        rows = [row for i, tissue in enumerate(("a", "b", "c"))
                for row in self.rows(tissue, true, 6000, i)]
        done = fit(self.write("same.csv", rows))
        self.assertEqual(done.returncode, 0, done.stderr)
        found = {name: list(map(float, rest.split()))
                 for name, rest in re.findall(r"^(\w+) +((?:-?[\d.]+ *){4})$", done.stdout, re.M)}
        self.assertEqual(list(found), TERMS)
        for name, weight in zip(TERMS, true):
            _, whole, least, most = found[name]
            # A weight's standard error is at most 2.5/√n here: .02 for 18000 rows, .023 for 12000.
            # The limit is five of these and the rounding.
            self.assertAlmostEqual(whole, weight, delta=0.105)
            self.assertAlmostEqual(least, weight, delta=0.125)
            self.assertAlmostEqual(most, weight, delta=0.125)
            self.assertLessEqual(least, most)
        other = [row for tissue, weights, seed in (
                     ("a", true, 1), ("b", true, 2), ("other", -true, 3))
                 for row in self.rows(tissue, weights, 3000, seed)]
        done = fit(self.write("other.csv", other))
        self.assertIn("worst: other", done.stdout)

    def test_wrong_files_are_refused(self):
        weights = np.zeros(len(TERMS))
        a, b = self.rows("a", weights, 20, 1), self.rows("b", weights, 20, 2)
        for file, words in (
                (self.folder / "nowhere.csv", "No such file"),
                (self.write("head.csv", a + b, ["x", "y", *TERMS]),
                 "no file of csd-accuracy --evidence"),
                (self.write("terms.csv", ["a,1,1"], ["tissue", "right", "foo"]), "has other terms"),
                (self.write("torn.csv", [*a, "b,1,x" + ",0" * (len(TERMS) - 1)]), "is damaged"),
                (self.write("none.csv", []), "no evidence"),
                (self.write("one.csv", a), "one tissue alone")):
            done = fit(file)
            self.assertEqual(done.returncode, 1, file)
            self.assertIn(words, done.stderr)
            self.assertNotIn("Traceback", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
