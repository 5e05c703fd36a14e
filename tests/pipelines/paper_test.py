#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/paper --quick runs, resumes, and reports errors.

paper_test.py ROOT BUILD"""

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
import unittest.mock
import xml.etree.ElementTree

os.environ["CSDTRACK_TISSUE"] = "/nowhere"  # the same whether or not real pictures are there
from pipelines.experiments import (  # noqa: E402
    claims, evaluation, figures, running, scores, sequences, truth)

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])
RUN_SEQUENCE = ("/usr/bin/python3", "-B", "-P", "-m", "pipelines.experiments.run_sequence")
TRACKERS = ("csd-2012", "lk", "ms1", "ms2", "sift", "csd-forest", "csd")


def paper(*arguments):
    return subprocess.run(
        [ROOT / "pipelines" / "experiments" / "paper", "--no-install", *map(str, arguments)],
        capture_output=True, text=True, env={**os.environ, "CSDTRACK_BUILD": str(BUILD)})


class Quick(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.out = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-paper-"))
        cls.addClassCleanup(shutil.rmtree, cls.out)
        before = cls.published()
        done = paper("--quick", "--out", cls.out)
        assert done.returncode == 0, done.stderr
        cls.said = done.stderr
        cls.page = (cls.out / "paper.md").read_text()
        assert cls.published() == before, "--quick leaves docs/ alone"

    @staticmethod
    def published():
        return {path: path.stat().st_mtime_ns for path in (ROOT / "docs" / "results").rglob("*")}

    def test_it_says_that_the_pictures_are_missing(self):
        self.assertIn("all tissue is simulated", self.said)
        self.assertIn("/nowhere/heart.png", self.said)

    def test_each_finished_run_has_its_line_of_progress(self):
        runs = len(sequences.paper_quick(1).runs())
        over = [int(n) for n in re.findall(rf"^(\d+) of {runs} runs, ", self.said, re.M)]
        self.assertEqual(over, list(range(1, runs + 1)))

    def rows(self, heading):
        """The tables' rows below a heading, as lists of cells."""
        part = self.page.split(f"\n## {heading}\n")[1].split("\n## ")[0]
        return [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines()
                if line.startswith("|")]

    def test_the_page_has_its_title_and_command(self):
        self.assertTrue(self.page.startswith("# The paper's experiments again\n"))
        self.assertIn("\n    pipelines/experiments/paper --quick\n", self.page)
        self.assertEqual(
            sorted(p.name for p in self.out.iterdir() if p.name.startswith(".unfinished")), [])

    def test_every_tracker_has_its_row(self):
        for heading in ("The simulation (Fig. 7)", "Table 1: deformation", "Table 2: occlusion",
                        "Table 3: scale, rotation and smoke"):
            measured = [row[0] for row in self.rows(heading)]
            tables = [measured[i + 2:i + 2 + len(TRACKERS)] for i, name in enumerate(measured)
                      if name == "tracker"]
            self.assertEqual([set(table) for table in tables], [set(TRACKERS)] * 2, heading)

    def test_every_scene_has_its_row(self):
        """With the kind of its tissue."""
        for heading, table in (("Table 1: deformation", "table1"), ("Table 2: occlusion", "table2"),
                               ("Table 3: scale, rotation and smoke", "table3")):
            rows = self.rows(heading)
            header = next(i for i, row in enumerate(rows) if row[0] == "sensitivity / K")
            self.assertEqual(rows[header][2:], list(TRACKERS))
            kinds = [s for s in sequences.paper_quick(1).sequences if s.table == table]
            self.assertEqual([row[:2] for row in rows[header + 2:]],
                             [[f"{s.title} (Fig. {s.figure})", f"simulated {s.style}"]
                              for s in kinds])

    def test_the_simulation_over_time(self):
        rows = self.rows("The simulation (Fig. 7)")
        header = next(i for i, row in enumerate(rows) if row[-1] == "last fifth")
        self.assertEqual([row[:2] for row in rows[header + 2:]],
                         [["simulated heart", t]
                          for t in (*sequences.PERSISTENT, *sequences.PERSISTENT)])
        lk = next(row for row in rows[header:] if row[1] == "lk")
        self.assertGreater(float(lk[2].split(" / ")[0]), 0.95)

    def test_the_numbers_of_the_paper(self):
        """Those of the paper's Table 2, as printed there."""
        rows = {row[0]: row[1:] for row in self.rows("Table 2: occlusion")}
        self.assertEqual(rows["sensitivity, the paper in vivo"],
                         ["0.557", "0.307", "0.322", "0.458", "0.728"])
        self.assertEqual(rows["K, the paper in vivo"],
                         ["0.356", "0.500", "0.494", "0.017", "0.144"])

    def test_known_scores(self):
        """In one second of a mildly beating heart LK loses nothing."""
        # Reversed: of two rows the one in the first table, about all features, stays.
        rows = {row[0]: row[1] for row in reversed(self.rows("The simulation (Fig. 7)"))}
        self.assertGreater(float(rows["lk"].split()[0]), 0.95)
        drawn = self.rows("Table 1: deformation")
        above, below = drawn.index(next(r for r in drawn if r[0] == "sensitivity, simulated")), None
        of_layout = dict(zip(drawn[0][1:], drawn[above][1:]))
        for name, column in (("lk", "LK"), ("csd-2012", "CSD"), ("sift", "SIFT")):
            below = next(r for r in drawn if r[0] == name)
            self.assertEqual(below[1].split(" (p")[0], of_layout[column], "the two tables differ")

    def test_figures(self):
        named = set(re.findall(r"!\[\]\(paper/(.*?)\)", self.page))
        self.assertEqual(named, {path.name for path in (self.out / "paper").iterdir()})
        self.assertEqual({"fig7.svg", "fig7-start.svg", "fig8.svg", "fig9.svg", "fig10.svg",
                          "fig11.svg", "threshold.svg"}, named)
        for name in named:
            drawn = xml.etree.ElementTree.parse(self.out / "paper" / name)
            self.assertGreater(len(drawn.findall(".//{*}path")), 10, name)

    def test_links_lead_to_files(self):
        pages = set(re.findall(r"\]\(([^)#:]+\.md)", self.page))
        self.assertGreaterEqual(len(pages), 3)
        for page in pages:
            self.assertTrue((self.out / page).is_file(), page)

    def test_the_cost_of_the_runs(self):
        self.assertRegex(self.page, r"The runs took [1-9]\d* (s|min) of processor time, "
                         r"[1-9]\d* (s|min) one after the other, "
                         rf"and [1-9]\d* (s|min) by the clock, {os.cpu_count()} at a time\.")
        self.assertIn("stand on 1 seed of each sequence", self.page)
        by_name = {row[0]: row[-1] for row in self.rows("The sequences")}
        self.assertEqual(by_name["simulation"], "0 %, 0 %")
        self.assertRegex(by_name["tools, blood and irrigation"], r"^\d+ %, \d+ %$")

    def test_runs_keep_their_settings_and_tracks_but_no_video(self):
        runs = [path for path in self.out.iterdir() if (path / "run.json").exists()]
        self.assertEqual({run.name for run in runs},
                         {f"{s.name}-{seed}" for s, seed in sequences.paper_quick(1).runs()})
        for run in runs:
            trackers = {"dry-101": ["csd-2012"],
                        "more-102": sequences.PERSISTENT}.get(run.name, TRACKERS)
            self.assertEqual({p.name for p in run.iterdir()},
                             {"run.json", "truth-tracked.jsonl", *(f"{t}.jsonl" for t in trackers)},
                             "no video is left")
            made = json.loads((run / "run.json").read_text())
            self.assertIn(f"seed={run.name[-3:]}", made["identity"]["source"])
            self.assertIn(f"| processor | {made['versions']['processor']} |", self.page)

    def test_resumes(self):
        """Complete runs are not repeated. A run that is missing or has other settings is, with the
        same result."""
        made = {path.name: (path / "run.json").stat().st_mtime_ns
                for path in self.out.glob("*-10?")}
        (self.out / "liver-101" / "run.json").unlink()
        (self.out / ".unfinished-liver-101").mkdir()
        other = self.out / "zoom-101" / "run.json"
        other.write_text(other.read_text().replace("scenario=zoom", "scenario=cut"))
        # Made with another OpenCV, but the same in all that a run depends on.
        older = self.out / "smoke-101" / "run.json"
        older.write_text(re.sub('"OpenCV": ".*"', '"OpenCV": "0.1"', older.read_text()))
        made["smoke-101"] = older.stat().st_mtime_ns
        done = paper("--quick", "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{len(made) - 2} of {len(made)} runs were there already", done.stderr)
        again = {path.name for path in self.out.glob("*-10?")
                 if (path / "run.json").stat().st_mtime_ns != made[path.name]}
        self.assertEqual(again, {"liver-101", "zoom-101"})
        # All but the time that the runs took, and the state of the repository: somebody may work in
        # it meanwhile.
        written = (self.out / "paper.md").read_text()
        again, before = ([line for line in text.splitlines()
                          if "of processor time" not in line and
                          not line.startswith(("| csdtrack |", "| OpenCV |"))]
                         for text in (written, self.page))
        self.assertEqual(again, before)
        opencv, = re.findall(r"^\| OpenCV \| (.*) \|$", written, re.M)
        self.assertNotIn("| these |", written)
        self.assertEqual(set(opencv.split("; ")) - {"0.1"},
                         set(re.findall(r"^\| OpenCV \| (.*) \|$", self.page, re.M)))
        self.assertIn("0.1", opencv.split("; "), "versions must be those of the runs")
        self.assertNotIn("by the clock", written, "the runs were not made at one time")
        self.assertEqual(list(self.out.glob(".unfinished*")), [])


