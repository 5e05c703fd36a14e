#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Videos as other recorders and archives leave them: a line and a packet for each frame.
strangers_test.py REPOSITORY BUILD. docs/results/strangers.md has the table of what was tried."""

import json
import os
import pathlib
import re
import subprocess
import sys

import harness

REPOSITORY, BUILD = map(pathlib.Path, sys.argv[1:3])
FRAMES = 12
H264 = ("-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt", "yuv420p")
TRACKER = ("--set", "algorithm=lk", "--set", "max-features=5")


def picture(size="160x120", rate="25"):
    return ("-f", "lavfi", "-i", f"testsrc2=size={size}:rate={rate}")


def soft_telecine(data):
    """MPEG-2 with flags for 2:3 pulldown: every second picture is shown for three fields."""
    data, order, marked = bytearray(data), 0, 0
    for start in re.finditer(rb"\x00\x00\x01[\x00\xb5]", bytes(data)):
        at = start.end()
        if data[at - 1] == 0:  # picture_header: temporal_reference, the place in display order
            order = data[at] << 2 | data[at + 1] >> 6
        elif data[at] >> 4 == 1:  # sequence_extension
            data[at + 1] &= ~8  # progressive_sequence
        elif data[at] >> 4 == 8:  # picture_coding_extension
            top, repeated = ((1, 1), (0, 0), (0, 1), (1, 0))[order % 4]
            data[at + 3] = data[at + 3] & 0x7d | top << 7 | repeated << 1
            data[at + 4] |= 0x80  # progressive_frame
            marked += 1
    assert marked == FRAMES, marked
    return bytes(data)


class Strangers(harness.Case):

    def make(self, name, *arguments, frames=FRAMES):
        subprocess.run(["ffmpeg", "-nostdin", "-v", "error", "-y", *map(str, arguments),
                        "-frames:v", str(frames), str(self.tmp / name)], check=True)
        return self.tmp / name

    def run_command(self, name, *arguments, **environment):
        return subprocess.run([REPOSITORY / "pipelines" / name, "--no-install",
                               *map(str, arguments)], capture_output=True, text=True, cwd=self.tmp,
                              stdin=subprocess.DEVNULL, timeout=120,
                              env=dict(os.environ, CSDTRACK_BUILD=str(BUILD), **environment))

    def check_file(self, video, tracks, frames):
        lines = harness.read_lines(tracks)
        self.assertEqual((len(lines), harness.decoded_frames(video)), (frames, frames))
        times = [line["pts"] for line in lines]
        self.assertEqual(times, sorted(set(times)), "times rise")

    def check_recorded(self, source, frames=FRAMES, count=True):
        """`count`: whether ffmpeg finds the frames in the source, too."""
        with self.subTest(source.name):
            if count:
                self.assertEqual(harness.decoded_frames(source), frames)
            out = self.tmp / f"of {source.name}"
            done = self.run_command("record", *TRACKER, "--", source, out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(sorted(path.name for path in out.iterdir()),
                             ["00000.jsonl", "00000.mkv"])
            self.check_file(out / "00000.mkv", out / "00000.jsonl", frames)

    def test_streams_from_dicom(self):
        """They have no container, and a byte of zero makes their length even."""
        for name, encoder in ("dicom.m2v", ("-c:v", "mpeg2video", "-bf", "2")), ("dicom.264", H264):
            stream = self.make(name, *picture(), *encoder)
            stream.write_bytes(stream.read_bytes() + b"\0")
            self.check_recorded(stream)

    def test_interlaced_and_telecined(self):
        self.check_recorded(self.make(
            "interlaced.mkv", *picture("320x240", "50"), "-vf", "interlace", *H264, "-flags",
            "+ilme+ildct", "-x264-params", "tff=1"))
        soft = self.make("telecine.m2v", *picture(rate="30000/1001"), "-c:v", "mpeg2video", "-bf",
                         "2")
        soft.write_bytes(soft_telecine(soft.read_bytes()))
        self.check_recorded(soft)

    def test_high_dynamic_range(self):
        self.check_recorded(self.make(
            "hdr.mp4", *picture(), "-c:v", "libx265", "-preset", "ultrafast", "-pix_fmt",
            "yuv420p10le", "-color_primaries", "bt2020", "-colorspace", "bt2020nc", "-color_trc",
            "smpte2084", "-x265-params", "log-level=none"))

    def test_clocks(self):
        """A transport stream's clock of 33 bits starts again after 26.5 hours; a camera's is set a
        day forward or back."""
        stream = (*picture(), *H264, "-bf", "0", "-muxdelay", "0")
        self.check_recorded(self.make("wraps.ts", *stream, "-output_ts_offset", "95442.7",
                                      frames=36), 36)
        now = self.make("now.ts", *stream).read_bytes()
        later = self.make("later.ts", *stream, "-output_ts_offset", "86400").read_bytes()
        for name, data in ("forward.ts", now + later), ("back.ts", later + now):
            (self.tmp / name).write_bytes(data)
            self.check_recorded(self.tmp / name, 2 * FRAMES, count=False)

    def test_other_tracks(self):
        cover = self.make("cover.jpg", "-f", "lavfi", "-i", "color=red:size=600x600", frames=1)
        self.check_recorded(self.make(
            "cover.mp4", "-i", cover, *picture(), "-map", "0", "-map", "1", *H264, "-c:v:0", "copy",
            "-disposition:v:0", "attached_pic"))
        texts = self.tmp / "texts.srt"
        texts.write_text("1\n00:00:00,000 --> 00:00:00,200\none\n\n", encoding="utf-8")
        self.check_recorded(self.make("texts.mov", "-i", texts, *picture(), "-map", "0", "-map",
                                      "1", *H264, "-c:s", "mov_text", "-timecode", "01:00:00:00"))

    def test_capture_cards(self):
        for name, options in (("v210.avi", ("-c:v", "v210")),
                              ("grey.mkv", ("-c:v", "ffv1", "-pix_fmt", "gray16le"))):
            self.check_recorded(self.make(name, *picture(), *options))

    def test_fragments(self):
        self.check_recorded(self.make(
            "fragments.mp4", *picture(), *H264, "-g", "5", "-movflags",
            "cmaf+frag_keyframe+empty_moov+default_base_moof"))

    def test_names_and_locales(self):
        """One name that starts with a dash and holds what shells, parsers and printf take apart.
        Decimals have a point, whatever the locale."""
        made = self.make("plain.mkv", *picture(), *H264)
        name = "-a 'b' \"c\" ! %05d $HOME *?[x]{y};&\\ü→\n.mkv"
        made.rename(self.tmp / name)
        known = subprocess.run(["locale", "-a"], capture_output=True, text=True).stdout.split()
        comma = next((one for one in known if one.startswith(("de_", "fr_", "tr_"))), "POSIX")
        out = self.tmp / f"out {name}"
        done = self.run_command("quickstart", "--algorithm", "lk", "--points", "80.5,60.25", "--",
                                name, out, LC_ALL=comma)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("no page", done.stderr)
        self.check_file(out / "overlay.mp4", out / "tracks.jsonl", FRAMES)
        self.assertTrue((out / "page" / "index.html").exists())
        row = (out / "tracks.csv").read_text(encoding="utf-8").splitlines()[1]
        self.assertTrue(row.startswith("0,0,0,0,80.500,60.250,"), row)
        point = json.loads((out / "tracks.jsonl").read_text().splitlines()[0])["features"][0]
        self.assertEqual((point["x"], point["y"]), (80.5, 60.25))
        self.check_recorded(self.tmp / name, count=False)


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
