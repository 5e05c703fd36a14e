#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The commands of docs/pipelines.md that need no hardware, unchanged."""

import os
import pathlib
import shlex
import subprocess
import sys

import harness

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
PAGE = SOURCE / "docs" / "pipelines.md"
SHORT = ["--seconds", "3"]
MORE = {"pipelines/live": [*SHORT, "--sink", "fakesink"],
        "pipelines/review": [*SHORT, "--sink", "fakesink"], "pipelines/archive": []}


class Page(harness.Case):
    def test_each_command_runs(self):
        commands = [line.strip() for line in PAGE.read_text().splitlines()
                    if line.startswith("    pipelines/")]
        self.assertGreaterEqual(len(commands), 4)
        for text in commands:
            with self.subTest(text):
                program, *arguments = shlex.split(text.removesuffix(" &"))
                more = ["--no-install"] + (["--seconds", "90"] if text.endswith("&")
                                           else MORE.get(program, SHORT))
                options = dict(cwd=self.tmp, text=True, stdin=subprocess.DEVNULL,
                               env={**os.environ, "CSDTRACK_BUILD": str(BUILD)})
                if text.endswith("&"):
                    self.begin([SOURCE / program, *more, *arguments], **options)
                    continue
                done = subprocess.run([SOURCE / program, *more, *arguments], capture_output=True,
                                      timeout=120, **options)
                self.assertEqual((done.returncode, done.stderr), (0, ""))

    def begin(self, command, **options):
        """Starts a command in the background and waits for the line it prints when it is ready. It
        is killed when the test is over."""
        process = subprocess.Popen(command, stdout=subprocess.PIPE, **options)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertTrue(process.stdout.readline())

    def test_each_command_of_the_first_table_has_help(self):
        rows = [line.split("|")[2] for line in PAGE.read_text().splitlines()
                if line.startswith("| ") and "`pipelines/" in line]
        programs = {row.split("`")[1].split()[0] for row in rows}
        self.assertGreaterEqual(len(programs), 4)
        for program in programs:
            done = subprocess.run([SOURCE / program, "--help"], capture_output=True, text=True,
                                  timeout=60)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn(f"usage: {program}", done.stdout)


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
