#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd-motion as users run it. $CSD_MOTION is the program."""

import csv
import io
import json
import math
import os
import pathlib
import subprocess
import tempfile
import unittest
from random import Random

BREATH, HEART = 0.25, 1.2


def run(*arguments, **more):
    return subprocess.run([os.environ["CSD_MOTION"], *map(str, arguments)], capture_output=True,
                          text=True, **more)


class Scene:
    """Three features for 40 s at 25 fps, on a grid of 1/64 px. Feature 1 is hidden for 4 s, feature
    2 begins after 10 s."""

    def __init__(self, frames=1000):
        self.times = [i / 25 for i in range(frames)]
        self.features = [{} for _ in self.times]  # id: x, y, state
        random = Random(1)
        for i, t in enumerate(self.times):
            for f in range(3):
                if f == 2 and t < 10:
                    continue
                x = (100 * f + 2 * math.sin(2 * math.pi * (HEART * t + f / 10)) +
                     0.5 * math.sin(4 * math.pi * HEART * t))
                y = 50 + 4 * math.sin(2 * math.pi * BREATH * t) + 0.05 * t
                noise = [random.uniform(-0.5, 0.5) for _ in range(2)]
                hidden = f == 1 and 20 <= t < 24
                self.features[i][f] = (round((x + 0.4 * noise[0]) * 64) / 64,
                                       round((y + 0.4 * noise[1]) * 64) / 64,
                                       "occluded" if hidden else "tracked")

    def write_jsonl(self, path, role="track", pts=True):
        with open(path, "w") as file:
            for i, t in enumerate(self.times):
                features = [{"id": f, "x": x, "y": y, "state": state, "confidence": 0.9}
                            for f, (x, y, state) in self.features[i].items()]
                file.write(json.dumps({"schema": 1, "source": "csdtrack0", "role": role,
                                       "algorithm": "csd", "frame": i,
                                       "pts": round(t * 1e9) if pts else None, "width": 640,
                                       "height": 480, "features": features}) + "\n")

    def write_csv(self, path):
        with open(path, "w") as file:
            file.write("frame,pts,stream_time,id,x,y,state,confidence,fresh\n")
            for i, t in enumerate(self.times):
                for f, (x, y, state) in self.features[i].items():
                    file.write(f"{i},{round(t * 1e9)},,{f},{x},{y},{state},0.9,true\n")


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)
        self.scene = Scene()
        self.tracks = self.tmp / "tracks.jsonl"
        self.scene.write_jsonl(self.tracks)

    def json(self, *arguments):
        done = run("--json", *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)


