#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/archive on this machine: which videos it tracks, tracks again or leaves as they are."""

import contextlib
import fcntl
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time

import harness
import machines

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
ARCHIVE = SOURCE / "pipelines" / "archive"
ENVIRONMENT = {**os.environ, "CSDTRACK_BUILD": str(BUILD)}
FEW = ("--set", "max-features=8")  # quick


def start(*arguments):
    return subprocess.Popen([ARCHIVE, "--no-install", *map(str, arguments)],
                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, env=ENVIRONMENT)


def run(*arguments, env=ENVIRONMENT):
    return subprocess.run([ARCHIVE, "--no-install", *map(str, arguments)], capture_output=True,
                          text=True, stdin=subprocess.DEVNULL, timeout=300, env=env)


def index(out):
    with contextlib.closing(sqlite3.connect(out / "index.sqlite")) as base:
        base.row_factory = sqlite3.Row
        return {row["name"]: dict(row) for row in base.execute("SELECT * FROM videos")}


def files(out):
    """{file: what changes when the file is written again} of all results."""
    return {str(path.relative_to(out)): (path.stat().st_ino, path.stat().st_mtime_ns)
            for path in out.rglob("*") if path.is_file() and
            not path.is_relative_to(out / ".archive") and path.name != "index.sqlite"}


def made_again(out, before):
    return {name for name, mark in files(out).items() if name.endswith(".jsonl") and
            before.get(name) != mark}


