#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scores of tracks of a video with known truth. $CSD_SCORE is csd-score."""

import json
import os
import subprocess
import unittest

import harness


def csd_score(*arguments):
    done = subprocess.run([os.environ["CSD_SCORE"], *map(str, arguments)], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


class Score(harness.Case):
    def track(self, video, truth, tracks, *properties, caps="application/x-ndjson"):
        points = csd_score("--print-points", truth).strip()
        subprocess.run(["gst-launch-1.0", "-q", "filesrc", f"location={video}", "!", "decodebin",
                        "!", "csdtrack", f"points={points}", "learning=sync", *properties, "!",
                        "csdtrackenc", "!", caps, "!", "filesink", f"location={tracks}"],
                       check=True, timeout=600)

    def score(self, *arguments):
        return json.loads(csd_score("--json", "--resamples", 0, *arguments))["trackers"]

    def test_a_made_up_video(self):
        scene = harness.Scene()
        video = harness.scene_video(self.tmp / "video.mkv", 50)
        truth = self.tmp / "truth.csv"
        points = [(80, 60), (160.5, 120.25), (230, 170)]
        start = scene.motion(0)
        with open(truth, "w") as file:
            file.write("frame,id,x,y,visible\n")
            for t in range(0, 50, 7):
                dx, dy = (now - then for now, then in zip(scene.motion(t), start))
                for i, (x, y) in enumerate(points):
                    file.write(f"{t},{i},{x + dx},{y + dy},1\n")
        self.track(video, truth, self.tmp / "lk.jsonl", "algorithm=lk")
        self.track(video, truth, self.tmp / "table.csv", "algorithm=lk", caps="text/csv")
        lines, table = self.score("--size", "320x240", truth, self.tmp / "lk.jsonl",
                                  self.tmp / "table.csv")
        self.assertEqual([lines["name"], table["name"]], ["lk", "table"],
                         "CSV has no algorithm, so the file names the tracker")
        for tracker in (lines, table):
            self.assertEqual(tracker["sensitivity"]["value"], 1)
            self.assertEqual(tracker["k"]["value"], 0)
            self.assertLess(tracker["error"]["median"], 0.5)
            self.assertEqual(tracker["counts"]["correct"], 3 * 8)
            self.assertEqual(tracker["error"], lines["error"])

    def test_beads(self):
        """Nineteen beads on tissue (the clips' README): LK keeps all of them."""
        folder = harness.clips()[0].parent
        truth = folder / "beads.truth.csv"
        if not truth.exists():
            raise unittest.SkipTest(f"no {truth}")
        self.track(folder / "beads.mkv", truth, self.tmp / "beads.jsonl", "algorithm=lk")
        tracker, = self.score(truth, self.tmp / "beads.jsonl")
        self.assertGreater(tracker["sensitivity"]["value"], 0.99)
        self.assertLess(tracker["k"]["value"], 0.01)
        self.assertEqual(sum(tracker["counts"].values()), 5703 + 2,
                         "as many as are labelled, without uncertain ones")


if __name__ == "__main__":
    harness.main()
