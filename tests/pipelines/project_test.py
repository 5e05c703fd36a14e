#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The files of the project itself: citation, releases, reports, continuous integration.
project_test.py ROOT"""

import datetime
import email.utils
import os
import pathlib
import re
import sys
import unittest

import yaml

ROOT = pathlib.Path(sys.argv[1])
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
# What nobody can do without, in each form.
REQUIRED = {
    "bug.yml": ["command", "expected", "system"],
    "feature.yml": ["purpose", "today"],
    "wrong-tracks.yml": ["seen", "video", "command", "version"],
}


def text(name):
    return (ROOT / name).read_text()


class Release(unittest.TestCase):
    """The version and the day are the same wherever they stand."""

    def setUp(self):
        self.cited = yaml.safe_load(text("CITATION.cff"))

    def test_version(self):
        version = re.search(r"^  version: '([^']+)'", text("meson.build"), re.M)[1]
        self.assertRegex(version, r"^\d+\.\d+\.\d+$")
        self.assertEqual(self.cited["version"], version)
        self.assertEqual(re.search(r"^## (\S+), ", text("CHANGELOG.md"), re.M)[1], version)

    def test_day(self):
        day = self.cited["date-released"]
        self.assertIsInstance(day, datetime.date)
        self.assertEqual(re.search(r"^## \S+, (\S+)$", text("CHANGELOG.md"), re.M)[1], str(day))
        signed = re.search(r"^ -- .*>  (.*)$", text("debian/changelog"), re.M)[1]
        self.assertEqual(email.utils.parsedate_to_datetime(signed).date(), day)

    def test_citation(self):
        """What the format demands, and the paper that README names."""
        self.assertEqual(self.cited["cff-version"], "1.2.0")
        for name in ("message", "title"):
            self.assertTrue(self.cited[name], name)
        self.assertEqual(self.cited["type"], "software")
        self.assertTrue(self.cited["authors"][0]["name"])
        paper, = self.cited["references"]
        readme = " ".join(text("README.md").split())
        for word in (paper["title"], paper["journal"], str(paper["year"]),
                     *(author["family-names"] for author in paper["authors"])):
            self.assertIn(word, readme)
        self.assertIn(self.cited["license"], text("meson.build"))


class Reports(unittest.TestCase):
    def test_each_form_is_one(self):
        forms = [path for path in FORMS if path.name != "config.yml"]
        self.assertEqual([path.name for path in forms], sorted(REQUIRED))
        for path in forms:
            with self.subTest(path.name):
                form = yaml.safe_load(path.read_text())
                self.assertEqual(set(form), {"name", "description", "body"})
                fields = [field for field in form["body"] if field["type"] != "markdown"]
                self.assertEqual([field["id"] for field in fields
                                  if field.get("validations", {}).get("required") is True],
                                 REQUIRED[path.name])
                names = [field["id"] for field in fields]
                self.assertEqual(len(names), len(set(names)))
                for field in fields:
                    self.assertIn(field["type"], ("input", "textarea"))
                    self.assertTrue(field["attributes"]["label"])
                    self.assertLessEqual(set(field["attributes"]),
                                         {"label", "description", "render"})

    def test_files_that_they_name_exist(self):
        named = {name for path in FORMS
                 for name in re.findall(r"\b(?:[\w-]+/)+[\w.-]*\w|\b[A-Z_]+\.md\b",
                                        path.read_text())}
        self.assertLessEqual({"SECURITY.md", "docs/method.md", "docs/own-video.md", "tests/run",
                              "pipelines/experiments/palindrome"}, named)
        for name in named - {"etc/os-release"}:
            self.assertTrue((ROOT / name).exists(), name)

    def test_no_page_sends_people_to_an_address(self):
        """There is none that would be real for whoever hosts a copy."""
        for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), ROOT / "CITATION.cff", *FORMS):
            self.assertEqual(re.findall(r"[\w.+-]+@[\w-]+\.\w+", path.read_text()), [], path.name)


class Integration(unittest.TestCase):
    def setUp(self):
        self.job, = yaml.safe_load(text(".github/workflows/ci.yml"))["jobs"].values()

    def test_it_runs_what_a_contributor_runs(self):
        commands = [step.get("run") for step in self.job["steps"]]
        self.assertIn(".ci/run | tee ../ci.log", commands)
        self.assertTrue(os.access(ROOT / ".ci" / "run", os.X_OK))

    def test_in_both_systems_on_both_processors(self):
        matrix = self.job["strategy"]["matrix"]
        self.assertEqual(matrix["image"], ["debian:bookworm", "debian:trixie"])
        self.assertEqual([runner.endswith("-arm") for runner in matrix["runner"]], [False, True])
        self.assertEqual(self.job["container"]["image"], "${{ matrix.image }}")
        self.assertEqual(self.job["runs-on"], "${{ matrix.runner }}")

    def test_it_uses_nothing_of_others(self):
        self.assertEqual([step for step in self.job["steps"] if "uses" in step], [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