class Archive(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        machines.need("parallel")
        cls.videos = videos = cls.tmp / "videos"
        (videos / "a folder").mkdir(parents=True)
        cls.good = {"one.mkv": 30, "a folder/it's {} \"two\"\n.mkv": 40, "three.MP4": 20}
        for seed, (name, frames) in enumerate(cls.good.items()):
            harness.scene_video(videos / name, frames, seed=seed)
        (videos / "notes.txt").write_text("no video")
        (videos / "broken.mp4").write_text("no video either\n" * 99)
        cls.long = harness.scene_video(cls.tmp / "long.mkv", 400)

    def setUp(self):
        self.out = self.tmp / self.id().split(".")[-1]

    def copy(self, *names):
        folder = self.tmp / (self.id().split(".")[-1] + "-videos")
        folder.mkdir()
        for name in names:
            shutil.copy(self.videos / name, folder / pathlib.Path(name).name)
        return folder

    def test_each_video_is_tracked_and_the_index_has_the_broken_one(self):
        done = run(self.videos, self.out)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, "^archive: 1 of 4 videos not done: .*--list")
        rows = index(self.out)
        self.assertEqual({name: row["status"] for name, row in rows.items()},
                         {**dict.fromkeys(self.good, "done"), "broken.mp4": "failed"})
        self.assertRegex(rows["broken.mp4"]["error"],
                         "broken.mp4' isn't a video that GStreamer knows: give a video file")
        self.assertEqual(set(files(self.out)), {f"{name}.{kind}" for name in self.good for kind
                                                in ("json", "jsonl")} | {"broken.mp4.json"})
        for name, frames in self.good.items():
            row, tracks = rows[name], self.out / f"{name}.jsonl"
            lines = harness.read_lines(tracks)
            self.assertEqual(harness.decoded_frames(self.videos / name), frames)
            harness.check_tracks(self, lines, frames)
            claims = [{f["id"] for f in line["features"] if f["state"] in harness.CLAIMS}
                      for line in lines]
            self.assertGreater(len(claims[-1]), 20)
            self.assertEqual((row["frames"], row["width"], row["height"], row["features"],
                              row["claimed"], row["tracks_size"], row["note"], row["error"]),
                             (frames, 320, 240, len(set().union(*claims)), sum(map(bool, claims)),
                              tracks.stat().st_size, None, None))
            self.assertAlmostEqual(row["duration"], frames / 25, delta=0.002)
            self.assertEqual(row["settings"],
                             "forget-after=0 learning=sync max-features=200 post-messages=none")
            self.assertEqual(json.loads((self.out / f"{name}.json").read_text()), row)
        # The same tracks as with the preset in a pipeline.
        plain = self.tmp / "plain.jsonl"
        harness.play(f"filesrc location={self.videos}/one.mkv ! decodebin ! csdtrack name=csdtrack "
                     "max-features=200 learning=sync forget-after=0 frame-budget=0 "
                     "post-messages=none ! csdtrackenc ! application/x-ndjson ! filesink "
                     f"location={plain}")
        self.assertEqual((self.out / "one.mkv.jsonl").read_bytes(), plain.read_bytes())
        # The text that users read.
        features, claimed = (sum(rows[name][key] for name in self.good)
                             for key in ("features", "claimed"))
        told = ["4 videos: 3 done, 1 failed, 0 unfinished", "0:00:04 of video, 90 frames; ",
                f"{features} features tracked; {100 * claimed / 90:.1f} % of the frames have"]
        listed = run("--list", self.out)
        self.assertEqual((listed.returncode, listed.stderr), (0, ""))
        for text in (done.stdout, listed.stdout):
            for line, begin in zip(text.splitlines()[-3:], told, strict=True):
                self.assertTrue(line.startswith(begin), line)
        self.assertEqual(len(done.stdout.splitlines()), 4 + 1 + 3)
        self.assertEqual(done.stdout.splitlines()[4],
                         f"failed: broken.mp4: {rows['broken.mp4']['error']}")
        self.assertNotIn(" left", done.stdout)  # after one second there is no estimate
        self.assertRegex(listed.stdout, r"\nfailed +1  broken\.mp4: .*\n")
        self.assertRegex(listed.stdout,
                         r"\ndone +0:00:01 +30 +[0-9.]+ +\d+ +\d+\.\d % +1  one\.mkv\n")
        self.assertRegex(listed.stdout, r'done .*a folder/it\'s \{\} "two"\\n\.mkv\n')
        self.assertIn("\nway 1: csdtrack 0.", listed.stdout)
        # The SQL queries of docs/archive.md.
        questions = re.search("```sql\n(.*?)```", (SOURCE / "docs" / "archive.md").read_text(),
                              re.S).group(1).splitlines()
        with contextlib.closing(sqlite3.connect(self.out / "index.sqlite")) as base:
            answers = [base.execute(question).fetchall() for question in questions]
        self.assertEqual(answers[0], [("broken.mp4", rows["broken.mp4"]["error"])])
        self.assertEqual(answers[1], [])
        self.assertEqual(answers[2][0][2], 3)
        self.assertAlmostEqual(answers[2][0][3], 90 / 25 / 3600, delta=1e-6)
        self.assertEqual([len(found) for found in answers[3:]], [1, 0])

    def test_only_what_changed_is_tracked_again(self):
        videos = self.copy("one.mkv", "three.MP4", "broken.mp4")
        both = {"one.mkv.jsonl", "three.MP4.jsonl"}

        def again(*options, expect):
            before = files(self.out)
            rows = index(self.out) if (self.out / "index.sqlite").exists() else None
            done = run(*FEW, *options, videos, self.out)
            self.assertRegex(done.stderr, "^archive: 1 of 3 videos not done: .*\n$")
            self.assertEqual(made_again(self.out, before), expect)
            self.assertEqual({name: row["status"] for name, row in index(self.out).items()},
                             {"one.mkv": "done", "three.MP4": "done", "broken.mp4": "failed"})
            if rows and not expect and not options:
                self.assertEqual((files(self.out), index(self.out)), (before, rows))
                # The failed video, and the statistics.
                self.assertEqual(len(done.stdout.splitlines()), 1 + 3)

        again(expect=both)
        again(expect=set())
        again("--set", "n-threads=2", expect=set())  # the tracks do not depend on it
        again("--set", "training-time=300000000", expect=both)
        again(expect=both)  # and back
        # As if an older version had made them.
        for path in (self.out / "one.mkv.json", self.out / "three.MP4.json"):
            path.write_text(json.dumps({**json.loads(path.read_text()), "version": "0.0.9"}))
        with contextlib.closing(sqlite3.connect(self.out / "index.sqlite")) as base, base:
            base.execute("UPDATE videos SET version = '0.0.9' WHERE name = 'one.mkv'")
        # The other one's row in the index has this version, and its tracks are as the row says.
        again(expect={"one.mkv.jsonl"})
        os.utime(videos / "three.MP4", (1, 1))
        again(expect={"three.MP4.jsonl"})
        (self.out / "one.mkv.jsonl").unlink()
        again(expect={"one.mkv.jsonl"})
        (self.out / "one.mkv.jsonl").write_text("other tracks\n")
        again(expect={"one.mkv.jsonl"})
        # A result that can't be read counts as none.
        (self.out / "one.mkv.json").write_text('{"status": "done", "name": 3}')
        (self.out / "index.sqlite").unlink()
        again(expect={"one.mkv.jsonl"})
        # The index is made again from the results beside the tracks.
        rows = index(self.out)
        (self.out / "index.sqlite").unlink()
        again(expect=set())
        self.assertEqual(index(self.out), rows)
        # A failed video is tried again only with --redo.
        result = self.out / "broken.mp4.json"
        before = result.stat().st_ino
        again(expect=set())
        self.assertEqual(result.stat().st_ino, before)
        again("--redo", "failed", expect=set())
        self.assertNotEqual(result.stat().st_ino, before)
        again("--redo", "all", expect=both)
        # A video that fails now, but was done before, loses its tracks.
        (videos / "one.mkv").write_text("overwritten")
        self.assertRegex(run(*FEW, videos, self.out).stderr, "^archive: 2 of 3 videos not done")
        self.assertFalse((self.out / "one.mkv.jsonl").exists())

    def test_regions_and_points_reach_the_jobs(self):
        videos = self.copy("one.mkv")
        for setting, fits in (
                ("region=100,80,120,90", lambda f: 100 <= f["x"] <= 220 and 80 <= f["y"] <= 170),
                ("points=100,100;150.5,120",
                 lambda f: (f["x"], f["y"]) == ((100, 100), (150.5, 120))[f["id"]])):
            done = run(*FEW, "--set", setting, videos, self.out)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn(f" {setting}", index(self.out)["one.mkv"]["settings"])
            features = harness.read_lines(self.out / "one.mkv.jsonl")[0]["features"]
            self.assertGreater(len(features), 1)
            self.assertTrue(all(map(fits, features)), features)

    def test_a_list_of_videos(self):
        listed = self.tmp / "a list.txt"
        listed.write_text(f"# of today\n{self.videos.name}/one.mkv\n\n{self.videos}/one.mkv\n"
                          "none.mkv\n")
        done = run(*FEW, listed, self.out)
        self.assertEqual(done.returncode, 1, done.stderr)
        rows = index(self.out)
        self.assertEqual({name: row["status"] for name, row in rows.items()},
                         {"videos/one.mkv": "done", "none.mkv": "failed"})
        self.assertRegex(rows["none.mkv"]["error"], "there is no file .*none.mkv")
        # The missing file appears.
        shutil.copy(self.videos / "three.MP4", self.tmp / "none.mkv")
        before = files(self.out)
        done = run(*FEW, listed, self.out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(made_again(self.out, before), {"none.mkv.jsonl"})
        # OUT elsewhere than the list.
        elsewhere = self.tmp / "elsewhere"
        elsewhere.mkdir()
        (elsewhere / "list").write_text(f"{self.videos}/one.mkv")
        self.assertEqual(run(*FEW, elsewhere / "list", elsewhere / "out").returncode, 0)
        self.assertEqual(list(index(elsewhere / "out")), [f"{self.videos}/one.mkv".lstrip("/")])
        # Another video of the same name is refused; the same one, moved, is not.
        other = self.copy("one.mkv") / "one.mkv"
        (elsewhere / "out {} \n").mkdir()
        for folder, code, words in ((self.videos / "a folder", 0, "^$"), (other.parent, 0, "^$"),
                                    (self.videos, 1,
                                     "has tracks of another 'one.mkv'.*another OUT")):
            done = run(*FEW, folder, elsewhere / "out {} \n")
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertRegex(done.stderr, words)
        moved = other.parent.rename(self.tmp / "moved")
        before = files(elsewhere / "out {} \n")
        self.assertEqual(run(*FEW, moved, elsewhere / "out {} \n").returncode, 0)
        self.assertEqual(made_again(elsewhere / "out {} \n", before), set())

    def test_a_disk_that_swallows_a_line_is_noticed(self):
        folder = self.tmp / "plant"
        folder.mkdir()
        # Each Python program runs it first, and a job has its own. Others must not load GStreamer.
        only = "import sys\nif 'pipelines.lib.archive_job' in sys.orig_argv:"
        (folder / "sitecustomize.py").write_text(
            only + (harness.SWALLOW % "tracks").replace("\n", "\n "))
        videos = self.copy("three.MP4")
        done = run(*FEW, videos, self.out, env={**ENVIRONMENT, "PYTHONPATH": str(folder)})
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stdout.splitlines()[0], "unfinished: three.MP4: 20 frames came, and "
                         f"the tracks hold 19 lines: check the disk of '{self.out}'")
        self.assertEqual(files(self.out), {})

    def test_a_truncated_video_is_noted(self):
        videos = self.copy()
        whole = self.long
        (videos / "cut.mkv").write_bytes(whole.read_bytes()[:whole.stat().st_size // 4])
        (videos / "cut.mp4").write_bytes((self.videos / "three.MP4").read_bytes()[:9000])
        done = run(*FEW, videos, self.out)
        self.assertEqual(done.returncode, 1)
        rows = index(self.out)
        self.assertEqual(done.stdout.splitlines()[2:4],
                         [f"done: cut.mkv: {rows['cut.mkv']['note']}",
                          f"failed: cut.mp4: {rows['cut.mp4']['error']}"])
        self.assertEqual(rows["cut.mkv"]["status"], "done")
        self.assertRegex(rows["cut.mkv"]["note"],
                         r"has a picture up to \d\.\d s only, and says that it lasts 16.0 s")
        self.assertEqual(rows["cut.mp4"]["status"], "failed")
        self.assertRegex(rows["cut.mp4"]["error"],
                         "has no index, its recording was cut off: repair it")

    def test_a_killed_job_is_repeated(self):
        videos = self.copy("three.MP4")
        shutil.copy(self.long, videos / "long.mkv")
        process = start(*FEW, "--jobs", 1, videos, self.out)
        killed = machines.job_at_work(self.out, "long.mkv")
        self.assertFalse((self.out / "long.mkv.jsonl").exists())
        os.kill(killed, signal.SIGKILL)
        told, said = process.communicate(timeout=300)
        self.assertEqual((process.returncode, said), (0, ""))
        harness.check_tracks(self, harness.read_lines(self.out / "long.mkv.jsonl"), 400)
        self.assertIn("2 videos: 2 done", told)

    def test_an_interrupted_run_leaves_no_half_results_and_can_continue(self):
        videos = self.copy("one.mkv")
        shutil.copy(self.long, videos / "two.mkv")
        for number, hard in enumerate((False, True)):
            process = start(*FEW, "--jobs", 1, videos, self.out)
            job = machines.job_at_work(self.out, "two.mkv")
            done = files(self.out)
            self.assertFalse((self.out / "two.mkv.jsonl").exists())
            # Stopped, the job is still unfinished when a slow machine looks, and handles no signal.
            self.hold(job)
            if hard:
                process.kill()  # GNU parallel goes on and keeps the lock
                process.communicate()
                self.assertIn("/parallel\0", self.refused(videos))
                os.kill(job, signal.SIGCONT)
                machines.wait(lambda: (self.out / "two.mkv.json").exists())
                machines.wait(lambda: run("--list", self.out).returncode == 0 and
                              run(*FEW, videos, self.out).returncode == 0)
                self.assertEqual(made_again(self.out, done), {"two.mkv.jsonl"})
            else:
                self.assertIn("\0pipelines.lib.archive\0", self.refused(videos))
                process.terminate()
                _, said = process.communicate(timeout=60)
                self.assertEqual((process.returncode, said),
                                 (130, "archive: ended: 1 of 2 videos are done, the same command "
                                  "does the rest\n"))
                self.assertEqual(list(self.out.glob(".*.unfinished")), [])
                machines.wait(lambda: not pathlib.Path(f"/proc/{job}").exists())
                self.assertFalse((self.out / "two.mkv.jsonl").exists() or
                                 (self.out / "two.mkv.json").exists())
                self.assertEqual({name: row["status"] for name, row in index(self.out).items()},
                                 {"one.mkv": "done", "two.mkv": "unfinished"})
        self.assertEqual(list(self.out.glob(".*.unfinished")), [])
        harness.check_tracks(self, harness.read_lines(self.out / "two.mkv.jsonl"), 400)

    def hold(self, job):
        os.kill(job, signal.SIGSTOP)

        def let_go():
            with contextlib.suppress(ProcessLookupError):
                os.kill(job, signal.SIGCONT)

        self.addCleanup(let_go)

    def refused(self, videos):
        """Checks that a run is refused while another works on OUT. Returns the command line of the
        process that the message names."""
        done = run(*FEW, videos, self.out)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr,
                         "^archive: another run works on '.*' since [-0-9]+ [:0-9]+: wait for it, "
                         f"or end it with 'kill \\d+' on {re.escape(os.uname().nodename)}\n$")
        self.kill = re.search("kill (\\d+)", done.stderr).group(1)
        return pathlib.Path(f"/proc/{self.kill}/cmdline").read_text()

    def check_ended(self, *names):
        """Checks that nobody works on OUT any more, and that these videos have no results."""
        self.assertEqual(list(self.out.glob(".*.unfinished")), [])
        self.assertFalse([name for name in names if (self.out / f"{name}.json").exists()])
        with open(self.out / ".archive" / "lock") as lock:
            # On a busy machine a killed process releases the lock a moment later (seen).
            for left in reversed(range(100)):
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    if not left:
                        raise
                    time.sleep(0.1)

    def test_the_run_ends_when_its_output_is_closed(self):
        videos = self.copy("one.mkv")
        shutil.copy(self.long, videos / "two.mkv")
        process = start(*FEW, "--jobs", 1, videos, self.out)
        process.stdout.close()  # so the line about one.mkv can't be written
        process.stdout = None
        _, said = process.communicate(timeout=60)
        self.assertEqual((process.returncode, said), (130, "archive: ended: 1 of 2 videos are "
                                                      "done, the same command does the rest\n"))
        self.check_ended("two.mkv")

    def test_closing_the_output_when_all_is_done_is_no_failure(self):
        videos = self.copy("one.mkv")
        # Not read: the statistics; the statistics again; the video's line and the statistics.
        for lines, again in ((1, ()), (0, ()), (0, ("--redo", "all"))):
            process = start(*FEW, *again, videos, self.out)
            for _ in range(lines):
                self.assertIn("one.mkv: 30 frames", process.stdout.readline())
            process.stdout.close()
            process.stdout = None
            _, said = process.communicate(timeout=60)
            self.assertEqual((process.returncode, said), (0, ""))
            self.assertEqual(index(self.out)["one.mkv"]["status"], "done")

    def test_the_run_ends_when_its_terminal_is_closed(self):
        videos = self.copy()
        shutil.copy(self.long, videos)
        process, terminal = pty.fork()
        if not process:
            os.execve(ARCHIVE, [str(ARCHIVE), "--no-install", *FEW, str(videos), str(self.out)],
                      ENVIRONMENT)
        self.hold(machines.job_at_work(self.out, "long.mkv"))
        os.close(terminal)
        code = machines.wait(lambda: os.waitpid(process, os.WNOHANG)[1])
        self.assertEqual(os.waitstatus_to_exitcode(code), 130)
        self.check_ended("long.mkv")

    def test_repeated_signals_leave_no_process(self):
        videos = self.copy()
        shutil.copy(self.long, videos)
        process = start(*FEW, videos, self.out)
        self.hold(machines.job_at_work(self.out, "long.mkv"))  # so that ending takes a while
        while process.poll() is None:
            for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
                process.send_signal(number)
            time.sleep(0.05)
        _, said = process.communicate(timeout=60)
        self.assertEqual((process.returncode, said), (130, "archive: ended: 0 of 1 videos are "
                                                      "done, the same command does the rest\n"))
        self.check_ended("long.mkv")

    def kill_the_command(self, videos):
        """Kills the command while its job tracks long.mkv, and checks that the next run is refused.
        Returns the job, which is stopped."""
        process = start(*FEW, videos, self.out)
        job = machines.job_at_work(self.out, "long.mkv")
        self.hold(job)
        process.kill()
        process.communicate()
        self.refused(videos)
        return job

    def test_the_processes_of_a_killed_run_can_be_ended(self):
        videos = self.copy()
        shutil.copy(self.long, videos)
        job = self.kill_the_command(videos)
        os.kill(int(self.kill), signal.SIGTERM)
        machines.wait(lambda: not pathlib.Path(f"/proc/{job}").exists() and
                      not pathlib.Path(f"/proc/{self.kill}").exists())
        self.assertFalse((self.out / "long.mkv.jsonl").exists())
        self.assertEqual(run(*FEW, videos, self.out).returncode, 0)
        self.assertEqual(list(self.out.glob(".*.unfinished")), [])

    def test_a_job_without_its_run_is_named(self):
        videos = self.copy()
        # Long enough that its job still works when it is stopped again.
        subprocess.run(["ffmpeg", "-v", "error", "-stream_loop", "5", "-i", self.long, "-c", "copy",
                        videos / "long.mkv"], check=True)
        job = self.kill_the_command(videos)
        # A stopped process would get SIGHUP when the leader of its session ends.
        os.kill(job, signal.SIGCONT)
        os.kill(int(self.kill), signal.SIGKILL)
        machines.wait(lambda: not pathlib.Path(f"/proc/{self.kill}").exists())
        os.kill(job, signal.SIGSTOP)
        self.assertIn("\0pipelines.lib.archive_job\0", self.refused(videos))
        self.assertEqual(int(self.kill), job)
        os.kill(job, signal.SIGKILL)
        machines.wait(lambda: not pathlib.Path(f"/proc/{job}").exists())
        self.assertEqual(run(*FEW, videos, self.out).returncode, 0)

    def test_a_full_disk_ends_the_run_with_a_reason(self):
        videos = self.copy()
        for name in ("a.mkv", "b.mkv", "c.mkv"):
            shutil.copy(self.long, videos / name)
        self.out.mkdir()
        small = ["unshare", "-rm", "sh", "-c"]
        if subprocess.run([*small, 'mount -t tmpfs none "$0"', self.out],
                          capture_output=True).returncode:
            self.skipTest("no small file system can be mounted here")
        done = subprocess.run(
            [*small, 'mount -t tmpfs -o size=1m none "$0" && "$1" --no-install --jobs 1 "$2" "$0"; '
             'code=$?; "$1" --no-install --list "$0"; exit $code', self.out, ARCHIVE, videos],
            capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=300, env=ENVIRONMENT)
        why = f"can't write into '{self.out}' (the disk is full): make room or give another place"
        self.assertEqual((done.returncode, done.stderr),
                         (1, "archive: ended: 0 of 3 videos are done, the same command does the "
                          f"rest\narchive: {why}\n"))
        self.assertEqual(re.findall(r"^unfinished +1  (.*)$", done.stdout, re.M),
                         [f"a.mkv: {why}", "b.mkv: not yet tracked", "c.mkv: not yet tracked"])

    def test_a_video_that_is_missing_now(self):
        videos = self.copy("one.mkv", "three.MP4")
        (videos / "empty.mkv").touch()
        self.assertEqual(run(*FEW, videos, self.out).returncode, 1)
        self.assertRegex(index(self.out)["empty.mkv"]["error"], "^'.*/empty.mkv' is empty: ")
        self.assertNotIn("be seen", run("--list", self.out).stdout)
        (videos / "one.mkv").unlink()
        (videos / "empty.mkv").unlink()
        self.assertEqual(run(*FEW, videos, self.out).returncode, 0)
        self.assertEqual({name: row["status"] for name, row in index(self.out).items()},
                         {"one.mkv": "done", "three.MP4": "done"})
        self.assertEqual(re.findall("(\\S+): its video can't be seen from here\n",
                                    run("--list", self.out).stdout), ["one.mkv"])
        (self.out / "one.mkv.jsonl").unlink()
        self.assertEqual(run(*FEW, videos, self.out).returncode, 0)
        self.assertEqual(list(index(self.out)), ["three.MP4"])

    def test_an_error_of_writing_is_not_counted_as_the_videos(self):
        videos = self.copy("one.mkv", "three.MP4")
        # A folder where the tracks should be.
        (self.out / "one.mkv.jsonl").mkdir(parents=True)
        done = run(*FEW, videos, self.out)
        self.assertRegex(done.stderr, "^archive: 1 of 2 videos not done")
        rows = index(self.out)
        self.assertEqual((rows["one.mkv"]["status"], rows["three.MP4"]["status"]),
                         ("unfinished", "done"))
        self.assertRegex(rows["one.mkv"]["error"], "^'.*one.mkv.jsonl.*': Is a directory")
        (self.out / "one.mkv.jsonl").rmdir()
        self.assertEqual(run(*FEW, videos, self.out).returncode, 0)

    def test_errors_are_reported(self):
        videos, empty, file = self.copy("one.mkv"), self.tmp / "empty", self.tmp / "file"
        empty.mkdir()
        file.write_text("")
        letter, moved, unknown = self.tmp / "letter", self.tmp / "moved.txt", self.tmp / "unknown"
        letter.write_text("Dear reader,\nthis is no list\n")
        moved.write_text("nowhere/one.mkv\n")
        shutil.copy(videos / "one.mkv", unknown)
        for arguments, code, words in (
                ((videos, file), 2, "'.*file' is a file: give a folder"),
                ((moved, moved), 2, "is a file: give a folder"),
                ((videos, videos), 2, "LIST and OUT at once"),
                ((letter, self.out), 1,
                 "^archive: '.*letter' is no list of videos: .* '.*/Dear reader,'\n$"),
                ((moved, self.out), 1,
                 "moved.txt' is no list of videos: .* '.*/nowhere/one.mkv'\n$"),
                ((unknown, self.out), 1, "is no text: give a folder"),
                (("nothing", self.out), 1, "no 'nothing'"), ((videos,), 2, "LIST and OUT"),
                ((empty, self.out), 1, "names no video"), ((file, self.out), 1, "names no video"),
                ((videos / "one.mkv", self.out), 1, "is no text: give a folder"),
                ((videos, self.out, "--jobs", "0"), 2, "--jobs"),
                ((videos, self.out, "--set", "max-features=many"), 2,
                 "'many' is no value for max-features"),
                ((videos, self.out, "--set", "attach-meta=false"), 1, "attach-meta"),
                ((videos, self.out, "--preset", "none"), 2, "no preset 'none': .*archive"),
                ((videos, self.out, "--ssh", ","), 2, "--ssh"),
                ((videos, self.out, "--ssh", "a", "--slurm"), 2, "--slurm"),
                (("--list", empty), 1, "no index"), (("--list", empty, videos), 2, "--list"),
                ((videos, self.out, "--redo", "some"), 2, "--redo")):
            with self.subTest(arguments=arguments):
                done = run(*arguments)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertRegex(done.stderr, words)
                self.assertNotIn("Traceback", done.stderr)
        self.out.mkdir(exist_ok=True)
        (self.out / "index.sqlite").write_text("no SQLite" * 200)
        done = run(*FEW, videos, self.out)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, "^archive: can't use '.*index.sqlite' .*remove it.*\n$")


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
