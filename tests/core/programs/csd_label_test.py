#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd-label with a real window, mouse and keys, in an X server of its own.

$CSD_LABEL and $CSD_SCORE are the programs."""

import os
import pathlib
import subprocess
import tempfile
import time
import unittest

WAIT = 60  # seconds; on an idle machine all that a test waits for comes at once


def until(what, predicate):
    end = time.monotonic() + WAIT
    while time.monotonic() < end:
        result = predicate()
        if result:
            return result
        time.sleep(0.05)
    raise AssertionError(f"waited {WAIT} s for {what}")


class Label(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        read, write = os.pipe()
        # -noreset: else the server closes all connections when its last client leaves. That client
        # is xdotool, which can leave just as csd-label connects.
        # -r turns auto-repeat off. Else a key repeats where xdotool is slow to release it. The `q`
        # that ends a session would even stay down, as its window is gone before the release, and
        # would end the next session too.
        cls.server = subprocess.Popen(
            ["Xvfb", "-noreset", "-r", "-displayfd", str(write), "-screen", "0", "1280x800x24",
             "-nolisten", "tcp"], pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as display:
            cls.display = ":" + display.readline().strip()

    @classmethod
    def tearDownClass(cls):
        cls.server.terminate()
        cls.server.wait()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)
        self.video, self.labels = self.tmp / "video.mkv", self.tmp / "labels.csv"
        subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i",
                        "testsrc2=size=320x240:rate=25", "-frames:v", "70", "-c:v", "ffv1",
                        str(self.video)], check=True)
        self.environment = {**os.environ, "DISPLAY": self.display, "QT_X11_NO_MITSHM": "1",
                            "XDG_RUNTIME_DIR": folder.name}

    def open(self):
        self.program = subprocess.Popen(
            [os.environ["CSD_LABEL"], "--every", "30", "-o", self.labels, self.video],
            env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.program.stdout.close)
        self.addCleanup(self.program.stderr.close)
        self.addCleanup(self.program.kill)
        # The window gets this title once csd-label handles events; earlier ones would be lost.
        self.window = until("the window", self.windows)[-1]
        # No window manager is here to give it the keyboard.
        self.xdotool("windowfocus", self.window)

    def windows(self):
        if self.program.poll() is not None:
            raise AssertionError(f"csd-label ended with {self.program.returncode}: "
                                 f"{self.program.stderr.read()}")
        return self.xdotool("search", "--onlyvisible", "--name", "^csd-label: frame").split()

    def xdotool(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], env=self.environment,
                              capture_output=True, text=True).stdout

    def rows(self):
        return self.labels.read_text().split()[1:] if self.labels.exists() else []

    def act(self, rows, *arguments):
        """Does something once, and checks that the file then has these rows."""
        before = self.rows()
        self.xdotool(*arguments)
        until(rows, lambda: self.rows() != before)
        self.assertEqual(self.rows(), rows)

    def click(self, x, y, rows):
        self.act(rows, "mousemove", "--window", self.window, x, y, "click", 1)

    def key(self, key, rows):
        self.act(rows, "key", "--window", self.window, key)

    def until_frame(self, number):
        until(f"frame {number}", lambda: self.xdotool("getwindowname", self.window).strip() ==
              f"csd-label: frame {number}")

    def test_labelling_in_two_sessions(self):
        self.open()
        first = ["0,0,100.000,50.000,1", "0,1,200.000,60.000,1"]
        self.click(100, 50, first[:1])
        self.click(10, 10, [first[0], "0,1,10.000,10.000,1"])
        self.key("u", first[:1])
        self.click(200, 60, first)
        self.xdotool("key", "--window", self.window, "Return")
        self.until_frame(30)
        rows = first + ["30,0,102.000,51.000,1"]
        self.click(102, 51, rows)
        self.key("h", rows + ["30,1,,,0"])
        self.xdotool("key", "--window", self.window, "q")
        self.assertEqual(self.program.wait(WAIT), 0)

        self.open()
        self.until_frame(60)
        rows += ["30,1,,,0"]
        self.key("question", rows + ["60,0,,,2"])
        # Frame 90 is past the end, so the program ends by itself after the last answer.
        self.click(204, 61, rows + ["60,0,,,2", "60,1,204.000,61.000,1"])
        out, error = self.program.communicate(timeout=WAIT)
        self.assertEqual((self.program.returncode, error), (0, ""))
        self.assertIn("all 2 points", out)
        points = subprocess.run([os.environ["CSD_SCORE"], "--print-points", self.labels],
                                capture_output=True, text=True)
        self.assertEqual(points.stdout, "100.000,50.000;200.000,60.000\n")

    def test_wrong_options_and_files_are_refused(self):
        def refuse(code, text, *arguments):
            done = subprocess.run([os.environ["CSD_LABEL"], *map(str, arguments)],
                                  env=self.environment, capture_output=True, text=True,
                                  timeout=WAIT)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(text, done.stderr)

        refuse(2, "takes one VIDEO")
        refuse(2, "--every: at least 1", "--every", 0, self.video)
        refuse(1, "nowhere.mkv: ", self.tmp / "nowhere.mkv")
        (self.tmp / "text").write_text("no video\n" * 100)
        refuse(1, f"{self.tmp / 'text'}: ", self.tmp / "text")
        self.labels.write_text("frame,id,x,y,visible\n0,0,1,1,1\n7,0,1,1,1\n")
        refuse(1, "labels.csv:3: is not what labelling", "-o", self.labels, self.video)

    def test_without_a_display(self):
        for name in ("WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
            self.environment.pop(name, None)
        for display, named in (("", "''"), (":77", "':77'"), ("nonsense", "'nonsense'"),
                               (None, "not set")):
            with self.subTest(display):
                environment = {**self.environment, "DISPLAY": display or ""}
                if display is None:
                    del environment["DISPLAY"]
                done = subprocess.run([os.environ["CSD_LABEL"], self.video], env=environment,
                                      capture_output=True, text=True, timeout=WAIT)
                self.assertEqual((done.returncode, done.stdout), (1, ""))
                self.assertEqual(done.stderr, "csd-label: no window can be opened (DISPLAY is "
                                 f"{named}): run it in a terminal of a desktop, or over ssh -X\n")


if __name__ == "__main__":
    unittest.main(verbosity=2)
