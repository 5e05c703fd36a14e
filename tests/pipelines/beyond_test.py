#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/beyond --quick runs, resumes, and leaves other files alone.

beyond_test.py ROOT BUILD"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

from pipelines.experiments import reach, reach_pages, sequences, truth

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])
RIVALS = {"lk", "ms1", "ms2", "lk-fb", "lk-anchored", "still", "csrt", "kcf", "medianflow",
          "csd-2012", "sift"}
KEPT = "of the clips, measured before\n"


def beyond(*arguments, clips="/nowhere"):
    return subprocess.run([ROOT / "pipelines" / "experiments" / "beyond", "--no-install",
                           *map(str, arguments)],
                          capture_output=True, text=True,
                          env={**os.environ, "CSDTRACK_BUILD": str(BUILD), "CSDTRACK_CLIPS": clips})


class Quick(unittest.TestCase):
    """Runs without the clips, in a folder that already has the page about them."""

    @classmethod
    def setUpClass(cls):
        cls.out = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-beyond-"))
        cls.addClassCleanup(shutil.rmtree, cls.out)
        (cls.out / "beyond-clips.md").write_text(KEPT)
        done = beyond("--quick", "--out", cls.out)
        assert done.returncode == 0, done.stderr
        cls.page = (cls.out / "beyond.md").read_text()
        # This process's plan has no clips either.
        cls.runs = {f"{name}-101" for name, *_ in sequences.BEYOND_KINDS}

    def rows(self, after):
        """The rows of the first table after this text, as lists of cells; without the line below
        the header."""
        lines = self.page.split(after, 1)[1].splitlines()
        first = next(i for i, line in enumerate(lines) if line.startswith("|"))
        rows = []
        for line in lines[first:]:
            if not line.startswith("|"):
                break
            rows.append([cell.strip() for cell in line[1:-1].split("|")])
        return rows[:1] + rows[2:]

    def test_every_scenario_has_its_row(self):
        header, *rows = self.rows("one after the other")
        self.assertEqual(header[:6], ["scenario", "the paper's CSD in vivo", "to reach",
                                      "csd: sensitivity", "csd: K", "median, px"])
        by_title = {row[0]: row for row in rows}
        self.assertEqual(list(by_title), [goals["title"] for goals in reach.GOALS["rows"].values()])
        self.assertEqual([row[1] for row in rows],
                         ["0.752 / 0.170", "0.728 / 0.144", *["0.892 / 0.076"] * 3, "–", "–", "–"],
                         "as in the paper's tables")
        still = by_title["rotation −50…120°"]
        self.assertEqual(still[2], "sensitivity ≥ 0.998; K ≤ 0.001")
        self.assertRegex(still[3], r"^[01]\.\d{4} \([01]\.\d{4}–[01]\.\d{4}\)$")
        for title in ("occlusion by tools; irrigation",
                      "black for 2 s while the view turns; cut and return; lens wipe"):
            self.assertIn("no occasion", by_title[title][-1], "nothing is hidden in ten frames")
        for name in (s for s, *_ in sequences.BEYOND_KINDS):
            self.assertTrue((self.out / f"{name}-101" / "csd.jsonl").exists())

    def test_every_rival_has_its_row_in_each_scenario(self):
        """The summary counts these rows."""
        won = 0
        for goals in reach.GOALS["rows"].values():
            header, *rows = self.rows(f"\n{goals['title']}:\n")
            self.assertEqual(header[0], "rival")
            self.assertEqual({row[0] for row in rows}, RIVALS)
            for row in rows:
                for cell in row[1:4]:
                    self.assertRegex(cell,
                                     r"^[01]\.\d{3}, [01]\.\d{3} \(p (< \.001|[01]\.\d{3})\)$")
            won += sum(row[4] in ("**above**", "equal") for row in rows)
        self.assertIn(f"In {won} of {len(RIVALS) * len(reach.GOALS['rows'])} pairs", self.page)

    def test_a_tracker_that_never_moves_scores_below_csd(self):
        """On the deforming heart, within ten frames."""
        row = next(r for r in self.rows(f"\n{reach.GOALS['rows']['deformation']['title']}:\n")
                   if r[0] == "still")
        rival, csd = (float(value) for value in row[1].split(" (")[0].split(", "))
        self.assertLess(rival, csd)

    def test_other_files_stay(self):
        self.assertEqual((self.out / "beyond-clips.md").read_text(), KEPT)
        self.assertEqual({p.name for p in self.out.iterdir() if p.is_dir()}, self.runs | {"beyond"})
        self.assertEqual(list(self.out.rglob(".unfinished*")), [])

    def test_the_reliability_diagram_is_drawn(self):
        self.assertEqual(self.page.count("![](beyond/calibration.svg)"), 1)
        self.assertEqual([path.name for path in self.out.rglob("*.svg")], ["calibration.svg"])
        drawn = (self.out / "beyond" / "calibration.svg").read_text()
        for text in ("all sequences", "everything mixed", "perfect", "reliability"):
            self.assertIn(f">{text}<", drawn)

    def test_resumes(self):
        """Complete runs are not repeated. A run that lacks a tracker is, with the same result."""
        made = {name: (self.out / name / "run.json").stat().st_mtime_ns for name in self.runs}
        (self.out / "faint-101" / "csd.jsonl").unlink()
        done = beyond("--quick", "--out", self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{len(made) - 1} of {len(made)} runs were there already", done.stderr)
        self.assertEqual({name for name in made
                          if (self.out / name / "run.json").stat().st_mtime_ns != made[name]},
                         {"faint-101"})
        # All but the time that the runs took, and the state of the repository: somebody may work in
        # it meanwhile.
        again, before = ([line for line in text.splitlines()
                          if "of processor time" not in line and
                          not line.startswith("| csdtrack |")]
                         for text in ((self.out / "beyond.md").read_text(), self.page))
        self.assertEqual(again, before)


def interval(value):
    return {"value": value, "low": value, "high": value}


class Numbers(unittest.TestCase):
    def row(self, goals, **csd):
        figures = {"sensitivity": interval(1), "k": interval(0), "error": {"median": 0.1}, **csd}
        return reach.Row("title", goals, [],
                         {"tracked": types.SimpleNamespace(trackers={"csd": figures})})

    def judged(self, goals, **csd):
        return reach.verdict(reach.criteria(self.row(goals, **csd), pathlib.Path("/nowhere")))

    def test_verdicts(self):
        """A figure equal to the goal reaches it; a slightly worse one does not."""
        goals = {"sensitivity": 0.99, "k": 0.003, "median": 0.2}
        self.assertEqual(self.judged(goals, sensitivity=interval(0.99), k=interval(0.003),
                                     error={"median": 0.2}), "**reached**")
        self.assertEqual(self.judged(goals, sensitivity=interval(0.98999)),
                         "not reached: sensitivity")
        self.assertEqual(self.judged(goals, k=interval(0.00301), error={"median": 0.21}),
                         "not reached: K, median")
        self.assertEqual(self.judged(goals, sensitivity=interval(None), k=interval(None)),
                         "not reached: sensitivity, K", "an unknown figure is not good")

    def test_time_until_a_return(self):
        goals = {"k": 0.003, "frames_until": 3}
        for frames, times, expected in ((3, 5, "**reached**"),
                                        (4, 5, "not reached: median of the return"),
                                        (None, 5, "not reached: median of the return"),
                                        (None, 0, "no occasion: median of the return")):
            recovery = {"median_frames": frames, "recovered": 1, "returns": times}
            self.assertEqual(self.judged(goals, recovery=recovery), expected)

    def test_whether_the_last_fifth_is_as_good(self):
        """The last fifth is as good where the interval includes 0 and no loss above 0.01. A wider
        interval shows nothing."""
        sequence = sequences.beyond(1).sequence("mixed")
        for change, expected in (((-0.1, -0.2, -0.01), False), ((-0.1, -0.2, 0), False),
                                 ((-0.005, -0.01, 0), True), ((0, -0.0101, 0.01), False),
                                 ((-0.005, -0.009, -0.001), False), ((0.1, 0.05, 0.2), True),
                                 (None, False)):
            scores = types.SimpleNamespace(
                change=lambda *_, c=change: c, part=lambda *_: 0.5,
                trackers={"csd": {"error": {"first_fifth": 0.1, "last_fifth": 0.2}}})
            found = reach.lasting(reach.Row("", {"lasting": 0.01}, [sequence], {"tracked": scores}))
            self.assertIs(found.reached, expected)
            self.assertIn("no loss of sensitivity beyond 0.01", found.goal)

    def test_above_equal_or_below(self):
        """Above or below needs p < .01. Where both round to 1.000 they are equal, whatever p is."""
        for rival, csd, p, expected in ((0.8, 0.9, 0.009, "above"), (0.9, 0.8, 0.009, "below"),
                                        (0.8, 0.9, 0.01, "not told apart"),
                                        (1, 0.9996, 0.001, "equal"), (0.9994, 1, 0.001, "above"),
                                        (None, 1, 0.001, "unknown")):
            self.assertEqual(reach.standing(rival, csd, p), expected)
        three = {"delta_avg": (1, 1, 1, "equal"), "aj": (0.8, 0.9, 0, "above"),
                 "oa": (0.8, 0.9, 0, "above")}
        self.assertEqual(reach.all_of(three), "**above**")
        self.assertEqual(reach.all_of({**three, "oa": (0.9, 0.8, 0, "below")}), "OA: below")
        self.assertEqual(reach.all_of(dict.fromkeys(three, (1, 1, 1, "equal"))), "equal")

    def test_returns(self):
        """All six features are hidden in frames 10 to 19. 0 is found in the tenth frame after that,
        1 in the eleventh. 2 is hidden alone five frames later and is never found. 3 is outside the
        picture at first. 4 is never found. 5 is found at once, and again after it was hidden
        alone."""
        def state(i, n):
            if 10 <= n < 20 or (i == 2 and 25 <= n < 28) or (i == 5 and 30 <= n < 35):
                return "occluded"
            return "out" if i == 3 and 20 <= n < 28 else "tracked"

        since = {0: 29, 1: 30, 2: 99, 3: 28, 4: 99, 5: 20}
        video = [{i: (10 * i, 0, state(i, n)) for i in range(6)} for n in range(50)]
        tracks = [{i: (10 * i, 0, "tracked" if n < 10 or n >= since[i] else "lost")
                   for i in range(6)} for n in range(50)]
        self.assertEqual(truth.returns(video, tracks, 10, 0.2), [True, False, True, False, True])
        self.assertEqual(truth.returns(video, tracks, 10, 0.1),
                         [True, False, False, True, False, True, True], "one in six is enough")
        self.assertEqual(truth.returns(video[:25], tracks[:25], 10, 0.2), [True],
                         "a return cut off by the end counts for no other feature")

    def test_angle_and_scale_of_a_turned_view(self):
        a = {0: (1, 0, ""), 1: (-1, 0, ""), 2: (0, 1, ""), 3: (0, -1, "")}
        b = {i: (5 - 2 * y, 3 + 2 * x, "") for i, (x, y, _) in a.items()}
        angle, scale = truth.turned(a, b)
        self.assertAlmostEqual(angle, 90)
        self.assertAlmostEqual(scale, 2)

    def test_how_the_view_moves_while_it_is_black(self):
        """Two seeds with two black frames each. One view turns by 90°; the other turns by 180° and
        grows by half."""
        plan = sequences.beyond(2)
        with tempfile.TemporaryDirectory() as out:
            for seed, after in ((101, lambda x, y: (-y, x)),
                                (102, lambda x, y: (-1.5 * x, -1.5 * y))):
                folder = pathlib.Path(out) / f"black-{seed}"
                folder.mkdir()
                with open(folder / "truth-tracked.jsonl", "w") as file:
                    for n in range(6):
                        points = [p if n < 3 else after(*p) for p in ((1, 0), (-1, 0), (0, 2))]
                        json.dump({"features": [{"id": i, "x": x, "y": y,
                                                 "state": "occluded" if n in (2, 3) else "tracked"}
                                                for i, (x, y) in enumerate(points)]}, file)
                        file.write("\n")
            said = reach_pages.black_in_words(plan, pathlib.Path(out))
        self.assertIn("In the dark, 2 frames (0.08 s), the view turns by 90° to 180°", said)
        self.assertIn("by a factor of 1.00 to 1.50", said)

    def test_verdicts_of_palindromes(self):
        found = {"palindromes": [{"tracks": f"{name}/csd.jsonl",
                                  "claimed": goals["claimed"] - (name == "heart") / 100,
                                  "apart": goals["apart"] + (name == "smoke") / 100,
                                  "counts": {"features": 50, "frames": 499}}
                                 for name, goals in reach.GOALS["palindromes"].items()]}
        verdicts = {line.split("|")[1].strip(): line.split("|")[-2].strip()
                    for line in reach_pages.palindromes_part(found).splitlines()[2:]}
        self.assertEqual(verdicts, {"heart": "not reached: claimed", "abdomen": "**reached**",
                                    "beads": "**reached**", "cholecystectomy": "**reached**",
                                    "cutting": "**reached**", "smoke": "not reached: apart"})

    def test_plan(self):
        plan = sequences.beyond(3)
        self.assertEqual([s.frames for s in plan.of_table("mixed")], [4000])
        self.assertEqual({s.features for s in plan.sequences}, {100})
        self.assertEqual(min(seed for _, seed in plan.runs()), 101,
                         "seeds 1 to 20 are for development")
        wipe = plan.sequence("wipe")
        self.assertEqual([[share.name for share in plan.shares_of(wipe, seed)]
                          for seed in wipe.seeds],
                         [["tracked", "slow", "early"], ["tracked", "slow"], ["tracked", "slow"]])
        self.assertEqual({t for share in plan.shares for t in share.trackers}, RIVALS | {"csd"})
        rows = set(reach.GOALS["rows"])
        self.assertEqual({s.table for s in plan.sequences} - {"pictures"}, rows)
        self.assertEqual({name for name, *_ in sequences.PICTURE_KINDS},
                         set(reach.GOALS["pictures"]))


class Errors(unittest.TestCase):
    def test_wrong_options_are_refused(self):
        for arguments in (["--seeds", "0"], ["--jobs", "none"], ["--nothing"], ["surplus"]):
            with self.subTest(arguments):
                done = beyond(*arguments)
                self.assertEqual(done.returncode, 2)
                self.assertIn(arguments[-1], done.stderr)

    def test_help(self):
        done = beyond("--help")
        self.assertEqual(done.returncode, 0)
        self.assertIn("--quick", done.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
