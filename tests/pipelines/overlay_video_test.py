#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The overlay video of quickstart: markers are where the tracks say, in the right frame; sound is
kept; and a second run builds nothing.

overlay_video_test.py REPOSITORY BUILD"""

import os
import pathlib
import subprocess
import sys

import numpy as np

import harness

REPOSITORY, BUILD = map(pathlib.Path, sys.argv[1:3])
del sys.argv[1:3]
# Sky blue and yellow of the palette by Okabe and Ito.
COLOURS = {"tracked": (86, 180, 233), "learning": (240, 228, 66)}


def quickstart(*arguments):
    return subprocess.run(
        [REPOSITORY / "pipelines" / "quickstart", "--no-install", *map(str, arguments)], text=True,
        capture_output=True, env=dict(os.environ, CSDTRACK_BUILD=str(BUILD)), timeout=300,
        stdin=subprocess.DEVNULL)


def pictures(path, width, height):
    raw = subprocess.run(["ffmpeg", "-v", "error", "-i", str(path), "-vsync", "0", "-f", "rawvideo",
                          "-pix_fmt", "rgb24", "-"],
                         capture_output=True, check=True).stdout
    return np.frombuffer(raw, np.uint8).reshape(-1, height, width, 3).astype(float)


def marker(drawn, plain, feature):
    """Centre (x, y) of the marker near a claimed position, and its colour; None if nothing is drawn
    there.

    The id is drawn above and to the right. So x is taken from the lower half, y from the left."""
    reach = 10
    x, y = round(feature["x"]), round(feature["y"])
    part = np.s_[y - reach:y + reach + 1, x - reach:x + reach + 1]
    changed = abs(drawn[part].mean(axis=2) - plain[part].mean(axis=2)) > 20
    columns = np.flatnonzero(changed[reach:].any(axis=0))
    rows = np.flatnonzero(changed[:, :reach + 1].any(axis=1))
    if not len(columns) or not len(rows):
        return None
    brightest = drawn[part][changed]
    total = brightest.sum(axis=1)
    colour = brightest[total >= np.quantile(total, 0.8)].mean(axis=0)
    return (x - reach + (columns[0] + columns[-1]) / 2,
            y - reach + (rows[0] + rows[-1]) / 2), colour


class Overlay(harness.Case):
    def test_markers_are_where_the_tracks_say(self):
        # 4 px a frame: a marker in the wrong frame would be 4 px away.
        scene = harness.Scene(width=480, height=360,
                              motion=lambda t: (abs(t * 4 % 64 - 32) - 16, 0))
        # Grey and dark, so that the markers are the brightest and most colourful parts.
        grey = (scene.picture(t).mean(axis=2, keepdims=True).repeat(3, axis=2) for t in range(40))
        video = harness.encode(self.tmp / "in.mkv",
                               ((40 + 0.3 * picture).astype(np.uint8) for picture in grey),
                               *harness.H264)
        out = self.tmp / "out"
        grid = ";".join(f"{x},{y}" for y in (80, 180, 280) for x in (90, 200, 310, 400))
        done = quickstart("--points", grid, "--set", "training-time=400000000", video, out)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = harness.read_lines(out / "tracks.jsonl")
        harness.check_tracks(self, lines, harness.decoded_frames(video))
        plain, drawn = (pictures(p, 480, 360) for p in (video, out / "overlay.mp4"))
        self.assertEqual(len(drawn), len(plain), "frames of overlay.mp4")
        seen = dict.fromkeys(COLOURS, 0)
        for t in range(0, 40, 3):
            for f in lines[t]["features"]:
                if f["state"] not in seen:
                    continue
                found = marker(drawn[t], plain[t], f)
                self.assertIsNotNone(found, f"frame {t}: {f} has no marker")
                (x, y), colour = found
                self.assertLess(np.hypot(x - f["x"], y - f["y"]), 1.5, f"frame {t}: {f}")
                # 4:2:0 takes colour out of thin lines, but the two can still be told apart.
                likeness = {state: np.linalg.norm(colour - c) for state, c in COLOURS.items()}
                self.assertEqual(min(likeness, key=likeness.get), f["state"],
                                 f"frame {t}: {f}, {colour}")
                seen[f["state"]] += 1
        self.assertGreater(sum(seen.values()), 100, seen)

    def test_sound_that_mp4_cannot_hold_is_encoded_anew(self):
        for codec, options in (("vorbis", ("-c:a", "libvorbis")), ("flac", ("-c:a", "flac"))):
            with self.subTest(codec):
                video = self.tmp / f"{codec}.mkv"
                subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "lavfi", "-i",
                                "testsrc2=size=320x240:rate=25:duration=2", "-f", "lavfi", "-i",
                                "sine=duration=2", "-c:v", "libx264", "-pix_fmt", "yuv420p",
                                *options, str(video)],
                               check=True, stdin=subprocess.DEVNULL)
                done = quickstart("--algorithm", "lk", video, self.tmp / codec)
                self.assertEqual(done.returncode, 0, done.stderr)
                result = self.tmp / codec / "overlay.mp4"
                probed = subprocess.run(["ffprobe", "-v", "error", "-show_entries",
                                         "stream=codec_name,duration", "-of", "csv=p=0",
                                         str(result)],
                                        capture_output=True, text=True, check=True).stdout.split()
                streams = dict(row.split(",") for row in probed)
                self.assertEqual(set(streams), {"h264", "aac"})
                self.assertAlmostEqual(float(streams["h264"]), 2, delta=0.05)
                # AAC has frames of 1024 samples.
                self.assertAlmostEqual(float(streams["aac"]), 2, delta=0.1)
                self.assertEqual(harness.decoded_frames(result), 50)

    def test_a_second_run_builds_nothing(self):
        video = harness.scene_video(self.tmp / "again.mkv", 5)
        marks = []
        for _ in range(2):
            done = quickstart("--algorithm", "lk", video, self.tmp / "again")
            self.assertEqual(done.returncode, 0, done.stderr)
            marks.append([os.stat(BUILD / p).st_mtime_ns
                          for p in ("gst/libgstcsdtrack.so", "build.ninja")])
        self.assertEqual(marks[0], marks[1])


if __name__ == "__main__":
    harness.main()
