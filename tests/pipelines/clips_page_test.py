#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/clips on made-up clips: what it writes, and what it refuses.

clips_page_test.py ROOT BUILD"""

import os
import pathlib
import subprocess
import sys

import harness

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])
FRAMES = 12
POINTS = ((100, 80), (200, 160))


class ClipsPage(harness.Case):
    """Runs in a folder of its own, self.tree, with a link to the repository's pipelines."""

    def setUp(self):
        self.tree = self.tmp / self.id().rsplit(".", 1)[-1]
        self.tree.mkdir()
        (self.tree / "pipelines").symlink_to(ROOT / "pipelines")
        self.page = self.tree / "docs" / "results" / "clips.md"
        self.page.parent.mkdir(parents=True)
        self.page.write_text("what was measured before\n")
        self.clips = self.tree / "clips"
        self.clips.mkdir()

    def make_beads(self):
        scene = harness.Scene()
        harness.encode(self.clips / "beads.mkv", (scene.picture(t) for t in range(FRAMES)),
                       *harness.H264)
        rows = [f"{t},{i},{x + scene.motion(t)[0]},{y + scene.motion(t)[1]},1"
                for t in range(FRAMES) for i, (x, y) in enumerate(POINTS)]
        (self.clips / "beads.truth.csv").write_text("\n".join(["frame,id,x,y,visible", *rows, ""]))

    def run_it(self, *arguments, **environment):
        return subprocess.run([self.tree / "pipelines" / "experiments" / "clips", "--no-install",
                               *map(str, arguments)],
                              capture_output=True, text=True, stdin=subprocess.DEVNULL,
                              timeout=10 * harness.TIMEOUT,
                              env={**os.environ, "CSDTRACK_BUILD": str(BUILD), **environment})

    def refused(self, code, text, *arguments, **environment):
        done = self.run_it(*arguments, **environment)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertIn(text, done.stderr)
        self.assertEqual(self.page.read_text(), "what was measured before\n",
                         "the page stays as it was")

    def test_the_page(self):
        self.make_beads()
        done = self.run_it(CSDTRACK_CLIPS=str(self.clips))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, f"{self.page}\n")
        new = self.page.read_text()
        self.assertTrue(new.startswith("# Real clips\n"))
        self.assertIn(f"\n* beads.truth.csv: {len(POINTS)} features, {FRAMES} labelled frames, ",
                      new)
        self.assertNotIn(str(self.clips), new)
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in new.splitlines()
                if line.startswith("|")]
        versions = dict(row for row in rows if len(row) == 2)
        self.assertLessEqual({"csdtrack", "GStreamer", "processor"}, set(versions))
        rows = [row for row in rows if len(row) > 2]
        self.assertEqual(rows[0][4:7], ["correct", "wrong", "missed"])
        correct = {row[0]: (int(row[4]), int(row[5]) + int(row[6])) for row in rows[2:6]}
        self.assertEqual(list(correct), ["csd-2012", "csd-forest", "lk", "csd"])
        self.assertEqual(correct["lk"], (FRAMES * len(POINTS), 0),
                         "LK follows this scene with ease")
        self.assertEqual([row[:2] + row[3:4] for row in rows if row[0].startswith("beads/")],
                         [[f"beads/{name}.jsonl", name, str(2 * FRAMES - 1)]
                          for name in ("csd-2012", "csd-forest", "lk", "csd")])

        self.assertEqual([path.name for path in self.page.parent.iterdir()], ["clips.md"])

        def page():  # without the state of the repository: somebody may work in it meanwhile
            return [line for line in self.page.read_text().splitlines()
                    if not line.startswith("| csdtrack |")]

        again = page()
        self.assertEqual(self.run_it(self.clips).returncode, 0)
        self.assertEqual(page(), again, "the same clips give the same page")

    def test_without_clips(self):
        self.refused(1, f"no beads.mkv with beads.truth.csv in '{self.clips}': give the folder of "
                     "the clips", self.clips)
        self.refused(1, "in '/nowhere'", CSDTRACK_CLIPS="/nowhere")

    def test_a_clip_that_fails_leaves_the_page(self):
        self.make_beads()
        (self.clips / "text.mkv").write_text("no video at all\n" * 100)
        self.refused(1, "text.mkv' isn't a video", self.clips)

    def test_wrong_options_are_refused(self):
        self.refused(2, "clips: no option --frobnicate", "--frobnicate")
        self.refused(2, "clips: one folder, not 2", self.clips, self.clips)
        self.assertIn("usage: pipelines/experiments/clips", self.run_it("--help").stdout)


if __name__ == "__main__":
    sys.argv[1:] = []
    harness.main()
