#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csdtrack does not change a recording: encoded bytes, timestamps and pixels are the same with it
and without."""

import hashlib
import os
import pathlib
import subprocess
import sys
import unittest

import harness
from harness import Gst

# One thread and a fixed quantizer: x264 then gives the same bytes on every run.
X264 = ("x264enc threads=1 pass=quant quantizer=24 speed-preset=veryfast bframes=2 b-adapt=false "
        "rc-lookahead=5 key-int-max=30")
# async=false: the encoder's sink gets nothing until the look-ahead is full, and must not keep the
# other branch waiting for that.
SINK = "fakesink name=out async=false"


def stamped_bytes(buffer):
    ok, map_ = buffer.map(Gst.MapFlags.READ)
    assert ok
    digest = hashlib.md5(map_.data).hexdigest()
    buffer.unmap(map_)
    kept = buffer.get_flags() & (Gst.BufferFlags.DELTA_UNIT | Gst.BufferFlags.DISCONT |
                                 Gst.BufferFlags.GAP | Gst.BufferFlags.HEADER)
    return digest, buffer.pts, buffer.dts, buffer.duration, int(kept)


def stream(launch):
    run = harness.Run(launch)
    seen = run.collect("out", stamped_bytes)
    run.to_end()
    return seen, run


class Recording(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        video = harness.scene_video(cls.tmp / "in.mkv", 60, *harness.H264, "-bf", "2")
        cls.source = f"filesrc location={video} ! decodebin"

    def encoded(self, before_tee="", branch="", after=""):
        return stream(f"{self.source} {before_tee} ! tee name=t "
                      f"t. ! queue {after} ! {X264} ! {SINK} t. ! queue {branch} ! fakesink")

    @unittest.skipUnless(Gst.ElementFactory.find("x264enc"), "no x264enc")
    def test_the_encoded_stream_is_the_same(self):
        plain, _ = self.encoded()
        again, _ = self.encoded()
        self.assertEqual(plain, again, "the encoder itself gives other bytes on each run")
        self.assertEqual(len(plain), 60)
        frame = "! csdtrack post-messages=frame"
        learning = "! csdtrack algorithm=csd-2012 learning=sync max-features=10"
        for name, where in {
                "in line, before the tee": dict(before_tee=f"{frame} attach-roi=true"),
                "in line, tracks written": dict(before_tee=frame, branch="! csdtrackenc"),
                "in the encoder's branch": dict(after="! csdtrack"),
                "in the other branch": dict(branch=f"{frame} ! csdtrackenc"),
                "drawn in the other branch": dict(branch="! csdtrack overlay=draw"),
                "csd-2012, waiting for learning": dict(before_tee=learning)}.items():
            with self.subTest(name):
                tracked, run = self.encoded(**where)
                self.assertEqual(tracked, plain)
                self.assertEqual(run.warnings, [])
                self.assertTrue(run.messages)

    @unittest.skipUnless(Gst.ElementFactory.find("x264enc"), "no x264enc")
    def test_the_encoded_stream_is_the_same_from_every_format(self):
        formats = harness.formats(Gst.ElementFactory.find("csdtrack").get_static_pad_templates()[0])
        for number, format_ in enumerate(formats):
            overlay = ("none", "meta")[number % 2]
            with self.subTest(f"{format_}, overlay={overlay}"):
                plain, tracked = (
                    stream(f"{self.source} ! videoconvert dither=none ! "
                           f"video/x-raw,format={format_} ! {element} ! videoconvert dither=none ! "
                           f"{X264} ! {SINK}")[0]
                    for element in ("identity", f"csdtrack max-features=10 overlay={overlay}"))
                self.assertEqual(len(plain), 60)
                self.assertEqual(tracked, plain)

    @unittest.skipUnless(Gst.ElementFactory.find("x264enc"), "no x264enc")
    def test_the_encoded_stream_is_the_same_under_load(self):
        plain, _ = self.encoded()
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"])
                for _ in range(os.cpu_count())]
        try:
            # The budget is used up at once, so most of the 30 features wait in each frame.
            tracked, run = self.encoded(before_tee="! csdtrack name=track max-features=30 "
                                        "frame-budget=1 post-messages=frame",
                                        branch="! csdtrackenc")
        finally:
            for process in busy:
                process.kill()
                process.wait()
        self.assertEqual(tracked, plain)
        self.assertGreater(run.element("track").get_property("stats").get_value("waited"), 0)
        waited = [f["fresh"] for message in run.messages for f in message["features"]].count(False)
        self.assertGreater(waited, 0, "no message says which features waited")

    def test_only_drawing_in_line_changes_the_pixels(self):
        plain, _ = stream(f"{self.source} ! {SINK}")
        drawn, _ = stream(f"{self.source} ! csdtrack overlay=draw ! {SINK}")
        self.assertEqual([p[1:] for p in plain], [d[1:] for d in drawn],
                         "timestamps must stay the same even then")
        self.assertTrue(all(p[0] != d[0] for p, d in zip(plain, drawn)))

    def test_raw_frames_are_the_same(self):
        plain, _ = stream(f"{self.source} ! {SINK}")
        self.assertEqual(len(plain), 60)
        for line in ("csdtrack", "csdtrack algorithm=lk attach-roi=true post-messages=frame",
                     "csdtrack ! csdtrack", "tee ! queue ! csdtrack"):
            with self.subTest(line):
                self.assertEqual(stream(f"{self.source} ! {line} ! {SINK}")[0], plain)

    def test_an_overlay_that_downstream_cannot_show_leaves_the_pixels(self):
        plain, _ = stream(f"{self.source} ! {SINK}")
        # videoflip knows neither the meta nor the caps feature.
        meta, run = stream(f"{self.source} ! csdtrack overlay=meta ! videoflip method=none ! "
                           f"{SINK}")
        self.assertEqual(meta, plain)
        self.assertEqual(len(run.warnings), 1, run.warnings)

    def frames_copied(self, element):
        """How often memory was copied, says GStreamer's log, with `element` in one branch of a tee.

        Without queues the tee holds each frame while a branch has it, so that it is always shared.
        """
        log = self.tmp / "performance.log"
        line = (f"{self.source} ! tee name=t t. ! {element} ! fakesink async=false t. ! fakesink "
                "async=false")
        done = subprocess.run([sys.executable, "-c", f"import harness; harness.play({line!r})"],
                              cwd=pathlib.Path(__file__).parent, capture_output=True, text=True,
                              env=dict(os.environ, GST_DEBUG="GST_PERFORMANCE:5",
                                       GST_DEBUG_NO_COLOR="1", GST_DEBUG_FILE=str(log)))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("GST_PERFORMANCE", log.read_text(), "without a log this test shows nothing")
        return len([line for line in log.read_text().splitlines() if "memcpy" in line or
                    "_mem_copy" in line or "GstMemory" in line and "copy" in line])

    def test_behind_a_tee_no_pixel_is_copied(self):
        self.assertEqual(self.frames_copied("identity"), 0)
        self.assertEqual(self.frames_copied("csdtrack post-messages=frame attach-roi=true"), 0)
        self.assertGreaterEqual(self.frames_copied("csdtrack overlay=draw"), 60,
                                "drawing must copy each frame")


if __name__ == "__main__":
    harness.main()
