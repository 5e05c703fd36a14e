#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks inside a recording, as a text track in Matroska: ffmpeg extracts the same lines, also from
a recording in parts, and the video beside them is not changed."""

import json
import pathlib
import re
import subprocess

import harness

FRAMES = 90
WIDE = "queue max-size-time=5000000000 max-size-buffers=0 max-size-bytes=0"
# With these settings x264 gives the same bytes on every run.
X264 = "x264enc threads=1 pass=quant quantizer=24 speed-preset=veryfast key-int-max=25"


def output(*command):
    return subprocess.run(list(map(str, command)), check=True, capture_output=True).stdout


def streams(file):
    return json.loads(output("ffprobe", "-v", "error", "-show_streams", "-count_packets", "-of",
                             "json", file))["streams"]


def lines(file):
    return output("ffmpeg", "-v", "error", "-i", file, "-map", "0:s", "-c", "copy", "-f", "data",
                  "-")


def video(file):
    return output("ffmpeg", "-v", "error", "-i", file, "-map", "0:v", "-c", "copy", "-f", "h264",
                  "-")


class Matroska(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        video = harness.scene_video(cls.tmp / "in.mkv", FRAMES, *harness.H264)
        cls.source = f"filesrc location={video} ! decodebin"
        cls.recording, cls.sidecar = cls.tmp / "out.mkv", cls.tmp / "out.jsonl"
        cls.record(X264, cls.recording, cls.sidecar)

    @classmethod
    def record(cls, encoder, recording, sidecar, source=None):
        harness.Run(f"{source or cls.source} ! csdtrack ! tee name=t matroskamux name=m ! filesink "
                    f"location={recording} t. ! queue ! {encoder} ! h264parse ! m. t. ! "
                    f"csdtrackenc ! {WIDE} ! m.subtitle_0 t. ! csdtrackenc ! {WIDE} ! filesink "
                    f"location={sidecar}").to_end()

    def test_the_lines_come_out_byte_for_byte(self):
        expected = self.sidecar.read_bytes()
        self.assertEqual(expected.count(b"\n"), FRAMES)
        self.assertIn(b'"id":', expected)
        self.assertEqual(lines(self.recording), expected.replace(b"\n", b""))

    def test_the_lines_come_out_beside_an_encoder_with_look_ahead(self):
        recording, sidecar = self.tmp / "late.mkv", self.tmp / "late.jsonl"
        self.record("x264enc", recording, sidecar)
        self.assertEqual(lines(recording), sidecar.read_bytes().replace(b"\n", b""))

    def test_the_lines_come_out_beside_a_decoder_that_asks_twice_for_memory(self):
        """avdec_h264 does so after some frames where the width is no multiple of 16."""
        odd = harness.scene_video(self.tmp / "odd.mkv", FRAMES, *harness.H264, width=360,
                                  height=288)
        recording, sidecar = self.tmp / "asked.mkv", self.tmp / "asked.jsonl"
        self.record("x264enc", recording, sidecar, f"filesrc location={odd} ! decodebin")
        self.assertEqual(lines(recording), sidecar.read_bytes().replace(b"\n", b""))

    def test_the_text_track_has_its_title_and_language(self):
        for source in (self.recording, self.untagged()):
            _, text = streams(source)
            tags = {name.lower(): value for name, value in text["tags"].items()}
            self.assertEqual((text["codec_type"], tags["title"], tags["language"]),
                             ("subtitle", "csdtrack", "zxx"))

    def untagged(self):
        """A recording of a source that sends no tags."""
        file = self.tmp / "untagged.mkv"
        harness.Run("csdsimsrc num-buffers=20 ! video/x-raw,format=I420,width=160,height=120 ! "
                    f"csdtrack ! tee name=t matroskamux name=m ! filesink location={file} t. ! "
                    f"queue ! {X264} ! h264parse ! m. t. ! csdtrackenc ! {WIDE} ! "
                    "m.subtitle_0").to_end()
        return file

    def test_the_video_is_the_same_without_csdtrack(self):
        plain = self.tmp / "plain.mkv"
        harness.Run(f"{self.source} ! {X264} ! h264parse ! matroskamux ! filesink "
                    f"location={plain}").to_end()
        self.assertEqual(video(self.recording), video(plain))

    def test_the_default_flag_can_be_cleared(self):
        cleared = self.tmp / "cleared.mkv"
        self.assertEqual(streams(self.recording)[1]["disposition"]["default"], 1)
        output("ffmpeg", "-v", "error", "-i", self.recording, "-map", "0", "-c", "copy",
               "-disposition:s:0", "0", cleared)
        self.assertEqual(streams(cleared)[1]["disposition"]["default"], 0)
        self.assertEqual(lines(cleared), lines(self.recording))

    def test_a_recording_in_parts_has_all_lines(self):
        sidecar = self.tmp / "parts.jsonl"
        harness.Run(f"{self.source} ! csdtrack ! tee name=t splitmuxsink name=m "
                    "muxer-factory=matroskamux max-size-time=1000000000 "
                    f"location={self.tmp}/part%05d.mkv t. ! queue ! {X264} ! h264parse ! m.video "
                    f"t. ! csdtrackenc ! {WIDE} ! m.subtitle_0 t. ! csdtrackenc ! {WIDE} ! "
                    f"filesink location={sidecar}").to_end()
        parts = sorted(self.tmp.glob("part*.mkv"))
        self.assertEqual(len(parts), -(-FRAMES // 25))
        for part in parts:
            shown, text = streams(part)
            self.assertEqual(shown["nb_read_packets"], text["nb_read_packets"])
        self.assertEqual(b"".join(map(lines, parts)), sidecar.read_bytes().replace(b"\n", b""))

    def test_the_line_of_the_docs_for_parts(self):
        page = (pathlib.Path(__file__).resolve().parents[2] / "docs" / "metadata.md").read_text()
        line, = re.findall(r"^    gst-launch-1\.0 -e (.*splitmuxsink[^`]*?subtitle_0)$", page,
                           re.M | re.S)
        self.assertEqual(line.count("location=X"), 1)
        folder = self.tmp / "documented"
        folder.mkdir()
        harness.Run(line.replace("\\\n", " ").replace("%05d", f"{folder}/%05d").replace(
            "location=X", f"location={self.tmp / 'in.mkv'}")).to_end()
        shown, text = streams(folder / "00000.mkv")
        self.assertEqual((int(shown["nb_read_packets"]), int(text["nb_read_packets"])),
                         (FRAMES, FRAMES))


if __name__ == "__main__":
    harness.main()
