#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks in MPEG-TS, as KLV: from files, HLS and RTP, extracted with ffmpeg, from the middle of a
stream, and with losses."""

import json
import pathlib
import random
import re
import subprocess

import harness
from harness import Gst

FRAMES = 75
PACKET = 188  # bytes, of a transport stream
WIDE = "queue max-size-time=5000000000 max-size-buffers=0 max-size-bytes=0"
SIMULATED = (f"csdsimsrc num-buffers={FRAMES} ! "
             "video/x-raw,format=I420,width=320,height=240,framerate=25/1 ! csdtrack "
             "name=csdtrack0 algorithm=lk max-features=20")
PAGE = (pathlib.Path(__file__).resolve().parents[2] / "docs" / "metadata.md").read_text()


def output(*command, **options):
    return subprocess.run(list(map(str, command)), check=True, capture_output=True,
                          **options).stdout


def streams(file):
    return json.loads(output("ffprobe", "-v", "error", "-show_streams", "-count_packets", "-of",
                             "json", file))["streams"]


def read_klv(data):
    """The lines, as the program in docs/metadata.md reads them."""
    program, = re.findall(r"```python\n(def lines_of_klv.*?)```", PAGE, re.S)
    names = {}
    exec(program, names)
    return b"".join(line + b"\n" for line in names["lines_of_klv"](data))


def extracted(file):
    return output("ffmpeg", "-v", "error", "-i", file, "-map", "0:d", "-c", "copy", "-f", "data",
                  "-")


def tracks(line):
    """What a line says, without the frame's times: the stream counts them from another start."""
    return {name: value for name, value in json.loads(line).items()
            if name not in ("pts", "running_time", "stream_time", "duration")}


