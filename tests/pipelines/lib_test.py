#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What is in pipelines/lib and the commands can't be brought to show."""

import errno
import os
import pathlib
import sys
import unittest.mock

import harness
from gi.repository import GLib
from harness import Gst

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "pipelines" / "lib"))
import archive_index  # noqa: E402
import failure  # noqa: E402
import properties  # noqa: E402
import tracking  # noqa: E402


class Lib(harness.Case):
    def test_a_filesink_that_can_not_write(self):
        def error(code, text="Error while writing to file \"x\"."):
            return GLib.Error.new_literal(Gst.ResourceError.quark(), text, code)

        full = "can't write into 'a  b' (the disk is full): make room or give another place"
        for given, debug, kind, text in ((error(Gst.ResourceError.NO_SPACE_LEFT), None, failure.Full, full),
                                         (error(Gst.ResourceError.WRITE), f"system error: {os.strerror(errno.EDQUOT)}", failure.Full, full),
                                         (error(Gst.ResourceError.WRITE), None, failure.Failure,
                                          "can't write into 'a  b' (Error while writing to file \"x\"): give another place")):
            found = failure.of_filesink("a  b", given, debug)
            self.assertEqual((type(found), str(found)), (kind, text))
            self.assertEqual(tracking.explain("video", "a  b", "csdtrack", "filesink", given, debug or "", []), text)

    def test_a_property_as_text_sets_it(self):
        one, other = (Gst.ElementFactory.make("csdtrack") for _ in range(2))
        for name, text in {"points": 'a "b" \\ c;\nü', "region": "10,20,100,80", "overlay": "draw", "attach-meta": "false", "attach-roi": "true",
                           "max-features": "7", "forget-after": str(2**63 - 1)}.items():
            properties.set_from_text(one, name, text)
            self.assertEqual(properties.as_text(one, name), text)
        for name in properties.settable(one):
            properties.set_from_text(other, name, properties.as_text(one, name))
            self.assertEqual(other.get_property(name), one.get_property(name), name)

    def test_a_file_that_is_made_whole_follows_no_link(self):
        path, other = self.tmp / "plan.json", self.tmp / "other"
        other.write_text("other")
        known = self.tmp / f".plan.json.{os.uname().nodename}-{os.getpid()}.unfinished"
        known.symlink_to(other)
        archive_index.whole(path, "ü")
        self.assertEqual((path.read_text(encoding="utf-8"), path.is_symlink(), other.read_text()), ("ü", False, "other"))
        self.assertEqual(path.stat().st_mode, other.stat().st_mode)  # who may read others may read it
        # Even of a name that was guessed.
        known.rename(self.tmp / f".plan.json.guess.{os.uname().nodename}-{os.getpid()}.unfinished")
        with unittest.mock.patch("secrets.token_hex", return_value="guess"), self.assertRaises(FileExistsError):
            archive_index.whole(path, "new")
        self.assertEqual((path.read_text(encoding="utf-8"), other.read_text()), ("ü", "other"))


if __name__ == "__main__":
    harness.main()
