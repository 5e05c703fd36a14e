#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""gst-launch-1.0 as users type it: decoders without converters, locales, full disks, killed
recordings."""

import contextlib
import locale
import os
import pathlib
import re
import signal
import subprocess
import time
import unittest

import numpy as np

import harness
from harness import Gst

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"


@contextlib.contextmanager
def filmed(display, path):
    """Films the top left 320×240 pixels of the screen, five times a second. Yields a list, which is
    filled at the end."""
    pictures = []
    with subprocess.Popen(["ffmpeg", "-v", "error", "-y", "-f", "x11grab", "-draw_mouse", "0",
                           "-framerate", "5", "-video_size", "320x240", "-i", display, "-f",
                           "rawvideo", "-pix_fmt", "rgb24", "-flush_packets", "1", str(path)],
                          stdin=subprocess.DEVNULL) as camera:
        try:
            while camera.poll() is None and not (path.exists() and path.stat().st_size):
                time.sleep(0.05)
            yield pictures
        finally:
            camera.terminate()
    pictures += list(np.fromfile(path, np.uint8).reshape(-1, 240, 320, 3))


def coloured(picture):
    """How many pixels are not grey."""
    return int((np.ptp(picture.astype(int), axis=2) > 60).sum())


def yellow_or_blue(picture):
    """How many pixels have the colour of a marker: yellow (learning) or blue (tracked). Simulated
    tissue has neither."""
    red, green, blue = np.moveaxis(picture.astype(int), 2, 0)
    return int(((np.minimum(red, green) - blue > 150) | (blue - red > 60)).sum())


class Launch(harness.Case):
    def play(self, *line, **options):
        done = harness.launch("-q", *line, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def test_no_converter_is_needed(self):
        for name, options in {"h264.mkv": harness.H264,
                              "hevc10.mkv": ("-c:v", "libx265", "-pix_fmt", "yuv420p10le",
                                             "-x265-params", "log-level=0"),
                              "prores.mov": ("-c:v", "prores_ks"), "v210.mov": ("-c:v", "v210"),
                              "mjpeg.avi": ("-c:v", "mjpeg", "-pix_fmt", "yuvj422p"),
                              "ffv1.mkv": ("-c:v", "ffv1", "-pix_fmt", "yuv444p"),
                              "uyvy.avi": ("-c:v", "rawvideo", "-pix_fmt", "uyvy422"),
                              "rgb.avi": ("-c:v", "rawvideo", "-pix_fmt", "bgr24"),
                              "grey.mkv": ("-c:v", "ffv1", "-pix_fmt", "gray"),
                              "mpeg2.ts": ("-c:v", "mpeg2video", "-q:v", "2")}.items():
            with self.subTest(name):
                video = harness.scene_video(self.tmp / name, 20, *options)
                path = self.tmp / "tracks.jsonl"
                self.play(f"filesrc location={video} ! decodebin ! csdtrack ! csdtrackenc ! "
                          f"filesink location={path}")
                lines = harness.read_lines(path)
                harness.check_tracks(self, lines, harness.decoded_frames(video), stamped=False)
                self.assertTrue(lines[-1]["features"])

    def test_the_overlay_is_seen_on_a_screen(self):
        # The video is still and grey, so everything coloured is a marker.
        grey = harness.Scene().picture(0).mean(axis=2, keepdims=True)
        still = grey.repeat(3, axis=2).astype(np.uint8)
        video = harness.encode(self.tmp / "X.mkv", [still] * 60, *harness.H264)
        with harness.screen() as display:
            for number, (overlay, marked) in enumerate((("", False), ("overlay=draw", True),
                                                        ("overlay=meta", True))):
                with self.subTest(overlay):
                    line = (f"filesrc location={video} ! decodebin ! csdtrack {overlay} ! "
                            "autovideosink")
                    with filmed(display, self.tmp / f"film{number}.rgb") as pictures:
                        done = harness.launch(line, env={"DISPLAY": display, "WAYLAND_DISPLAY": ""},
                                              timeout=180)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertIn("Got EOS", done.stdout)
                    # On a busy machine the sink may warn of late frames, and of nothing else.
                    late = r"WARNING: from element \S+: A lot of buffers are being dropped"
                    self.assertNotIn("WARNING", re.sub(late, "", done.stdout + done.stderr))
                    shown = [p for p in pictures if p.mean() > still.mean() / 2]
                    self.assertTrue(shown, f"{len(pictures)} pictures of the screen, all dark")
                    if marked:  # 50 markers of at least 20 coloured pixels each, overlapping
                        self.assertGreater(max(coloured(p) for p in shown), 500)
                    else:
                        self.assertLess(min(np.abs(p.astype(float) - still).mean() for p in shown),
                                        3)
                        self.assertEqual(max(coloured(p) for p in shown), 0)

    def test_the_demo_line_of_the_readme(self):
        demo, = re.findall(r"^ +gst-launch-1.0 (csdsimsrc .* ! autovideosink)$", README.read_text(),
                           re.MULTILINE)
        short = demo.replace("csdsimsrc", "csdsimsrc num-buffers=75")
        plain = short.replace("overlay=draw", "overlay=none")
        self.assertNotEqual(plain, short)
        with harness.screen() as display:
            most = []
            for name, line in (("drawn", short), ("plain", plain)):
                with filmed(display, self.tmp / f"{name}.rgb") as pictures:
                    done = harness.launch(line, env={"DISPLAY": display, "WAYLAND_DISPLAY": ""},
                                          timeout=180)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("Got EOS", done.stdout)
                # Not the sink's own warning that frames are late: here software draws.
                self.assertNotRegex(done.stdout + done.stderr, "WARNING: from element .*csd")
                self.assertTrue([p for p in pictures if p.mean() > 40],
                                f"{len(pictures)} pictures of the screen, all dark")
                most.append(max(map(yellow_or_blue, pictures)))
        drawn, plain = most
        self.assertGreater(drawn, plain + 200,
                           "fewer than ten of the hundred markers are in the filmed part")

    def test_a_german_locale_changes_no_byte(self):
        try:
            before = locale.setlocale(locale.LC_ALL)
            locale.setlocale(locale.LC_ALL, "de_DE.UTF-8")
            self.assertEqual(locale.localeconv()["decimal_point"], ",")
            locale.setlocale(locale.LC_ALL, before)
        except locale.Error:
            raise unittest.SkipTest("the locale de_DE.UTF-8 is not installed") from None
        video = harness.scene_video(self.tmp / "X.mkv", 30)
        results = []
        for name in ("C.UTF-8", "de_DE.UTF-8"):
            stem = self.tmp / name
            self.play(f"filesrc location={video} ! decodebin ! csdtrack algorithm=lk "
                      "points=100.5,80.25;200.125,99 ! tee name=t t. ! queue ! csdtrackenc ! "
                      f"filesink location={stem}.jsonl t. ! queue ! csdtrackenc ! text/csv ! "
                      f"filesink location={stem}.csv", env={"LC_ALL": name})
            results.append([(self.tmp / f"{name}{end}").read_bytes() for end in (".jsonl", ".csv")])
        self.assertEqual(results[0], results[1])
        first = harness.read_lines(self.tmp / "de_DE.UTF-8.jsonl")[0]["features"]
        self.assertEqual([(f["x"], f["y"]) for f in first], [(100.5, 80.25), (200.125, 99)])

    def test_a_full_disk_is_an_error_of_no_space(self):
        video = harness.scene_video(self.tmp / "X.mkv", 60)
        run = harness.Run(f"filesrc location={video} ! decodebin ! csdtrack ! csdtrackenc ! "
                          "filesink buffer-mode=unbuffered location=/dev/full")
        with self.assertRaises(harness.PipelineError) as caught:
            run.to_end()
        self.assertTrue(caught.exception.error.matches(Gst.ResourceError.quark(),
                                                       Gst.ResourceError.NO_SPACE_LEFT))

    def test_a_full_disk_of_the_tracks_stops_a_recording_through_a_tee(self):
        # Not what one would want, but what GStreamer does: a tee passes the branch's error upstream
        # and the source stops. A recorder that must go on removes the branch at this error.
        video = harness.scene_video(self.tmp / "X.mkv", 60)
        run = harness.Run(f"filesrc location={video} ! decodebin ! csdtrack ! tee name=t t. ! "
                          "queue ! matroskamux ! filesink async=false "
                          f"location={self.tmp}/copy.mkv t. ! queue ! csdtrackenc ! filesink "
                          "async=false buffer-mode=unbuffered location=/dev/full")
        with self.assertRaises(harness.PipelineError) as caught:
            run.to_end()
        self.assertTrue(caught.exception.error.matches(Gst.ResourceError.quark(),
                                                       Gst.ResourceError.NO_SPACE_LEFT))

    @unittest.skipUnless(os.geteuid() == 0, "mounting needs root")
    def test_a_disk_that_fills_keeps_whole_lines(self):
        disk = self.tmp / "disk"
        disk.mkdir()
        with harness.small_disk(disk, "size=64k"):
            video = harness.scene_video(self.tmp / "X.mkv", 60)
            done = harness.launch(f"-q filesrc location={video} ! decodebin ! csdtrack "
                                  "algorithm=lk ! csdtrackenc ! filesink buffer-mode=unbuffered "
                                  f"location={disk}/t.jsonl")
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, re.compile("no space", re.I))
            lines = harness.read_lines(disk / "t.jsonl", torn=True)
            harness.check_tracks(self, lines)
            self.assertGreater(len(lines), 2)

    def test_a_killed_recording_keeps_all_but_the_last_line(self):
        path = self.tmp / "killed.jsonl"
        # The tee gives each frame to the file first, then to the pipe. So what is read from the
        # pipe has been written to the file.
        line = ("gst-launch-1.0 -q videotestsrc pattern=smpte is-live=true ! "
                "video/x-raw,width=320,height=240,framerate=100/1 ! csdtrack ! csdtrackenc ! tee "
                f"name=t t. ! filesink async=false buffer-mode=unbuffered location={path} t. ! "
                "fdsink async=false sync=false")
        with subprocess.Popen(line.split(), stdout=subprocess.PIPE,
                              stdin=subprocess.DEVNULL) as process:
            seen = b"".join(process.stdout.readline() for _ in range(50))
            process.send_signal(signal.SIGKILL)
            seen += process.stdout.read()
        self.assertEqual(process.returncode, -signal.SIGKILL)
        whole = seen[:seen.rindex(b"\n") + 1]
        written = path.read_bytes()
        self.assertEqual(written[:len(whole)], whole,
                         "a line that left the pipeline is not in the file")
        self.assertLessEqual(written.count(b"\n") - whole.count(b"\n"), 1)
        harness.check_tracks(self, harness.read_lines(path, torn=True))


if __name__ == "__main__":
    harness.main()
