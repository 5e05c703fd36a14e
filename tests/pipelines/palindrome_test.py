#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/palindrome plays the same frames forwards and backwards, in bounded memory,
and scores the tracks.

palindrome_test.py ROOT BUILD"""

import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])
COMMAND = ROOT / "pipelines" / "experiments" / "palindrome"
os.environ["CSDTRACK_BUILD"] = str(BUILD)
from pipelines.experiments import builds, mirror, palindrome as command  # noqa: E402

os.environ.update(builds.environment())  # before harness initializes GStreamer
import harness  # noqa: E402

TRACKERS = ("lk", "still", "csrt")


def palindrome(*arguments):
    return subprocess.run([COMMAND, "--no-install", *map(str, arguments)], capture_output=True,
                          text=True)


def ffmpeg(*arguments):
    return subprocess.run(["ffmpeg", "-v", "error", "-y", *map(str, arguments)], check=True,
                          capture_output=True).stdout


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="csdtrack-palindrome-")
        cls.addClassCleanup(folder.cleanup)
        cls.tmp = pathlib.Path(folder.name)

    def simulated(self, name, frames=40, size=(320, 240), container="matroskamux"):
        """A video with few key frames and with B-frames, so that seeking is not trivial."""
        path = self.tmp / name
        subprocess.run("gst-launch-1.0 -q csdsimsrc scenario=deformation seed=3 "
                       f"num-buffers={frames} ! "
                       f"video/x-raw,format=I420,width={size[0]},height={size[1]},framerate=25/1 ! "
                       "x264enc bframes=3 key-int-max=17 speed-preset=veryfast ! h264parse ! "
                       f"{container} ! filesink location={path}".split(), check=True)
        return path


class Mirror(Case):
    def play(self, path, most, pieces, since=0):
        """Returns the frames' hashes, without the padding of rows, their times, and the Mirror.
        `pieces` is the number of images in each piece."""
        shown = mirror.Mirror(path, since, most, 0)
        hashes, times = [], []
        for time, frame in shown:
            info = shown.picture.info
            shown._memory = pieces * info.size
            self.assertEqual(len(frame), info.size)
            rows = hashlib.md5()
            for plane, (width, height) in enumerate(
                    ((info.width, info.height),
                     *[((info.width + 1) // 2, (info.height + 1) // 2)] * 2)):
                for row in range(height):
                    at = info.offset[plane] + row * info.stride[plane]
                    rows.update(frame[at:at + width])
            hashes.append(rows.hexdigest())
            times.append(time)
        return hashes, times, shown

    def decoded(self, path):
        """The hashes of the frames as ffmpeg decodes them."""
        lines = ffmpeg("-i", path, "-pix_fmt", "yuv420p", "-f", "framemd5",
                       "-").decode().splitlines()
        return [line.split(",")[-1].strip() for line in lines if not line.startswith("#")]

    def test_frames_are_the_same_forwards_and_backwards(self):
        """The video has 322×238 pixels, so after the 161 columns of chroma there is padding."""
        path = self.simulated("clip.mkv", size=(322, 238))
        expected = self.decoded(path)
        self.assertEqual(len(set(expected)), 40)
        for most, pieces in ((250, 7), (40, 100), (12, 1)):
            with self.subTest(most=most, pieces=pieces):
                hashes, times, shown = self.play(path, most, pieces)
                images = min(most, 40)
                self.assertEqual(hashes, expected[:images] + expected[:images - 1][::-1])
                self.assertEqual(shown.images, images)
                self.assertEqual(shown.pieces, -(-(images - 1) // pieces))
                self.assertEqual(shown.decoded_anew, 0)
                self.assertEqual([round(time / 1e6) for time in times],
                                 [40 * i for i in range(2 * images - 1)])

    def test_a_part_of_a_video(self):
        path = self.simulated("clip.mkv")
        hashes, _, _ = self.play(path, 10, 4, since=800000000)
        expected = self.decoded(path)[20:30]
        self.assertEqual(hashes, expected + expected[:-1][::-1])

    def test_real_clips(self):
        for clip in harness.clips():
            with self.subTest(clip=clip.name):
                hashes, _, shown = self.play(clip, 40, 15, since=1000000000)
                self.assertEqual(len(hashes), 79)
                self.assertGreater(len(set(hashes)), 35)
                self.assertEqual(hashes, hashes[::-1])
                self.assertEqual((shown.pieces, shown.decoded_anew), (3, 0))

    def test_a_video_without_an_index(self):
        path = self.simulated("bare.h264", container="video/x-h264,stream-format=byte-stream")
        expected = self.decoded(path)
        hashes, _, _ = self.play(path, 250, 10)
        self.assertEqual(hashes, expected + expected[:-1][::-1])

    def test_seeks_to_a_wrong_time_are_corrected(self):
        path = self.simulated("clip.mkv")
        expected = self.decoded(path)
        found = mirror.Decoding

        def late(path, since):
            return found(path, since + 120000000 if since else 0)

        with unittest.mock.patch.object(mirror, "Decoding", late):
            hashes, _, shown = self.play(path, 250, 10)
        self.assertEqual(hashes, expected + expected[:-1][::-1])
        self.assertEqual((shown.pieces, shown.decoded_anew), (4, 3),
                         "all pieces but the first")

    def test_other_frames_are_noticed(self):
        shown = mirror.Mirror(self.simulated("clip.mkv"), 0, 20, 1 << 20)
        with self.assertRaisesRegex(builds.Failure, "does not decode to the same frames"):
            for i, _ in enumerate(shown):
                if i == 19:
                    shown._sums[11] ^= 1


class Scores(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        clip = cls.simulated(cls, "clip.mkv")
        (cls.tmp / "other").mkdir()
        ffmpeg("-i", clip, "-t", 0.2, "-c", "copy", cls.tmp / "other" / "clip.mkv")
        done = palindrome("--trackers", ",".join(TRACKERS), "--features", 12, "--frames", 24,
                          "--json", "--out", cls.tmp / "out", clip, cls.tmp / "other" / "clip.mkv")
        assert done.returncode == 0, done.stderr
        cls.rows = {row["tracks"]: row for row in json.loads(done.stdout)["palindromes"]}
        cls.said = done.stderr

    def lines(self, name):
        return [json.loads(line) for line in (self.tmp / "out" / name).read_text().splitlines()]

    def test_a_tracker_that_never_moves_always_returns(self):
        row = self.rows["clip/still.jsonl"]
        self.assertEqual(row["counts"],
                         {"frames": 47, "features": 12, "claims": 12 * 47, "pairs": 12 * 23,
                          "apart": 0, "returned": 12, "falsely_returned": 0})

    def test_rows(self):
        self.assertEqual(list(self.rows),
                         [f"{clip}/{t}.jsonl" for clip in ("clip", "clip-2") for t in TRACKERS])
        self.assertEqual([row["tracker"] for row in self.rows.values()], [*TRACKERS] * 2)
        self.assertEqual(self.rows["clip/csrt.jsonl"]["counts"]["features"], 10,
                         "slow trackers get fewer features")
        self.assertGreater(self.rows["clip/lk.jsonl"]["returned"], 0.8,
                           "LK follows a second of a mildly beating heart")

    def test_all_trackers_get_the_same(self):
        """The same features, frames and times."""
        lk = self.lines("clip/lk.jsonl")
        begun = {f["id"]: (f["x"], f["y"]) for f in lk[0]["features"]}
        self.assertEqual(list(begun), list(range(12)))
        self.assertEqual([line["pts"] for line in lk], [40000000 * i for i in range(47)])
        for name in ("still", "csrt"):
            other = self.lines(f"clip/{name}.jsonl")
            self.assertEqual([line["frame"] for line in other], [line["frame"] for line in lk])
            for feature in other[0]["features"]:
                self.assertEqual((feature["x"], feature["y"]), begun[feature["id"]])

    def test_each_clip_has_a_name_of_its_own(self):
        """Also where a clip's name looks like a numbered one."""
        for videos, names in ((("a/clip.mkv", "b/clip.mkv", "clip-2.mkv", "c/clip.mp4"),
                               ["clip", "clip-3", "clip-2", "clip-4"]),
                              (("clip-2.mkv", "a/clip-2.mkv", "clip.mkv", "a/clip.mkv"),
                               ["clip-2", "clip-2-2", "clip", "clip-3"])):
            self.assertEqual([name for name, _ in command.named(list(map(pathlib.Path, videos)))],
                             names)

    def test_progress_is_shown_and_only_tracks_are_left(self):
        self.assertIn("100 % (47 frames", self.said)
        self.assertEqual({path.name for path in (self.tmp / "out").iterdir()}, {"clip", "clip-2"})
        self.assertEqual({path.name for path in (self.tmp / "out" / "clip").iterdir()},
                         {f"{t}.jsonl" for t in TRACKERS})

    def test_table(self):
        done = palindrome("--trackers", "still", "--frames", 4, "--markdown", self.tmp / "clip.mkv")
        self.assertEqual(done.stdout.splitlines()[-1],
                         "| clip/still.jsonl | still | 50 | 7 | 1.000 | 0.000 | 1.000 | 0.000 |")