class Errors(unittest.TestCase):
    def test_wrong_options_are_refused(self):
        for arguments in (["--seeds", "0"], ["--seeds", "many"], ["--jobs", "-1"], ["--nothing"],
                          ["surplus"]):
            with self.subTest(arguments):
                done = paper(*arguments)
                self.assertEqual(done.returncode, 2)
                self.assertIn(arguments[-1], done.stderr)

    def test_a_file_in_place_of_a_folder_is_refused(self):
        with tempfile.NamedTemporaryFile() as file:
            done = paper("--quick", "--out", file.name)
            self.assertEqual(done.returncode, 1)
            self.assertIn(file.name, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_usage_of_a_single_run(self):
        for arguments, code in ((["--help"], 0), ([], 2), (["paper-quick"], 2)):
            done = subprocess.run([*RUN_SEQUENCE, *arguments], capture_output=True, text=True)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn("PLAN SEEDS FOLDER SEQUENCE SEED", done.stderr if code else done.stdout)

    def test_a_missing_element_is_reported(self):
        with tempfile.TemporaryDirectory() as out:
            empty = {"GST_PLUGIN_PATH_1_0": out, "GST_PLUGIN_SYSTEM_PATH_1_0": out,
                     "GST_REGISTRY": f"{out}/registry.bin"}
            done = subprocess.run([*RUN_SEQUENCE, "paper-quick", "1", out, "zoom", "101"],
                                  capture_output=True, text=True,
                                  env={**os.environ, "CSDTRACK_BUILD": str(BUILD), **empty})
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r'^zoom, seed 101: no element "\w+": is a plugin of '
                         r'GStreamer missing\?\n$')

    def test_help(self):
        done = paper("--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("--quick", done.stdout)


PLAN = sequences.paper(1)


def verdicts(found):
    return [c.verdict for c in found]


class Figures:
    """A table's figures, and their differences from csd-2012, each with an interval of ±width."""

    def __init__(self, figures_by_measure, width=0.001):
        self._figures = figures_by_measure
        self.comparisons = {
            t: {m: {"difference": v[t] - v["csd-2012"], "low": v[t] - v["csd-2012"] - width,
                    "high": v[t] - v["csd-2012"] + width}
                for m, v in figures_by_measure.items()}
            for t in next(iter(figures_by_measure.values()))}

    def value(self, tracker, measure):
        return self._figures[measure][tracker]


class Curves(scores.Scores):
    """Scores of curves by frame: {sequence: {tracker: {measure by frame: curve}}}."""

    def __init__(self, curves, scene):
        self._curves, self._scene = curves, scene

    def of_clips(self, sequence, tracker, measure):
        return [self._curves[sequence.name][tracker][measure]]

    def of_sequence(self, sequence, tracker, measure):
        return figures.mean(self._curves[sequence.name][tracker][f"{measure}_by_frame"])

    def value(self, tracker, measure):
        return figures.mean([self.of_sequence(PLAN.sequence(s), tracker, measure)
                             for s in self._curves])

    def truths(self, sequence):
        return [self._scene]

    def change(self, sequence, tracker, windows=None):
        """The change of one feature that is found as often as the curve says, ±0.001."""
        curve = self._curves[sequence.name][tracker]["sensitivity_by_frame"]
        parts = windows(self._scene) if windows else truth.fifths(len(curve))
        if parts is None:
            return None
        before, after = (sum(curve[n] for n in part) / len(part) for part in parts)
        return after - before, after - before - 0.001, after - before + 0.001


def found(name, sensitivity, k, scene):
    return types.SimpleNamespace(
        simulation=Curves({name: {t: {"sensitivity_by_frame": sensitivity[t], "k_by_frame": k[t]}
                                  for t in claims.ALL}}, scene))


def sequences_found(table, kinds, scene):
    """kinds: {sequence: {tracker: sensitivity or (sensitivity, K)}}. Each value is a curve, or a
    number for all of 100 frames."""
    def curves(given):
        s, k = given if isinstance(given, tuple) else (given, 0.1)
        return {m: v if isinstance(v, list) else [v] * 100
                for m, v in (("sensitivity_by_frame", s), ("k_by_frame", k))}

    names = [s.name for s in PLAN.of_table(table)]
    return Curves({n: {t: curves(kinds.get(n, {}).get(t, 0.5)) for t in claims.ALL} for n in names},
                  scene)


class Numbers(unittest.TestCase):
    def test_bins(self):
        """Means over two frames and both seeds. Unknown values don't count."""
        self.assertEqual(figures.binned([[0, 1, 2, 3, 1], [1, 2, None, None, None]], 2),
                         [(0.5, 1.0), (2.5, 2.5), (4.0, 1.0)])
        self.assertEqual(figures.binned([[None, None]], 2), [(0.5, None)])

    def test_claims_of_tables(self):
        """With the paper's own numbers each of its claims about a table holds; with swapped numbers
        each fails; with wide intervals none is decided."""
        printed = json.loads((ROOT / "pipelines" / "experiments" / "paper.json").read_text())
        for name in ("table1", "table2", "table3"):
            self.assertEqual(verdicts(claims.of_scores(name, Figures(printed[name]), True)),
                             [claims.HOLDS] * 3)
        swapped = Figures({"k": printed["table1"]["sensitivity"],
                           "sensitivity": printed["table1"]["k"]})
        self.assertEqual(verdicts(claims.of_scores("", swapped, True)), [claims.FAILS] * 3)
        near = Figures(printed["table1"], width=0.9)
        self.assertEqual(verdicts(claims.of_scores("", near, False)), [claims.UNDECIDED] * 2)
        shifts = {"sensitivity": {"csd-2012": 0.2, "ms2": 0.25}}
        self.assertEqual(verdicts(claims.of_mean_shifts(Figures(shifts, 0.04))), [claims.HOLDS])
        self.assertEqual(verdicts(claims.of_mean_shifts(Figures(shifts, 0.06))), [claims.UNDECIDED])

    def test_claims_of_the_simulation(self):
        """Deformation is largest in the middle of each 20 frames. There sift falls from .6 to .2
        and the others by .1, as in the paper."""
        deformation = [10 - abs(n % 20 - 10) for n in range(100)]

        def curve(start, end, depth):
            return [start + (end - start) * n / 99 - depth * d / 10
                    for n, d in enumerate(deformation)]

        s = {"csd-2012": curve(0.8, 0.8, 0.1), "lk": curve(1, 0.4, 0.1),
             "ms1": curve(0.2, 0.2, 0.1), "ms2": curve(0.2, 0.2, 0.1), "sift": curve(0.6, 0.6, 0.4)}
        k = {"lk": [0.1] * 100, **{t: [0.5] * 100 for t in claims.ALL if t != "lk"}}
        scene = types.SimpleNamespace(deformation=deformation)
        self.assertEqual(verdicts(claims.of_simulation(PLAN, found("simulation", s, k, scene))),
                         [claims.HOLDS] * 6)
        level = {t: [0.6] * 100 for t in claims.ALL}
        bad = found("simulation", level, {t: [0.25] * 100 for t in level}, scene)
        self.assertEqual(verdicts(claims.of_simulation(PLAN, bad)), [claims.FAILS] * 6)

    def check_sequences(self, of, table, good, bad, scenes):
        """good, bad: {sequence: {tracker: (sensitivity by frame, K by frame)}}."""
        self.assertEqual(set(verdicts(of(PLAN, sequences_found(table, good, scenes)))),
                         {claims.HOLDS})
        self.assertEqual(set(verdicts(of(PLAN, sequences_found(table, bad, scenes)))),
                         {claims.FAILS})

    def test_claims_of_deformation(self):
        cyclic = [0.9 if n % 2 else 0.4 for n in range(100)]
        scene = types.SimpleNamespace(deformation=[n % 2 for n in range(1, 101)])
        worn = [1 - n / 100 for n in range(100)]
        good = {"strong-heart": {"lk": worn, "ms1": 0.1, "ms2": 0.1, "sift": 0.2},
                "mild-heart": {"lk": worn, "ms1": 0.3, "ms2": 0.3},
                "liver": {"lk": 0.3, "ms1": 0.2, "ms2": 0.2, "sift": cyclic, "csd-2012": 0.9}}
        bad = {"strong-heart": {"lk": 0.6, "ms1": 0.3, "ms2": 0.3, "sift": 0.8},
               "mild-heart": {"lk": 0.6, "ms1": 0.1, "ms2": 0.1},
               "liver": {"lk": 0.9, "ms1": 0.8, "ms2": 0.8, "sift": 0.5, "csd-2012": 0.4}}
        self.check_sequences(claims.of_deformation, "table1", good, bad, scene)
        near = {**bad, "mild-heart": {"lk": 0.6, "ms1": 0.32, "ms2": 0.34}}
        self.assertIn(claims.UNDECIDED,
                      verdicts(claims.of_deformation(PLAN, sequences_found("table1", near, scene))))

    def test_claims_of_occlusion(self):
        scene = types.SimpleNamespace(hidden=[0] * 50 + [0.1] * 50)
        step = [0.9] * 50 + [0.05] * 50
        good = {s: {"lk": step, "ms1": step, "ms2": step, "sift": (0.7, 0.01),
                    "csd-2012": (0.9, 0.1)} for s in ("few-occluded", "irrigation")}
        bad = {s: {"lk": 0.9, "ms1": 0.9, "ms2": 0.9, "sift": (step, 0.5), "csd-2012": (step, 0.6)}
               for s in ("few-occluded", "irrigation")}

        def of(recovered, kinds, sensitivity, k):
            scores = sequences_found("table2", kinds, scene)
            scores.trackers = {t: {"recovery": {"returns": 10 if recovered else 0,
                                                "recovered": (recovered or {}).get(t, 0)},
                                   "k": {"value": k, "low": k - 0.01, "high": k + 0.01}}
                               for t in claims.ALL}
            scores.comparisons = {"sift": {"sensitivity": {"low": sensitivity - 0.05,
                                                           "high": sensitivity + 0.05}}}
            return claims.of_occlusion(PLAN, scores)

        self.assertEqual(set(verdicts(of({"sift": 9, "csd-2012": 8, "lk": 1}, good, -0.2, 0.1))),
                         {claims.HOLDS})
        self.assertEqual(set(verdicts(of({"lk": 5}, bad, 0.2, 0.5))), {claims.FAILS})
        nobody, nothing = of({"none": 1}, good, -0.2, 0.1), of(None, good, 0, 0.2)
        self.assertEqual(next(c.verdict for c in nobody if "again" in c.says), claims.FAILS,
                         "features came back, but no tracker found them")
        self.assertEqual(next(c.verdict for c in nothing if "again" in c.says), claims.NO_OCCASION)
        self.assertEqual(next(c.verdict for c in nothing if "higher" in c.says), claims.UNDECIDED)
        self.assertEqual(next(c.verdict for c in nothing if "low K" in c.says), claims.UNDECIDED)

        scene.hidden = [0] * 100
        unhidden = of({"lk": 5}, good, -0.2, 0.1)
        self.assertEqual([c.verdict for c in unhidden if "tool" in c.says or "robust" in c.says],
                         [claims.NO_OCCASION] * 2)

    def test_changes_with_an_interval(self):
        """The whole interval must be beyond 0.1, the smallest loss that counts."""
        for change, expected in (((-0.3, -0.4, -0.2), claims.HOLDS),
                                 ((-0.3, -0.6, -0.05), claims.UNDECIDED),
                                 ((-0.05, -0.08, 0), claims.FAILS), (None, claims.NO_OCCASION)):
            self.assertEqual(claims.loses(change), expected)
        self.assertEqual(claims.signed((-0.3, -0.4, 0.01)), "−0.300 (−0.400 to +0.010)")

    def test_claims_of_cameras(self):
        scene = types.SimpleNamespace(scale=[1] * 30 + [2.8] * 30 + [0.66] * 40)
        by_scale, wrong = [0.6] * 30 + [0.2] * 70, [0.01] * 60 + [0.3] * 40
        worn, thick = [1 - n / 200 for n in range(100)], [0.5] * 50 + [0] * 10 + [0.5] * 40
        good = {"zoom": {"lk": worn, "ms1": (0.2, 0.6), "ms2": (0.2, 0.6),
                         "sift": (by_scale, wrong), "csd-2012": 0.9},
                "rotation": {"lk": 0.9, "ms1": 0.2, "ms2": 0.2, "sift": 0.6, "csd-2012": 0.9},
                "smoke": {"lk": worn, "ms1": 0.8, "ms2": 0.8, "sift": thick,
                          "csd-2012": [0.9] * 50 + [0.8] * 50}}
        bad = {"zoom": {"lk": 0.9, "ms1": (0.6, 0.1), "ms2": (0.6, 0.1),
                        "sift": ([0.3] * 30 + [0.7] * 70, [0.3] * 60 + [0.1] * 40),
                        "csd-2012": 0.3},
               "rotation": {"lk": 0.4, "ms1": 0.8, "ms2": 0.8, "sift": 0.9, "csd-2012": 0.4},
               "smoke": {"lk": 0.9, "ms1": 0.4, "ms2": 0.4, "sift": 0.5,
                         "csd-2012": [0.9] * 50 + [0.3] * 50}}
        self.check_sequences(claims.of_cameras, "table3", good, bad, scene)

    def test_claims_of_blood(self):
        """Features 0 to 3 are covered in frames 20 to 39. The frames after that are compared with
        the same scene without blood."""
        def video(frames, covered):
            return [{i: (10.0 * i, 5.0,
                         "occluded" if covered and 20 <= n < 40 and i < 4 else "tracked")
                     for i in range(8)} for n in range(frames)]

        def track(lost_from, features):
            return [{i: (10.0 * i + (9 if n >= lost_from and i in features else 0), 5.0, "tracked")
                     for i in range(8)} for n in range(100)]

        wet, dry = video(100, True), video(100, False)
        good, all_wrong = track(100, ()), track(50, range(8))
        lost_there, lost_elsewhere = track(40, range(4)), track(40, range(4, 8))
        for tracks, expected in (
                ((lost_there, good), claims.HOLDS), ((all_wrong, all_wrong), claims.UNDECIDED),
                ((lost_elsewhere, good), claims.UNDECIDED), ((good, lost_there), claims.FAILS)):
            self.assertEqual(verdicts(claims.of_blood(truth.aftermath(wet, dry, *tracks))),
                             [expected] * 2)
        # Without blood, as on a heart that beats hard, a tracker that degrades says nothing about
        # blood.
        self.assertEqual(verdicts(claims.of_blood(truth.aftermath(dry, dry, all_wrong, good))),
                         [claims.NO_OCCASION] * 2)
        self.assertEqual(truth.aftermath(wet, dry, all_wrong, good), [(-50 / 60, 50 / 60)] * 4,
                         "wrong in 50 of the 60 frames after")

    def test_claims_of_cost(self):
        paper_says = {"exhaustive_over_ranked": 10, "retraining_is_rare_after_frames": 2,
                      "track_ms_mean": 1.9}

        def of(exhaustive, later, tracking):
            return claims.of_cost(types.SimpleNamespace(
                cost={"exhaustive": [(exhaustive, 9, 1)] * 4,
                      "ranked": [(1, 10, 9)] * 2 + [(1, later, tracking)] * 2}), paper_says)

        self.assertEqual(verdicts(of(10, 1, 0.5)), [claims.HOLDS] * 3)
        self.assertEqual(verdicts(of(2, 5, 3)), [claims.FAILS] * 3)

    def test_two_trackers_together(self):
        video = [{0: (0, 0, "tracked"), 1: (9, 0, "tracked")},
                 {0: (0, 0, "tracked"), 1: (9, 0, "occluded")}] * 2
        right, wrong, silent = (0, 1, "tracked"), (0, 50, "tracked"), (0, 0, "lost")
        first = [{0: right, 1: wrong}, {0: right, 1: wrong}, {0: silent, 1: silent}, {0: right}]
        other = [{0: right, 1: (9, 1, "tracked")}, {0: silent}, {0: right, 1: silent},
                 {0: right, 1: silent}]
        # Of 6 visible features the first tracker finds 3 with 5 claims. The other finds 2 more, one
        # of them where the first claims nothing. In 3 claims both agree, and 2 of these are right.
        expected = (3 / 6, 1 - 3 / 5, 5 / 6, 1 / 6, 2 / 6, 1 - 2 / 3)
        for found, wanted in zip(truth.together(video, first, other), expected):
            self.assertAlmostEqual(found, wanted)
        self.assertEqual(truth.together(video, [{}] * 4, other)[:3], (0, None, 4 / 6))

    def test_deformation_scale_and_hidden_share(self):
        """Two features are 2 apart, then 6 apart, and one of them is hidden. Each has moved by
        2."""
        scene = truth.Truth([{0: (0, 0, "tracked"), 1: (2, 0, "tracked")},
                             {0: (-2, 0, "tracked"), 1: (4, 0, "occluded")}])
        self.assertEqual((scene.deformation, scene.scale, scene.hidden), ([0, 2], [1, 3], [0, 0.5]))

    def test_windows_of_frames(self):
        """Feature 0 is lost after frame 4 of 10. Feature 1 is hidden in the second half, so it says
        nothing about a change. Feature 2 is always found."""
        video = [{0: (0, 0, "tracked"), 1: (9, 0, "occluded" if n > 4 else "tracked"),
                  2: (20, 0, "tracked")} for n in range(10)]
        tracks = [{0: (0, 0, "tracked" if n <= 4 else "lost"), 1: (9, 0, "tracked"),
                   2: (20, 4.9, "learning")} for n in range(10)]
        self.assertEqual(truth.change(video, tracks, range(5), range(4, 10)), [-5 / 6, 0, 0])
        self.assertEqual(truth.change(video, tracks, range(5), range(5, 10)), [-1, 0])
        self.assertEqual(truth.fifths(10), (range(2), range(8, 10)))

    def test_verdicts_of_readings_are_marked(self):
        """All of them, as the legend says that verdicts without the mark rest on an interval."""
        for verdict in (claims.HOLDS, claims.FAILS, claims.UNDECIDED, claims.NO_OCCASION):
            self.assertTrue(
                evaluation.verdict(claims.Claim("", "", verdict, ""), True).endswith(" †"), verdict)
            self.assertNotIn("†",
                             evaluation.verdict(claims.Claim("", "", verdict, "", False), True))
        self.assertEqual(evaluation.verdict(claims.Claim("", "", claims.HOLDS, "", False), True),
                         "**holds**")
        self.assertEqual(evaluation.verdict(claims.Claim("", "", claims.HOLDS, "", False), False),
                         "holds", "in a quick run")

    def test_seeds_in_words(self):
        """Sequences with one seed are named. A title with a comma stays one title."""
        kinds = [types.SimpleNamespace(title=t, seeds=(1,) * n)
                 for t, n in (("heart", 3), ("rotation, smoke", 1), ("fat", 1))]

        def said(kinds, of, spent=(600, 300), clock=None):
            return evaluation.effort(types.SimpleNamespace(sequences=kinds), spent, clock, "They",
                                     of)

        self.assertIn("They stand on 3 seeds of each sequence. There is one seed only of "
                      "“rotation, smoke”; “fat”.", said(kinds, kinds))
        self.assertIn("5 min of processor time, 10 min one after the other (several run at a "
                      "time).", said(kinds, kinds))
        self.assertIn("and 7 min by the clock, 2 at a time.", said(kinds, kinds, (1, 1), (420, 2)))
        self.assertNotIn("only", said(kinds[:1], kinds[:1]))
        # Scenes that the figures don't use change nothing.
        self.assertIn("They stand on 1 seed of each sequence. One seed is few clips",
                      said(kinds, kinds[1:]))

    def test_versions_of_runs(self):
        """Versions that differ are all named. Where a run has none, the page says that its own time
        counts."""
        plan = types.SimpleNamespace(runs=lambda: [(PLAN.sequence("zoom"), 1),
                                                   (PLAN.sequence("zoom"), 2)])
        with tempfile.TemporaryDirectory() as out:
            def made(seed, **run):
                folder = running.folder_of(pathlib.Path(out), PLAN.sequence("zoom"), seed)
                folder.mkdir(exist_ok=True)
                (folder / "run.json").write_text(json.dumps(run))
                return running.versions(plan, pathlib.Path(out)) if seed == 2 else None

            made(1, versions={"OpenCV": "1.0", "processor": "slow"})
            self.assertEqual(made(2, versions={"OpenCV": "1.1", "processor": "slow"}),
                             {"OpenCV": "1.0; 1.1", "processor": "slow"})
            self.assertIn("when this page was written", made(2)["these"])

    def test_seeds(self):
        plan = sequences.paper(2)
        self.assertEqual(sorted(s.frames for s, _ in plan.runs() if s.figure),
                         [500] * 18 + [4000] * 3)
        self.assertEqual(min(seed for _, seed in plan.runs()), 101,
                         "seeds 1 to 20 are for development")

    def test_textures(self):
        """Every second scene has real tissue, and so has each long simulation. Without the pictures
        no scene has."""
        with (tempfile.TemporaryDirectory() as folder,
              unittest.mock.patch.object(sequences, "TISSUE", pathlib.Path(folder))):
            self.assertEqual({s.texture(seed) for s, seed in sequences.paper(2).runs()}, {None})
            self.assertIn("were not there", evaluation.tissue_in_words(sequences.paper(2)))
            for *_, pictures in (*sequences.KINDS, sequences.MORE, sequences.DRY):
                for picture in filter(None, pictures):
                    (pathlib.Path(folder) / picture).touch()
            plan = sequences.paper(2)
            zoom = plan.sequence("zoom")
            self.assertEqual([zoom.texture(seed) for seed in zoom.seeds],
                             [None, f"{folder}/uterus.png"])
            self.assertIn("style=peritoneum seed=101", zoom.source(101))
            self.assertRegex(zoom.source(102),
                             f'texture="{folder}/uterus.png" seed=102 .* ! x264enc')
            self.assertEqual([s.texture(seed) for s, seed in plan.runs() if s.frames == 4000],
                             [f"{folder}/{p}"
                              for p in ("heart.png", "gallbladder-a.png", "liver.jpg")])
            self.assertEqual(plan.sequence("dry").textures, plan.sequence("irrigation").textures,
                             "the dry scene must be the same without blood")
            self.assertEqual(evaluation.settings(zoom),
                             "scenario=zoom style=peritoneum or texture=uterus.png")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
