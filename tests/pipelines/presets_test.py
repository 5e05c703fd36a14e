#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csdtrack's presets, found and loaded as by GStreamer's own programs."""

import configparser
import os
import pathlib

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "gst" / "presets"
os.environ["GST_PRESET_PATH"] = str(FOLDER)  # GStreamer reads it once, at the first preset
import harness  # noqa: E402
from harness import Gst  # noqa: E402

LISTED = ("accurate", "archive", "beating-heart", "laparoscopy-1080p", "live-low-latency")


class Presets(harness.Case):
    def test_each_preset_sets_what_its_file_says_and_nothing_else(self):
        file = configparser.ConfigParser(interpolation=None)
        file.read(FOLDER / "GstCsdTrack.prs")
        usual = Gst.ElementFactory.make("csdtrack")
        self.assertEqual(tuple(sorted(usual.get_preset_names())), LISTED)
        for name in LISTED:
            with self.subTest(name):
                track = Gst.ElementFactory.make("csdtrack")
                self.assertTrue(track.load_preset(name))
                self.assertTrue(track.get_meta(name, "comment")[0])
                set_there = {key for key in file[name] if not key.startswith("_meta")}
                for spec in track.list_properties():
                    if spec.name in ("name", "parent", "stats"):
                        continue
                    value, plain = track.get_property(spec.name), usual.get_property(spec.name)
                    if spec.name in set_there:
                        said = file[name][spec.name]
                        self.assertEqual(getattr(value, "value_nick", str(value)), said, spec.name)
                    else:
                        self.assertEqual(str(value), str(plain), spec.name)

    def test_gst_launch_loads_them(self):
        for name in LISTED:
            with self.subTest(name):
                done = harness.launch("-q csdsimsrc num-buffers=3 !",
                                      f"csdtrack @preset={name} ! fakesink")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
        done = harness.launch("-q csdsimsrc num-buffers=3 !", "csdtrack @preset=fast ! fakesink")
        self.assertIn("fast", done.stderr)


if __name__ == "__main__":
    harness.main()
