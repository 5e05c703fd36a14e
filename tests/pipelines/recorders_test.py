#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The five pipelines of docs/recorders.md, unchanged."""

import json
import pathlib
import re
import subprocess

import harness

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "recorders.md"
PRESETS = PAGE.parents[1] / "gst" / "presets"
FRAMES = 60


def commands():
    """{number: command} of the page."""
    return {int(number): command.replace("\\\n", " ")
            for number, command in re.findall(
                r"^## (\d)\..*?\n\n    gst-launch-1.0 -e ((?:.*\\\n)*.*)\n", PAGE.read_text(),
                re.MULTILINE)}


class Recorders(harness.Case):
    def run_as_written(self, number, **replaced):
        line = commands()[number]
        for what, by in replaced.values():
            self.assertIn(what, line)
            line = line.replace(what, by)
        done = harness.launch("-e", line, cwd=self.tmp, env={"GST_PRESET_PATH": str(PRESETS)})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("ERROR", done.stdout + done.stderr)
        return done

    def recorded(self):
        said = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-select_streams", "v",
                               "-show_entries", "stream=width,height,nb_read_frames", "-of", "json",
                               self.tmp / "out.mkv"],
                              capture_output=True, text=True, check=True).stdout
        stream, = json.loads(said)["streams"]
        return stream["width"], stream["height"], int(stream["nb_read_frames"])

    def lines(self, count=FRAMES):
        lines = harness.read_lines(self.tmp / "tracks.jsonl")
        self.assertEqual([line["frame"] for line in lines], list(range(count)))
        return lines

    def test_there_are_five(self):
        self.assertEqual(sorted(commands()), [1, 2, 3, 4, 5])

    def test_1_tracks_beside_the_recording(self):
        self.run_as_written(1)
        self.assertEqual(self.recorded()[2], FRAMES)
        self.assertTrue(self.lines()[-1]["features"])

    def test_2_a_small_copy_is_tracked(self):
        # Not live, as the simulator can't make 25 such frames a second. So each frame waits for its
        # line.
        self.run_as_written(2, source=("is-live=true num-buffers=60", "num-buffers=20"))
        self.assertEqual(self.recorded(), (1920, 1080, 20))
        lines = self.lines(20)
        self.assertEqual({(line["width"], line["height"]) for line in lines}, {(1920, 1080)})
        self.assertGreater(max(f["x"] for f in lines[-1]["features"]), 960)

    def test_3_tracks_in_the_recording(self):
        self.run_as_written(3)
        self.assertEqual(self.recorded()[2], FRAMES)
        text = subprocess.run(["ffmpeg", "-v", "error", "-i", self.tmp / "out.mkv", "-map", "0:s",
                               "-c", "copy", "-f", "data", "-"],
                              capture_output=True, check=True).stdout
        self.assertEqual(text.count(b'"schema"'), FRAMES)

    def test_4_a_window_beside_the_recording(self):
        self.run_as_written(4, sink=("autovideosink", "fakesink sync=true"))
        self.assertEqual(self.recorded()[2], FRAMES)

    def test_5_over_the_network(self):
        self.run_as_written(5, sink=("srtsink uri=srt://127.0.0.1:8890?mode=listener "
                                     "wait-for-connection=false",
                                     f"filesink location={self.tmp}/out.mkv"))
        self.assertEqual(self.recorded()[2], FRAMES)


if __name__ == "__main__":
    harness.main()
