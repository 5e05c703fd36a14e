#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""In every video format, and in interlaced video, the same scene gives the same, correct tracks."""

import itertools
import math
import statistics

import cv2
import numpy as np

import harness
from gi.repository import GLib, GstVideo
from harness import Gst, Scene

COMMON = ("I420 YV12 NV12 NV21 Y42B Y444 YUY2 UYVY GRAY8 RGB BGR RGBx BGRx xRGB xBGR RGBA BGRA "
          "ARGB ABGR v210 I420_10LE I422_10LE Y444_10LE P010_10LE").split()
# Those that csdtrack reads in place.
NATIVE = (COMMON + "NV16 VUYA P012_LE I420_12LE RGBA64_LE ARGB64 Y210 Y410 r210 BGR10A2_LE "
          "GRAY10_LE32 GRAY16_LE GRAY16_BE Y41B GBR GBRA RGBP BGRP GBR_10LE GBR_10BE GBR_12LE "
          "GBR_12BE GBRA_10LE GBRA_10BE GBRA_12LE GBRA_12BE".split())
NEWER = "GBR_16LE GBR_16BE".split()
# All others that the running GStreamer knows, but those that are no pixels.
OTHERS = sorted({GstVideo.VideoFormat.to_string(f) for f in GstVideo.video_formats_raw()}
                - {*NATIVE, *NEWER, "ENCODED", "DMA_DRM"})
# What luma loses where it has less than 8 bits, in levels.
STEPS = {"RGB15": 8, "BGR15": 8, "RGB16": 8, "BGR16": 8, "RGB8P": 51}
STARTS = [(x, y) for y in (70, 120, 170) for x in (70, 130, 190, 250)]
POINTS = ";".join(f"{x},{y}" for x, y in STARTS)


def errors(lines, motion):
    """Distances in pixels of all claimed positions from the truth."""
    found = []
    for t, line in enumerate(lines):
        dx, dy = motion(t)
        for (x, y), f in zip(STARTS, line["features"]):
            if f["state"] in harness.CLAIMS:
                found.append(float(np.hypot(f["x"] - x - dx, f["y"] - y - dy)))
    return found