class Rhythms(Case):
    def check(self, rhythms):
        breath, heart = rhythms
        self.assertEqual([breath["usual_name"], heart["usual_name"]], ["breath", "heart"])
        self.assertAlmostEqual(breath["frequency"], BREATH, delta=0.002)
        self.assertAlmostEqual(heart["frequency"], HEART, delta=0.002)
        self.assertAlmostEqual(breath["amplitude"], 4, delta=0.1)
        self.assertAlmostEqual(heart["amplitude"], 2, delta=0.05)
        self.assertAlmostEqual(heart["per_minute"], 60 * heart["frequency"])
        self.assertAlmostEqual(heart["period"], 1 / heart["frequency"])
        self.assertAlmostEqual(abs(breath["direction"]), 90, delta=1)
        self.assertAlmostEqual(heart["direction"], 0, delta=1)
        harmonic, = heart["harmonics"]
        self.assertEqual(harmonic["multiple"], 2)
        self.assertAlmostEqual(harmonic["amplitude"], 0.5, delta=0.05)
        self.assertEqual(breath["harmonics"], [])
        self.assertLess(heart["false_alarm"], 1e-6)

    def test_json(self):
        report = self.json(self.tracks)
        self.assertEqual([report[key] for key in ("schema", "frames", "from", "to", "window")],
                         [1, 1000, 0, 39.96, 60])
        self.assertAlmostEqual(report["interval"], 0.04)
        self.assertNotIn("series", report)
        self.check(report["scene"]["rhythms"])
        self.assertEqual([r["agreeing"] for r in report["scene"]["rhythms"]], [3, 3])
        self.assertEqual([feature["id"] for feature in report["features"]], [0, 1, 2])
        for feature in report["features"]:
            self.check(feature["rhythms"])
        hidden, late = report["features"][1:]
        self.assertAlmostEqual(hidden["claimed"], 36)
        self.assertEqual(late["from"], 10)
        self.assertEqual(late["start"], list(self.scene.features[250][2][:2]))
        self.assertAlmostEqual(late["rest"][0], 200, delta=0.5)
        self.assertEqual(report["notes"], [])

    def test_csv_and_text_say_what_json_says(self):
        report = self.json(self.tracks)
        rows = list(csv.DictReader(io.StringIO(run("--csv", self.tracks).stdout)))
        rhythms = [("", r) for r in report["scene"]["rhythms"]]
        rhythms += [(str(f["id"]), r) for f in report["features"] for r in f["rhythms"]]
        self.assertEqual(len(rows), 2 + 3 * 2)
        text = run(self.tracks).stdout
        self.assertIn("3 features, 1000 frames, 0.000 to 39.960 s", text)
        for row, (feature, rhythm) in zip(rows, rhythms):
            self.assertEqual(row["feature"], feature)
            self.assertEqual(row["usual_name"], rhythm["usual_name"])
            for column, key in (("frequency_hz", "frequency"), ("per_minute", "per_minute"),
                                ("period_s", "period"), ("amplitude_px", "amplitude"),
                                ("amplitude_low_px", "amplitude_low"),
                                ("amplitude_high_px", "amplitude_high"),
                                ("direction_deg", "direction"), ("explained", "explained")):
                self.assertAlmostEqual(float(row[column]), rhythm[key], delta=0.006, msg=column)
            self.assertEqual(row["harmonics"], ";".join(f"{h['multiple']}:{h['amplitude']:.3f}"
                                                        for h in rhythm["harmonics"]))
            self.assertEqual(row["agreeing"], "3" if not feature else "")
            self.assertIn(f"{rhythm['frequency']:.4f}", text)

    def test_csv_truth_and_lines_without_times_give_the_same(self):
        report = self.json(self.tracks)
        self.scene.write_csv(self.tmp / "table")
        self.scene.write_jsonl(self.tmp / "truth", role="truth")
        self.scene.write_jsonl(self.tmp / "untimed", pts=False)
        for file, options in (("table", ()), ("truth", ()), ("untimed", ("--fps", "25"))):
            other = self.json(self.tmp / file, *options)
            self.assertEqual(other["features"], report["features"], file)
            self.assertEqual(other["scene"], report["scene"], file)

    def test_frames_of_the_same_time(self):
        """As GStreamer has them in an AVI with B-frames, at each key frame."""
        report = self.json(self.tracks)
        for i in range(24, 1000, 24):
            self.scene.times[i] = self.scene.times[i - 1]
        self.scene.write_jsonl(self.tracks)
        other = self.json("--series", self.tracks)
        self.assertEqual(other["frames"], 1000)
        self.assertEqual(other["notes"], [])
        for one, two in zip(report["scene"]["rhythms"], other["scene"]["rhythms"], strict=True):
            self.assertAlmostEqual(one["frequency"], two["frequency"], delta=0.002)
            self.assertAlmostEqual(one["amplitude"], two["amplitude"], delta=0.1)
        self.assertNotIn(None, other["series"]["features"][0]["vx"])
        self.scene.times = [5] * 1000
        self.scene.write_jsonl(self.tracks)
        other = self.json(self.tracks)
        self.assertEqual((other["interval"], other["scene"]["rhythms"]), (0, []))

    def test_pts_that_go_back(self):
        """The later half was played first: an edit list in another order."""
        report = self.json(self.tracks)
        lines = [json.loads(line) for line in self.tracks.read_text().splitlines()]
        for line, later in zip(lines, lines[500:] + lines[:500]):
            line["stream_time"], line["running_time"] = line["pts"], line["pts"] + 10**9
            line["new"] = later["pts"]
        for name, clock in (("stream_time", 0), ("running_time", 1)):
            with open(self.tracks, "w") as file:
                for line in lines:
                    line = line | {"pts": line["new"]}
                    if name == "running_time":
                        line["stream_time"] = line["pts"]
                    file.write(json.dumps(line) + "\n")
            other = self.json(self.tracks)
            self.assertEqual(other["from"], clock)
            self.assertEqual(other["notes"],
                             [f"{self.tracks}: pts go back, so the times are {name}"])
            self.assertEqual(len(other["scene"]["rhythms"]), 2)
            self.assertAlmostEqual(other["scene"]["rhythms"][1]["amplitude"],
                                   report["scene"]["rhythms"][1]["amplitude"], delta=1e-3)

    def test_the_picture_changes_its_size(self):
        """csdtrack begins anew then, with other features."""
        lines = self.tracks.read_text().splitlines(keepends=True)
        late = [line.replace('"width": 640', '"width": 320').replace('"id": ', '"id": 1')
                for line in lines[600:]]
        self.tracks.write_text("".join(lines[:600] + late))
        done = run(self.tracks)
        said = "400 frames are left out, as the picture's size changes to 320x480"
        self.assertEqual(
            (done.returncode, done.stdout.splitlines()[0], done.stderr),
            (0, f"{self.tracks}: 3 features, 600 frames, 0.000 to 23.960 s; {said}",
             f"csd-motion: note: {self.tracks}:601: {said}\n"))
        whole = self.json(self.tracks)
        self.assertEqual(whole["notes"], [f"{self.tracks}:601: {said}"])
        self.tracks.write_text("".join(lines[:600]))
        first = self.json(self.tracks)
        self.assertEqual(whole | {"notes": []}, first)

    def test_span_window_and_band(self):
        report = self.json("--from", 12, "--to", 32, "--window", 10, self.tracks)
        self.assertEqual([report["from"], report["to"], report["frames"]], [12, 32, 501])
        self.assertEqual(report["features"][0]["windows"], 3)
        self.assertEqual(report["features"][0]["start"], list(self.scene.features[300][0][:2]))
        report = self.json("--lowest", 0.6, "--highest", 2, self.tracks)
        self.assertEqual([r["usual_name"] for r in report["scene"]["rhythms"]], ["heart"])

    def test_false_alarm(self):
        """--false-alarm 1 also reports rhythms that are probably noise, with that probability."""
        random = Random(2)
        for features in self.scene.features:
            for f in features:
                features[f] = (random.gauss(50, 1), random.gauss(50, 1), "tracked")
        self.scene.write_jsonl(self.tracks)
        self.assertEqual(self.json(self.tracks)["scene"]["rhythms"], [])
        rhythms = self.json("--false-alarm", 1, self.tracks)["scene"]["rhythms"]
        self.assertGreater(max(r["false_alarm"] for r in rhythms), 0.01)

    def test_a_single_frame_has_no_rhythm(self):
        Scene(1).write_jsonl(self.tracks)
        done = run(self.tracks)
        self.assertEqual(done.returncode, 0)
        self.assertIn("No rhythm of the scene", done.stdout)
        self.assertIn("note: " + str(self.tracks) + ": no feature is claimed long enough",
                      done.stderr)
        report = self.json("--series", self.tracks)
        self.assertEqual(report["series"]["features"][0]["vx"], [None])
        self.assertIsNone(report["features"][0]["speed"])


