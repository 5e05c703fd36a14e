#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd-report as a command: report_command_test.py REPOSITORY BUILD."""

import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

import harness
from reports import (BUILD, ENVIRONMENT, FPS, PROGRAM, ReportCase, features, picture, report,
                     write_tracks)


def contents(folder):
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


class Command(ReportCase):
    def refused(self, *arguments, code=1, words=()):
        done = report(*arguments)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        lines = done.stderr.splitlines()
        self.assertTrue(lines[-1].startswith("csd-report: ") and (code == 2 or len(lines) == 1),
                        done.stderr)
        for word in words:
            self.assertIn(word, lines[-1])

    def test_help_and_wrong_options(self):
        done = report("--help")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("TRACKS.jsonl", done.stdout)
        for wrong in ((), (self.video,), (self.video, self.tracks, "out", "more"),
                      ("--magic", self.video, self.tracks)):
            self.refused(*wrong, code=2)

    def test_runs_as_installed(self):
        """From bin/, with csd-motion beside it and its parts in share/."""
        (self.tmp / "usr" / "bin").mkdir(parents=True)
        for program in (PROGRAM, BUILD / "core" / "programs" / "csd-motion"):
            shutil.copy(program, self.tmp / "usr" / "bin")
        shutil.copytree(PROGRAM.parent / "report", self.tmp / "usr" / "share" / "csdtrack" /
                        "report", ignore=shutil.ignore_patterns("__pycache__"))
        done = subprocess.run([self.tmp / "usr" / "bin" / "csd-report", self.video, self.tracks],
                              capture_output=True, text=True, cwd=self.tmp,
                              stdin=subprocess.DEVNULL, timeout=300)
        self.assertEqual((done.returncode, done.stdout, done.stderr),
                         (0, "csdtrack-report/index.html\n", ""))
        self.assertTrue((self.tmp / "csdtrack-report" / "index.html").is_file())

    def test_wrong_videos_tracks_and_folders_are_refused(self):
        out = self.tmp / "refused"
        lines = self.tracks.read_text().splitlines(keepends=True)[:5]

        def tracks(name, *text):
            (self.tmp / name).write_text("".join(text))
            return self.tmp / name

        (self.tmp / "text.mp4").write_text("only words\n" * 100)
        self.refused(self.tmp / "none.mp4", self.tracks, out, words=["no file", "none.mp4"])
        self.refused(self.video, self.tmp, out, words=["folder"])
        self.refused(self.tmp / "text.mp4", self.tracks, out, words=["text.mp4", "no video"])
        self.refused(self.video, tracks("empty.jsonl"), out, words=["empty"])
        self.refused(self.video, tracks("torn.jsonl", lines[0], lines[1][:50] + "\n", lines[2]),
                     out, words=["torn.jsonl:2:", "JSON"])
        self.refused(self.video, tracks("csv.jsonl", "frame,pts\n1,2\n"), out,
                     words=["csv.jsonl:1:"])
        self.refused(self.video, tracks("number.jsonl", "[]\n"), out, words=["number.jsonl:1:"])
        self.refused(self.video,
                     tracks("schema.jsonl", lines[0].replace('"schema":1', '"schema":2')), out,
                     words=["schema 2"])
        self.refused(self.video, tracks("state.jsonl", lines[0].replace("tracked", "magic")), out,
                     words=["state.jsonl:1:"])
        self.refused(self.video, tracks("deep.jsonl", "[" * 200_000 + "\n"), out,
                     words=["deep.jsonl:1:", "JSON"])
        self.refused(self.video, tracks("long.jsonl", lines[0], "9" * (9 << 20)), out,
                     words=["long.jsonl:2:", "8 MiB"])
        for name, said, wrong in (
                ("id", '"id":0', '"id":[1]'), ("name", '"id":0', '"id":"<img src=x>"'),
                ("bool", '"id":0', '"id":true'), ("x", '"x":', '"x":1e308,"_":'),
                ("flat", '"height":240', '"height":0'), ("frame", '"frame":0', '"frame":"0"'),
                ("pts", '"pts":0', '"pts":"0"')):
            self.refused(self.video, tracks(f"{name}.jsonl", lines[0].replace(said, wrong, 1)), out,
                         words=[f"{name}.jsonl:1:"])
        self.refused(self.video, tracks("back.jsonl", lines[1], lines[0]), out,
                     words=["back.jsonl:2:", "time"])
        sized = [x.replace('"height":240', '"height":180') for x in lines]
        self.refused(self.video, tracks("size.jsonl", *sized), out, words=["320×180", "320×240"])
        self.refused(self.video, write_tracks(self.tmp / "fps.jsonl", 9000, features, fps=3000),
                     out, words=["time of a frame"])
        self.refused(self.video, write_tracks(self.tmp / "none.jsonl", 5, lambda _: []), out,
                     words=["no position"])
        self.refused(self.video, self.tracks, pathlib.Path("/dev/null/page"),
                     words=["can't write into '/dev/null'"])
        self.assertFalse(out.exists())
        self.assertEqual(list(self.tmp.glob(".unfinished-*")), [])

    @unittest.skipUnless(os.geteuid() == 0, "mounting needs root")
    def test_a_full_disk_is_reported_for_the_page(self):
        """The disk is full at the tracks, at the copy of the video, or at ffmpeg's new video."""
        boxed = self.tmp / "boxed.mkv"
        subprocess.run(["ffmpeg", "-v", "error", "-i", self.video, "-c", "copy", boxed], check=True,
                       stdin=subprocess.DEVNULL)
        short, disk = write_tracks(self.tmp / "few.jsonl", 5, features), self.tmp / "disk"
        disk.mkdir()
        for video, tracks in ((self.video, self.tracks), (self.video, short), (boxed, short)):
            with harness.small_disk(disk, "size=24k"):
                self.refused(video, tracks, disk / "page", words=[
                    f"csd-report: can't write into '{disk}/page' (the disk is full)"])

    @unittest.skipUnless(os.geteuid() == 0, "mounting needs root")
    def test_needs_no_folder_for_temporary_files(self):
        """Neither for the output of csd-motion nor for that of ffmpeg: only OUT's parent can be
        written."""
        video = harness.encode(self.tmp / "temporary.avi", (picture(i) for i in range(30)), "-c:v",
                               "ffv1", rate=FPS)
        alone = ("for folder in /tmp /var/tmp; do mount --bind $folder $folder && mount -o "
                 "remount,bind,ro $folder || exit 77; done\n"
                 'mount --bind "$0" "$0" && mount -o remount,bind,rw "$0" || exit 77\n'
                 'cd /proc && exec "$@"')
        done = subprocess.run(
            ["unshare", "-m", "sh", "-c", alone, self.tmp, PROGRAM, video,
             write_tracks(self.tmp / "thirty.jsonl", 30, features), self.tmp / "temporary"],
            capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=300, env=ENVIRONMENT)
        if done.returncode == 77 or "unshare" in done.stderr:
            raise unittest.SkipTest("mounting is not allowed here")
        self.assertEqual((done.returncode, done.stdout),
                         (0, f"{self.tmp / 'temporary' / 'index.html'}\n"), done.stderr)

    def test_names_that_are_not_utf_8(self):
        odd = os.fsdecode(b"\xff")
        video = shutil.copy(self.video, self.tmp / f"{odd}.mp4")
        tracks = shutil.copy(self.tracks, self.tmp / f"{odd}.jsonl")
        done = subprocess.run([PROGRAM, video, tracks, self.tmp / odd], capture_output=True,
                              stdin=subprocess.DEVNULL, timeout=300,
                              env={**ENVIRONMENT, "LC_ALL": "C.UTF-8"})
        self.assertEqual((done.returncode, done.stdout, done.stderr),
                         (0, os.fsencode(self.tmp / odd / "index.html") + b"\n", b""))
        self.assertIn(r'"title":"\udcff.mp4"', (self.tmp / odd / "data" / "index.js").read_text())

    def test_stream_times_that_go_back(self):
        """Two streams joined, and both begin at 0: running_time goes on."""
        lines = [json.loads(line) for line in self.tracks.read_text().splitlines()]
        for line in lines[300:]:
            line["pts"] -= lines[300]["running_time"]
            line["stream_time"] = line["pts"]
        joined = self.tmp / "joined.jsonl"
        joined.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
        said = self.make(self.video, joined, self.tmp / "joined").stderr
        self.assertEqual(
            said, "csd-report: note: stream_time goes back, so the times are running_time\n")
        self.make(self.video, self.tracks, self.tmp / "unjoined")
        for name in ("scene", "tracks-00000", "tracks-00001", "tracks-00002"):
            one, two = ((self.tmp / page / "data" / f"{name}.js").read_bytes()
                        for page in ("joined", "unjoined"))
            self.assertEqual(one, two, name)
        self.assertEqual(len(list((self.tmp / "joined" / "data").glob("tracks-*"))), 3)

    def test_the_picture_changes_its_size(self):
        lines = self.tracks.read_text().splitlines(keepends=True)
        changed = self.tmp / "changed.jsonl"
        changed.write_text("".join(lines[:500] + [
            line.replace('"width":320', '"width":640') for line in lines[500:]]))
        said = self.make(self.video, changed, self.tmp / "changed").stderr
        note = "note: 250 lines are left out, as the picture's size changes from 320×240"
        self.assertEqual(said, f"csd-report: {note}\n")
        index = (self.tmp / "changed" / "data" / "index.js").read_text()
        self.assertIn(f'"notes":["{note}"', index)
        self.assertIn('"frames":500,', index)

    def test_hours_between_two_frames(self):
        lines = self.tracks.read_text().splitlines(keepends=True)[:100]
        late = lines[-1].replace('"stream_time":3960000000', '"stream_time":7200000000000')
        (self.tmp / "hours.jsonl").write_text("".join([*lines[:-1], late]))
        self.make(self.video, self.tmp / "hours.jsonl", self.tmp / "hours")

    def test_tracks_that_may_be_of_another_video_are_a_warning(self):
        small = harness.encode(self.tmp / "small.mp4", (picture(i)[::2, ::2] for i in range(100)),
                               *harness.H264, rate=FPS)
        said = self.make(small, write_tracks(self.tmp / "long.jsonl", 150, features),
                         self.tmp / "other").stderr
        self.assertRegex(said, r"^csd-report: warning: the tracks may be another video's: .* "
                         r"320×240, .* 160×120; 67% of .* 6\.0 s, .* 4\.0 s\n$")
        self.assertIn("may be another video's",
                      (self.tmp / "other" / "data" / "index.js").read_text())
        self.assertEqual(self.make(self.video, self.tracks, self.tmp / "own").stderr, "")

    def test_out_is_replaced_only_if_it_is_a_report(self):
        out = self.tmp / "replaced"
        out.mkdir()
        (out / "notes.txt").write_text("of the user")
        self.refused(self.video, self.tracks, out, words=["holds what is no report"])
        self.assertEqual([p.name for p in out.iterdir()], ["notes.txt"])
        (out / "notes.txt").unlink()
        self.make(self.video, self.tracks, out)
        shutil.copy(self.video, out / "mine.mp4")
        self.refused(out / "mine.mp4", self.tracks, out, words=["is in"])
        before = contents(out)
        short = write_tracks(self.tmp / "short.jsonl", 100, features)
        self.make(self.video, short, out, "--title", "<b>&")
        after = contents(out)
        self.assertNotIn(pathlib.Path("mine.mp4"), after)
        self.assertLess(len(after), len(before))
        self.assertIn("<title>&lt;b&gt;&amp; ", after[pathlib.Path("index.html")].decode())

    def test_videos_that_browsers_play_are_copied_others_converted(self):
        def packets(path):
            return subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-map", "0:v", "-c", "copy",
                                   "-bsf:v", "h264_mp4toannexb", "-f", "h264", "-"],
                                  capture_output=True, check=True, stdin=subprocess.DEVNULL).stdout

        self.make(self.video, self.tracks, self.tmp / "copied")
        self.assertEqual((self.tmp / "copied" / "video.mp4").read_bytes(), self.video.read_bytes())
        subprocess.run(["ffmpeg", "-v", "error", "-i", self.video, "-c", "copy",
                        self.tmp / "bars.mkv"],
                       check=True, stdin=subprocess.DEVNULL)
        self.make(self.tmp / "bars.mkv", self.tracks, self.tmp / "remuxed")
        self.assertEqual(hashlib.md5(packets(self.tmp / "remuxed" / "video.mp4")).digest(),
                         hashlib.md5(packets(self.video)).digest())
        lossless = harness.encode(self.tmp / "bars.avi", (picture(i) for i in range(50)), "-c:v",
                                  "ffv1", rate=FPS)
        done = self.make(lossless, write_tracks(self.tmp / "fifty.jsonl", 50, features),
                         self.tmp / "converted")
        self.assertIn("converting the video to H.264 100%", done.stderr)
        self.assertEqual(harness.decoded_frames(self.tmp / "converted" / "video.mp4"), 50)


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
