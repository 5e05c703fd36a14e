#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Exceptions reach Python and the bus, in whatever order a program imports libraries that have an
unwinder of their own. $THROWS is throws.cpp."""

import itertools
import os
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
pipeline = Gst.parse_launch(
    "videotestsrc num-buffers=5 ! csdtrackdec location=bad.jsonl ! fakesink")
pipeline.set_state(Gst.State.PLAYING)
message = pipeline.get_bus().timed_pop_filtered(
    60 * Gst.SECOND, Gst.MessageType.ERROR | Gst.MessageType.EOS)
assert message.type == Gst.MessageType.ERROR, message
assert "bad.jsonl" in message.parse_error()[0].message, message
pipeline.set_state(Gst.State.NULL)
"""
THROWN = """
for name in ("throws_ours", "throws_the_library", "throws_opencv", "throws_again",
             "throws_for_memory"):
    assert getattr(throws, name)() & 1, name
"""
IMPORTS = {"csdtrack": "import csdtrack", "cv2": "import cv2",
           "gi": "import gi; gi.require_version('Gst', '1.0'); from gi.repository import Gst; "
                 "Gst.init(None)",
           "throws": f"import ctypes; throws = ctypes.CDLL({os.environ['THROWS']!r})"}


class Imports(unittest.TestCase):
    def check_every_order(self, names, then):
        with tempfile.TemporaryDirectory(prefix="csdtrack-") as folder:
            (pathlib.Path(folder) / "bad.jsonl").write_text('{"schema":1}\n')
            for order in itertools.permutations(names):
                program = "\n".join(IMPORTS[name] for name in order) + then
                with self.subTest(order):
                    done = subprocess.run([sys.executable, "-c", program], cwd=folder,
                                          capture_output=True, text=True, timeout=120)
                    self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_module_and_the_plugin(self):
        self.check_every_order(["csdtrack", "cv2", "gi"], MODULE + PLUGIN)

    def test_exceptions_of_opencv_of_the_library_and_out_of_memory(self):
        self.check_every_order(["throws", "cv2", "gi"], THROWN)

    def test_the_plugin_has_its_own_resume_only_where_gstreamer_needs_libunwind(self):
        plugin = str(pathlib.Path(os.environ["GST_PLUGIN_PATH_1_0"]) / "libgstcsdtrack.so")
        program = IMPORTS["gi"] + "\nprint(open('/proc/self/maps').read())"
        maps = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True,
                              check=True, timeout=120).stdout
        core = next(line.split()[-1] for line in maps.splitlines() if "/libgstreamer-1.0" in line)

        def read(*arguments):
            return subprocess.run(["readelf", "-W", *arguments], capture_output=True, text=True,
                                  check=True).stdout
        imported = [line for line in read("--dyn-syms", plugin).splitlines()
                    if "UND _Unwind_Resume" in line]
        self.assertEqual(not imported, "libunwind" in read("-d", core))


if __name__ == "__main__":
    unittest.main(verbosity=2)