class Formats(harness.Case):
    FRAMES = 30

    def tracks(self, format_, properties, scene, frames=FRAMES):
        path = self.tmp / "tracks.jsonl"
        # Colour matrix, range and chroma siting are the same for all: only the format differs.
        caps = f"video/x-raw,format={format_}"
        harness.play(f"appsrc name=in ! videoconvert dither=none ! {caps} ! csdtrack "
                     f"points={POINTS} {properties} ! csdtrackenc ! filesink location={path}",
                     harness.buffers(scene.picture(t) for t in range(frames)),
                     harness.rgb_caps())
        lines = harness.read_lines(path)
        harness.check_tracks(self, lines, frames)
        return lines

    def test_pad_templates_list_all_formats(self):
        for template in Gst.ElementFactory.find("csdtrack").get_static_pad_templates():
            listed = harness.formats(template)
            self.assertEqual(listed[:len(NATIVE)], NATIVE)
            self.assertEqual(sorted(set(listed) - {*NATIVE, *NEWER}), OTHERS)
            self.assertEqual(len(listed), len(set(listed)))

    def test_a_source_with_every_format_gives_a_common_one(self):
        for element in "csdtrack", "csdtrack overlay=meta", "csdtrackdec":
            with self.subTest(element):
                pipeline = Gst.parse_launch(f"videotestsrc num-buffers=1 ! {element} ! fakesink "
                                            "name=sink")
                pad = pipeline.get_by_name("sink").get_static_pad("sink")
                pipeline.set_state(Gst.State.PAUSED)
                self.assertEqual(pipeline.get_state(10 * Gst.SECOND)[0],
                                 Gst.StateChangeReturn.SUCCESS)
                format_ = pad.get_current_caps()[0]["format"]
                pipeline.set_state(Gst.State.NULL)
                self.assertIn(format_, COMMON)

    def test_lk_agrees_across_formats(self):
        # Formats differ in how luma is rounded (8 bit: ±½, at a contrast of σ = 45) and whether it
        # is computed from RGB. A patch of n pixels with gradients of g levels a pixel turns noise
        # of σ = 0.3·√2 into an error of 0.42/(g√n). With g ≈ 10 and n ≥ 150 that is 0.004 px a
        # frame. Over 30 frames it adds up to 0.02 px if independent, 0.1 px if not.
        scene = Scene()
        first = self.tracks("I420", "algorithm=lk", scene)
        self.assertLess(max(errors(first, scene.motion)), 0.25)
        self.assertEqual(len(errors(first, scene.motion)), self.FRAMES * len(STARTS),
                         "nothing is lost")
        # For formats that GStreamer unpacks some frames are enough: check-row_unpacker compares all
        # samples. Coarse luma has an error of σ = step/√12 a frame instead of 0.3.
        for format_ in NATIVE[1:] + OTHERS:
            with self.subTest(format_):
                lines = self.tracks(format_, "algorithm=lk", scene,
                                    self.FRAMES if format_ in NATIVE else 5)
                limit = 0.1 * max(1, STEPS.get(format_, 1) / math.sqrt(12) / 0.3)
                for a, b in zip(first, lines):
                    for f, g in zip(a["features"], b["features"]):
                        self.assertEqual(f["state"], g["state"])
                        self.assertLess(np.hypot(f["x"] - g["x"], f["y"] - g["y"]), limit,
                                        f"frame {a['frame']}")

    def test_draw_refuses_a_palette_and_says_so(self):
        caps = "video/x-raw,format=RGB8P,width=320,height=240,framerate=25/1"
        with self.assertRaisesRegex(GLib.GError, "could not link"):
            Gst.parse_launch(f"videotestsrc ! {caps} ! csdtrack overlay=draw ! fakesink")
        # A source that asks for no caps.
        frames = [np.zeros(320 * 240 + 1024, np.uint8)] * 3
        with self.assertRaisesRegex(harness.PipelineError,
                                    "overlay=draw can't draw into these frames"):
            harness.play("appsrc name=in ! csdtrack overlay=draw ! fakesink",
                         harness.buffers(frames), caps)

    def test_learnt_features_are_right_in_every_format(self):
        # csd-2012 chooses among 49 colour spaces and sees other colours in each format, so tracks
        # needn't agree. But 9 of 10 claims must be within 5 px, the limit that the tracker's
        # confidence is about.
        scene = Scene()
        for algorithm, format_ in itertools.product(("csd", "csd-2012"),
                                                    ("I420", "UYVY", "GRAY8", "BGRx", "v210",
                                                     "P010_10LE", "GRAY16_LE")):
            with self.subTest(format_, algorithm=algorithm):
                found = errors(self.tracks(format_, f"algorithm={algorithm} learning=sync "
                                           "training-time=200000000", scene), scene.motion)
                self.assertGreater(len(found), self.FRAMES * len(STARTS) / 2,
                                   "less than half is claimed")
                self.assertGreater(sum(e < 5 for e in found), 0.9 * len(found))


