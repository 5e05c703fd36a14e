#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd-peers as users run it: pipes, files, errors."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

import numpy

PROGRAM = os.environ["CSD_PEERS"]


def y4m(frames, width=96, height=64):
    """Noise in blocks of 4 pixels, which moves to the right by a pixel a frame."""
    coarse = numpy.random.default_rng(3).integers(40, 220, (height // 4, width // 2),
                                                  dtype=numpy.uint8)
    texture = coarse.repeat(4, 0).repeat(4, 1)
    out = b"YUV4MPEG2 W%d H%d F25:1 C420jpeg\n" % (width, height)
    chroma = bytes([128]) * (width * height // 2)
    for i in range(frames):
        out += b"FRAME\n" + texture[:, 40 - i:40 - i + width].tobytes() + chroma
    return out


def run(*arguments, data=b""):
    return subprocess.run([PROGRAM, *arguments], input=data, capture_output=True, timeout=120)


class Peers(unittest.TestCase):
    def test_lines_from_a_pipe(self):
        result = run("--tracker", "lk-fb", "--points", "40,30;60,40", "-", data=y4m(10))
        self.assertEqual((result.returncode, result.stderr), (0, b""))
        lines = [json.loads(line) for line in result.stdout.decode().splitlines()]
        self.assertEqual([line["frame"] for line in lines], list(range(10)))
        self.assertEqual([line["pts"] for line in lines], [40000000 * i for i in range(10)])
        for i, line in enumerate(lines):
            self.assertEqual([f["id"] for f in line["features"]], [0, 1])
            for feature, x in zip(line["features"], (40, 60)):
                self.assertEqual(feature["state"], "tracked")
                self.assertAlmostEqual(feature["x"], x + i, delta=0.5)

    def test_points_from_a_file_and_limits(self):
        with tempfile.TemporaryDirectory() as folder:
            first, second = folder + "/first.jsonl", folder + "/second.jsonl"
            points = ";".join(f"{x},{y}" for x in (30, 45, 60) for y in (20, 40))
            self.assertEqual(
                run("-t", "still", "-p", points, "-o", first, "-", data=y4m(2)).returncode, 0)
            # More frames than it needs: the program that writes them must be able to finish.
            result = run("-t", "still", "-p", first, "-f", "2", "-n", "3", "-o", second, "-",
                         data=y4m(40))
            self.assertEqual((result.returncode, result.stdout), (0, b""))
            with open(second, encoding="utf-8") as file:
                lines = [json.loads(line) for line in file]
            result = run("-t", "still", "-p", first, "-", data=y4m(2, 64, 48))
            self.assertEqual(result.returncode, 1)
            self.assertIn(f"{first} is of pictures of 96x64, - has 64x48", result.stderr.decode())
            self.assertEqual(run("-t", "still", "-p", first, "-f", "1", "-",
                                 data=y4m(2, 64, 48)).returncode,
                             1, "also with fewer points")
        self.assertEqual(len(lines), 3)
        self.assertEqual([f["id"] for f in lines[2]["features"]], [0, 3])

    def test_a_video_file(self):
        with tempfile.TemporaryDirectory() as folder:
            video = folder + "/video.y4m"
            with open(video, "wb") as file:
                file.write(y4m(5))
            result = run("-t", "lk-anchored", "-p", "40,30", "-P", video)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [json.loads(line) for line in result.stdout.decode().splitlines()]
        self.assertEqual([line["pts"] for line in lines], [40000000 * i for i in range(5)])
        self.assertAlmostEqual(lines[4]["features"][0]["x"], 44, delta=0.5)
        self.assertIn(b"5 frames, 1 points", result.stderr)

    def test_times_of_a_video_with_b_frames(self):
        # Its pts begin late, by the delay of reordering, and an edit list corrects that.
        with tempfile.TemporaryDirectory() as folder:
            video = folder + "/video.mp4"
            subprocess.run(["ffmpeg", "-v", "error", "-i", "-", "-c:v", "libx264", "-bf", "2",
                            video],
                           input=y4m(20), check=True)
            result = run("-t", "still", "-p", "40,30", video)
        self.assertEqual((result.returncode, result.stderr), (0, b""))
        lines = [json.loads(line) for line in result.stdout.decode().splitlines()]
        times = [40000000 * i for i in range(20)]
        late = lines[0]["pts"]
        self.assertGreater(late, 0)
        self.assertEqual([line["pts"] - late for line in lines], times)
        for name in ("running_time", "stream_time"):
            self.assertEqual([line[name] for line in lines], times)
        self.assertEqual({line["duration"] for line in lines}, {40000000})

    def test_errors_are_reported(self):
        def failure(code, text, *arguments, data=b""):
            result = run(*arguments, data=data)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(text, result.stderr.decode())

        failure(2, 'there is no tracker "best"', "-t", "best", "-p", "1,1", "-")
        failure(2, "--tracker is missing", "-p", "1,1", "-")
        failure(2, "--points is missing", "-t", "still", "-")
        failure(2, "one VIDEO is wanted", "-t", "still", "-p", "1,1")
        failure(2, "one VIDEO is wanted", "-t", "still", "-p", "1,1", "one", "two")
        failure(2, "--frames 0", "-t", "still", "-p", "1,1", "-n", "0", "-")
        failure(2, "3x", "-t", "still", "-p", "1,1", "-n", "3x", "-")
        failure(2, "--sideways", "-t", "still", "-p", "1,1", "--sideways", "-")
        failure(1, "no frames in it", "-t", "still", "-p", "1,1", "-",
                data=b"YUV4MPEG2 W4 H4 F25:1\n")
        failure(1, "frame 4 breaks off", "-t", "still", "-p", "1,1", "-", data=y4m(5)[:-7])
        failure(1, "/nonexistent.mkv: ", "-t", "still", "-p", "1,1", "/nonexistent.mkv")
        failure(1, f"{__file__}: ", "-t", "still", "-p", "1,1", __file__)
        failure(1, 'csd-peers: "missing.jsonl" is no file, and as points: "missing.jsonl" (point '
                '1) is not x,y', "-t", "still", "-p", "missing.jsonl", "-")
        failure(1, "can't be written", "-t", "still", "-p", "1,1", "-o", "/nonexistent/x", "-",
                data=y4m(1))

    def test_help(self):
        result = run("--help")
        self.assertEqual((result.returncode, result.stderr), (0, b""))
        for name in (b"csrt", b"kcf", b"medianflow", b"lk-fb", b"lk-anchored", b"still",
                     b"--frames"):
            self.assertIn(name, result.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv)
