#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/experiments/summary: docs/evaluation.md, performance.md and own-video.md agree with
docs/results/. summary_test.py ROOT"""

import pathlib
import re
import shutil
import sys
import tempfile
import unittest

from pipelines.experiments import builds, page, summaries

DOCS = pathlib.Path(sys.argv[1]) / "docs"
PAGES = ("evaluation.md", "performance.md", "own-video.md")
PLOTS = ("evaluation/scenes.svg", "performance/growth.svg")


class Summaries(unittest.TestCase):
    def setUp(self):
        """Copies the pages and the results they are made from."""
        self.docs = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-summary-"))
        self.addCleanup(shutil.rmtree, self.docs)
        shutil.copytree(DOCS / "results", self.docs / "results")
        for name in PAGES:
            shutil.copy(DOCS / name, self.docs)

    def change(self, name, old, new):
        path = self.docs / "results" / f"{name}.md"
        text = path.read_text()
        self.assertIn(old, text)
        path.write_text(text.replace(old, new))

    def test_the_committed_pages_are_up_to_date(self):
        """Where this fails, run pipelines/experiments/summary."""
        self.assertEqual({path.relative_to(self.docs) for path in summaries.write(self.docs)},
                         set(map(pathlib.Path, (*PAGES, *PLOTS))))
        for name in PAGES:
            self.assertEqual((DOCS / name).read_text(), (self.docs / name).read_text(), name)
        for plot in PLOTS:
            drawn, committed = ((folder / plot).read_text() for folder in (self.docs, DOCS))
            made_by = [re.search(r"<desc>.*?</desc>", text)[0] for text in (drawn, committed)]
            if made_by[0] == made_by[1]:  # another gnuplot draws other lines
                self.assertEqual(drawn, committed, plot)

    def test_a_changed_result_is_seen_in_table_text_and_plot(self):
        summaries.write(self.docs)
        before = {name: (self.docs / name).read_text() for name in (*PAGES, *PLOTS)}
        row = next(line for line in (self.docs / "results" / "beyond.md").read_text().splitlines()
                   if line.startswith("| smoke, two bursts | 0."))
        changed = re.sub(r"\| not reached: .*\|$|\| \*\*reached\*\* \|$", "| not reached: median |",
                         row).replace(row.split(" | ")[3], "0.1234 (0.1–0.2)")
        self.change("beyond", row, changed)
        self.change("benchmarks", "\n1920x1080      1000 ",
                    "\n1920x1080      1000   77.77 /  88.88    99.9\n1920x1080      1001 ")
        path = self.docs / "results" / "clips.md"
        path.write_text(re.sub(r"(?m)^(\| mean of \d+ \| csd \| .*?\| .*?\|) \S+ \| \S+ \|",
                               r"\1 0.111 | 0.222 |", path.read_text()))
        summaries.write(self.docs)
        after = {name: (self.docs / name).read_text() for name in before}
        smoke = next(line for line in after["evaluation.md"].splitlines()
                     if line.startswith("| simulated | smoke"))
        self.assertIn(" 0.1234 / ", smoke)
        self.assertTrue(smoke.endswith("| median |"))
        self.assertIn("77.77 / 88.88", after["performance.md"])
        self.assertIn(" 0.111 / 0.222 |", after["own-video.md"])
        self.assertNotEqual(after["performance/growth.svg"], before["performance/growth.svg"])
        # Text written by people stays.
        self.assertEqual(*(re.sub(r"(?s)(<!-- (\w+): written by .*? -->).*?(<!-- end of \2 -->)",
                                  r"\1\3", of["evaluation.md"]) for of in (before, after)))

    def test_a_missing_result_is_named(self):
        for name, old, new, words in (("beyond", "| scenario | the paper's",
                                       "| scene | the paper's", "has no table 'scenario"),
                                      ("benchmarks", "\ncsd over time", "\nlk over time",
                                       "nothing that begins with 'csd over time'"),
                                      ("paper", "| csdtrack |", "| other |", "0 places like")):
            with self.subTest(name):
                before = (self.docs / "results" / f"{name}.md").read_text()
                self.change(name, old, new)
                with self.assertRaises(builds.Failure) as failed:
                    summaries.write(self.docs)
                self.assertIn(words, str(failed.exception))
                self.assertIn(f"{name}.md", str(failed.exception))
                (self.docs / "results" / f"{name}.md").write_text(before)
        for name in PAGES:
            self.assertEqual((self.docs / name).read_text(), (DOCS / name).read_text(),
                             "nothing may be written then")
        (self.docs / "results" / "tissue.md").unlink()
        with self.assertRaisesRegex(builds.Failure, "tissue.md: No such file"):
            summaries.write(self.docs)

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
        for path in (*(DOCS / name for name in PAGES), *(DOCS / "results").glob("*.md")):
            for line in path.read_text().splitlines():
                if re.fullmatch(r"\|(:?---:?\|)+", line):
                    self.assertLessEqual(line.count("---"), page.WIDEST, path.name)

    def test_links_are_relative_to_the_page(self):
        text = ("[a](method.md#x) [b](results/paper.md) [c](../core/csd.h) ![](beyond/d.svg) "
                "[e](#f) [g](https://h/i.md)")
        self.assertEqual(page.linked(text, DOCS / "results"),
                         "[a](../method.md#x) [b](paper.md) [c](../../core/csd.h) "
                         "![](beyond/d.svg) [e](#f) [g](https://h/i.md)")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
