#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Exceptions reach Python, and the bus, in whatever order a program imports what brings unwinders along."""

import itertools
import pathlib
import subprocess
import sys
import tempfile
import unittest

MODULE = """
try:
    csdtrack.Tracker(algorithm="kcf")
except ValueError as error:
    assert "kcf" in str(error)
else:
    raise AssertionError("accepted")
"""
PLUGIN = """
pipeline = Gst.parse_launch("videotestsrc num-buffers=5 ! csdtrackdec location=bad.jsonl ! fakesink")
pipeline.set_state(Gst.State.PLAYING)
message = pipeline.get_bus().timed_pop_filtered(60 * Gst.SECOND, Gst.MessageType.ERROR | Gst.MessageType.EOS)
assert message.type == Gst.MessageType.ERROR and "bad.jsonl" in message.parse_error()[0].message, message
pipeline.set_state(Gst.State.NULL)
"""
IMPORTS = {
    "csdtrack": "import csdtrack",
    "cv2": "import cv2",
    "gi": "import gi; gi.require_version('Gst', '1.0'); from gi.repository import Gst; Gst.init(None)",
}


class Imports(unittest.TestCase):
    def test_every_order(self):
        with tempfile.TemporaryDirectory(prefix="csdtrack-") as folder:
            (pathlib.Path(folder) / "bad.jsonl").write_text('{"schema":1}\n')
            for order in itertools.permutations(IMPORTS):
                program = "\n".join(IMPORTS[name] for name in order) + MODULE + PLUGIN
                with self.subTest(order):
                    done = subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, timeout=120)
                    self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
