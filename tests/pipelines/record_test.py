#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/record: each file has its tracks beside it, and no trouble with the tracks changes the
recording."""

import http.server
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest

import cv2
import harness

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
RECORD = SOURCE / "pipelines" / "record"
ENVIRONMENT = {**os.environ, "CSDTRACK_BUILD": str(BUILD), **harness.SAME_MEMORY}


def run(*arguments):
    return subprocess.run([RECORD, "--no-install", *map(str, arguments)], capture_output=True,
                          text=True, stdin=subprocess.DEVNULL, timeout=180, env=ENVIRONMENT)


def review(*arguments):
    return subprocess.run([SOURCE / "pipelines" / "review", "--no-install", "--sink", "fakesink",
                           *arguments],
                          capture_output=True, text=True, timeout=120, env=ENVIRONMENT)


def frame_times(video):
    """The frames' times in milliseconds, as Matroska keeps them."""
    done = subprocess.run(["ffprobe", "-v", "error", "-select_streams", "v", "-show_entries",
                           "packet=pts_time", "-of", "csv=p=0", video],
                          capture_output=True, text=True, check=True)
    return sorted(round(1000 * float(line.strip(","))) for line in done.stdout.split())


def stream_of(folder):
    """The encoded video of all files, joined."""
    found = b""
    for video in sorted(folder.glob("*.mkv")):
        found += subprocess.run(["ffmpeg", "-v", "error", "-i", video, "-c", "copy", "-f", "h264",
                                 "-"],
                                capture_output=True, check=True).stdout
    return found