class DeepGray(harness.Case):
    """GRAY16_LE from cameras that use a small part of its range."""

    FRAMES = 75

    def found(self, pictures, scene, algorithm, format_="GRAY16_LE"):
        """Each frame's errors, as from errors()."""
        path = self.tmp / "tracks.jsonl"
        harness.play(f"appsrc name=in ! csdtrack points={POINTS} algorithm={algorithm} "
                     f"training-time=200000000 ! csdtrackenc ! filesink location={path}",
                     harness.buffers(pictures),
                     f"video/x-raw,format={format_},width=320,height=240,framerate=25/1")
        lines = harness.read_lines(path)
        harness.check_tracks(self, lines, self.FRAMES)
        return [errors([line], lambda _, t=t: scene.motion(t)) for t, line in enumerate(lines)]

    def grey(self, scene):
        return [cv2.cvtColor(np.ascontiguousarray(scene.picture(t)), cv2.COLOR_RGB2GRAY)
                for t in range(self.FRAMES)]

    def deep(self, pictures, span, light):
        """Uses `span` of the 65536 levels, from level 1000 on, times the brightness light(t)."""
        return [np.round(1000 + light(t) * span * (p / 255.0)).astype("<u2")
                for t, p in enumerate(pictures)]

    def test_a_small_drifting_range_is_as_good_as_8_bit(self):
        scene = Scene()
        pictures = self.grey(scene)
        for algorithm, drift in itertools.product(("lk", "csd"), (0, 0.3)):
            def light(t, drift=drift):
                return 1 + drift * math.sin(2 * math.pi * t / self.FRAMES)

            # lk takes changes of light for motion, so the 8 bit pictures drift in the same way.
            eight = [np.round(0.75 * light(t) * p).astype(np.uint8) for t, p in enumerate(pictures)]
            good = sum(self.found(eight, scene, algorithm, "GRAY8"), [])
            for span in 0.04 * 65535, 200:
                with self.subTest(algorithm, levels=span, drift=drift):
                    found = sum(self.found(self.deep(pictures, span, light), scene, algorithm), [])
                    self.assertGreaterEqual(len(found), 0.98 * len(good),
                                            "less is claimed than in 8 bit")
                    self.assertLess(np.mean(found), np.mean(good) + 0.02)
                    self.assertLess(np.percentile(found, 99), np.percentile(good, 99) + 0.05)

    def test_tracking_recovers_from_an_exposure_change_within_a_second(self):
        scene = Scene()
        eight = self.grey(scene)
        for factor in (0.1, 0.5, 2, 6):
            with self.subTest(factor=factor):
                found = self.found(self.deep(eight, 4000, lambda t: factor if t >= 30 else 1),
                                   scene, "csd")
                self.assertEqual(min(len(f) for f in found[50:]), len(STARTS),
                                 "not all are claimed again")
                self.assertLess(max(sum(found, [])), 1)