class Series(Case):
    def test_json(self):
        report = self.json("--series", self.tracks)
        series = report["series"]
        self.assertEqual(series["times"][:3], [0, 0.04, 0.08])
        self.assertEqual(series["frames"], list(range(1000)))
        self.assertEqual([f["first"] for f in series["features"]], [0, 0, 250])
        for feature in series["features"]:
            f, first = feature["id"], feature["first"]
            places = [self.scene.features[i][f] for i in range(first, 1000)]
            for place, dx, dy in zip(places, feature["dx"], feature["dy"], strict=True):
                if place[2] == "tracked":
                    self.assertAlmostEqual(dx, place[0] - places[0][0], delta=0.00051)
                    self.assertAlmostEqual(dy, place[1] - places[0][1], delta=0.00051)
                else:
                    self.assertIsNone(dx)
            self.assertAlmostEqual(feature["vx"][10], (places[11][0] - places[9][0]) / 0.08,
                                   delta=0.00051)
        hidden = series["features"][1]
        self.assertEqual([i for i, vx in enumerate(hidden["vx"]) if vx is None],
                         list(range(500, 600)))
        self.assertEqual(series["scene"]["features"][249:252], [2, 3, 3])
        self.assertEqual([series["scene"]["dx"][0], series["scene"]["dy"][0]], [0, 0])
        self.assertLess(max(abs(dx) for dx in series["scene"]["dx"]), 8)

    def test_csv(self):
        series = self.json("--series", self.tracks)["series"]
        done = run("--csv", "--series", self.tracks)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.DictReader(io.StringIO(done.stdout)))
        self.assertEqual(len(rows), 1000 + 1000 + 900 + 750)
        scene = [row for row in rows if not row["feature"]]
        self.assertEqual([int(row["features"]) for row in scene], series["scene"]["features"])
        for name in ("dx", "dy"):
            self.assertEqual([float(row[name + "_px"]) for row in scene], series["scene"][name])
        late = [row for row in rows if row["feature"] == "2"]
        self.assertEqual([float(row["vy_px_s"]) for row in late], series["features"][2]["vy"])
        self.assertEqual(float(late[5]["time_s"]), 10.2)
        self.assertEqual(float(late[5]["x_px"]), round(self.scene.features[255][2][0], 3))


