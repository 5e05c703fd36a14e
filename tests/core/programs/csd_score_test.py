#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd-score as users run it. On random data its numbers must equal those of score_reference.py.

$CSD_SCORE is the program."""

import csv
import io
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

import numpy as np

import score_reference as reference

SIZE = (720, 576)


class Scene:
    """Random truth, and tracks that are sometimes near it, sometimes far off, sometimes lost."""

    def __init__(self, seed, features=7, frames=60):
        random = np.random.default_rng(seed)
        shape = (features, frames)
        self.truth = (random.uniform(100, 450, (features, 1, 2)) +
                      np.cumsum(random.normal(0, 3, (*shape, 2)), axis=1)).round(3)
        # Errors from tenths of pixels to hundreds, so that there are some on both sides of each
        # threshold.
        angle, off = random.uniform(0, 2 * np.pi, shape), 10 ** random.uniform(-1, 2.5, shape)
        self.tracks = (self.truth + np.stack([off * np.cos(angle), off * np.sin(angle)],
                                             -1)).round(3)
        self.tracks[:, :3] = self.truth[:, :3]  # else csd-score notes that they begin elsewhere
        self.labelled = random.random(shape) < 0.9
        self.labelled[:, :3] = True
        self.visible = self.labelled & (random.random(shape) < 0.8)
        self.claimed = random.random(shape) < 0.75
        self.confidence = random.random(shape).round(3)

    def write_truth(self, path, first_frame=0):
        with open(path, "w", newline="") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(["frame", "id", "x", "y", "visible"])
            for (feature, frame), labelled in np.ndenumerate(self.labelled):
                visible = int(self.visible[feature, frame]) if labelled else 2
                out.writerow([frame + first_frame, feature, *self.truth[feature, frame], visible])

    def write_tracks(self, path, algorithm="random", role="track", size=SIZE):
        with open(path, "w") as file:
            for frame in range(self.claimed.shape[1]):
                places = zip(self.tracks[:, frame], self.claimed[:, frame])
                features = [{"id": i, "x": x, "y": y, "state": "tracked" if claimed else "lost",
                             "confidence": self.confidence[i, frame] if claimed else 0}
                            for i, ((x, y), claimed) in enumerate(places)]
                file.write(json.dumps({"schema": 1, "source": "csdtrack0", "role": role,
                                       "algorithm": algorithm, "frame": frame,
                                       "pts": frame * 40000000, "width": size[0], "height": size[1],
                                       "features": features}) + "\n")

    def write_truth_jsonl(self, path):
        with open(path, "w") as file:
            for frame in range(self.claimed.shape[1]):
                features = [{"id": i, "x": x, "y": y,
                             "state": "tracked" if self.visible[i, frame] else "occluded",
                             "confidence": float(self.visible[i, frame])}
                            for i, (x, y) in enumerate(self.truth[:, frame])
                            if self.labelled[i, frame]]
                file.write(json.dumps({"schema": 1, "role": "truth", "algorithm": "truth",
                                       "frame": frame + 1000, "pts": frame * 40000000,
                                       "width": SIZE[0], "height": SIZE[1],
                                       "features": features}) + "\n")

    def write_tracks_csv(self, path):
        with open(path, "w", newline="") as file:
            out = csv.writer(file, lineterminator="\n")
            out.writerow(["frame", "pts", "stream_time", "id", "x", "y", "state", "confidence",
                          "fresh"])
            for frame in range(self.claimed.shape[1]):
                for i, (x, y) in enumerate(self.tracks[:, frame]):
                    claimed = self.claimed[i, frame]
                    out.writerow([frame, frame * 40000000, "", i, x, y,
                                  "tracked" if claimed else "occluded",
                                  self.confidence[i, frame] if claimed else 0, "true"])


def run(*arguments, cwd=None):
    return subprocess.run([os.environ["CSD_SCORE"], *map(str, arguments)], capture_output=True,
                          text=True, cwd=cwd)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)

    def write(self, scene, name="a", algorithm="random"):
        truth, tracks = self.tmp / f"{name}.truth", self.tmp / f"{name}.tracks"
        scene.write_truth(truth)
        scene.write_tracks(tracks, algorithm)
        return truth, tracks

    def report(self, *arguments):
        done = run("--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def assert_close(self, found, expected):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


class Numbers(Case):
    def test_scores_equal_the_reference(self):
        for seed in range(5):
            with self.subTest(seed=seed):
                scene = Scene(seed)
                found = self.report("--resamples", 10, *self.write(scene))["trackers"][0]
                data = scene.truth, scene.tracks, scene.labelled, scene.visible, scene.claimed

                within, jaccard, agreed = reference.tap_vid(*data, SIZE)
                self.assert_close(found["tap_vid"]["within"], within)
                self.assert_close(found["tap_vid"]["jaccard"], jaccard)
                self.assert_close(found["delta_avg"]["value"], within.mean())
                self.assert_close(found["aj"]["value"], jaccard.mean())
                self.assert_close(found["oa"]["value"], agreed)

                within, jaccard, agreed = reference.stir_2026(*data)
                self.assert_close(found["stir_2026"]["within"], within)
                self.assert_close(found["stir_2026"]["jaccard"], jaccard)
                self.assert_close(found["stir_2026"]["aj"], jaccard.mean())
                self.assert_close(found["stir_2026"]["oa"], agreed)

                for point in found["curve"]:
                    sensitivity, k = reference.paper(*data, point["pixels"])
                    self.assert_close(point["sensitivity"], np.nanmean(sensitivity))
                    self.assert_close(point["k"], np.nanmean(k))
                    if point["pixels"] == 5:
                        self.assert_close(found["sensitivity"]["value"], point["sensitivity"])
                        self.assert_close(
                            np.array(found["clips"][0]["sensitivity_by_frame"], float), sensitivity)
                        self.assert_close(np.array(found["clips"][0]["k_by_frame"], float), k)

                self.assert_close(found["survival"]["value"],
                                  reference.survival(scene.truth, scene.tracks, scene.labelled,
                                                     scene.visible, SIZE))
                errors = reference.distances(scene.truth, scene.tracks,
                                             1.0)[scene.visible & scene.claimed]
                self.assert_close(found["error"]["median"], np.median(errors))
                self.assert_close(found["error"]["percentile_95"], np.percentile(errors, 95))

    def test_other_formats_give_the_same_scores(self):
        scene = Scene(6)
        truth, tracks = self.write(scene)
        scene.write_truth_jsonl(self.tmp / "1")  # frames numbered otherwise: matched by pts
        scene.write_tracks_csv(self.tmp / "2")
        plain = self.report("--resamples", 50, truth, tracks)["trackers"][0]
        for files in ((self.tmp / "1", tracks), (truth, self.tmp / "2"),
                      (self.tmp / "1", self.tmp / "2")):
            other = self.report("--resamples", 50, "--size", "720x576", *files)["trackers"][0]
            other["name"] = plain["name"]
            seconds = other["recovery"]["median_seconds"]
            self.assertEqual(seconds,
                             None if files[0] == truth else other["recovery"]["median_frames"] / 25)
            other["recovery"]["median_seconds"] = plain["recovery"]["median_seconds"]
            self.assertEqual(other, plain)

    def test_means_over_clips(self):
        scenes = [Scene(11, 4, 30), Scene(12, 9, 50)]
        files = [file for i, scene in enumerate(scenes) for file in self.write(scene, f"clip{i}")]
        found = self.report("--resamples", 0, *files)
        each = [reference.tap_vid(s.truth, s.tracks, s.labelled, s.visible, s.claimed, SIZE)
                for s in scenes]
        tracker = found["trackers"][0]
        self.assert_close(tracker["aj"]["value"],
                          np.mean([jaccard.mean() for _, jaccard, _ in each]))
        self.assert_close(tracker["delta_avg"]["value"],
                          np.mean([within.mean() for within, _, _ in each]))
        self.assertEqual([clip["features"] for clip in found["clips"]], [4, 9])
        self.assertIsNone(tracker["aj"]["low"], "no draws, no interval")

    def test_ids_scores_only_the_chosen_features(self):
        scene = Scene(3)
        some = self.report("--ids", "1,4-6", "--resamples", 0, *self.write(scene))
        chosen = [1, 4, 5, 6]
        sensitivity, _ = reference.paper(
            *(a[chosen] for a in (scene.truth, scene.tracks, scene.labelled, scene.visible,
                                  scene.claimed)), 5)
        self.assert_close(some["trackers"][0]["sensitivity"]["value"], np.nanmean(sensitivity))


class Output(Case):
    def setUp(self):
        super().setUp()
        self.truth, self.a = self.write(Scene(1), algorithm="csd-2012")
        self.b = self.tmp / "b.tracks"
        other = Scene(1)
        other.tracks = other.truth + 0.25
        other.write_tracks(self.b, "lk")

    def test_table(self):
        done = run(self.truth, self.a, self.b)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        lines = done.stdout.splitlines()
        self.assertEqual(lines[0], f"{self.truth}: 7 features, 60 labelled frames, 720×576")
        self.assertIn("10000 draws of the features", lines[1])
        self.assertEqual(len([line for line in lines if line.startswith("  lk ")]), 6,
                         "in each table, and in the comparison")
        self.assertIn("Difference from csd-2012, and p", lines)

    def test_csv_and_markdown_say_what_json_says(self):
        report = self.report("--resamples", 100, self.truth, self.a, self.b)
        named = self.tmp / 'the 2", again'  # what CSV must quote
        shutil.copy(self.truth, named)
        done = run("--csv", "--resamples", 100, named, self.a, self.b)
        rows = {(row["tracker"], row["clip"], row["metric"], row["threshold"]): row
                for row in csv.DictReader(io.StringIO(done.stdout))}
        for tracker in report["trackers"]:
            for metric in ("sensitivity", "k", "delta_avg", "aj", "oa", "survival"):
                row = rows[tracker["name"], "", metric, ""]
                for column in ("value", "low", "high"):
                    self.assertAlmostEqual(float(row[column]), tracker[metric][column], 6)
            self.assertAlmostEqual(float(rows[tracker["name"], "", "k_at", "16"]["value"]),
                                   tracker["curve"][5]["k"], 6)
            self.assertEqual(int(rows[tracker["name"], str(named), "missed", ""]["value"]),
                             tracker["clips"][0]["counts"]["missed"])
        done = run("--markdown", "--resamples", 0, self.truth, self.a, self.b)
        tables = [table.splitlines() for table in done.stdout.strip().split("\n\n")
                  if table.startswith("|")]
        self.assertEqual(len(tables), 6)
        self.assertIn(f"* {self.truth}: ", done.stdout)
        for table in tables:
            self.assertEqual(len({line.count("|") for line in table}), 1, table)
        sensitivity = report["trackers"][1]["sensitivity"]["value"]
        self.assertEqual([cell.strip() for cell in tables[0][3].split("|")][1:3],
                         ["lk", f"{sensitivity:.3f}"])

    def test_intervals_contain_the_score_and_differences_add_up(self):
        report = self.report("--resamples", 999, self.truth, self.a, self.b)
        for tracker in report["trackers"]:
            for metric in ("sensitivity", "k", "delta_avg", "aj", "oa"):
                self.assertLessEqual(tracker[metric]["low"], tracker[metric]["value"])
                self.assertGreaterEqual(tracker[metric]["high"], tracker[metric]["value"])
        difference = report["comparisons"][0]["delta_avg"]
        self.assertAlmostEqual(difference["difference"],
                               report["trackers"][1]["delta_avg"]["value"] -
                               report["trackers"][0]["delta_avg"]["value"])
        self.assertAlmostEqual(difference["p"], 2 ** (1 - 7),
                               msg="with seven features it can't be 2/1000")
        self.assertEqual(report["comparisons"][0]["oa"]["p"], 1, "both trackers claim the same")

    def test_plots(self):
        done = run("--plots", self.tmp / "plots", "--resamples", 0, "--names", "it's {a},b_1",
                   self.truth, self.a, self.b)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        for name in ("over-time", "over-threshold", "reliability"):
            svg = xml.etree.ElementTree.parse(self.tmp / "plots" / f"{name}.svg")
            text = " ".join(" ".join(node.itertext())
                            for node in svg.iter("{http://www.w3.org/2000/svg}text"))
            self.assertIn("it's {a}", text)
            self.assertIn("b_1", text)
            self.assertEqual((self.tmp / "plots" / f"{name}.png").read_bytes()[:4], b"\x89PNG")
        done = run("--plots", self.truth / "x", self.truth, self.a)
        self.assertEqual(done.returncode, 1)

    def test_code_in_an_algorithms_name_is_not_run(self):
        trace = self.tmp / "trace"
        Scene(1).write_tracks(self.tmp / "hostile",
                              algorithm=f"csd'\nsystem(\"touch {trace}\")\n#\x1b[2J")
        done = run("--plots", self.tmp / "plots", "--resamples", 0, self.truth,
                   self.tmp / "hostile")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertFalse(trace.exists(), "gnuplot ran it")
        self.assertNotIn("\x1b", done.stdout, "a terminal would obey it")
        self.assertIn("csd'?system(", done.stdout)

    def test_plots_where_nothing_is_claimed(self):
        silent = Scene(1)
        silent.claimed[:] = False
        silent.write_tracks(self.tmp / "silent")
        done = run("--plots", self.tmp / "plots", "--resamples", 0, self.truth, self.tmp / "silent")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_trackers_are_named_by_algorithm_or_as_given(self):
        names = [t["name"] for t in self.report("--resamples", 0, self.truth, self.a, self.a,
                                                self.b)["trackers"]]
        self.assertEqual(names, ["csd-2012 (a)", "csd-2012 (a)", "lk"])
        names = [t["name"] for t in self.report("--resamples", 0, "--names", "x,y", self.truth,
                                                self.a, self.b)["trackers"]]
        self.assertEqual(names, ["x", "y"])

    def test_print_points(self):
        (self.tmp / "points").write_text("frame,id,x,y,visible\n3,1,7,8.25,1\n3,0,5.5,6,1\n"
                                         "9,0,1,1,0\n")
        self.assertEqual(run("--print-points", self.tmp / "points").stdout,
                         "5.500,6.000;7.000,8.250\n")
        (self.tmp / "points").write_text("frame,id,x,y,visible\n3,1,7,8.25,1\n3,0,5.5,6,0\n")
        done = run("--print-points", self.tmp / "points")
        self.assertEqual(done.returncode, 1)
        self.assertIn("feature 0", done.stderr)

    def test_help(self):
        done = run("--help")
        self.assertEqual(done.returncode, 0)
        for word in ("TRUTH TRACKS", "--plots", "labels.json", "Exit code"):
            self.assertIn(word, done.stdout)


class Palindrome(Case):
    def write_there_and_back(self, name, algorithm, frames=30, **still):
        """Writes tracks of a video that plays forwards, then backwards. With `still` nothing
        moves."""
        scene = Scene(4, frames=frames)
        if still:
            scene.tracks[:], scene.claimed[:] = scene.tracks[:, :1], True
        scene.write_tracks(self.tmp / name, algorithm)
        return scene, self.tmp / name

    def test_counts_equal_those_by_numpy(self):
        for frames in (30, 31):
            scene, tracks = self.write_there_and_back("tracks", "lk", frames)
            row, = self.report("--palindrome", tracks)["palindromes"]
            begun = scene.claimed[:, 0]
            path, claimed = scene.tracks[begun], scene.claimed[begun]
            off = np.linalg.norm(path - path[:, ::-1], axis=2)[:, :frames // 2]
            both = (claimed & claimed[:, ::-1])[:, :frames // 2]
            self.assertEqual(row["counts"],
                             {"frames": frames, "features": begun.sum(), "claims": claimed.sum(),
                              "pairs": both.sum(), "apart": (both & (off > 5)).sum(),
                              "returned": (both & (off <= 2))[:, 0].sum(),
                              "falsely_returned": (both & (off > 5))[:, 0].sum()})
            self.assert_close(row["claimed"], claimed.mean())
            self.assert_close(row["apart"], (both & (off > 5)).sum() / both.sum())

    def test_means_and_tables(self):
        _, a = self.write_there_and_back("a", "lk")
        _, b = self.write_there_and_back("b", "lk", still=True)
        _, c = self.write_there_and_back("c", "csd-2012", still=True)
        found = self.report("--palindrome", a, b, c)
        self.assertEqual([row["tracker"] for row in found["palindromes"]], ["lk", "lk", "csd-2012"])
        mean, = found["means"]
        self.assertEqual((mean["tracker"], mean["clips"]), ("lk", 2))
        for share in ("claimed", "apart", "returned", "falsely_returned"):
            self.assert_close(mean[share],
                              np.mean([row[share] for row in found["palindromes"][:2]]))
        self.assertEqual([found["palindromes"][2][s]
                          for s in ("claimed", "apart", "returned", "falsely_returned")],
                         [1, 0, 1, 0], "a tracker that never moves")
        text = run("--palindrome", a, b, c).stdout.splitlines()
        self.assertEqual(text[4].split(),
                         [str(c), "csd-2012", "7", "30", "1.000", "0.000", "1.000", "0.000"])
        rows = [line.split("|") for line in run("--palindrome", "--markdown", a, b,
                                                c).stdout.splitlines() if "|" in line]
        self.assertEqual({len(row) for row in rows}, {10})
        self.assertEqual([rows[-1][i].strip() for i in (1, 2, 5)],
                         ["mean of 2", "lk", f"{mean['claimed']:.3f}"])

    def refuse(self, code, text, *arguments):
        done = run(*arguments)
        self.assertEqual((done.returncode, done.stdout), (code, ""))
        self.assertIn(text, done.stderr)

    def test_what_is_no_palindrome_is_refused(self):
        scene, tracks = self.write_there_and_back("tracks", "lk")
        scene.write_truth(self.tmp / "truth")
        scene.write_tracks_csv(self.tmp / "table")
        self.refuse(1, "is truth", "--palindrome", self.tmp / "truth")
        self.refuse(1, "wants csdtrackenc's .jsonl", "--palindrome", self.tmp / "table")
        self.refuse(2, "--palindrome goes with", "--palindrome", "--csv", tracks)
        self.refuse(2, "--palindrome goes with", "--palindrome", "--ids", "1", tracks)
        tracks.write_text(tracks.read_text()[:-9])
        self.refuse(1, "nobody knows where the video turned", "--palindrome", tracks)


class Refusals(Case):
    def refuse(self, code, text, *arguments):
        done = run(*arguments)
        self.assertEqual(done.stdout, "", "no score is printed")
        self.assertIn(text, done.stderr)
        self.assertEqual(done.returncode, code, done.stderr)

    def test_wrong_options_are_refused(self):
        truth, tracks = self.write(Scene(1))
        self.refuse(2, "no files")
        self.refuse(2, "Unknown option --frobnicate", "--frobnicate", truth, tracks)
        self.refuse(2, "one of --json, --csv and --markdown", "--json", "--csv", truth, tracks)
        self.refuse(2, "--size: '640' is not WxH", "--size", "640", truth, tracks)
        self.refuse(2, "--size: both are at least 1", "--size", "640x0", truth, tracks)
        self.refuse(2, "--ids: 'a' is no whole number", "--ids", "1,a", truth, tracks)
        self.refuse(2, "--ids: '5-3' is no range", "--ids", "5-3", truth, tracks)
        self.refuse(2, "--names: 2 names for 1 trackers", "--names", "a,b", truth, tracks)
        self.refuse(2, "--resamples", "--resamples", "-1", truth, tracks)

    def test_a_wrong_order_of_files_is_refused(self):
        truth, tracks = self.write(Scene(1))
        truth2, tracks2 = self.write(Scene(2), "second", algorithm="other")
        self.refuse(1, f"{tracks}: is tracks; the truth comes first", tracks, truth)
        self.refuse(1, f"{truth}: is truth, and no tracks follow", truth)
        self.refuse(1, f"{truth}: is truth, and no tracks follow", truth, truth2, tracks2)
        self.refuse(1, f"{tracks2}: is by 'other', in the clip before 'random'", truth, tracks,
                    truth2, tracks2)
        self.refuse(1, f"{tracks}: is one more than", truth, tracks, truth2, tracks, tracks)
        self.refuse(1, f"{truth2}: has tracks of 1 trackers, the clip before of 2", truth, tracks,
                    tracks, truth2, tracks)

    def test_a_torn_last_line_is_noted(self):
        truth, tracks = self.write(Scene(1))
        whole = tracks.read_text()
        tracks.write_text(whole[:-40])
        done = run(truth, tracks)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr.splitlines(), [
            f"csd-score: note: {tracks}:60: the last line has no newline, may be torn, is ignored",
            f"csd-score: {tracks}: lacks frame 59 of {truth}:{1 + 60}"])
        # Where the truth doesn't need the torn frame, there is a score as well as the note.
        scene = Scene(1)
        scene.labelled[:, -1] = scene.visible[:, -1] = False
        scene.write_truth(truth)
        done = run("--resamples", 0, truth, tracks)
        self.assertEqual(done.returncode, 0)
        self.assertIn("may be torn", done.stderr)

    def test_a_csv_file_without_its_last_rows_is_noted(self):
        """The file is cut between two rows of the last frame. No row is torn, but three of seven
        features are missing."""
        scene = Scene(1)
        truth, _ = self.write(scene)
        tracks = self.tmp / "tracks.csv"
        scene.write_tracks_csv(tracks)
        tracks.write_text("".join(tracks.read_text().splitlines(keepends=True)[:-3]))
        done = run("--json", "--resamples", 0, "--size", "720x576", truth, tracks)
        self.assertEqual(done.returncode, 0)
        note = (f"{tracks}:{2 + 59 * 7}: from frame 59 on, 3 features are absent that had not "
                "ended, in 1 frame, counted as not tracked: is the file whole?")
        self.assertEqual(done.stderr, f"csd-score: note: {note}\n")
        self.assertEqual(json.loads(done.stdout)["notes"], [note])

    def test_tracks_of_another_size_are_refused(self):
        truth, tracks = self.write(Scene(1))
        self.refuse(1, "720x576 pixels, not of 640x480", "--size", "640x480", truth, tracks)


if __name__ == "__main__":
    unittest.main(verbosity=2)
