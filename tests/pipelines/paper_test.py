#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/paper --quick: all of it runs, goes on where it was, and says what is wrong. paper_test.py ROOT BUILD"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import types
import unittest
import xml.etree.ElementTree

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])
sys.path.insert(0, str(ROOT / "pipelines" / "experiments"))
import claims  # noqa: E402
import figures  # noqa: E402
import sequences  # noqa: E402

TRACKERS = ("csd-2012", "lk", "ms1", "ms2", "sift", "csd-2012-smoothed", "lk-fb", "lk-anchored", "still")
BOXES = ("csrt", "kcf", "medianflow")


def paper(*arguments):
    return subprocess.run([ROOT / "pipelines" / "experiments" / "paper", "--no-install", *map(str, arguments)],
                          capture_output=True, text=True, env={**os.environ, "CSDTRACK_BUILD": str(BUILD)})


class Quick(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.out = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-paper-"))
        cls.addClassCleanup(shutil.rmtree, cls.out)
        before = cls.published()
        done = paper("--quick", "--out", cls.out)
        assert done.returncode == 0, done.stderr
        cls.page = (cls.out / "evaluation.md").read_text()
        assert cls.published() == before, "--quick leaves docs/ alone"

    @staticmethod
    def published():
        return {path: path.stat().st_mtime_ns for path in (ROOT / "docs").rglob("evaluation*")}

    def rows(self, heading):
        """The tables' rows below a heading, as lists of cells."""
        part = self.page.split(f"\n## {heading}\n")[1].split("\n## ")[0]
        return [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line.startswith("|")]

    def test_every_tracker_has_its_row(self):
        for heading in ("The simulation (Fig. 7)", "Table 1: deformation", "Table 2: occlusion",
                        "Table 3: scale, rotation and smoke"):
            self.assertLessEqual(set(TRACKERS), {row[0] for row in self.rows(heading)}, heading)
        self.assertLessEqual({"csd-2012", "lk", *TRACKERS[5:], *BOXES}, {row[0] for row in self.rows("Trackers of boxes")})

    def test_what_is_taken_away(self):
        rows = {row[0]: row[1:] for row in self.rows("What keeps csd-2012 from the paper's figures")}
        self.assertEqual(rows["sensitivity / K"], ["csd-2012", "csd-2012-smoothed", "lk"])
        self.assertEqual(len(rows), 2 + len(sequences.WHY))  # and the header's rule
        self.assertIn("effects=\"heart-mild=0,heart-strong=1,chroma=0,noise=0\"", self.page)

    def test_real_tissue(self):
        """Where the clips are, a row for each of them; else it is said that they aren't."""
        clips = [clip for *_, clip in sequences.PICTURE_KINDS if (sequences.CLIPS / clip).is_file()]
        if not clips:
            self.assertIn("the clips were not there", self.page)
            self.skipTest("the clips are not there")
        by_sequence = next(row for row in self.rows("Real tissue as texture") if row[0] == "sensitivity / K")
        self.assertEqual(len(by_sequence), 1 + len(clips))
        for clip in clips:
            self.assertIn(f"texture=(of {clip})", self.page)

    def test_the_paper_s_numbers(self):
        """Of the paper's Table 2, as printed."""
        rows = {row[0]: row[1:] for row in self.rows("Table 2: occlusion")}
        self.assertEqual(rows["sensitivity, the paper in vivo"], ["0.557", "0.307", "0.322", "0.458", "0.728"])
        self.assertEqual(rows["K, the paper in vivo"], ["0.356", "0.500", "0.494", "0.017", "0.144"])

    def test_scores_that_are_known(self):
        """In one second of a mildly beating heart LK loses nothing; what never moves is wrong."""
        rows = {row[0]: row[1] for row in self.rows("The simulation (Fig. 7)")}
        self.assertGreater(float(rows["lk"].split()[0]), 0.95)
        self.assertLess(float(rows["still"].split()[0]), 0.8)
        drawn = self.rows("Table 1: deformation")
        above, below = drawn.index(next(r for r in drawn if r[0] == "sensitivity, simulated")), None
        of_layout = dict(zip(drawn[0][1:], drawn[above][1:]))
        for name, column in (("lk", "LK"), ("csd-2012", "CSD"), ("sift", "SIFT")):
            below = next(r for r in drawn if r[0] == name)
            self.assertEqual(below[1].split(" (p")[0], of_layout[column], "two tables, one number")

    def test_figures(self):
        named = set(re.findall(r"!\[\]\(evaluation/(.*?)\)", self.page))
        self.assertEqual(named, {path.name for path in (self.out / "evaluation").iterdir()})
        self.assertLessEqual({f"fig{n}.svg" for n in (7, 8, 9, 10, 11)}, named)
        for name in named:
            drawn = xml.etree.ElementTree.parse(self.out / "evaluation" / name)
            self.assertGreater(len(drawn.findall(".//{*}path")), 10, name)

    def test_runs_hold_what_they_were_made_from(self):
        runs = [path for path in self.out.iterdir() if (path / "run.json").exists()]
        self.assertEqual({run.name for run in runs}, {f"{s.name}-101" for s in sequences.quick(1).sequences})
        for run in runs:
            self.assertEqual({p.name for p in run.iterdir()}, {"run.json", "truth-tracked.jsonl", "truth-slow.jsonl",
                             *(f"{t}.jsonl" for t in (*TRACKERS, *BOXES))}, "no video is left")
            self.assertIn("seed=101", json.loads((run / "run.json").read_text())["identity"]["source"])

    def test_goes_on_where_it_was(self):
        """What is there is not run again; what is missing, or of something else, is, and gives the same."""
        made = {path.name: (path / "run.json").stat().st_mtime_ns for path in self.out.glob("*-101")}
        (self.out / "liver-101" / "run.json").unlink()
        (self.out / ".unfinished-liver-101").mkdir()
        other = self.out / "zoom-101" / "run.json"
        other.write_text(other.read_text().replace("scenario=zoom", "scenario=cut"))
        done = paper("--quick", "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{len(made) - 2} of {len(made)} runs were there already", done.stderr)
        again = {path.name for path in self.out.glob("*-101") if (path / "run.json").stat().st_mtime_ns != made[path.name]}
        self.assertEqual(again, {"liver-101", "zoom-101"})
        self.assertEqual((self.out / "evaluation.md").read_text(), self.page)
        self.assertEqual(list(self.out.glob(".unfinished*")), [])


class Errors(unittest.TestCase):
    def test_wrong_use(self):
        for arguments in (["--seeds", "0"], ["--seeds", "many"], ["--jobs", "-1"], ["--nothing"], ["surplus"]):
            with self.subTest(arguments):
                done = paper(*arguments)
                self.assertEqual(done.returncode, 2)
                self.assertIn(arguments[-1], done.stderr)

    def test_a_file_for_a_folder(self):
        with tempfile.NamedTemporaryFile() as file:
            done = paper("--quick", "--out", file.name)
            self.assertEqual(done.returncode, 1)
            self.assertIn(file.name, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_a_clip_that_is_no_video(self):
        with tempfile.TemporaryDirectory() as clips, tempfile.TemporaryDirectory() as out:
            clip = pathlib.Path(clips) / "heart.mkv"
            clip.write_bytes(b"no video " * 1000)
            done = subprocess.run([ROOT / "pipelines" / "experiments" / "paper", "--no-install", "--quick", "--out", out],
                                  capture_output=True, text=True,
                                  env={**os.environ, "CSDTRACK_BUILD": str(BUILD), "CSDTRACK_CLIPS": clips})
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(f"{clip}: no frame could be read", done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_help(self):
        done = paper("--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("--quick", done.stdout)


class Numbers(unittest.TestCase):
    def test_bins(self):
        """Means over two frames and both seeds; what is unknown counts nowhere."""
        self.assertEqual(figures.binned([[0, 1, 2, 3, 1], [1, 2, None, None, None]], 2), [(0.5, 1.0), (2.5, 2.5), (4.0, 1.0)])
        self.assertEqual(figures.binned([[None, None]], 2), [(0.5, None)])

    def test_claims(self):
        """Of a table the paper's own numbers make each of its sentences true, and swapped ones false."""
        def scores(sensitivity, k):
            values = {"sensitivity": sensitivity, "k": k}
            return types.SimpleNamespace(value=lambda tracker, measure: values[measure][tracker])

        printed = json.loads((ROOT / "pipelines" / "experiments" / "paper.json").read_text())
        for name in ("table1", "table2", "table3"):
            found = claims.of_scores(name, scores(**printed[name]))
            self.assertEqual([c.holds for c in found], [True, True, True])
        swapped = scores(printed["table1"]["k"], printed["table1"]["sensitivity"])
        self.assertEqual([c.holds for c in claims.of_scores("", swapped)], [False, False, False])

    def test_seeds(self):
        plan = sequences.full(3)
        self.assertEqual(sorted(s.frames for s, _ in plan.runs() if s.figure), [500] * 27 + [4000])
        self.assertEqual(min(seed for _, seed in plan.runs()), 101, "1 to 20 are for development")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
