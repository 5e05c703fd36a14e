#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""docs/site: the documentation as a web site. site_test.py ROOT"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(sys.argv[1])
TIMEOUT = 300


def site(root, *arguments):
    return subprocess.run([root / "docs" / "site", *arguments], capture_output=True, text=True,
                          timeout=TIMEOUT)


class Site(unittest.TestCase):
    def setUp(self):
        self.tmp = pathlib.Path(tempfile.mkdtemp(prefix="csdtrack-site-"))
        self.addCleanup(shutil.rmtree, self.tmp)
        self.out = self.tmp / "out"

    def test_every_page_is_in_it(self):
        done = site(ROOT, self.out)
        self.assertEqual((done.returncode, done.stdout), (0, f"{self.out}\n"), done.stderr)
        for page in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")):
            name = page.relative_to(ROOT).with_suffix(".html")
            html = (self.out / name.parent / name.name.replace("README", "index")).read_text()
            # What is no Markdown to mkdocs is left as it stands.
            text = re.sub(r"(?s)<pre>.*?</pre>", "", html)
            self.assertEqual(re.findall(r"(?m)^(?:<p>)?(?:\* |\||#+ |```).*", text), [], name)
        # The menu has each page of docs/.
        home = (self.out / "index.html").read_text()
        for page in (ROOT / "docs").glob("*.md"):
            self.assertIn(f'"docs/{page.stem.replace("README", "index")}.html', home)
        # A source to which a page links.
        self.assertTrue((self.out / "core" / "csd2012" / "choices.h").is_file())
        self.check_nothing_comes_from_elsewhere()
        again = site(ROOT, self.out)
        self.assertEqual(again.returncode, 0, again.stderr)

    def test_a_broken_link_fails(self):
        copy = self.tmp / "copy"
        for name in ("docs", "core"):
            shutil.copytree(ROOT / name, copy / name)
        for page in ROOT.glob("*.md"):
            shutil.copy(page, copy)
        done = site(copy, self.out)
        self.assertEqual(done.returncode, 0, done.stderr)
        shutil.rmtree(self.out)
        page = copy / "docs" / "security.md"
        text = page.read_text()
        # What mkdocs sees, and what only the finished pages show.
        for planted in ({"nowhere.md": "nowhere.md", "../core/nothing.h": "core/nothing.h"},
                        {"motion.md#nothing": "motion.html#nothing", "man": "man",
                         "#nothing": "#nothing", "../pipelines/nothing": "../pipelines/nothing",
                         "https://example.org/a.png": "https://example.org/a.png"}):
            page.write_text(text + "".join(f"\n{'!' * link.endswith('.png')}[planted]({link})\n"
                                           for link in planted))
            done = site(copy, self.out)
            self.assertEqual(done.returncode, 1)
            for link, seen in planted.items():
                self.assertRegex(done.stderr, rf"(?m)security\.(md|html)\b.*{re.escape(seen)}\b",
                                 link)
            self.assertFalse(self.out.exists())

    def check_nothing_comes_from_elsewhere(self):
        loaded = [address for page in self.out.rglob("*.html")
                  for address in re.findall(r"<(?:script|link|img)\b[^>]*(?:src|href)=\"([^\"]*)",
                                            page.read_text())]
        self.assertGreater(len(loaded), 100)
        self.assertEqual([address for address in loaded if "//" in address], [])

    def test_a_folder_of_others_stays(self):
        self.out.mkdir()
        (self.out / "index.html").write_text("mine")
        done = site(ROOT, self.out)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"{self.out} exists", done.stderr)
        self.assertEqual([path.name for path in self.out.iterdir()], ["index.html"])
        self.assertEqual(site(ROOT, "--no-such-option").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
