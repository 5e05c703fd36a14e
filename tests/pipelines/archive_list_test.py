#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/archive: which videos of a folder it finds, and what it leaves where it can't begin."""

import os
import pathlib
import shutil
import subprocess
import sys

import harness
import machines

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])


def run(*arguments, cwd=None, **environment):
    return subprocess.run([SOURCE / "pipelines" / "archive", "--no-install", "--set",
                           "max-features=8", *map(str, arguments)],
                          capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=300,
                          cwd=cwd, env={**os.environ, "CSDTRACK_BUILD": str(BUILD), **environment})


class List(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        machines.need("parallel")
        cls.video = harness.scene_video(cls.tmp / "video.mkv", 20)

    def setUp(self):
        self.home = self.tmp / self.id().split(".")[-1]
        self.videos, self.out = self.home / "videos", self.home / "out"
        (self.videos / "sub").mkdir(parents=True)

    def put(self, name):
        shutil.copy(self.video, self.home / name)

    def tracked(self):
        return {str(path.relative_to(self.out)) for path in self.out.rglob("*.jsonl")}

    def test_a_link_to_a_parent_folder_is_followed_once(self):
        self.put("videos/one.mkv")
        self.put("videos/sub/two.mkv")
        self.put("other.mkv")
        (self.videos / "sub" / "loop").symlink_to("../..")  # OUT is there too
        done = run(self.videos, self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, f"archive: left out, for it is '{self.videos}' again: "
                         f"'{self.videos}/sub/loop/videos'\n")
        self.assertEqual(self.tracked(),
                         {"one.mkv.jsonl", "sub/two.mkv.jsonl", "sub/loop/other.mkv.jsonl"})
        before = {path: path.stat().st_mtime_ns for path in self.out.rglob("*.json*")}
        self.assertEqual(run(self.videos, self.out).returncode, 0)
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.out.rglob("*.json*")},
                         before)

    def test_each_file_and_folder_is_taken_once_its_own_name_first(self):
        self.put("videos/sub/two.mkv")
        self.put("away.mkv")
        (self.videos / "a folder").symlink_to("sub")
        (self.videos / "a.mkv").symlink_to("sub/two.mkv")
        (self.videos / "b.mkv").symlink_to("../away.mkv")
        (self.videos / "c.mkv").symlink_to("../away.mkv")
        done = run(self.videos, self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, f"archive: left out, for it is '{self.videos}/sub' again: "
                         f"'{self.videos}/a folder', and 2 more of the kind\n")
        self.assertEqual(self.tracked(), {"sub/two.mkv.jsonl", "b.mkv.jsonl"})
        # A list may name a file twice. A link to nothing is not the same file as another.
        listed = self.home / "list"
        listed.write_text("videos/a.mkv\nvideos/sub/two.mkv\n")
        done = run(listed, self.home / "of a list")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue((self.home / "of a list" / "videos" / "a.mkv.jsonl").exists())
        (self.videos / "d.mkv").symlink_to("nothing")
        self.assertRegex(run(self.videos, self.out).stderr,
                         "2 more of the kind\narchive: 1 of 3 videos not done")

    def test_names_that_are_no_utf_8_are_reported(self):
        self.put("videos/one.mkv")
        bad = self.home / os.fsdecode(b"b\xe9d")
        bad.mkdir()
        self.put(bad / "two.mkv")
        listed = self.home / "list"
        listed.write_bytes(b"videos/one.mkv\nb\xe9d/two.mkv\n")
        done = run(listed, self.out)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"failed: b\\xe9d/two.mkv: '{self.home}/b\\xe9d/two.mkv' is no UTF-8: rename "
                      "it\n", done.stdout)
        self.assertEqual(self.tracked(), {"videos/one.mkv.jsonl"})
        # The name is UTF-8, the name of its folder is not.
        done = run(".", self.home / "of a folder", cwd=bad)
        self.assertIn(f"failed: two.mkv: '{self.home}/b\\xe9d/two.mkv' is no UTF-8: rename it\n",
                      done.stdout)
        self.check_refused(run(self.videos, "new", cwd=bad), 2,
                           f"archive: '{self.home}/b\\xe9d/new' is no UTF-8, ")
        self.assertEqual([path.name for path in bad.iterdir()], ["two.mkv"])

    def test_sound_and_pipes_are_reported(self):
        harness.play("audiotestsrc num-buffers=20 ! wavenc ! filesink "
                     f"location={self.videos}/sound.mkv")
        os.mkfifo(self.videos / "pipe.mkv")
        done = run(self.videos, self.out)
        self.assertIn(f"failed: pipe.mkv: '{self.videos}/pipe.mkv' is no file but a pipe",
                      done.stdout)
        self.assertIn(f"failed: sound.mkv: '{self.videos}/sound.mkv' has no picture in it",
                      done.stdout)

    def test_a_run_that_cannot_begin_leaves_nothing(self):
        out = self.home / "deep" / "out"

        def check(words, *arguments):
            done = run(*arguments, out, PARALLEL_SSH="false")  # no host answers
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, words)

        self.put("videos/one.mkv")
        cases = (("sub' names no video", self.videos / "sub"),
                 ("none of the hosts", "--ssh", "nurse", self.videos))
        for case in cases:
            check(*case)
            self.assertEqual(list(self.home.iterdir()), [self.videos])
        # Files that were there before stay.
        out.mkdir(parents=True)
        (out / "notes").touch()
        for case in cases:
            check(*case)
            self.assertEqual(list(out.iterdir()), [out / "notes"])
        (out / "notes").unlink()
        check(*cases[0])
        self.assertEqual(list(out.parent.iterdir()), [out])
        self.assertEqual(run(self.videos, out).returncode, 0)
        check(*cases[0])
        self.assertEqual({path.name for path in out.iterdir()},
                         {".archive", "index.sqlite", "one.mkv.json", "one.mkv.jsonl"})


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
