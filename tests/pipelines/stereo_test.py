#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/stereo: tracks of two pictures with one clock."""

import os
import pathlib
import signal
import subprocess
import sys
import time

import harness

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
STEREO = [SOURCE / "pipelines" / "stereo", "--no-install"]
ENVIRONMENT = {**os.environ, "CSDTRACK_BUILD": str(BUILD)}


def run(*arguments):
    return subprocess.run([*STEREO, *map(str, arguments)], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, timeout=180, env=ENVIRONMENT)


class Stereo(harness.Case):
    def setUp(self):
        self.out = self.tmp / self.id().split(".")[-1]

    def tracks(self):
        """Returns the lines of both sides. Checks that all are complete and name their side."""
        found = []
        for side in ("left", "right"):
            lines = harness.read_lines(self.out / f"{side}.jsonl")
            harness.check_tracks(self, lines)
            self.assertEqual({line["source"] for line in lines}, {side})
            found.append(lines)
        return found

    def test_files_share_their_times(self):
        videos = []
        for side, shift in (("left", 0), ("right", 8)):
            scene = harness.Scene(motion=lambda t, shift=shift: (shift + t // 4, 0))
            videos.append(harness.encode(self.tmp / f"{side}.mkv",
                                         (scene.picture(t) for t in range(50)), *harness.H264))
        # In both pictures feature 0 begins at the same pixel.
        done = run("--set", "points=160,120", *videos, self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, r"^left: 50 frames; .*\nright: 50 frames; .*\n$")
        left, right = self.tracks()
        self.assertEqual([round(line["running_time"] / 1e6) for line in left],
                         [40 * t for t in range(50)])
        self.assertEqual([line["running_time"] for line in left],
                         [line["running_time"] for line in right])
        for lines in left, right:
            self.assertAlmostEqual(lines[-1]["features"][0]["x"], 160 + 49 // 4, delta=1)

    def test_one_side_may_change_its_size(self):
        program = """
from pipelines.lib import command, sources, stereo

def launch(name):
    widths = (160, 201) if name == "changes" else (160, 160)
    parts = ("videotestsrc num-buffers=25 ! "
             f"video/x-raw,width={width},height=120,framerate=25/1 ! {name}." for width in widths)
    return " ".join(parts) + f" concat name={name}"

sources.launch = launch
command.run("stereo", stereo.main)
"""
        done = harness.run_python(program, "--preset", "", "--display=fakesink", "changes", "stays",
                                  self.out, env=ENVIRONMENT, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        # Not check_tracks(): concat begins the pts of each part at 0.
        sides = [harness.read_lines(self.out / f"{side}.jsonl") for side in ("left", "right")]
        self.assertEqual([[line["width"] for line in lines] for lines in sides],
                         [[160] * 25 + [201] * 25, [160] * 50])

    def test_live_with_a_window(self):
        process = subprocess.Popen([*STEREO, "--display=fakesink", "simulate", "simulate:smoke",
                                    self.out],
                                   env=ENVIRONMENT, start_new_session=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        files = [self.out / "left.jsonl", self.out / "right.jsonl"]

        def enough():
            """More than 20 lines each; if busy, one side may begin a second later (seen)."""
            if not all(file.exists() and file.read_bytes().count(b"\n") > 20 for file in files):
                return False
            left, right = (harness.read_lines(file, torn=True) for file in files)
            return (left[0]["running_time"] < right[-1]["running_time"] and
                    right[0]["running_time"] < left[-1]["running_time"])

        for _ in range(600):
            if process.poll() is not None or enough():
                break
            time.sleep(0.1)
        os.killpg(process.pid, signal.SIGINT)
        self.assertEqual((process.wait(60), process.stderr.read()), (0, ""))
        left, right = self.tracks()
        self.assertGreater(min(len(left), len(right)), 20)
        # They ran at the same time, and their running times say so.
        self.assertLess(left[0]["running_time"], right[-1]["running_time"])
        self.assertLess(right[0]["running_time"], left[-1]["running_time"])

    def test_a_disk_that_swallows_a_line_is_noticed(self):
        done = harness.run_swallowing("stereo", "a", "b", self.out, sink="right-file",
                                      env=ENVIRONMENT)
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"stereo: '{self.out}/right.jsonl' holds 24 lines of 25 frames\n"))

    def test_of_two_at_once_one_is_refused(self):
        command = [*STEREO, "--seconds", "2", "simulate", "simulate:smoke", self.out]
        both = [subprocess.Popen(command, env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                for _ in range(2)]
        said = {process.communicate(timeout=60)[1]: process for process in both}
        self.assertEqual(sorted(process.returncode for process in both), [0, 1], said)
        self.assertEqual(said[""].returncode, 0)
        self.assertRegex(max(said), f"^stereo: another run works on '{self.out}' since .*'kill "
                         f"{said[''].pid}' on .*\n$")
        self.tracks()
        self.assertEqual(len(list(self.out.iterdir())), 2)

    def test_closing_the_terminal_leaves_whole_tracks(self):
        terminal = harness.Terminal(self, [*STEREO, "simulate", "simulate:smoke", self.out],
                                    ENVIRONMENT)
        for side in ("left", "right"):
            terminal.await_lines(self.out / f"{side}.jsonl", 5)
        self.assertEqual(terminal.close(), 0)
        self.tracks()
        self.assertEqual(len(list(self.out.iterdir())), 2)

    def test_errors_are_one_line(self):
        file = self.tmp / "file"
        file.write_text("")
        for arguments, code, words in (
                (("simulate", "/dev/video99", self.out), 1, "no device /dev/video99"),
                (("nothing.mkv", "simulate", self.out), 1, "nothing.mkv"),
                (("/dev/video0", "/dev/video0", self.out), 2, "two devices"),
                (("simulate", self.out), 2, "OUT"),
                (("simulate", "simulate", file), 1, "another folder"),
                (("simulate", "simulate", self.tmp / ("x" * 300)), 1, "too long"),
                (("simulate", "simulate", self.out, "--set", "points=1"), 2, "points"),
                (("simulate", "simulate", self.out, "--set", "foo=1"), 2, "'foo'"),
                (("simulate", "simulate", self.out, "--display=x!y"), 2, "--display")):
            with self.subTest(arguments=arguments):
                self.check_refused(run(*arguments), code, words)
                self.assertFalse(self.out.exists())
        # Files that were opened stay, as they may be another command's.
        self.check_refused(run("simulate", file, self.out), 1, str(file))
        self.assertEqual(sorted(path.name for path in self.out.iterdir()),
                         ["left.jsonl", "right.jsonl"])
        # Tracks of an earlier run are not overwritten, even where only one side has them.
        (self.out / "right.jsonl").write_text("kept\n")
        self.check_refused(run("simulate", "simulate", self.out, "--seconds", "1"), 2,
                           "right.jsonl' is there already")
        self.assertEqual((self.out / "right.jsonl").read_text(), "kept\n")


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
