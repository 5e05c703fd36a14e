#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The manual pages (docs/man) agree with the programs' --help, and man and mandoc accept them.

man_test.py SOURCE BUILD PROGRAM..."""

import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import unittest

SOURCE, BUILD, *PROGRAMS = map(pathlib.Path, sys.argv[1:])
ENV = {**os.environ, "LC_ALL": "C.UTF-8", "MANWIDTH": "80"}
SECTIONS = ["NAME", "SYNOPSIS", "DESCRIPTION", "OPTIONS", "EXIT STATUS", "EXAMPLES", "SEE ALSO"]


def run(*command):
    return subprocess.run(command, env=ENV, capture_output=True, text=True, timeout=60)


def helped_options(program):
    """{(short, long, argument): description} of each option that --help lists."""
    text = run(program, "--help").stdout
    found = re.findall(r"^  (?:-(\w), )?--([\w-]+)(?:[= ](\S+))? {2,}(\S.*)$", text, re.MULTILINE)
    return {(short, name, argument): about for short, name, argument, about in found}


def parts(page):
    names = re.findall(r"^\.Sh (.*)$", page, re.MULTILINE)
    return dict(zip(names, re.split(r"^\.Sh .*\n", page, flags=re.MULTILINE)[1:]))


def paged_options(page):
    """The same as helped_options(), of the options that the page lists."""
    options = {}
    for head, about in re.findall(r"^\.It (Fl .*)\n((?:(?!\.It|\.El).*\n)*)",
                                  parts(page)["OPTIONS"], re.MULTILINE):
        short, name, argument = re.fullmatch(
            r"(?:Fl (\w)(?: Ar \S+)? , )?Fl -([\w-]+)(?: Ns = Ns Ar (\S+))?", head).groups("")
        options[short, name, argument] = about
    return options


class Man(unittest.TestCase):
    maxDiff = None

    def each(self):
        for program in PROGRAMS:
            yield program, SOURCE / "docs" / "man" / f"{program.name}.1"

    def test_programs_print_the_version_of_the_build(self):
        version = re.search(r"^  version: '([^']+)'", (SOURCE / "meson.build").read_text(),
                            re.MULTILINE)[1]
        for program in PROGRAMS:
            with self.subTest(program):
                env = {**ENV, "PATH": f"{BUILD / 'core' / 'programs'}:{os.environ['PATH']}"}
                done = subprocess.run([program, "--version"], env=env, capture_output=True,
                                      text=True, timeout=60)
                self.assertEqual((done.returncode, done.stdout, done.stderr),
                                 (0, f"{program.name} {version}\n", ""))

    def test_each_installed_program_has_an_installed_page(self):
        meson = shlex.split(os.environ.get("MESONINTROSPECT", "meson introspect"))
        plan = json.loads(subprocess.run([*meson, "--installed", BUILD], capture_output=True,
                                         text=True, check=True).stdout)
        places = [pathlib.Path(place) for place in plan.values()]
        programs = {place.name for place in places if place.parent.name == "bin"}
        pages = {place.stem for place in places if place.parent.name == "man1"}
        self.assertEqual(programs, {program.name for program in PROGRAMS})
        self.assertEqual(pages, programs)

    def test_man_and_mandoc_have_no_complaint(self):
        for _, page in self.each():
            with self.subTest(page.name):
                if shutil.which("mandoc"):
                    said = run("mandoc", "-T", "lint", "-W", "style", page)
                    # It is no fault of this page that others are not installed here.
                    complaints = [line for line in (said.stdout + said.stderr).splitlines()
                                  if page.name + ":" in line]
                    self.assertEqual([line for line in complaints
                                      if "referenced manual not found" not in line], [])
                else:
                    print("SKIP: there is no mandoc here", file=sys.stderr)
                if shutil.which("man"):
                    read = run("man", "--warnings", "-E", "UTF-8", "-l", page)
                    self.assertEqual((read.returncode, read.stderr), (0, ""))
                    for section in SECTIONS:
                        self.assertRegex(read.stdout, rf"(?m)^{section}$")
                else:
                    print("SKIP: there is no man here", file=sys.stderr)

    def test_sections(self):
        for program, path in self.each():
            with self.subTest(path.name):
                page = path.read_text(encoding="utf-8")
                self.assertEqual(re.findall(r'^\.Sh "?(.*?)"?$', page, re.MULTILINE), SECTIONS)
                self.assertIn(f".Dt {program.name.upper()} 1\n", page)
                self.assertTrue(all(text.strip() for text in parts(page).values()))
                self.assertEqual(re.findall(r"^\.It (\d)$", parts(page)["EXIT STATUS"],
                                            re.MULTILINE), ["0", "1", "2"])
                about = re.search(r"^\.Nd (.*)$", page, re.MULTILINE)[1]
                self.assertRegex(run(program, "--help").stdout,
                                 rf"(?mi)(^| - ){re.escape(about)}\.?$", "described alike")

    def test_options_are_those_of_help(self):
        for program, path in self.each():
            with self.subTest(path.name):
                page = path.read_text(encoding="utf-8")
                helped, paged = helped_options(program), paged_options(page)
                self.assertGreaterEqual(len(helped), 3)
                self.assertEqual(list(sorted(paged)), list(sorted(helped)))
                for option, about in helped.items():
                    self.assertTrue(paged[option].strip(), option)
                    for default in re.findall(r"\(([\d.]+)\b", about):
                        self.assertIn(f"({default})", paged[option], option)
                    self.assertRegex(parts(page)["SYNOPSIS"], rf"(Fl|\|) -{option[1]}\b")

    def test_trackers_and_keys_of_help_are_on_the_page(self):
        """The trackers of csd-peers and the keys of csd-label. In --help two spaces stand before
        each and at least two after it."""
        for program, path in self.each():
            with self.subTest(path.name):
                page = path.read_text(encoding="utf-8")
                helped = set(re.findall(r"(?<=  )([\w?-]+)  +(?=\S)",
                                        run(program, "--help").stdout))
                listed = set(re.findall(r"Cm (?:\\&)?(\S+)", page))
                arguments = set(re.findall(r"Ar (\S+)", page))
                self.assertEqual(listed - {"Esc"},
                                 {word for word in helped if not word.startswith("-")} - arguments)

    def test_examples_use_existing_options(self):
        known = {program.name: helped_options(program) for program in PROGRAMS}
        for program, path in self.each():
            with self.subTest(path.name):
                examples = "".join(re.findall(r"^\.Bd -literal[^\n]*\n(.*?)^\.Ed",
                                              parts(path.read_text(encoding="utf-8"))["EXAMPLES"],
                                              re.DOTALL | re.MULTILINE))
                commands = re.findall(r"\b(csd-(?!2012)[a-z]+)((?: [^|)\n]*)?)",
                                      examples.replace("\\e\n", " "))
                self.assertIn(program.name, [name for name, _ in commands])
                for name, rest in commands:
                    options = known[name]
                    for word in shlex.split(rest):
                        if re.match("-.", word):
                            key = word.lstrip("-").split("=")[0]
                            self.assertTrue(any(key in option[:2] for option in options),
                                            f"{name} {word}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
