#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""debian/ has all that is installed: the short form of tests/debian. packages_test.py ROOT BUILD"""

import fnmatch
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT, BUILD = map(pathlib.Path, sys.argv[1:3])
DEBIAN = ROOT / "debian"


def lines_of(file):
    return file.read_text().splitlines()


class Packages(unittest.TestCase):
    def setUp(self):
        options = json.loads(subprocess.run(["meson", "introspect", "--buildoptions", BUILD],
                                            check=True, capture_output=True).stdout)
        self.options = {option["name"]: option["value"] for option in options}

    def installed(self):
        """Paths as in Debian: below usr/, with Debian's own folder for modules of Python."""
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["meson", "install", "-C", BUILD, "--no-rebuild", "--destdir", folder],
                           check=True, capture_output=True)
            prefix = pathlib.Path(folder + self.options["prefix"])
            paths = [str(path.relative_to(prefix)) for path in prefix.rglob("*")
                     if not path.is_dir()]
            self.assertEqual([path for path in pathlib.Path(folder).rglob("*")
                              if not path.is_dir() and prefix not in path.parents], [])
        return ["usr/" + re.sub(r"^(local/)?lib/python3[.\d]*/", "lib/python3/", path)
                for path in paths]

    def test_each_installed_file_is_in_one_package(self):
        patterns = {pattern: package.name.removesuffix(".install")
                    for package in DEBIAN.glob("*.install") for pattern in lines_of(package)}
        used = set()
        for path in self.installed():
            found = {pattern for pattern in patterns if fnmatch.fnmatch(path, pattern) or
                     path.startswith(pattern + "/")}
            self.assertEqual(len(found), 1, path)
            used |= found
        self.assertEqual(used, set(patterns))

    def test_every_package_of_control_gets_files(self):
        packages = re.findall(r"^Package: (\S+)$", (DEBIAN / "control").read_text(), re.M)
        self.assertEqual(sorted(packages), sorted(path.name.removesuffix(".install")
                                                  for path in DEBIAN.glob("*.install")))

    def test_the_changelog_has_the_version_of_the_build(self):
        version = re.search(r"^  version: '([^']+)'", (ROOT / "meson.build").read_text(), re.M)[1]
        self.assertRegex(lines_of(DEBIAN / "changelog")[0], rf"^csdtrack \({re.escape(version)}\) ")

    def test_build_dependencies_are_in_tests_packages(self):
        control = re.sub(r"\n ", " ", (DEBIAN / "control").read_text())
        wanted = re.search(r"^Build-Depends: (.*)$", control, re.M)[1]
        known = {line.split()[1] for line in lines_of(ROOT / "tests" / "packages")
                 if re.match(r"(run|test) ", line)}
        for one in filter(None, (part.strip() for part in wanted.split(","))):
            names = {re.match(r"[\w.+-]+", name.strip())[0] for name in one.split("|")}
            # debhelper's own; and of locales the list has another package.
            if not names & {"debhelper-compat", "dh-sequence-python3", "locales-all"}:
                self.assertTrue(names & known, one)


if __name__ == "__main__":
    del sys.argv[1:3]
    unittest.main()
