#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd-score, csd-motion and csd-peers when memory runs out.

Each call of operator new fails once; then it and all later ones fail. The program must print what
it always prints, or end with exit code 1 and the reason. $CSD_SCORE, $CSD_MOTION and $CSD_PEERS (if
there is one) are the programs, $FAULTS is faults.cpp.

CSDTRACK_FAULTS=N plants about N faults of each kind (default: 30), spread over all calls. 0 lets
each call fail."""

import json
import os
import pathlib
import random
import subprocess
import tempfile
import unittest

FRAMES = 100


def line(frame, role, shift):
    features = [{"id": i, "x": 100 * i + frame / 4 + shift, "y": 50 + frame % 5, "state": "tracked",
                 "confidence": 0.9} for i in range(2)]
    return json.dumps({"schema": 1, "source": "s", "role": role, "algorithm": role, "frame": frame,
                       "pts": frame * 40_000_000, "width": 320, "height": 240,
                       "features": features}) + "\n"


class Faults(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.truth, self.tracks = (pathlib.Path(folder.name) / name
                                   for name in ("truth.jsonl", "tracks.jsonl"))
        self.truth.write_text("".join(line(frame, "truth", 0) for frame in range(FRAMES)))
        self.tracks.write_text("".join(line(frame, "track", 0.5) for frame in range(FRAMES)))

    def run_with(self, arguments, given, **environment):
        done = subprocess.run(arguments, capture_output=True, encoding="latin-1", timeout=60,
                              input=given,
                              env=os.environ | {"LD_PRELOAD": os.environ["FAULTS"]} | environment)
        *errors, count = done.stderr.splitlines() or [""]
        return done.returncode, done.stdout, errors, count

    def check_each_fault(self, *arguments, given=None):
        name = pathlib.Path(arguments[0]).name
        arguments = [str(argument) for argument in arguments]
        code, whole, errors, count = self.run_with(arguments, given)
        self.assertEqual((code, errors), (0, []), count)
        there = int(count.removesuffix(" allocations"))
        wanted = int(os.environ.get("CSDTRACK_FAULTS", 30))
        step = max(1, there // wanted) if wanted else 1
        for lasting in ({}, {"CSDTRACK_FAULT_LASTS": "1"}):
            refused = 0
            for fault in range(0, there, step):
                code, out, errors, count = self.run_with(arguments, given,
                                                         CSDTRACK_FAULT=str(fault), **lasting)
                told = f"fault {fault} of {there} {lasting}: exit code {code}, {errors}, {count}"
                self.assertRegex(count, "allocations$", told)
                if code == 0:
                    self.assertEqual((out, errors), (whole, []), told)
                    continue
                self.assertEqual((code, errors), (1, [f"{name}: out of memory"]), told)
                refused += 1
            print(f"{name}{' and all later ones' * bool(lasting)}: {len(range(0, there, step))} of "
                  f"{there} faults planted: {refused} refused with the reason")
            self.assertGreater(refused, 0)

    def test_csd_score(self):
        self.check_each_fault(os.environ["CSD_SCORE"], "--resamples", "3", self.truth, self.tracks)

    def test_csd_motion(self):
        self.check_each_fault(os.environ["CSD_MOTION"], self.tracks)

    @unittest.skipUnless("CSD_PEERS" in os.environ, "no csd-peers here")
    def test_csd_peers(self):
        noise = random.Random(1)
        side, picture = 96, "".join(chr(noise.randrange(256)) for _ in range(96 * 96))
        # each frame is a pixel further to the left
        frames = "".join("FRAME\n" + picture[i:] + picture[:i] for i in range(6))
        self.check_each_fault(os.environ["CSD_PEERS"], "--tracker", "lk-fb", "--points",
                              "40,40;60,50", "-",
                              given=f"YUV4MPEG2 W{side} H{side} F25:1 Cmono\n{frames}")


if __name__ == "__main__":
    unittest.main()
