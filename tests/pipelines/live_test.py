#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/live: every source that needs no hardware, a real window with real clicks, errors."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

import harness

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
LIVE = SOURCE / "pipelines" / "live"


def run(*arguments, **options):
    return subprocess.run([LIVE, "--no-install", *map(str, arguments)], capture_output=True,
                          text=True, stdin=subprocess.DEVNULL, timeout=120,
                          env={**os.environ, "CSDTRACK_BUILD": str(BUILD)}, **options)


def states(line):
    return {feature["id"]: feature["state"] for feature in line["features"]}


class Live(harness.Case):
    def setUp(self):
        self.path = self.tmp / "tracks.jsonl"
        self.path.unlink(missing_ok=True)
        self.live = None

    def test_sources(self):
        for source in ("simulate", "simulate:occlusion", "test:UYVY", "test:v210"):
            with self.subTest(source):
                self.path.unlink(missing_ok=True)
                done = run("--sink", "fakesink", "--seconds", 2, "--tracks", self.path, source)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn("ms a frame", done.stdout)
                lines = harness.read_lines(self.path)
                self.assertGreater(len(lines), 10)
                self.assertEqual((lines[0]["width"], lines[0]["height"]),
                                 (640, 480) if source.startswith("sim") else (1920, 1080))

    def test_errors_are_one_line(self):
        for arguments, code, words in (
                (("/dev/video99",), 1, "no device /dev/video99"), (("/dev/null",), 1, "/dev/null"),
                (("/dev/video99/x",), 1, "no device"), (("test:v211",), 2, "test:v210"),
                (("nothing.mp4",), 1, "no file"),
                (("/usr",), 1, "live: '/usr' is a folder: give a video file"),
                (("rtsp://127.0.0.1:1/x",), 1,
                 "live: rtsp://127.0.0.1:1/x: nothing can be read from it"),
                (("http://127.0.0.1:1/x",), 1,
                 "live: http://127.0.0.1:1/x: nothing can be read from it"),
                (("decklink:x",), 2, "number"), (("--preset", "fast"), 2, "live-low-latency"),
                (("--set", "foo=1"), 2, "'foo'"), (("simulate:fog",), 2, "smoke, specular"),
                (("--set", "name=x"), 2, "max-features"),
                (("--set", "algorithm=foo"), 2, "csd, csd-2012"),
                (("--set", "max-features=-4"), 2,
                 "live: max-features is from 0 to 10000, not -4\n"),
                (("--set", "max-features=many"), 2, "from 0 to 10000"),
                (("--set", "replenish=x"), 2, "true or false"),
                (("--set", "points=1"), 2, "live: points: "),
                (("--tracks", "x" * 300), 1, "live: can't write into 'xxx"),
                (("--tracks", "/dev/full"), 1,
                 "live: can't write into '/dev/full' (the disk is full)"),
                (("--sink", "nosuchsink"), 1, "nosuchsink"), (("--seconds", "0"), 2, "--seconds"),
                (("--set", "foo"), 2, "PROPERTY=VALUE")):
            with self.subTest(arguments=arguments):
                self.check_refused(run(*(() if "--sink" in arguments else ("--sink", "fakesink")),
                                       *arguments),
                                   code, words)

    def test_sound_and_pipes_are_refused(self):
        sound, pipe = self.tmp / "sound.wav", self.tmp / "pipe"
        harness.play(f"audiotestsrc num-buffers=20 ! wavenc ! filesink location={sound}")
        os.mkfifo(pipe)
        self.check_refused(run("--sink", "fakesink", sound), 1,
                           f"live: '{sound}' has no picture in it")
        self.check_refused(run("--sink", "fakesink", pipe), 1,
                           f"live: '{pipe}' is no file but a pipe")
        for video, tracks in ((pipe, sound), (sound, pipe)):
            done = subprocess.run([LIVE.with_name("review"), "--no-install", "--sink", "fakesink",
                                   video, tracks],
                                  capture_output=True, text=True, timeout=60,
                                  env={**os.environ, "CSDTRACK_BUILD": str(BUILD)})
            self.check_refused(done, 1, f"review: '{pipe}' is no file but a pipe")

    def test_tracks_of_an_earlier_run_stay(self):
        self.path.write_text("kept\n")
        self.check_refused(run("--sink", "fakesink", "--seconds", 1, "--tracks", self.path,
                               "simulate"),
                           2, f"'{self.path}' is there already")
        self.assertEqual(self.path.read_text(), "kept\n")

    def test_a_link_to_the_command_finds_the_repository(self):
        (self.tmp / "folder").symlink_to(LIVE.parent)
        (self.tmp / "command").symlink_to(LIVE)
        for linked in (self.tmp / "folder" / "live", self.tmp / "command"):
            done = subprocess.run([linked, "--help"], capture_output=True, text=True, timeout=60)
            self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_each_warning_is_printed_once(self):
        """A window that is too slow posts the same one every second."""
        program = """
from pipelines.lib import runner
from pipelines.lib.runner import GLib, Gst
run = runner.Run("live", "videotestsrc num-buffers=5 ! csdtrack name=csdtrack ! fakesink")
run.pipeline.set_state(Gst.State.READY)
for text in ("late", "late", "other", "late"):
    warning = Gst.Message.new_warning(run.pipeline, GLib.Error(text, "test", 1), "")
    run.pipeline.get_bus().post(warning)
run.play("")
"""
        done = harness.run_python(program)
        self.assertEqual((done.returncode, done.stdout, done.stderr),
                         (0, "", "live: warning: late\nlive: warning: other\n"))

    def test_why_an_element_cannot_start(self):
        """A wrong property is wrong use (code 2); any other reason is a failure (code 1). Either is
        one line."""
        folder = self.tmp / "of two\nlines"
        folder.mkdir()
        program = """
import sys
from pipelines.lib import failure, properties
from pipelines.lib.properties import Gst
for name, settings in (("csdtrack", {"points": "1"}), ("csdtrack", {"points": "1,1"}),
                       ("filesrc", {"location": sys.argv[1]})):
    element = Gst.ElementFactory.make(name)
    for each in settings.items():
        element.set_property(*each)
    try:
        properties.check_start(element)
        print("starts")
    except failure.Failure as why:
        print(why.code, why)
"""
        done = harness.run_python(program, folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        wrong, right, unfit = done.stdout.splitlines()
        self.assertRegex(wrong, "^2 points: ")
        self.assertEqual(right, "starts")
        self.assertRegex(unfit, "^1 .*of two lines.* is a directory")

    def test_a_file_is_tracked_to_its_end(self):
        video = self.tmp / "video.mkv"
        harness.play("csdsimsrc num-buffers=30 ! video/x-raw,width=320,height=240 ! x264enc ! "
                     f"matroskamux ! filesink location={video}")
        done = run("--sink", "fakesink", "--tracks", self.path, video)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        # Although it is decoded faster than it is tracked, no frame is dropped.
        self.assertEqual([line["frame"] for line in harness.read_lines(self.path)], list(range(30)))
        self.assertRegex(done.stdout, "^30 frames;")

    def test_a_disk_that_swallows_a_line_is_noticed(self):
        done = harness.run_swallowing("live", "--sink", "fakesink", "--tracks", self.path, "a")
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"live: '{self.path}' holds 24 lines of 25 frames\n"))

    @unittest.skipUnless(shutil.which("Xvfb") and shutil.which("xdotool"), "needs Xvfb and xdotool")
    def test_clicks_in_a_real_window(self):
        display = self.enterContext(harness.screen("800x600"))
        environment = {**os.environ, "DISPLAY": display, "CSDTRACK_BUILD": str(BUILD)}

        def xdotool(*arguments):
            return subprocess.run(["xdotool", *map(str, arguments)], env=environment,
                                  capture_output=True, text=True, check=True, timeout=30).stdout

        live = self.live = subprocess.Popen(
            [LIVE, "--no-install", "--sink", "ximagesink", "--set", "max-features=0", "--tracks",
             self.path, "simulate:deformation"],
            env=environment, stderr=subprocess.PIPE, text=True, start_new_session=True)
        self.addCleanup(live.wait)
        self.addCleanup(live.kill)
        self.addCleanup(live.stderr.close)
        self.until(lambda last: last["frame"] > 5)
        # By its size: the root window is found too.
        window = next(w for w in xdotool("search", "--onlyvisible", "--class", "").split()
                      if "WIDTH=640\nHEIGHT=480\n" in xdotool("getwindowgeometry", "--shell", w))

        def click(x, y, button):
            xdotool("mousemove", "--window", window, x, y, "click", button)

        click(320, 240, 1)
        first = self.until(lambda last: len(last["features"]) == 1)
        # The tissue moves meanwhile.
        self.assertLess(abs(first["features"][0]["x"] - 320) + abs(first["features"][0]["y"] - 240),
                        25)
        click(200, 120, 1)
        self.until(lambda last: len(last["features"]) == 2)
        time.sleep(1)
        screenshot = self.tmp / "window.png"
        harness.play(f"ximagesrc display-name={display} num-buffers=1 use-damage=false ! "
                     f"videoconvert ! pngenc ! filesink location={screenshot}")
        if os.environ.get("CSDTRACK_SCREENSHOTS"):
            shutil.copy(screenshot, pathlib.Path(os.environ["CSDTRACK_SCREENSHOTS"]) / "live.png")
        self.assertGreater(screenshot.stat().st_size, 10000)
        click(205, 125, 3)
        self.until(lambda last: list(states(last)) == [0])
        xdotool("mousemove", "--window", window, 100, 100, "key", "--window", window, "r")
        self.until(lambda last: not last["features"])
        os.killpg(live.pid, signal.SIGINT)
        self.assertEqual(live.wait(30), 0, live.stderr.read())

    def until(self, met):
        """Waits until met(the last line of the tracks), and returns that line."""
        lines = []
        for _ in range(600):  # a busy machine draws a window late
            time.sleep(0.1)
            if self.live.poll() is not None:
                self.fail(f"ended with {self.live.returncode}: {self.live.stderr.read()}")
            if self.path.exists():
                lines = harness.read_lines(self.path, torn=True)
                if lines and met(lines[-1]):
                    return lines[-1]
        self.fail(f"never: of {len(lines)} lines the last is {lines[-1] if lines else None}")


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