class Planes(harness.Case):
    def test_nv12_as_a_decoder_pads_it(self):
        """Rows are longer than the picture's, of another length in each plane. There are more rows,
        and other bytes before the planes."""
        scene, frames, width, height = Scene(), 20, 320, 240
        stride, offset = (384, 448), (64, 64 + 384 * 256 + 32)
        plain, padded = [], []
        for t in range(frames):
            i420 = cv2.cvtColor(np.ascontiguousarray(scene.picture(t)), cv2.COLOR_RGB2YUV_I420)
            y, u, v = np.split(i420.reshape(-1), [width * height, width * height * 5 // 4])
            planes = (y.reshape(height, width), np.stack((u, v), -1).reshape(height // 2, width))
            plain.append(Gst.Buffer.new_wrapped(b"".join(p.tobytes() for p in planes)))
            memory = np.full(offset[1] + stride[1] * 128, 0xEE, np.uint8)
            for p, s, o in zip(planes, stride, offset):
                memory[o:o + s * len(p)].reshape(len(p), s)[:, :width] = p
            padded.append(Gst.Buffer.new_wrapped(memory.tobytes()))
            GstVideo.buffer_add_video_meta_full(padded[-1], GstVideo.VideoFrameFlags.NONE,
                                                GstVideo.VideoFormat.NV12, width, height, 2,
                                                [*offset, 0, 0], [*stride, 0, 0])
            for buffer in plain[-1], padded[-1]:
                buffer.pts, buffer.duration = t * harness.FRAME, harness.FRAME
        lines = []
        for feed in plain, padded:
            path = self.tmp / f"{len(lines)}.jsonl"
            harness.play(f"appsrc name=in ! csdtrack points={POINTS} ! csdtrackenc ! filesink "
                         f"location={path}", feed,
                         f"video/x-raw,format=NV12,width={width},height={height},framerate=25/1")
            lines.append(harness.read_lines(path))
        self.assertEqual(len(lines[0]), frames)
        for one, other in zip(*lines):
            self.assertEqual(one["features"], other["features"])


class Fields(harness.Case):
    """A scene that moves by a pixel a field. A frame's positions are those of its first field in
    time."""

    FRAMES = 20

    @staticmethod
    def motion(field):
        return field, field

    def interlaced(self, scene, top_first):
        """Interlaced frames: their two fields are half a frame apart in time."""
        for t in range(self.FRAMES):
            first, second = scene.picture(2 * t), scene.picture(2 * t + 1)
            frame = np.array(second)
            parity = 0 if top_first else 1
            frame[parity::2] = first[parity::2]
            yield cv2.cvtColor(np.ascontiguousarray(frame), cv2.COLOR_RGB2GRAY)

    def scene(self):
        # Smooth enough that a field, which has every other line, still shows it.
        return Scene(motion=self.motion, sigma=4)

    def lines(self, source, properties="", feed=None, caps=None):
        path = self.tmp / "tracks.jsonl"
        harness.play(f"{source} ! csdtrack algorithm=lk {properties} ! csdtrackenc ! filesink "
                     f"location={path}", feed, caps)
        lines = harness.read_lines(path)
        harness.check_tracks(self, lines, self.FRAMES)
        return lines

    def check(self, lines):
        found = errors(lines, lambda t: self.motion(2 * t))
        self.assertEqual(len(found), self.FRAMES * len(STARTS), "nothing is lost")
        # Taking the wrong field first would be 1 px late in x and y: far above half a pixel.
        self.assertLess(max(found), 0.5)

    def test_the_field_order_in_caps_and_flags_is_used(self):
        size = "video/x-raw,format=GRAY8,width=320,height=240,framerate=25/1"
        for top_first in (True, False):
            order = "top" if top_first else "bottom"
            with self.subTest(f"{order} field first, by caps"):
                self.check(self.lines(
                    "appsrc name=in", f"points={POINTS}",
                    harness.buffers(self.interlaced(self.scene(), top_first)),
                    f"{size},interlace-mode=interleaved,field-order={order}-field-first"))
            with self.subTest(f"{order} field first, by flags"):
                def flagged(top_first=top_first):
                    for buffer in harness.buffers(self.interlaced(self.scene(), top_first)):
                        # INTERLACED and TFF of GstVideoBufferFlags.
                        buffer.set_flags(
                            Gst.BufferFlags((1 << 20) | ((1 << 21) if top_first else 0)))
                        yield buffer

                self.check(self.lines("appsrc name=in", f"points={POINTS}", flagged(),
                                      f"{size},interlace-mode=mixed"))

    def test_the_field_order_in_a_file_is_used(self):
        for order in ("tff", "bff"):
            with self.subTest(order):
                pictures = (cv2.cvtColor(p, cv2.COLOR_GRAY2RGB)
                            for p in self.interlaced(self.scene(), order == "tff"))
                video = harness.encode(self.tmp / f"{order}.mkv", pictures, "-vf",
                                       f"setfield={order},format=yuv420p", "-c:v", "libx264",
                                       "-crf", "12", "-threads", "1", "-flags", "+ildct+ilme",
                                       "-x264opts", f"{order}=1")
                self.check(self.lines(f"filesrc location={video} ! decodebin", f"points={POINTS}"))

    def test_detection_gives_rows_of_the_frame(self):
        # Blobs at known rows. One field tells a row to ±1, the median of 30 blobs far better.
        # Ignoring the field's parity would be off by 1 row.
        rng = np.random.default_rng(3)
        centres = [(x + float(rng.uniform(-4, 4)), y + float(rng.uniform(-4, 4)))
                   for y in range(30, 220, 40) for x in range(30, 300, 40)]
        ys, xs = np.mgrid[0:240, 0:320]
        still = np.full((240, 320), 60.0)
        for x, y in centres:
            still += 150 * np.exp(-((xs - x) ** 2 + (ys - y) ** 2) / (2 * 4.0 ** 2))
        still = np.round(still).astype(np.uint8)
        for order in ("top", "bottom"):
            with self.subTest(order):
                lines = self.lines("appsrc name=in", "max-features=200",
                                   harness.buffers([still] * self.FRAMES),
                                   "video/x-raw,format=GRAY8,width=320,height=240,framerate=25/1,"
                                   f"interlace-mode=interleaved,field-order={order}-field-first")
                away = []
                for f in lines[0]["features"]:
                    x, y = min(centres, key=lambda c: np.hypot(c[0] - f["x"], c[1] - f["y"]))
                    # At the blob's centre, not a corner on its slope.
                    if np.hypot(x - f["x"], y - f["y"]) < 3:
                        away.append(f["y"] - y)
                self.assertGreaterEqual(len(away), 15)
                self.assertLess(abs(statistics.median(away)), 0.6)


if __name__ == "__main__":
    harness.main()