class Record(harness.Case):
    def setUp(self):
        self.out = self.tmp / self.id().split(".")[-1]

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.video = cls.tmp / "operation.mkv"
        harness.play("csdsimsrc num-buffers=130 ! video/x-raw,width=320,height=240,framerate=25/1 "
                     "! x264enc speed-preset=ultrafast ! matroskamux ! filesink "
                     f"location={cls.video}")

    def check_together(self, files, live=False):
        """Checks that each frame has its line in the file beside it. In a live recording some have
        none, as they came faster than they could be tracked."""
        frames = 0
        videos = sorted(self.out.glob("*.mkv"))
        self.assertEqual(len(videos), files)
        for video in videos:
            lines = harness.read_lines(video.with_suffix(".jsonl"))
            times = [round(line["stream_time"] / 1e6) for line in lines]
            of_video = frame_times(video)
            if live:
                of_video = [time for time in of_video if time in set(times)]
            self.assertEqual(times, of_video, video.name)
            self.assertEqual(lines[0]["frame"], frames)
            frames += len(lines)
        return frames

    def test_each_frame_has_its_line_beside_it(self):
        done = run("--segment", 2, self.video, self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(self.check_together(3), 130)
        looked_at = review(self.out / "00001.mkv")
        self.assertEqual((looked_at.returncode, looked_at.stdout, looked_at.stderr),
                         (0, "50 frames\n", ""))
        # A file that was tracked by itself has other stream times.
        harness.play(f"filesrc location={self.out}/00001.mkv ! decodebin ! csdtrack ! csdtrackenc "
                     f"! filesink location={self.tmp}/itself.jsonl")
        self.assertEqual(harness.read_lines(self.tmp / "itself.jsonl")[0]["stream_time"], 0)
        self.assertEqual(review(self.out / "00001.mkv", self.tmp / "itself.jsonl").stderr, "")
        # Tracks of another file: other times, another size, another aspect. Where one has 25 and
        # the other 30 frames a second, every fifth line has the time of a frame.
        fast = harness.encode(self.tmp / "fast.mkv",
                              (harness.Scene().picture(t) for t in range(60)), *harness.H264,
                              rate=30)
        (self.tmp / "empty.jsonl").write_text("")
        self.assertRegex(review(fast, self.out / "00000.jsonl").stderr, "^review: warning: .* "
                         "another video's: of 50 lines 1\\d have the time of a frame\n$")
        self.assertRegex(review(fast, self.tmp / "empty.jsonl").stderr,
                         "^review: warning: '.*/empty.jsonl' is empty\n$")
        small, flat = (harness.scene_video(self.tmp / f"{height}.mkv", 20, width=160, height=height)
                       for height in (120, 80))
        for video, lines, words in ((self.out / "00000.mkv", "00001",
                                     "they begin at 2.00 s.* first 50 frames, from 0.00 s on"),
                                    (self.out / "00001.mkv", "00000",
                                     "they begin at 0.00 s, the video at 2.00 s"),
                                    (self.out / "00001.mkv", "00002",
                                     "they begin at 4.00 s.* first 50 frames, from 2.00 s on"),
                                    (small, "00000", "a picture of 320×240, the video has 160×120"),
                                    (flat, "00000", "another aspect")):
            said = review(video, self.out / f"{lines}.jsonl")
            self.assertEqual((said.returncode, said.stderr.count("\n")), (0, 1), said.stderr)
            self.assertRegex(said.stderr, f"^review: warning: .*{words}")
        # A second recording goes on with the numbers and overwrites nothing.
        before = {path: path.read_bytes() for path in self.out.iterdir()}
        self.assertEqual(run("--segment", 60, self.video, self.out).returncode, 0)
        self.assertEqual({path.name for path in self.out.iterdir()} -
                         {path.name for path in before}, {"00003.mkv", "00003.jsonl"})
        for path, content in before.items():
            self.assertEqual(path.read_bytes(), content)

    def test_a_width_that_is_no_multiple_of_16(self):
        """For this avdec_h264 asks for memory a second time, after some frames. Keeping it waiting
        would stop the pipeline for ever."""
        done = run(harness.scene_video(self.tmp / "odd.mkv", 60, width=360, height=288), self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(self.check_together(1), 60)

    def test_odd_sizes_lose_the_last_row_or_column(self):
        for kind, width, height, what in (
                ("yuv420p", 161, 121, "column and row are"), ("yuv420p", 160, 121, "row is"),
                ("yuv422p", 161, 121, "column is"), ("yuv420p10le", 161, 120, "column is"),
                ("yuv444p", 161, 121, None)):
            with self.subTest(kind=kind, width=width, height=height):
                video = harness.scene_video(self.tmp / f"{kind}-{width}x{height}.mkv", 30, "-c:v",
                                            "ffv1", "-pix_fmt", kind, width=width, height=height)
                self.out = self.tmp / video.stem
                done = run(video, self.out)
                said = (f"record: {video}: {width}×{height} is no even size, which H.264 wants: "
                        f"the last {what} left out\n" if what else "")
                self.assertEqual((done.returncode, done.stderr), (0, said))
                self.assertEqual(self.check_together(1), 30)
                size = width - ("column" in (what or "")), height - ("row" in (what or ""))
                shown = subprocess.run(["ffprobe", "-v", "error", "-select_streams", "v",
                                        "-show_entries", "stream=width,height", "-of", "csv=p=0",
                                        self.out / "00000.mkv"],
                                       capture_output=True, text=True, check=True).stdout
                self.assertEqual(tuple(map(int, shown.strip().split(","))), size)
                self.assertEqual({(line["width"], line["height"])
                                  for line in harness.read_lines(self.out / "00000.jsonl")}, {size})
                self.assertEqual(review(self.out / "00000.mkv").stderr, "")
                # The last row or column is left out, so all else is in its old place.
                came, recorded = (cv2.VideoCapture(str(path)).read()[1].astype(int)
                                  for path in (video, self.out / "00000.mkv"))
                self.assertLess(abs(recorded - came[:size[1], :size[0]]).mean(), 8)

    def test_a_new_size_or_format_begins_a_new_file(self):
        """Also in the middle of a segment, with an odd size, and for a single frame."""
        parts = ((60, "I420", 320, 240), (7, "I420", 161, 121), (1, "I420", 320, 240),
                 (30, "I420", 160, 120), (20, "Y444", 160, 120))
        program = f"""
from pipelines.lib import command, record, sources
each = ("videotestsrc num-buffers={{}} ! "
        "video/x-raw,format={{}},width={{}},height={{}},framerate=25/1 ! parts. ")
sources.launch = lambda _: "".join(each.format(*part) for part in {parts}) + "concat name=parts"
command.run("record", record.main)
"""
        done = harness.run_python(program, "--preset", "", "--set", "max-features=5", "--segment",
                                  "2", "changes", self.out, env=ENVIRONMENT, timeout=180)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([line.removeprefix("record: changes: ")
                          for line in done.stderr.splitlines()
                          if "odd" not in line and "even" not in line],
                         [f"the picture's {what}: a new file begins"
                          for what in ("size is 160×120 now", "size is 320×240 now",
                                       "size is 160×120 now", "form changes")])
        self.assertEqual(self.check_together(6), 118)
        videos = sorted(self.out.glob("*.mkv"))
        self.assertEqual([len(frame_times(video)) for video in videos], [50, 10, 7, 1, 30, 20])
        self.assertEqual([{(line["width"], line["height"])
                           for line in harness.read_lines(video.with_suffix(".jsonl"))}
                          for video in videos],
                         [{size} for size in ((320, 240), (320, 240), (160, 120), (320, 240),
                                              (160, 120), (160, 120))])
        self.assertEqual([harness.decoded_frames(video) for video in videos],
                         [50, 10, 7, 1, 30, 20])
        self.assertEqual(review(videos[2]).stderr, "")

    def start(self, *arguments):
        recorder = subprocess.Popen([RECORD, "--no-install", *map(str, arguments)],
                                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                    stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)
        self.addCleanup(recorder.communicate)
        self.addCleanup(recorder.kill)
        return recorder

    def until(self, what, recorder):
        for _ in range(600):
            if what() or recorder.poll() is not None:
                break
            time.sleep(0.1)
        self.assertIsNone(recorder.poll(), recorder.poll() is None or recorder.communicate()[1])

    def check_folder_in_use(self, stderr, folder, pid):
        self.assertRegex(stderr, f"^record: another run works on '{folder}' since "
                         f"{time.strftime('%Y')}-\\d\\d-\\d\\d [:0-9]{{8}}: wait for it, or end it "
                         f"with 'kill {pid}' on {re.escape(os.uname().nodename)}\n$")

    def test_a_folder_in_use_by_another_recorder_is_refused(self):
        tracks = self.tmp / "taken-tracks"
        first = self.start("--tracks", tracks, "simulate", self.out)
        self.until((tracks / "00000.jsonl").exists, first)
        names = {path: path.stat().st_ino for folder in (self.out, tracks)
                 for path in folder.iterdir()}
        for wanted, taken in (((self.out,), self.out), (("--tracks", tracks, self.out), tracks),
                              (("--tracks", tracks, self.out / "other"), tracks)):
            self.check_folder_in_use(self.refused("--seconds", 1, "simulate", *wanted), taken,
                                     first.pid)
        self.assertEqual({path: path.stat().st_ino for folder in (self.out, tracks)
                          for path in folder.iterdir()}, names)
        first.terminate()
        self.assertEqual(first.communicate(timeout=60)[1], "")
        self.assertEqual(first.returncode, 0)
        self.assertEqual([path.name for folder in (self.out, tracks) for path in folder.iterdir()],
                         ["00000.mkv", "00000.jsonl"])
        times = frame_times(self.out / "00000.mkv")
        self.assertGreater(len(times), 5)
        self.assertLessEqual({round(line["stream_time"] / 1e6)
                              for line in harness.read_lines(tracks / "00000.jsonl")}, set(times))

    def refused(self, *arguments):
        done = run(*arguments)
        self.check_refused(done, 1, "another run")
        return done.stderr

    def test_closing_the_terminal_ends_the_recording_whole(self):
        terminal = harness.Terminal(self, [RECORD, "--no-install", "simulate", self.out],
                                    ENVIRONMENT)
        terminal.await_lines(self.out / "00000.jsonl", 20)
        self.assertEqual(terminal.close(), 0)
        self.assertGreaterEqual(self.check_together(1, live=True), 20)
        done = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "format=duration", "-of",
                               "csv=p=0", self.out / "00000.mkv"],
                              capture_output=True, text=True, check=True)
        self.assertGreaterEqual(float(done.stdout), 0.8)  # N/A in a file that was not ended
        self.assertEqual(len(list(self.out.iterdir())), 2)

    def test_nohup_keeps_the_recording_when_the_terminal_closes(self):
        recorder = subprocess.Popen(["nohup", RECORD, "--no-install", "--seconds", "3", "simulate",
                                     self.out],
                                    env=ENVIRONMENT, stdin=subprocess.DEVNULL,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(recorder.wait)
        self.addCleanup(recorder.kill)
        self.until((self.out / "00000.jsonl").exists, recorder)
        recorder.send_signal(signal.SIGHUP)
        self.assertEqual(recorder.wait(60), 0)
        self.assertGreater(frame_times(self.out / "00000.mkv")[-1], 1500)

    def test_of_two_recorders_at_once_one_is_refused(self):
        both = [self.start("--seconds", 3, "simulate", self.out) for _ in range(2)]
        said = [recorder.communicate(timeout=60)[1] for recorder in both]
        self.assertEqual(sorted(recorder.returncode for recorder in both), [0, 1], said)
        first, second = both if both[0].returncode == 0 else both[::-1]
        self.check_folder_in_use(said[both.index(second)], self.out, first.pid)
        self.assertEqual(said[both.index(first)], "")
        self.assertEqual(len(list(self.out.iterdir())), 2)
        self.check_together(1, live=True)

    def test_without_file_locks_two_recorders_share_the_numbers(self):
        program = """
import errno, fcntl
def none(*_):
    raise OSError(errno.ENOLCK, "no locks")
fcntl.flock = none
from pipelines.lib import command, record
command.run("record", record.main)
"""
        # As pipelines/record sets it.
        presets = {"GST_PRESET_PATH": str(RECORD.parents[1] / "gst" / "presets")}

        def start():
            recorder = subprocess.Popen(
                [sys.executable, "-c", program, "--segment", "2", "simulate", self.out],
                cwd=SOURCE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                env={**ENVIRONMENT, **presets})
            self.addCleanup(recorder.communicate)
            self.addCleanup(recorder.kill)
            return recorder

        first = start()
        self.until((self.out / "00000.jsonl").exists, first)
        second = start()
        self.until((self.out / "00004.jsonl").exists, second)
        for recorder in (first, second):
            recorder.terminate()
            self.assertEqual((recorder.communicate(timeout=60)[1], recorder.returncode), ("", 0))
        frames = []
        for video in sorted(self.out.glob("*.mkv")):
            lines = harness.read_lines(video.with_suffix(".jsonl"))
            self.assertLessEqual({round(line["stream_time"] / 1e6) for line in lines},
                                 set(frame_times(video)), video.name)
            frames += [lines[0]["frame"]]
        self.assertEqual(frames.count(0), 2)  # both first files
        self.assertGreater(len(frames), 4)

    def test_review_reports_errors_in_the_tracks(self):
        self.assertEqual(run("--segment", 2, self.video, self.out).returncode, 0)
        video, tracks = self.out / "00001.mkv", self.out / "wrong.jsonl"
        first, rest = (self.out / "00001.jsonl").read_text().split("\n", 1)
        for wrong, words in (("[" * 200_000 + "]" * 200_000, "nested"),
                             ("[" * 200_000, "is no JSON: "),
                             (first.replace('"stream_time":2000000000', '"stream_time":"x"'),
                              "`stream_time` is no whole number"),
                             (first.replace('"stream_time":2000000000',
                                            f'"stream_time":{10 ** 400}'), "too large")):
            with self.subTest(wrong[:80]):
                self.assertNotEqual(wrong, first)
                tracks.write_text(f"{wrong}\n{rest}")
                self.check_refused(review(video, tracks), 1, f'Line 1 of "{tracks}": ')
                self.assertIn(words, review(video, tracks).stderr)
        # Blank lines don't count: the next one has the first time.
        tracks.write_text(f"\n\0\n{first}\n{rest}")
        said = review(video, tracks)
        self.assertEqual((said.returncode, said.stderr), (0, ""))
        tracks.write_text("time,pts\n")
        self.check_refused(review(video, tracks), 1, f'review: Line 1 of "{tracks}": is no JSON: ')
        self.assertRegex(review(video, tracks).stderr,
                         ": give a .jsonl file that csdtrackenc wrote\n$")
        tracks.chmod(0)
        if not os.access(tracks, os.R_OK):  # root may read all
            self.check_refused(review(video, tracks), 1, "wrong.jsonl")

    def test_tracks_elsewhere_are_not_overwritten(self):
        tracks = self.tmp / "elsewhere"
        for out in (self.out / "first", self.out / "second"):
            self.assertEqual(run("--tracks", tracks, self.video, out).returncode, 0)
        self.assertEqual([path.name for path in (self.out / "second").iterdir()], ["00001.mkv"])
        self.assertEqual([len(harness.read_lines(path)) for path in sorted(tracks.iterdir())],
                         [130, 130])

    def test_a_live_source_with_a_window(self):
        done = run("--segment", 1, "--seconds", 4, "--display=fakesink", "simulate:occlusion",
                   self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertGreater(self.check_together(len(list(self.out.glob("*.mkv"))), live=True), 5)

    def check_tracks_lost(self, tracks, words):
        """Records with tracks that can't be written. One warning must say so, and the recording
        must be as without that."""
        out = tracks.with_name(f"{tracks.name}-recording")
        done = run("--segment", 2, "--tracks", tracks, self.video, out)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, "^record: warning: the tracks end here, the recording goes "
                         f"on: .*({words}).*\nrecord: \\d+ of 130 frames have a line\n$")
        self.assertEqual(stream_of(out), self.whole())

    def whole(self):
        """The recording when all is well."""
        if not hasattr(type(self), "_whole"):
            out = self.tmp / "whole"
            self.assertEqual(run("--segment", 2, self.video, out).returncode, 0)
            type(self)._whole = stream_of(out)
        return self._whole

    def some_tracks(self):
        tracks = self.out / "tracks"
        tracks.mkdir(parents=True)
        return tracks

    def test_the_recording_is_the_same_as_without_csdtrack(self):
        self.out.mkdir()
        line = (f"filesrc location={self.video} ! decodebin ! tee name=in in. ! queue ! fakesink "
                "in. ! queue ! videoconvert ! x264enc speed-preset=veryfast bitrate=8000 "
                "vbv-buf-capacity=0 key-int-max=50 ! h264parse ! splitmuxsink muxer=matroskamux "
                f"max-size-time=2000000000 location={self.out}/%05d.mkv")
        subprocess.run([sys.executable, "-c", f"import harness; harness.play({line!r})"],
                       cwd=pathlib.Path(__file__).parent, env=ENVIRONMENT, check=True)
        self.assertEqual(stream_of(self.out), self.whole())

    def test_tracks_that_fail_from_the_second_file_on(self):
        tracks = self.some_tracks()
        (tracks / "00001.jsonl").mkdir()
        self.check_tracks_lost(tracks, "directory")
        self.assertGreater(len(harness.read_lines(tracks / "00000.jsonl")), 40)

    @unittest.skipUnless(os.geteuid() == 0, "mounting needs root")
    def test_a_full_disk_of_the_tracks(self):
        tracks = self.some_tracks()
        with harness.small_disk(tracks, "size=64k"):
            self.check_tracks_lost(tracks, "No space")
            # All lines that there was room for; a last one may be torn.
            written = (tracks / "00000.jsonl").stat().st_size
            self.assertGreater(written, 60_000)
            lines = harness.read_lines(tracks / "00000.jsonl", torn=True)
            self.assertEqual([line["frame"] for line in lines], list(range(len(lines))))
            self.assertGreater(len(lines), 5)

    def test_a_disk_of_the_tracks_that_is_full_from_the_start(self):
        tracks = self.some_tracks()
        (tracks / "00000.jsonl").symlink_to("/dev/full")
        self.check_tracks_lost(tracks, "No space")

    def test_a_reader_of_the_tracks_that_closes(self):
        tracks = self.some_tracks()
        os.mkfifo(tracks / "00000.jsonl")
        read = []

        def some_lines():
            with open(tracks / "00000.jsonl", encoding="utf-8") as pipe:
                read.extend(harness.parse_line(pipe.readline().rstrip("\n")) for _ in range(5))

        reader = threading.Thread(target=some_lines)
        reader.start()
        self.check_tracks_lost(tracks, "Broken pipe")
        reader.join(30)
        self.assertEqual([line["frame"] for line in read], list(range(5)))

    def test_a_disk_that_hangs_does_not_block_the_recording(self):
        """A pipe that nobody reads acts like such a disk: the thread that opens it waits for
        ever."""
        long = self.tmp / "long.mkv"
        harness.play("videotestsrc num-buffers=3200 pattern=black ! "
                     "video/x-raw,format=I420,width=160,height=120,framerate=25/1 ! x264enc "
                     f"speed-preset=ultrafast ! matroskamux ! filesink location={long}")
        for video, frames, words in ((self.video, 130, "stands still\n"),
                                     (long, 3200, "3000 lines wait for it\n")):
            tracks = self.tmp / f"pipe-{frames}"
            tracks.mkdir()
            os.mkfifo(tracks / "00000.jsonl")
            done = run("--tracks", tracks, video, self.out / str(frames))
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertRegex(done.stderr, "^record: warning: the tracks end here, the recording "
                             f"goes on: '{tracks}': its disk .*{words}"
                             f"record: \\d+ of {frames} frames have a line\n$")
            self.assertEqual(len(frame_times(self.out / str(frames) / "00000.mkv")), frames)

    @unittest.skipUnless(os.geteuid() == 0, "mounting needs root")
    def test_a_full_disk_is_reported(self):
        """Whether it has no space left or no room for more files."""
        disk = self.tmp / "disk"
        disk.mkdir()
        for size, name in (("64k", "00000"), ("8m,nr_inodes=3", "00001")):  # the lock is the third
            with harness.small_disk(disk, f"size={size}"):
                done = run("--segment", 2, "--tracks", self.out / name, self.video, disk)
                self.assertEqual(done.returncode, 1)
                self.assertRegex(done.stderr, rf"^record: can't write into '{disk}/{name}\.mkv' "
                                 r"\(the disk is full\): make room or give another place; \d+ of "
                                 r"\d+ frames are in the files, \d+ lines? beside\n$")

    def test_of_several_pictures_the_largest_is_recorded(self):
        video = self.tmp / "two.mkv"
        harness.play(f"matroskamux name=m ! filesink location={video} "
                     + "".join("videotestsrc num-buffers=20 ! "
                               f"video/x-raw,width={width},height=120 ! "
                               "x264enc tune=zerolatency ! m. " for width in (80, 160)))
        for source in video, video.as_uri():
            with self.subTest(source):
                self.out = self.tmp / f"largest-{str(source)[:4]}".replace("/", "")
                done = run(source, self.out)
                self.assertEqual((done.returncode, done.stderr),
                                 (0, f"record: warning: {source} has 2 pictures: the largest is "
                                  "taken\n"))
                self.assertEqual(self.check_together(1), 20)
                lines = harness.read_lines(self.out / "00000.jsonl")
                self.assertEqual({line["width"] for line in lines}, {160})

    def test_planar_rgb_and_411_are_recorded(self):
        """OBS records losslessly in RGB, NTSC DV is 4:1:1."""
        cases = (
            ("obs.mkv", (160, 120), ("-c:v", "libx264rgb", "-preset", "ultrafast", "-crf", 0)),
            ("dv.avi", (720, 480), ("-c:v", "dvvideo", "-pix_fmt", "yuv411p", "-r", "30000/1001")))
        for name, size, options in cases:
            with self.subTest(name):
                scene = harness.Scene(*size)
                video = harness.encode(self.tmp / name, (scene.picture(t) for t in range(10)),
                                       *options)
                self.out = self.tmp / f"{name}-recording"
                done = run(video, self.out)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertGreaterEqual(self.check_together(1), 10)
                self.assertEqual(review(self.out / "00000.mkv").stderr, "")

    def check_planted(self, fault, words):
        """Records with a fault that says nothing itself. The recording must say it."""
        program = f"""
import sys
from pipelines.lib import command, counts, record, recorded, runner, sidecar
Gst = runner.Gst
plain, count = recorded.Recorded.__init__, 0

def plant(self, Gst, files):
    plain(self, Gst, files)
    found = []
    files.iterate_recurse().foreach(found.append)
    [muxer] = [one for one in found if one.get_factory().get_name() == "matroskamux"]
    fault(files, muxer)

def drop(which):
    def on_buffer(*_):
        global count
        count += 1
        return Gst.PadProbeReturn.DROP if which(count) else Gst.PadProbeReturn.OK
    return Gst.PadProbeType.BUFFER, on_buffer

{fault}
recorded.Recorded.__init__ = plant
command.run("record", record.main)
"""
        done = harness.run_python(program, "--preset", "", "--segment", "2", self.video, self.out,
                                  env=ENVIRONMENT)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, f"^record: {words}\n$")

    def test_a_muxer_that_drops_a_packet_is_noticed(self):
        self.check_planted("""
def fault(_, muxer):
    muxer.sinkpads[0].add_probe(*drop(lambda count: count == 7))
""", r"'.*/00000\.mkv' holds 49 of the 50 packets that its muxer got; '.*/00000\.jsonl' holds 50 "
                           r"lines, and '.*/00000\.mkv' 49 packets")

    def test_an_encoder_that_drops_a_frame_is_noticed(self):
        self.check_planted("""
def fault(files, _):
    files.get_static_pad("video").add_probe(*drop(lambda count: count == 7))
""", r"130 frames came, and 129 left the encoder; .*")

    def test_a_disk_that_swallows_the_video_is_noticed(self):
        self.check_planted("""
def fault(files, _):
    files.connect("sink-added", lambda _, sink: sink.get_static_pad("sink").add_probe(
        *drop(lambda count: count > 40)))
""", r"'.*/00000\.mkv' holds \d+ of the 50 packets that its muxer got; '.*/00001\.mkv' holds 0 of "
                           "the 50 packets .*")

    def test_a_disk_that_swallows_a_line_is_noticed(self):
        self.check_planted("""
write = sidecar.os.write

def swallow(file, text):
    global count
    count += 1
    return len(text) if count == 7 else write(file, text)

sidecar.os.write = swallow

def fault(*_):
    pass
""", r"warning: the tracks end here, the recording goes on: '.*/00000\.jsonl': holds \d+ of the "
                           r"\d+ bytes that were written\nrecord: \d+ of 130 frames have a line")

    def test_a_file_that_cannot_be_read_back_is_told_from_a_loss(self):
        self.check_planted("""
import os
counts.STALLED, end = 1, recorded.Recorded.end_file

def spoil(self, name):
    if not name.endswith("0.mkv"):
        os.unlink(name)
        make = os.mkdir if name.endswith("1.mkv") else os.mkfifo  # whose reader waits for a writer
        make(name)
    end(self, name)

recorded.Recorded.end_file = spoil

def fault(*_):
    pass
""", r"'.*/00001\.mkv' could not be read back: \".*\" is a directory; "
                           r"'.*/00002\.mkv' could not be read back: no packet came from its disk "
                           "for 1 s")

    def check_rising(self, frames, said=None):
        """Each frame is in the one file, at a time of its own, with its line. `said`: what a live
        recording printed, in which some came faster than they could be tracked."""
        words = said and re.match(rf"(?:(\d+) of )?{frames} frames", said)
        self.assertEqual(self.check_together(1, live=said is not None),
                         int(words[1] or frames) if words else frames, said)
        times = frame_times(self.out / "00000.mkv")
        self.assertEqual(len(set(times)), frames)
        return times

    def test_stopped_before_the_first_picture_it_leaves_nothing(self):
        program = """
import os, signal
from pipelines.lib import command, record, runner, sources
sources.launch = lambda _: ("videotestsrc is-live=true ! video/x-raw,width=160,height=120 ! "
                            "valve drop=true drop-mode=forward-sticky-events")
play = runner.Run.play

def stop(run, *arguments, **options):
    runner.GLib.timeout_add(500, os.kill, os.getpid(), signal.SIGINT)
    play(run, *arguments, **options)

runner.Run.play = stop
command.run("record", record.main)
"""
        done = harness.run_python(program, "--preset", "", "camera", self.out, env=ENVIRONMENT)
        self.assertEqual((done.returncode, done.stderr),
                         (1, "record: camera: it was stopped before the first picture came: "
                          "nothing was recorded\n"))
        self.assertFalse(self.out.exists())

    def test_a_file_without_times_gets_them_by_its_rate(self):
        raw = harness.encode(self.tmp / "raw.mjpeg",
                             (harness.Scene().picture(t) for t in range(40)), "-q:v", 3)
        done = run(raw, self.out)
        self.assertEqual((done.returncode, done.stderr),
                         (0, f"record: {raw}: it says neither its frames' times nor their rate: 25 "
                          "a second are taken\n"))
        self.assertEqual(self.check_rising(40), list(range(0, 1600, 40)))

    def test_a_camera_without_times_is_stamped_on_arrival(self):
        pictures = [harness.encode(self.tmp / f"{i}.jpg", [harness.Scene().picture(i)])
                    for i in range(8)]

        class Camera(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=next")
                self.end_headers()
                for i in range(60):
                    picture = pictures[i % 8].read_bytes()
                    self.wfile.write(b"--next\r\nContent-Type: image/jpeg\r\nContent-Length: "
                                     b"%d\r\n\r\n%s\r\n" % (len(picture), picture))
                    time.sleep(0.05)

            def log_message(self, *_):
                pass

        server = http.server.HTTPServer(("127.0.0.1", 0), Camera)
        self.addCleanup(server.server_close)
        threading.Thread(target=server.handle_request, daemon=True).start()
        done = run(f"http://127.0.0.1:{server.server_port}/", self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        times = self.check_rising(60, done.stdout)
        self.assertGreater(times[-1] - times[0], 2500)
        self.assertLess(times[-1] - times[0], 8000)

    def test_two_frames_of_the_same_time_are_both_recorded(self):
        """GStreamer gives two frames of such a file the same time at each keyframe."""
        video = harness.encode(self.tmp / "xvid.avi",
                               (harness.Scene().picture(t) for t in range(60)), "-c:v", "mpeg4",
                               "-bf", 1, "-g", 12)
        done = run(video, self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.check_rising(60)

    def test_times_that_jump_go_on(self):
        """Two streams, one after the other, whose times are not one timeline: MPEG-4 in a program
        stream begins anew, a camera's clock is set."""
        program = """
from pipelines.lib import command, record, runner, sources
sources.launch = lambda _: ("videotestsrc is-live=true num-buffers=50 ! "
                            "video/x-raw,width=160,height=120,framerate=25/1 ! "
                            "identity name=jump")
make = runner.Gst.parse_launch

def jump(text):
    made = make(text)
    pad, count = made.get_by_name("jump").get_static_pad("src"), 0

    def on_buffer(pad, _):
        nonlocal count
        count += 1
        if count == 20:
            pad.set_offset(100 * runner.Gst.SECOND)
        return runner.Gst.PadProbeReturn.OK

    pad.add_probe(runner.Gst.PadProbeType.BUFFER, on_buffer)
    return made

runner.Gst.parse_launch = jump
command.run("record", record.main)
"""
        done = harness.run_python(program, "--preset", "", "clock", self.out, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"^record: clock: the times jump by \+\d+\.\d s: they go on "
                         r"from the frame before\n$")
        times = self.check_rising(50, done.stdout)
        self.assertLess(times[-1], 10000)

    SHORTAGE = re.compile(r"^the source gave (\d+) frames in ([\d.]+) s, (\d+) were due at its 25 "
                          r"a second: .*$", re.M)

    def test_a_live_source_that_stops_is_reported(self):
        program = """
from pipelines.lib import command, record, runner, sources
sources.launch = lambda _: ("videotestsrc is-live=true ! "
                            "video/x-raw,width=320,height=240,framerate=25/1 ! "
                            "valve name=valve drop-mode=forward-sticky-events")
play = runner.Run.play

def play_and_stop(run, *arguments, **options):
    runner.GLib.timeout_add_seconds(2, run.element("valve").set_property, "drop", True)
    play(run, *arguments, **options)

runner.Run.play = play_and_stop
command.run("record", record.main)
"""
        done = harness.run_python(program, "--preset", "", "--seconds", "6", "stops", self.out,
                                  env=ENVIRONMENT)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertRegex(done.stdout, self.SHORTAGE)
        gave, _, due = map(float, self.SHORTAGE.search(done.stdout).groups())
        self.assertGreater(due - gave, 50, done.stdout)

    def test_a_source_whose_times_begin_late(self):
        """As with RTSP: the recording did not begin at stream time 0."""
        program = """
from pipelines.lib import command, record, runner, sources
sources.launch = lambda _: ("csdsimsrc num-buffers=130 ! "
                            "video/x-raw,width=320,height=240,framerate=25/1 ! identity name=late")
make = runner.Gst.parse_launch

def late(text):
    made = make(text)
    if made.get_by_name("late"):
        # This changes the running time alone.
        made.get_by_name("late").get_static_pad("src").set_offset(700_000_000)
    return made

runner.Gst.parse_launch = late
command.run("record", record.main)
"""
        done = harness.run_python(program, "--preset", "", "--segment", "2", "late", self.out,
                                  env=ENVIRONMENT)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(self.check_together(3), 130)
        self.assertEqual(frame_times(self.out / "00000.mkv")[0], 700)
        self.assertEqual(review(self.out / "00001.mkv").stderr, "")

    def test_a_truncated_file_is_reported(self):
        torn = self.tmp / "torn.mkv"
        torn.write_bytes(self.video.read_bytes()[:self.video.stat().st_size // 2])
        done = run(torn, self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, rf"^record: '{torn}' has a picture up to [23]\.\d s only, "
                         r"and says that it lasts 5\.2 s: .*\n$")
        self.check_together(1)

    def test_all_frames_of_a_source_that_breaks_are_recorded(self):
        """Also those that are still in the encoder, which looks ahead."""
        program = """
from pipelines.lib import command, record, sources
sources.launch = lambda _: ("csdsimsrc ! video/x-raw,width=320,height=240,framerate=25/1 ! "
                            "identity error-after=61")
command.run("record", record.main)
"""
        done = harness.run_python(program, "--preset", "", "breaks", self.out, env=ENVIRONMENT)
        self.check_refused(done, 1, "record: breaks: the source broke off (Failed after iterations "
                           "as requested.)\n")
        self.assertEqual(self.check_together(1), 60)

    def test_a_source_that_ignores_eos_leaves_a_whole_file(self):
        """avdemux_gif is such a source."""
        gif = harness.encode(self.tmp / "endless.gif",
                             (harness.Scene().picture(t) for t in range(20)), "-loop", 0)
        done = run("--seconds", 1, gif, self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue(frame_times(self.out / "00000.mkv"))

    def test_a_slow_encoder_loses_no_frame_at_the_end(self):
        """It takes longer than a source is given to end, and than a pipeline may be still."""
        program = """
from pipelines.lib import command, record, runner, sources
sources.launch = lambda _: ("videotestsrc pattern=black ! "
                            "video/x-raw,width=160,height=120,framerate=25/1 ! "
                            "identity name=given ! queue max-size-buffers=40")
make = runner.Gst.parse_launch
count = 0

def given(*_):
    global count
    count += 1
    return runner.Gst.PadProbeReturn.OK

def slow(text):
    made = make(text.replace("! x264enc", "! identity sleep-time=80000 ! x264enc"))
    made.get_by_name("given").get_static_pad("src").add_probe(runner.Gst.PadProbeType.BUFFER, given)
    return made

runner.Gst.parse_launch = slow
command.run("record", record.main)
print(f"given: {count}")
"""
        done = harness.run_python(program, "--preset", "", "--set", "max-features=5", "--seconds",
                                  "2", "slow", self.out, env=ENVIRONMENT, timeout=180)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        frames = self.check_together(1)
        self.assertIn(f"given: {frames}\n", done.stdout)
        self.assertGreater(frames, 140)  # 11 s of work

    def test_a_live_source_below_its_frame_rate_is_reported(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            uri = f"srt://127.0.0.1:{probe.getsockname()[1]}"
        sender = subprocess.Popen(
            ["gst-launch-1.0", "-q",
             *("videotestsrc is-live=true ! "
               "video/x-raw,format=I420,width=320,height=240,framerate=10/1 ! capssetter "
               "caps=video/x-raw,framerate=25/1 ! x264enc tune=zerolatency key-int-max=10 ! "
               f"mpegtsmux ! srtsink wait-for-connection=false uri={uri}?mode=listener").split()],
            stdin=subprocess.DEVNULL)
        self.addCleanup(sender.wait)
        self.addCleanup(sender.kill)
        done = run("--seconds", 4, uri, self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        gave, seconds, due = self.SHORTAGE.search(done.stdout).groups()
        self.assertLess(int(gave), 0.6 * int(due))
        self.assertAlmostEqual(int(due), 25 * float(seconds) + 1, delta=2)
        # A file is read at any speed, so nothing is due.
        self.assertNotIn("due", run(self.video, self.tmp / "file-is-not-live").stdout)

    def test_a_window_that_fails_does_not_end_the_recording(self):
        done = run("--display=filesink", self.video, self.out)  # it fails, as it needs a location
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr,
                         "^record: warning: the window is gone, the recording goes on: .*\n$")
        self.assertEqual(self.check_together(1), 130)
        nowhere = {**ENVIRONMENT, "DISPLAY": "", "WAYLAND_DISPLAY": ""}
        done = subprocess.run([RECORD, "--no-install", "--display", self.video,
                               self.tmp / "nothing"],
                              capture_output=True, text=True, env=nowhere)
        self.check_refused(done, 1, "record: there is no display for a window")
        self.assertFalse((self.tmp / "nothing").exists())
        # Without such an element nothing begins, and no number of a file is taken.
        done = run("--display=nosuchsink", self.video, self.tmp / "nothing")
        self.check_refused(done, 1, 'no element "nosuchsink"')
        self.assertFalse((self.tmp / "nothing").exists())

    def test_a_killed_recorder_leaves_the_lines_of_all_recorded_frames(self):
        # Killed in the second and in the third file.
        for files in (2, 3):
            out = self.out / str(files)
            recorder = subprocess.Popen([RECORD, "--no-install", "--segment", "2", "simulate", out],
                                        env=ENVIRONMENT, start_new_session=True,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            last = out / f"{files - 1:05}.mkv"
            for _ in range(600):
                if last.exists() and last.stat().st_size > 50_000:
                    break
                time.sleep(0.1)
            # Before that the lines of a new file may still be in the one before it.
            time.sleep(0.5)
            os.killpg(recorder.pid, signal.SIGKILL)
            recorder.wait()
            lines = [line for video in sorted(out.glob("*.mkv")) for line
                     in harness.read_lines(video.with_suffix(".jsonl"), torn=video == last)]
            self.assertEqual(len(list(out.glob("*.jsonl"))), files)
            recorded = {time for video in out.glob("*.mkv") for time in frame_times(video)}
            tracked = {round(line["stream_time"] / 1e6) for line in lines}
            self.assertGreater(len(recorded), 50)
            # The source is live, so frames that its queue dropped have no line. But the last have.
            self.assertGreaterEqual(max(tracked), max(recorded))
            for video in sorted(out.glob("*.mkv"))[:-1]:
                self.assertLessEqual({round(line["stream_time"] / 1e6)
                                      for line in harness.read_lines(video.with_suffix(".jsonl"))},
                                     set(frame_times(video)), video.name)

    def test_errors_are_reported(self):
        file = self.tmp / "file"
        file.write_text("")
        for arguments, code, words in (
                ((self.video, file), 1, "another folder|where you may write"),
                (("nothing", self.out), 1, "no file"),
                ((self.video, self.tmp / ("x" * 300)), 1, "too long.*another folder"),
                (("x" * 300, self.out), 1, "no file"), ((self.video,), 2, "OUT"),
                ((self.video, self.out, "--segment", "-1"), 2, "--segment"),
                ((self.video, self.out, "--bitrate", "0"), 2, "--bitrate"),
                ((self.video, self.out, "--display=x!y"), 2, "--display"),
                ((file, self.out), 1, "file"),
                (("simulate", self.out, "--preset", "fast"), 2, "laparoscopy-1080p"),
                (("simulate", self.out, "--set", "points=1"), 2, "points")):
            with self.subTest(arguments=arguments):
                done = run(*arguments)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertTrue(re.search(words, done.stderr), done.stderr)
                self.assertNotIn("Traceback", done.stderr)
                self.assertFalse(self.out.exists())


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
