# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shared by the tests of csd-report: a video with the frame's number in bars, its tracks, and a
report made from them."""

import json
import math
import os
import pathlib
import subprocess
import sys

import numpy as np

import harness

REPOSITORY, BUILD = map(pathlib.Path, sys.argv[1:3])
PROGRAM = REPOSITORY / "core" / "programs" / "csd-report"
ENVIRONMENT = {**os.environ, "PATH": f"{BUILD / 'core' / 'programs'}:{os.environ['PATH']}"}
WIDTH, HEIGHT, FPS, FRAMES = 320, 240, 25, 750
BITS, BAR = 10, 24  # the frame's number: bars of BAR columns in the upper 20 rows


def position(number, frame):
    """Where feature `number` is: 75 heartbeats and 15 breaths a minute, in each feature another
    motion."""
    t = frame / FPS
    heart, breath = 2 * math.pi * 1.25 * t, 2 * math.pi * 0.25 * t
    x = 60 + 70 * number + 3 * math.sin(heart) + 8 * math.sin(breath + number)
    y = 90 + 40 * number + 5 * math.cos(heart) + 6 * math.sin(breath)
    return round(x, 3), round(y, 3)


def state_of(number, frame):
    """0 is always seen. 1 is hidden for one second in ten. 2 exists from frame 300 to 400 and is
    learning all that time."""
    if number == 1 and frame % 250 >= 225:
        return "occluded"
    if number == 2:
        return "learning" if 300 <= frame <= 400 else None
    return "tracked"


def features(frame):
    found = []
    for number in range(3):
        state = state_of(number, frame)
        if state:
            x, y = position(number, frame)
            found.append({"id": number, "x": x, "y": y, "state": state,
                          "confidence": 0.3 if state == "occluded" else 0.9})
    return found


def write_tracks(path, frames, of, width=WIDTH, height=HEIGHT, fps=FPS):
    with open(path, "w") as file:
        for frame in range(frames):
            ns = round(frame * 1e9 / fps)
            file.write(json.dumps({"schema": 1, "source": "csdtrack0", "role": "track",
                                   "algorithm": "csd", "frame": frame, "pts": ns, "duration": None,
                                   "running_time": ns, "stream_time": ns, "reference": None,
                                   "width": width, "height": height, "features": of(frame)},
                                  separators=(",", ":")) + "\n")
    return path


def picture(frame):
    made = np.full((HEIGHT, WIDTH, 3), 60, np.uint8)
    for bit in range(BITS):
        if frame >> bit & 1:
            made[:20, bit * BAR:(bit + 1) * BAR] = 230
    return made


def report(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, timeout=300, env=ENVIRONMENT)


class ReportCase(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.video = harness.encode(cls.tmp / "bars.mp4", (picture(i) for i in range(FRAMES)),
                                   *harness.H264, rate=FPS)
        cls.tracks = write_tracks(cls.tmp / "bars.jsonl", FRAMES, features)

    def make(self, video, tracks, out, *options):
        done = report(*options, video, tracks, out)
        self.assertEqual((done.returncode, done.stdout), (0, f"{out / 'index.html'}\n"),
                         done.stderr)
        return done
