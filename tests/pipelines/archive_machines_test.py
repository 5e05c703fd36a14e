#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/archive on other machines: over ssh and in a Slurm cluster, both started here."""

import contextlib
import os
import pathlib
import signal
import sqlite3
import subprocess
import sys

import harness
import machines

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
ARCHIVE = SOURCE / "pipelines" / "archive"
FRAMES = {"a.mkv": 30, "b b.mkv": 25, "c.mkv": 20, "long.mkv": 400}
BROKEN = "d.mp4"
OPTIONS = ("--no-install", "--set", "max-features=8")


class Machines(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        machines.need("parallel")
        cls.videos = cls.tmp / "videos"
        cls.videos.mkdir()
        for seed, (name, frames) in enumerate(FRAMES.items()):
            harness.scene_video(cls.videos / name, frames, seed=seed)
        (cls.videos / BROKEN).write_text("no video\n" * 99)
        cls.here = cls.tmp / "here"
        cls.run_archive(cls.here)

    @classmethod
    def start(cls, out, *options, environment=None):
        return subprocess.Popen([ARCHIVE, *OPTIONS, *options, cls.videos, out],
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True,
                                env={**(environment or os.environ), "CSDTRACK_BUILD": str(BUILD)})

    @classmethod
    def run_archive(cls, out, *options, environment=None):
        process = cls.start(out, *options, environment=environment)
        told, said = process.communicate(timeout=400)
        return process.returncode, told, said

    def setUp(self):
        self.out = self.tmp / self.id().split(".")[-1]

    def rows(self):
        with contextlib.closing(sqlite3.connect(self.out / "index.sqlite")) as base:
            return dict(base.execute("SELECT name, status FROM videos"))

    def check_all_done(self, code, said):
        self.assertEqual(code, 1, said)
        self.assertRegex(said.splitlines()[-1], "^archive: 1 of 5 videos not done")
        self.assertEqual(self.rows(), {**dict.fromkeys(FRAMES, "done"), BROKEN: "failed"})
        for name, frames in FRAMES.items():
            tracks = self.out / f"{name}.jsonl"
            self.assertEqual(len(harness.read_lines(tracks)), frames)
            self.assertEqual(tracks.read_bytes(), (self.here / f"{name}.jsonl").read_bytes(), name)
        self.assertEqual(list(self.out.glob(".*.unfinished")), [])

    def check_nothing_to_do(self, *options, environment):
        before = {path: path.stat().st_mtime_ns for path in self.out.glob("*.json*")}
        code, told, said = self.run_archive(self.out, *options, environment=environment)
        self.check_all_done(code, said)
        self.assertEqual(len(told.splitlines()), 1 + 3, told)
        self.assertEqual({path: path.stat().st_mtime_ns for path in self.out.glob("*.json*")},
                         before)

    def test_ssh_gives_the_same_tracks_and_a_killed_job_is_repeated(self):
        server = machines.Ssh()
        self.addCleanup(server.stop)
        environment = {**os.environ, "PARALLEL_SSH": server.command}
        process = self.start(self.out, "--ssh", "1/one,1/two,gone", environment=environment)
        os.kill(machines.job_at_work(self.out, "long.mkv"), signal.SIGKILL)
        told, said = process.communicate(timeout=400)
        self.assertRegex(said, "^archive: warning: gone is left out: .*refused")
        self.assertEqual(len(said.splitlines()), 2, said)
        self.check_all_done(process.returncode, said)
        self.assertEqual(len(told.splitlines()), 5 + 1 + 3, told)
        # Each job is a login: five, and one repeated. Two more check the hosts.
        self.assertGreaterEqual(server.sessions(), 8)
        logins = server.sessions()
        self.check_nothing_to_do("--ssh", "one,two", environment=environment)
        self.assertEqual(server.sessions(), logins)
        code, _, said = self.run_archive(self.tmp / "nowhere", "--ssh", "gone",
                                         environment=environment)
        self.assertEqual(code, 1)
        self.assertRegex(said, "\narchive: none of the hosts can do it")

    def test_ssh_jobs_end_with_the_command(self):
        server = machines.Ssh()
        self.addCleanup(server.stop)
        process = self.start(self.out, "--ssh", "one",
                             environment={**os.environ, "PARALLEL_SSH": server.command})
        job = machines.job_at_work(self.out, "long.mkv")
        process.terminate()
        self.assertEqual(process.wait(60), 130)
        process.communicate()
        machines.wait(lambda: not pathlib.Path(f"/proc/{job}").exists())
        self.assertFalse((self.out / "long.mkv.jsonl").exists())

    def test_slurm_gives_the_same_tracks_and_a_killed_job_is_repeated(self):
        cluster = machines.Slurm(array=3)  # five videos need two arrays
        self.addCleanup(cluster.stop)
        process = self.start(self.out, "--slurm", environment=cluster.environment)
        os.kill(machines.job_at_work(self.out, "long.mkv"), signal.SIGKILL)
        told, said = process.communicate(timeout=400)
        self.check_all_done(process.returncode, said)
        self.assertEqual(len(told.splitlines()), 5 + 1 + 3, told)
        self.assertEqual(cluster.submitted(), 3)  # the third is the killed job's
        self.check_nothing_to_do("--slurm", environment=cluster.environment)

    def test_no_cluster_is_reported(self):
        machines.need("sbatch", "squeue", "scontrol")
        code, told, said = self.run_archive(self.out, "--slurm",
                                            environment={**os.environ, "SLURM_CONF": "/dev/null"})
        self.assertEqual((code, told), (1, ""))
        self.assertRegex(said, "^archive: no Slurm cluster answers here: .*\n$")
        self.assertFalse(self.out.exists())

    def test_slurm_jobs_go_on_without_the_command(self):
        cluster = machines.Slurm(array=100)
        self.addCleanup(cluster.stop)
        process = self.start(self.out, "--slurm", environment=cluster.environment)
        job = machines.job_at_work(self.out, "long.mkv")
        # Stopped until the next run waits for it: else it would be done within a second.
        os.kill(job, signal.SIGSTOP)
        process.terminate()
        _, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        self.assertRegex(said, r"^archive: the cluster goes on: the same command follows it, "
                         r"'scancel \d+' ends it\n")
        self.assertTrue(pathlib.Path(f"/proc/{job}").exists())
        process = self.start(self.out, "--slurm", environment=cluster.environment)
        self.assertIn("an earlier run's jobs are still in the cluster", process.stdout.readline())
        os.kill(job, signal.SIGCONT)
        told, said = process.communicate(timeout=400)
        self.check_all_done(process.returncode, said)
        self.assertNotIn("long.mkv", told)  # it was not done a second time


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