class Wrong(Case):
    def refused(self, content, text):
        file = self.tmp / "wrong"
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        done = run(file)
        self.assertEqual((done.returncode, done.stdout), (1, ""), content[:80])
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn(text, done.stderr)
        self.assertTrue(done.stderr.startswith("csd-motion: "))

    LINE = ('{"schema":1,"role":"track","frame":%d,"pts":%d,"width":64,"height":48,'
            '"features":[{"id":0,"x":%s,"y":2,"state":"%s","confidence":1}]}\n')

    def test_files_that_cannot_be_used_are_refused(self):
        done = run(self.tmp / "absent")
        self.assertEqual(done.returncode, 1)
        self.assertIn("absent: can't be read: No such file", done.stderr)
        done = run(self.tmp)
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"csd-motion: {self.tmp}: is a folder: give a file of tracks\n"))
        self.refused("", "is empty")
        self.refused("hello\n", "neither JSON nor a header")
        self.refused(b"\x00\xff\xfe\x00" * 50 + b"\n", "neither JSON nor a header")
        self.refused('{"schema":1' + "[" * 100000 + "\n", "is no JSON")
        self.refused(
            '{"schema":1,"role":"track","frame":0,"pts":0,"width":64,"height":48,"features":[]}\n',
            "claims no position")
        self.refused(self.LINE % (0, 0, 1, "lost"), "claims no position")
        self.refused(self.LINE % (0, 1, 1, "tracked") + self.LINE % (1, 0, 1, "tracked"),
                     ":2: the time goes back")
        self.refused(self.LINE % (0, 0, 1, "flying"), ":1: there is no state 'flying'")
        self.refused(self.LINE % (0, 0, "1e400", "tracked"), "wrong:1: ")
        self.refused(self.LINE % (0, 0, "1e300", "tracked"), "is beyond 1048576 pixels")
        self.refused(self.LINE.replace('"pts":%d', '"pts":null') % (0, 1, "tracked"),
                     "has no times")

    def test_a_torn_line_is_noted(self):
        with open(self.tracks, "a") as file:
            file.write('{"schema":1,"role":"tr')
        done = run(self.tracks)
        self.assertEqual(done.returncode, 0)
        self.assertIn("may be torn", done.stderr)
        self.assertIn("may be torn", self.json(self.tracks)["notes"][0])

    def test_times_years_apart_are_read_in_time(self):
        with open(self.tracks, "w") as file:
            for i in range(200):
                file.write(self.LINE % (i, i * 40000000 + (9 * 10**18 if i > 99 else 0), i % 7,
                                        "tracked"))
        self.assertEqual(run(self.tracks, timeout=60).returncode, 0)

    def test_wrong_options_are_refused(self):
        for arguments in ((), (self.tracks, self.tracks), ("--json", "--csv", self.tracks),
                          ("--series", self.tracks), ("--from", "5", "--to", "4", self.tracks),
                          ("--from", "inf", self.tracks), ("--to", "nan", self.tracks),
                          ("--window", "4", self.tracks), ("--window", "nan", self.tracks),
                          ("--fps", "-1", self.tracks), ("--fps", "0", self.tracks),
                          ("--lowest", "3", "--highest", "2", self.tracks),
                          ("--highest", "1000", self.tracks), ("--false-alarm", "0", self.tracks),
                          ("--nonsense", self.tracks)):
            done = run(*arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""), arguments)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)

    def test_a_full_disk_is_reported(self):
        with open("/dev/full", "w") as full:
            done = subprocess.run([os.environ["CSD_MOTION"], "--json", "--series", self.tracks],
                                  stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("can't be written: No space left on device", done.stderr)

    def test_a_locale_with_decimal_commas_changes_nothing(self):
        plain = run("--csv", self.tracks).stdout
        self.assertEqual(
            run("--csv", self.tracks, env={**os.environ, "LC_ALL": "de_DE.UTF-8"}).stdout, plain)

    def test_help_and_progress(self):
        done = run("--help")
        self.assertEqual(done.returncode, 0)
        for word in ("TRACKS", "--series", "--window", "Exit code", "docs/motion.md"):
            self.assertIn(word, done.stdout)
        self.assertEqual(run(self.tracks).stderr, "", "no terminal, no progress")
        self.assertIn("csd-motion: reading " + str(self.tracks), run("-P", self.tracks).stderr)


if __name__ == "__main__":
    unittest.main()