class Memory(Case):
    def peak(self, video):
        """The peak of the command's memory, in MB."""
        process = subprocess.Popen([COMMAND, "--no-install", "--trackers", "lk", "--features", "5",
                                    "--frames", "1000", "--memory", "4", video],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(process.returncode, 0)
        return usage.ru_maxrss / 1024

    def test_memory_does_not_grow_with_the_video(self):
        """A frame of 640×480 takes 0.46 MB, so all frames of the longer video take 83 MB more."""
        peaks = []
        for frames in (60, 240):
            video = self.tmp / f"{frames}.mkv"
            ffmpeg("-f", "lavfi", "-i", "testsrc2=size=640x480:rate=25", "-frames:v", frames,
                   "-c:v", "libx264", "-preset", "veryfast", "-pix_fmt", "yuv420p", video)
            peaks.append(self.peak(video))
        self.assertLess(peaks[1] - peaks[0], 30, peaks)


class Errors(Case):
    def refused(self, code, text, *arguments):
        done = palindrome("--trackers", "still", *arguments)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertIn(text, done.stderr)
        self.assertNotIn("Traceback", done.stderr)

    def test_wrong_videos_are_refused(self):
        self.refused(1, "there is no file", self.tmp / "nothing.mkv")
        self.refused(1, "is no file", self.tmp)
        (self.tmp / "empty.mkv").touch()
        self.refused(1, "is empty", self.tmp / "empty.mkv")
        (self.tmp / "text.mkv").write_text("no video at all\n" * 100)
        self.refused(1, "isn't a video", self.tmp / "text.mkv")
        ffmpeg("-f", "lavfi", "-i", "sine", "-t", 1, self.tmp / "sound.m4a")
        self.refused(1, "has no video stream", self.tmp / "sound.m4a")
        ffmpeg("-f", "lavfi", "-i", "color=black:size=320x240", "-t", 1, self.tmp / "black.mkv")
        self.refused(1, "nothing stands out", self.tmp / "black.mkv")
        ffmpeg("-f", "lavfi", "-i", "testsrc2=size=320x240", "-frames:v", 1, self.tmp / "one.mkv")
        self.refused(1, "has 1 frame from 0 s on", self.tmp / "one.mkv")
        self.refused(1, "has no frames from 7.5 s on", "--from", 7.5, self.tmp / "black.mkv")

    def test_a_truncated_file_is_reported(self):
        """Its frames are scored all the same. There is no report where they were enough."""
        whole, cut = self.simulated("whole.mkv", 75), self.tmp / "cut.mkv"
        cut.write_bytes(whole.read_bytes()[:whole.stat().st_size // 3])
        for video, frames, said in ((cut, 250, True), (cut, 5, False), (whole, 250, False)):
            with self.subTest(video=video.name, frames=frames):
                done = palindrome("--trackers", "still", "--frames", frames, "--json", video)
                self.assertEqual(done.returncode, 0, done.stderr)
                report = "s only, and says that it lasts 3.0 s: is the file complete?"
                self.assertEqual(report in done.stderr, said, done.stderr)

    def test_other_videos_are_scored_where_one_is_wrong(self):
        (self.tmp / "text.mkv").write_text("no video at all\n" * 100)
        done = palindrome("--trackers", "still", "--json", self.tmp / "text.mkv",
                          self.simulated("good.mkv", 3))
        self.assertEqual(done.returncode, 1)
        self.assertIn("text.mkv' isn't a video", done.stderr)
        self.assertEqual([row["tracks"] for row in json.loads(done.stdout)["palindromes"]],
                         ["good/still.jsonl"])

    def test_wrong_options_are_refused(self):
        for arguments in ([], ["--frames", "1", "x"], ["--memory", "0", "x"], ["--from", "-1", "x"],
                          ["--trackers", "psychic", "x"], ["--json", "--markdown", "x"],
                          ["--nothing", "x"]):
            with self.subTest(arguments):
                done = palindrome(*arguments)
                self.assertEqual(done.returncode, 2)
                self.assertIn("usage", done.stderr)

    def test_a_file_in_place_of_the_folder_is_refused(self):
        clip = self.simulated("clip.mkv", 2)
        self.refused(1, str(clip), "--out", clip, clip)

    def test_help(self):
        done = palindrome("--help")
        self.assertEqual(done.returncode, 0)
        for word in ("csd-2012", "csrt", "--memory", "checksum", "Exit code"):
            self.assertIn(word, done.stdout)

    def test_a_link_to_the_command_finds_the_repository(self):
        with tempfile.TemporaryDirectory() as folder:
            outside = pathlib.Path(folder)
            (outside / "folder").symlink_to(COMMAND.parent)
            (outside / "command").symlink_to(COMMAND)
            (outside / "again").symlink_to("command")
            for linked in "folder/palindrome", "command", "again":
                done = subprocess.run([outside / linked, "--help"], capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
