#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays each scenario with gst-validate-1.0, where it is installed (not in Debian 12 and 13).

csdtrack and csdtrackdec must pass on the same buffers and events as identity, and gst-validate must
report the same issues. player_test.py checks much the same without gst-validate."""

import os
import pathlib
import re
import shutil
import subprocess
import unittest

import harness

HERE = pathlib.Path(__file__).resolve().parent
# Left out: metadata, which csdtrack adds; and requests for key frames, whose time is the clock's.
FLOW = ('validateflow, pad="middle:src", record-buffers=true, buffers-checksum=true, '
        'ignored-event-types={{custom-downstream}}, ignored-fields="stream-start={{stream-id}}, '
        'buffer={{meta}}", generate-expectations={first}, expectations-dir="{expected}", '
        'actual-results-dir="{actual}"')
FILE = ("filesrc location={video} ! qtdemux ! h264parse ! avdec_h264 max-threads=1 ! {element} "
        "name=middle ! fakesink")
MADE = ("videotestsrc num-buffers=50 ! video/x-raw,format=I420,width=160,height=120,framerate=25/1 "
        "! {element} name=middle ! ")
PIPELINES = {
    "seeks": FILE,
    "rates": FILE,
    "backwards": FILE,
    "pauses": FILE + " sync=true",
    "keys": MADE + "x264enc tune=zerolatency key-int-max=1000 ! fakesink sync=true",
    "states": MADE + "fakesink",  # no demuxer: gst_parse_launch() links its pads only once
}


@unittest.skipUnless(shutil.which("gst-validate-1.0"), "no gst-validate-1.0 here")
class Scenarios(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.video, cls.elements = harness.tracked_video(cls.tmp)

    def validated(self, name, element):
        """Returns the exit code, the issues about the element and its flow, and all output."""
        first = element == "identity"
        folder = self.tmp / name
        config = self.tmp / "config"
        config.write_text(FLOW.format(first=str(first).lower(), expected=folder,
                                      actual=folder / element.split()[0]) + "\n")
        done = subprocess.run(["gst-validate-1.0", f"--set-scenario={HERE / name}.scenario",
                               PIPELINES[name].format(video=self.video, element=element)],
                              env=os.environ | {"GST_VALIDATE_CONFIG": str(config)},
                              capture_output=True, text=True, timeout=4 * harness.TIMEOUT)
        reports = re.split(r"\n(?= *(?:critical|issue|warning) : )", done.stdout)[1:]
        about = sorted({report.splitlines()[0].strip() for report in reports
                        if "middle" in report or "ismatch" in report})
        return done.returncode, about, done.stdout + done.stderr

    def test_each_scenario_is_as_with_identity(self):
        self.assertEqual(sorted(path.stem for path in HERE.glob("*.scenario")), sorted(PIPELINES))
        for name in PIPELINES:
            code, about, _ = self.validated(name, "identity")
            expected = "".join(path.read_text() for path in (self.tmp / name).rglob("*expected*"))
            self.assertGreater(expected.count("\nbuffer: "), 30, name)
            for element in self.elements:
                with self.subTest(f"{name}: {element}"):
                    there, found, output = self.validated(name, element)
                    self.assertEqual((there, found), (code, about), output[-3000:])


if __name__ == "__main__":
    harness.main()
