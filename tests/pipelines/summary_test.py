#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/summary: README, docs/evaluation.md, performance.md, machines.md and
own-video.md agree with docs/results/. summary_test.py ROOT"""

import os
import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from pipelines.experiments import builds, page, summaries
from pipelines.lib.failure import Failure

ROOT = pathlib.Path(sys.argv[1])
DOCS = ROOT / "docs"
PAGES = ("README.md", "docs/evaluation.md", "docs/performance.md", "docs/machines.md",
         "docs/own-video.md")
PLOTS = ("docs/evaluation/scenes.svg", "docs/performance/growth.svg")


class Summaries(unittest.TestCase):
    def setUp(self):
        """Copies the pages and the results they are made from."""
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-summary-"))
        self.addCleanup(shutil.rmtree, self.root)
        self.results = self.root / "docs" / "results"
        shutil.copytree(DOCS / "results", self.results)
        for name in PAGES:
            shutil.copy(ROOT / name, self.root / name)

    def change(self, name, old, new):
        path = self.results / f"{name}.md"
        text = path.read_text()
        self.assertIn(old, text)
        path.write_text(text.replace(old, new))

    def test_the_committed_pages_are_up_to_date(self):
        """Where this fails, run pipelines/experiments/summary."""
        self.assertEqual({path.relative_to(self.root) for path in summaries.write(self.root)},
                         set(map(pathlib.Path, (*PAGES, *PLOTS))))
        for name in PAGES:
            self.assertEqual((ROOT / name).read_text(), (self.root / name).read_text(), name)
        for plot in PLOTS:
            drawn, committed = ((folder / plot).read_text() for folder in (self.root, ROOT))
            made_by = [re.search(r"<desc>.*?</desc>", text)[0] for text in (drawn, committed)]
            if made_by[0] == made_by[1]:  # another gnuplot draws other lines
                self.assertEqual(drawn, committed, plot)

    def test_a_changed_result_is_seen_in_table_text_and_plot(self):
        summaries.write(self.root)
        before = {name: (self.root / name).read_text() for name in (*PAGES, *PLOTS)}
        row = next(line for line in (self.results / "beyond.md").read_text().splitlines()
                   if line.startswith("| smoke, two bursts | 0."))
        changed = re.sub(r"\| not reached: .*\|$|\| \*\*reached\*\* \|$", "| not reached: median |",
                         row).replace(row.split(" | ")[3], "0.1234 (0.1–0.2)")
        self.change("beyond", row, changed)
        self.change("benchmarks", "\n1920x1080      1000 ",
                    "\n1920x1080      1000   77.77 /  88.88    99.9\n1920x1080      1001 ")
        self.change("benchmarks", "\n 640x480   I420       100 ",
                    "\n 640x480   I420       100 66.66 / 77.77 ")
        self.change("tissue", " | 0.9101 / 0.0698 | ", " | 0.1357 / 0.0698 | ")
        self.change("tissue", " | 0.4579 / 0.0960, ", " | 0.2468 / 0.0960, ")
        path = self.results / "clips.md"
        path.write_text(re.sub(r"(?m)^(\| mean of \d+ \| csd \| .*?\| .*?\|) \S+ \| \S+ \|",
                               r"\1 0.111 | 0.222 |", path.read_text()))
        summaries.write(self.root)
        after = {name: (self.root / name).read_text() for name in before}
        smoke = next(line for line in after["docs/evaluation.md"].splitlines()
                     if line.startswith("| simulated | smoke"))
        self.assertIn(" 0.1234 / ", smoke)
        self.assertTrue(smoke.endswith("| median |"))
        self.assertIn("77.77 / 88.88", after["docs/performance.md"])
        self.assertIn("1000 points 77.77 ms at 1920×1080",
                      after["docs/machines.md"].replace("\n  ", " "))
        words = " ".join(after["docs/machines.md"].split())
        self.assertIn("of the visible points: from 0.1357 (slide: one sheet over another)", words)
        self.assertIn("worst in all from 0.2468 (rotation −50…120°, smoke)", words)
        self.assertIn("it finds .14 to .99 of", " ".join(after["README.md"].split()))
        self.assertIn(" 0.111 / 0.222 |", after["docs/own-video.md"])
        self.assertNotEqual(after["docs/performance/growth.svg"],
                            before["docs/performance/growth.svg"])
        row = next(line for line in after["README.md"].splitlines() if line.startswith("| `csd`"))
        self.assertRegex(row, r"\| 0\.111 / 0\.222 \| \S+ / \S+ \| 66\.66 \|$")
        # Text written by people stays.
        for name in ("README.md", "docs/evaluation.md"):
            self.assertEqual(*(re.sub(
                r"(?s)(<!-- (\w+): written by .*? -->).*?(<!-- end of \2 -->)", r"\1\3", of[name])
                               for of in (before, after)))

    def test_readme_has_what_the_pages_have(self):
        """That is own-video.md, evaluation.md and performance.md."""
        def rows(name):
            return [line.strip("| ").split(" | ")
                    for line in (ROOT / name).read_text().splitlines() if line.startswith("| ")]

        def row(name, begin):
            return next(cells for cells in rows(name) if cells[0].startswith(begin))

        _, csd2012, _, lk, csd = row("docs/own-video.md", "mean of")
        clips = {"csd": csd, "csd-2012": csd2012, "lk": lk, "csrt": "–"}
        _, _, csd, _, csd2012, lk, _ = row("docs/performance.md", "640×480")
        cost = {"csd": csd, "csd-2012": csd2012, "lk": lk}
        for tracker, of_clips in clips.items():
            _, *cells, milliseconds = row("README.md", f"`{tracker}`")
            self.assertEqual(cells, [of_clips, row("docs/evaluation.md", f"`{tracker}`")[1]])
            if tracker in cost:
                self.assertEqual(milliseconds, cost[tracker].split(" / ")[0])
            else:
                of_a_point, = re.findall(r"CSRT\s(\d+)\.", (DOCS / "performance.md").read_text())
                self.assertEqual(milliseconds, f"{int(of_a_point) / 100:.0f} (10 points)")

    def test_a_missing_result_is_named(self):
        for name, old, new, words in (("beyond", "| scenario | the paper's",
                                       "| scene | the paper's", "has no table 'scenario"),
                                      ("benchmarks", "\ncsd over time", "\nlk over time",
                                       "nothing that begins with 'csd over time'"),
                                      ("tissue", "| tear: a cut opens | 50 |",
                                       "| tear: a cut opens | 49 |", "differ in their number"),
                                      ("paper", "| csdtrack |", "| other |", "0 places like")):
            with self.subTest(name):
                before = (self.results / f"{name}.md").read_text()
                self.change(name, old, new)
                with self.assertRaises(builds.Failure) as failed:
                    summaries.write(self.root)
                self.assertIn(words, str(failed.exception))
                self.assertIn(f"{name}.md", str(failed.exception))
                (self.results / f"{name}.md").write_text(before)
        for name in PAGES:
            self.assertEqual((self.root / name).read_text(), (ROOT / name).read_text(),
                             "nothing may be written then")
        (self.results / "tissue.md").unlink()
        with self.assertRaisesRegex(builds.Failure, "tissue.md: No such file"):
            summaries.write(self.root)

    def test_pages_without_marks_are_refused(self):
        begin, end = summaries.marks("scenes")
        for text in ("no marks\n", f"{begin}\n", f"{end}\n{begin}\n", f"{begin}\n{end}\n{end}\n"):
            with (self.subTest(text),
                  self.assertRaisesRegex(builds.Failure, "once each, in this order")):
                summaries.filled(text, {"scenes": "table\n"}, "page.md")
        self.assertEqual(summaries.filled(f"a\n{begin}\n{end}\nb\n", {"scenes": "table\n"}, ""),
                         f"a\n{begin}\n\ntable\n\n{end}\nb\n")


class Pages(unittest.TestCase):
    def test_a_wide_table_becomes_several(self):
        """Each has as many columns as possible, at most ten. The first columns are repeated."""
        rows = [[str(10 * row + column) for column in range(12)] for row in (1, 2)]
        first, second = (part.splitlines()
                         for part in page.table(list("abcdefghijkl"), rows).split("\n\n"))
        self.assertEqual([line.split(" | ") for line in (first[0], second[0])],
                         [["| a", *"bcde", "f |"], ["| a", *"ghijk", "l |"]])
        self.assertEqual(second[2:], ["| 10 | 16 | 17 | 18 | 19 | 20 | 21 |",
                                      "| 20 | 26 | 27 | 28 | 29 | 30 | 31 |"])
        self.assertEqual(page.table(list("abcdefghij"), []).count("\n"), 2)
        self.assertEqual([part.split(" |", 3)[:2]
                          for part in page.table(list("abcdefghijkl"), [], keys=2).split("\n\n")],
                         [["| a", " b"]] * 2)

    def test_no_table_is_wider_than_a_screen(self):
        for path in (*(ROOT / name for name in PAGES), *(DOCS / "results").glob("*.md")):
            for line in path.read_text().splitlines():
                if re.fullmatch(r"\|(:?---:?\|)+", line):
                    self.assertLessEqual(line.count("---"), page.WIDEST, path.name)

    def test_links_are_relative_to_the_page(self):
        text = ("[a](method.md#x) [b](results/paper.md) [c](../core/csd.h) ![](beyond/d.svg) "
                "[e](#f) [g](https://h/i.md)")
        self.assertEqual(page.linked(text, DOCS / "results"),
                         "[a](../method.md#x) [b](paper.md) [c](../../core/csd.h) "
                         "![](beyond/d.svg) [e](#f) [g](https://h/i.md)")

    def test_a_page_replaces_no_device_and_no_folder(self):
        with tempfile.TemporaryDirectory(prefix="csdtrack-summary-") as folder:
            pipe = pathlib.Path(folder) / "pipe"
            os.mkfifo(pipe)
            for path in (pipe, pathlib.Path(folder)):
                with self.assertRaisesRegex(Failure, f"^{path} is no file: not written$"):
                    page.replace(path, "text")
            self.assertTrue(pipe.is_fifo() and not list(pipe.parent.glob(".unfinished*")))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