class MpegTs(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.recording, cls.sidecar = cls.tmp / "out.ts", cls.tmp / "out.jsonl"
        cls.record("x264enc key-int-max=25", f"filesink location={cls.recording}", cls.sidecar)
        cls.sent = cls.sidecar.read_bytes().splitlines()

    @classmethod
    def record(cls, encoder, sink, sidecar):
        harness.Run(f"{SIMULATED} ! tee name=t mpegtsmux name=m ! {sink} t. ! queue ! {encoder} ! "
                    f"h264parse config-interval=-1 ! m. t. ! csdtrackenc ! {WIDE} ! m. t. ! "
                    f"csdtrackenc ! {WIDE} ! filesink location={sidecar}").to_end()

    def back(self, source, demuxer="tsdemux"):
        """Plays a recording with csdtrackdec. Returns the lines that it put on frames, and the
        warnings."""
        second = self.tmp / "back.jsonl"
        done = harness.Run(f"{source} ! {demuxer} name=d csdtrackdec name=r max-wait=3600000000000 "
                           f"! csdtrackenc ! filesink location={second} d. ! queue ! h264parse ! "
                           "avdec_h264 max-threads=1 ! videoconvert ! video/x-raw,format=I420 ! "
                           "r.sink d. ! meta/x-klv ! queue ! r.text").to_end()
        return second.read_bytes().splitlines(), [text for _, text in done.warnings
                                                  if "CONTINUITY" not in text]

    def check_frames(self, lines, first=0):
        """Checks that the lines are those of consecutive frames."""
        self.assertEqual(list(map(tracks, lines)),
                         list(map(tracks, self.sent[first:first + len(lines)])))

    def test_every_line_comes_back_on_its_frame(self):
        self.assertEqual(len(self.sent), FRAMES)
        self.assertIn(b'"id":', self.sent[0])
        for encoder in "x264enc key-int-max=25", "x264enc tune=zerolatency key-int-max=25":
            with self.subTest(encoder):
                recording, sidecar = self.tmp / "again.ts", self.tmp / "again.jsonl"
                self.record(encoder, f"filesink location={recording}", sidecar)
                self.assertEqual(sidecar.read_bytes(), self.sidecar.read_bytes())
                lines, warnings = self.back(f"filesrc location={recording}")
                self.assertEqual((len(lines), warnings), (FRAMES, []))
                self.check_frames(lines)

    def test_ffprobe_sees_a_klv_stream(self):
        video, data = streams(self.recording)
        self.assertEqual((data["codec_type"], data["codec_name"], data["codec_tag_string"]),
                         ("data", "klv", "KLVA"))
        self.assertEqual((video["nb_read_packets"], data["nb_read_packets"]),
                         (str(FRAMES), str(FRAMES)))
        self.assertEqual(read_klv(extracted(self.recording)), self.sidecar.read_bytes())

    def test_a_copy_by_ffmpeg_keeps_the_lines_but_not_their_times(self):
        copy = self.tmp / "copy.ts"
        output("ffmpeg", "-v", "error", "-y", "-i", self.recording, "-map", "0", "-c", "copy", copy)
        self.assertEqual([stream["codec_name"] for stream in streams(copy)], ["h264", "klv"])
        self.assertEqual(extracted(copy), extracted(self.recording))
        # Without the times nobody can tell which frame a line belongs to, so frames get no line
        # rather than a wrong one.
        lines, warnings = self.back(f"filesrc location={copy}")
        self.assertEqual((len(lines), {tracks(line)["frame"] for line in lines}), (FRAMES, {None}))
        self.assertRegex(warnings[0], "broke off in line 1")

    def test_extracted_lines_are_matched_by_their_own_times(self):
        file, second = self.tmp / "out.klv", self.tmp / "second.jsonl"
        file.write_bytes(extracted(self.recording))
        harness.Run(f"csdtrackdec name=r ! csdtrackenc ! filesink location={second} csdsimsrc "
                    f"num-buffers={FRAMES} ! "
                    "video/x-raw,format=I420,width=320,height=240,framerate=25/1 ! queue ! r.sink "
                    f"filesrc location={file} ! meta/x-klv ! queue ! r.text").to_end()
        self.assertEqual(second.read_bytes(), self.sidecar.read_bytes())

    def test_a_stream_from_its_middle_on(self):
        data = self.recording.read_bytes()
        middle = self.tmp / "middle.ts"
        for begin in len(data) // 5, len(data) // 2:  # not at the start of a packet
            with self.subTest(begin):
                middle.write_bytes(data[begin:])
                lines, warnings = self.back(f"filesrc location={middle} ! queue")
                self.assertEqual(warnings, [])
                self.assertGreaterEqual(len(lines), 25)
                self.assertEqual(len(lines) % 25, 0)  # from a key frame on
                self.check_frames(lines, FRAMES - len(lines))

    def test_a_lost_packet_costs_one_line(self):
        """About every 40th packet of the tracks is missing."""
        data = self.recording.read_bytes()
        packets = [data[at:at + PACKET] for at in range(0, len(data), PACKET)]
        pid = int(streams(self.recording)[1]["id"], 16)
        lossy = self.tmp / "lossy.ts"
        for seed in range(3):
            with self.subTest(seed):
                chance = random.Random(seed)
                lossy.write_bytes(b"".join(p for p in packets if (p[1] & 31) << 8 | p[2] != pid or
                                           chance.random() < 39 / 40))
                lines, warnings = self.back(f"filesrc location={lossy}")
                self.assertEqual(len(lines), FRAMES)
                whole = [n for n, line in enumerate(lines) if json.loads(line)["frame"] is not None]
                self.assertEqual([tracks(lines[n]) for n in whole],
                                 [tracks(self.sent[n]) for n in whole])
                self.assertTrue(FRAMES // 4 < len(whole) < FRAMES, whole)
                self.assertTrue(all("broke off" in text for text in warnings), warnings)

    def test_segments_of_hls(self):
        folder = self.tmp / "hls"
        folder.mkdir()
        self.record("x264enc tune=zerolatency key-int-max=25",
                    f"hlssink location={folder}/%05d.ts playlist-location={folder}/list.m3u8 "
                    "target-duration=1 max-files=0 playlist-length=0", self.tmp / "hls.jsonl")
        lines, warnings = self.back(f"filesrc location={folder}/list.m3u8 ! hlsdemux")
        self.assertEqual((len(lines), warnings), (FRAMES, []))
        self.check_frames(lines)
        parts = sorted(folder.glob("*.ts"))
        self.assertEqual(len(parts), 3)
        for number, part in enumerate(parts):
            lines, warnings = self.back(f"filesrc location={part}")
            self.assertEqual((len(lines), warnings), (25, []))
            self.check_frames(lines, 25 * number)

    def test_rtp_with_and_without_losses(self):
        for every in None, 11:  # which packet is lost
            with self.subTest(every):
                second, count = self.tmp / "rtp.jsonl", 0

                def lose(_pad, _info):
                    nonlocal count
                    count += 1
                    return (Gst.PadProbeReturn.DROP if every and
                            count % every == 0 else Gst.PadProbeReturn.OK)

                run = harness.Run(f"{SIMULATED} ! csdtrackenc ! {WIDE} ! rtpklvpay ! identity "
                                  f"name=sent ! rtpklvdepay ! {WIDE} ! r.text csdsimsrc "
                                  f"num-buffers={FRAMES} ! "
                                  "video/x-raw,format=I420,width=320,height=240,framerate=25/1 ! "
                                  "queue ! r.sink csdtrackdec name=r max-wait=3600000000000 ! "
                                  f"csdtrackenc ! filesink location={second}")
                run.element("sent").get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER, lose)
                run.to_end()
                self.assertGreater(count, FRAMES)
                lines = second.read_bytes().splitlines()
                whole = [n for n, line in enumerate(lines) if json.loads(line)["frame"] is not None]
                self.assertEqual(len(lines), FRAMES)
                self.assertEqual([lines[n] for n in whole], [self.sent[n] for n in whole])
                self.assertTrue(0 < len(whole) < FRAMES if every else len(whole) == FRAMES, whole)

    def test_the_line_of_the_docs(self):
        lines = re.findall(r"^    gst-launch-1\.0 (.*?mpegtsmux(?:.*\\\n)*.*)$", PAGE, re.M)
        line, = (line for line in lines if "srtsink" not in line)
        file = self.tmp / "documented.ts"
        source = harness.scene_video(self.tmp / "in.mkv", 30, *harness.H264)
        self.assertEqual((line.count("location=X"), line.count("out.ts")), (1, 1))
        line = line.replace("\\\n", " ").replace("out.ts", str(file))
        harness.Run(line.replace("location=X", f"location={source}")).to_end()
        self.assertEqual([stream["nb_read_packets"] for stream in streams(file)], ["30", "30"])
        self.assertEqual(read_klv(extracted(file)).count(b"\n"), 30)


if __name__ == "__main__":
    harness.main()
