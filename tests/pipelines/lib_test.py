#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Parts of pipelines/lib that can't be tested through the commands."""

import errno
import os
import pathlib
import shutil
import subprocess
import time
import unittest.mock

import harness
from gi.repository import GLib
from harness import Gst
from pipelines.lib import (archive_index, command, counts, failure, klv, properties, runner,
                           video_errors)


class Lib(harness.Case):
    def test_errors_of_filesink_are_explained(self):
        def error(code, text="Error while writing to file \"x\"."):
            return GLib.Error.new_literal(Gst.ResourceError.quark(), text, code)

        full = "can't write into 'a  b' (the disk is full): make room or give another place"
        for given, debug, kind, text in (
                (error(Gst.ResourceError.NO_SPACE_LEFT), None, failure.Full, full),
                (error(Gst.ResourceError.WRITE), f"system error: {os.strerror(errno.EDQUOT)}",
                 failure.Full, full),
                (error(Gst.ResourceError.WRITE), None, failure.Failure,
                 "can't write into 'a  b' (Error while writing to file \"x\"): give another "
                 "place")):
            found = failure.of_filesink("a  b", given, debug)
            self.assertEqual((type(found), str(found)), (kind, text))
            self.assertEqual(video_errors.explain("video", "a  b", "csdtrack", "filesink", given,
                                                  debug or "", []), text)

    def test_one_frame_is_one_frame(self):
        run = harness.play("videotestsrc num-buffers=1 ! csdtrack name=track ! fakesink")
        with unittest.mock.patch("pipelines.lib.command.print_line") as said:
            runner.print_cost(run.element("track"))
        self.assertRegex(said.call_args.args[0], "^1 frame; ")
        self.assertEqual(counts.missing_lines(pathlib.Path("/none"), 1), "'/none' is gone")
        path = self.tmp / "empty.jsonl"
        path.write_text("")
        self.assertEqual(counts.missing_lines(path, 1), f"'{path}' holds 0 lines of 1 frame")
        self.assertEqual(counts.missing_lines(path, 1, in_flight=1), "")
        self.assertEqual(counts.missing_lines(path, 2, in_flight=1),
                         f"'{path}' holds 0 lines of 2 frames")

    def test_what_came_to_a_file_is_in_it_before_the_pipeline_stops(self):
        path, bytes_each = self.tmp / "file", 200
        run = runner.Run("x", "audiotestsrc is-live=true samplesperbuffer=100 ! "
                         "audio/x-raw,format=S16LE,channels=1,rate=44100 ! queue ! "
                         f"{command.line_sink(path)}", counted=())
        run.watch_lines(run.element("file"), path)
        run.pipeline.set_state(Gst.State.PLAYING)
        try:
            while run.lines("file") < 20:
                time.sleep(0.01)
            run._hold_lines()
            came = run.lines("file")
            self.assertEqual(path.stat().st_size, came * bytes_each)
            time.sleep(0.2)
            self.assertEqual((run.lines("file"), path.stat().st_size), (came, came * bytes_each))
        finally:
            run.pipeline.set_state(Gst.State.NULL)

    def test_only_complete_klv_gives_lines(self):
        def packet(number, left, value):
            length = len(value).to_bytes(3, "big")
            key = bytes.fromhex("060e2b34010101010f6373647472")
            return key + bytes([number, left, 0x83]) + length + value

        foreign = bytes.fromhex("060e2b34020b01010e01030101000000") + b"\x03abc"
        line = b'{"schema":1,"source":"%d","features":[]}'
        a, b = (packet(0, 0, line % n) for n in (1, 2))
        first, second, third = (packet(7, left, value) for left, value in (
            (2, b'{"schema":1,"features":[{"id":0},'), (1, b'{"id":1},'), (0, b'{"id":2}]}')))
        joined = b'{"schema":1,"features":[{"id":0},{"id":1},{"id":2}]}\n'
        for packets, lines in (([a, b], [line % 1 + b"\n", line % 2 + b"\n"]),
                               ([foreign + a + foreign, foreign], [line % 1 + b"\n"]),
                               ([first, second, third, a], [joined, line % 1 + b"\n"]),
                               ([first + second + third], [joined]),
                               ([first, third, a], [line % 1 + b"\n"]),
                               ([second, third, a], [line % 1 + b"\n"]),
                               ([first, a, second, third], [line % 1 + b"\n"]),
                               ([first[:-3], second, third, a], [line % 1 + b"\n"]),
                               ([a[:16], a[:15], a[:20], b], [line % 2 + b"\n"])):
            reader = klv.Lines()
            self.assertEqual([found for each in packets for found in reader.take(each)], lines)

    def test_a_property_set_from_its_text_is_the_same(self):
        one, other = (Gst.ElementFactory.make("csdtrack") for _ in range(2))
        for name, text in {"points": 'a "b" c;\nü', "region": "10,20,100,80", "overlay": "draw",
                           "attach-meta": "false", "attach-roi": "true", "max-features": "7",
                           "forget-after": str(2**63 - 1)}.items():
            properties.set_from_text(one, name, text)
            self.assertEqual(properties.as_text(one, name), text)
        for name in properties.settable(one):
            properties.set_from_text(other, name, properties.as_text(one, name))
            self.assertEqual(other.get_property(name), one.get_property(name), name)

    def test_every_command_refuses_names_that_are_no_utf_8(self):
        """Before it does anything: as a source, as a file or folder to write, in a property."""
        tmp = self.tmp / "names"
        tmp.mkdir()
        video, bad = harness.scene_video(tmp / "video.mkv", 10), os.fsencode(tmp) + b"/b\xe9d"
        pipelines = pathlib.Path(__file__).resolve().parents[2] / "pipelines"
        shutil.copy(video, bad)
        new = bad + b".new"
        for name, *arguments in (
                ("record", bad, tmp / "out"), ("record", video, new),
                ("record", "--tracks", new, video, tmp / "out"), ("live", bad),
                ("live", "--tracks", new, video), ("review", bad), ("review", video, bad),
                ("stereo", video, bad, tmp / "out"), ("stereo", video, video, new), ("stream", bad),
                ("stream", "--tracks", new, video), ("receive", "srt://127.0.0.1:1", new),
                ("latency", "--set", b"points=\xe9"), ("archive", bad, tmp / "out"),
                ("archive", tmp, new), ("archive", "--list", new)):
            with self.subTest(name, arguments=arguments):
                done = subprocess.run([pipelines / name, "--no-install", *arguments],
                                      capture_output=True, text=True, timeout=60,
                                      env={**os.environ, "CSDTRACK_BUILD": "/dev/null"})
                self.check_refused(done, 2, "\\xe9")
                self.assertRegex(done.stderr, f"^{name}: '.*' is no UTF-8, .*: rename it\n$")
                self.assertEqual(set(os.listdir(os.fsencode(tmp))), {b"video.mkv", b"b\xe9d"})

    def test_a_file_that_is_replaced_follows_no_link(self):
        path, other = self.tmp / "plan.json", self.tmp / "other"
        other.write_text("other")
        known = self.tmp / f".plan.json.{os.uname().nodename}-{os.getpid()}.unfinished"
        known.symlink_to(other)
        archive_index.write_atomically(path, "ü")
        self.assertEqual((path.read_text(encoding="utf-8"), path.is_symlink(), other.read_text()),
                         ("ü", False, "other"))
        # The permissions are as of any new file.
        self.assertEqual(path.stat().st_mode, other.stat().st_mode)
        # Nor does it follow a link at the temporary name, if somebody guesses that.
        known.rename(self.tmp / f".plan.json.guess.{os.uname().nodename}-{os.getpid()}.unfinished")
        with (unittest.mock.patch("secrets.token_hex", return_value="guess"),
              self.assertRaises(FileExistsError)):
            archive_index.write_atomically(path, "new")
        self.assertEqual((path.read_text(encoding="utf-8"), other.read_text()), ("ü", "other"))


if __name__ == "__main__":
    harness.main()
