#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Times that pipelines/lib/frame_times.py gives to frames, from the times and the moments at which
they come."""

import sys
import unittest.mock

import harness
from harness import Gst
from pipelines.lib import frame_times

MS = 10**6


class FrameTimes(harness.Case):
    def through(self, times, live=False, waits=None, rising=True):
        """The times in ms of frames that come with these, None for none. They come 40 ms apart, or
        after these waits in ms. Every frame must keep its content."""
        pipeline = Gst.parse_launch(
            "appsrc name=in format=time caps=video/x-raw,format=GRAY8,width=16,height=1,"
            "framerate=25/1 ! identity name=first single-segment=true ! "
            "appsink name=out sync=false")
        now = 1
        clock = iter(range(len(times)))

        def moment():
            nonlocal now
            number = next(clock)
            now += (waits[number] if waits else 40) * MS
            return now

        counted = frame_times.FrameTimes(Gst, pipeline.get_by_name("first").get_static_pad("src"),
                                         "test", "frames", lambda: live, rising)
        pipeline.set_state(Gst.State.PLAYING)
        with unittest.mock.patch("time.monotonic_ns", moment), \
                unittest.mock.patch("pipelines.lib.command.print_line") as said:
            for number, time in enumerate(times):
                buffer = Gst.Buffer.new_wrapped(bytes([number % 256]) * 16)
                if time is not None:
                    buffer.pts = round(time * MS)
                pipeline.get_by_name("in").emit("push-buffer", buffer)
            pipeline.get_by_name("in").emit("end-of-stream")
            found = []
            while sample := pipeline.get_by_name("out").emit("pull-sample"):
                buffer = sample.get_buffer()
                self.assertEqual(buffer.extract_dup(0, 16), bytes([len(found) % 256]) * 16)
                found.append(buffer.pts / MS)
        pipeline.set_state(Gst.State.NULL)
        self.assertEqual(counted.frames, len(times))
        self.said = [call.args[0] for call in said.call_args_list]
        return found

    def test_good_times_stay(self):
        for live in False, True:
            self.assertEqual(self.through([0, 40, 80, 5000], live), [0, 40, 80, 5000])
            self.assertEqual(self.said, [])

    def test_missing_times_come_by_the_rate_or_by_arrival(self):
        self.assertEqual(self.through([None] * 4), [0, 40, 80, 120])
        self.assertEqual(self.through([100, None, None, 220]), [100, 140, 180, 220])
        self.assertEqual(self.through([100, None, None], True, [0, 70, 30]), [100, 170, 200])

    def test_a_repeated_time_lies_between_its_neighbours(self):
        self.assertEqual(self.through([0, 40, 40, 120]), [0, 40, 60, 120])
        self.assertEqual(self.through([0, 40, 40, 120], rising=False), [0, 40, 40, 120])

    def test_frames_of_one_time_are_a_frame_apart(self):
        found = self.through([0] * 60)
        self.assertEqual(found[:2], [0, 20])
        self.assertEqual([b - a for a, b in zip(found[1:], found[2:])], [40] * 58)
        self.assertEqual(self.said, [])

    def test_small_steps_back_catch_up(self):
        found = self.through([0, 40, 80, 60, 100, 140, 180, 220, 260])
        self.assertEqual(found, sorted(set(found)))
        self.assertEqual(found[-1], 260)

    def test_times_that_begin_anew_go_on(self):
        self.assertEqual(self.through([5000, 5040, 0, 40, 80]), [5000, 5040, 5080, 5120, 5160])
        self.assertEqual(len(self.said), 1)

    def test_a_live_clock_that_is_set_goes_on(self):
        self.assertEqual(self.through([0, 40, 100040, 100080], True), [0, 40, 80, 120])
        self.assertIn("jump by +100.0 s", self.said[0])

    def test_frames_that_come_in_a_list_are_counted(self):
        """Neither element that frames come from passes lists on."""
        for element in "identity single-segment=true", "csdtrack ! queue":
            pipeline = Gst.parse_launch(
                "appsrc name=in format=time caps=video/x-raw,format=GRAY8,width=64,height=64,"
                f"framerate=25/1 ! {element} name=last ! fakesink sync=false")
            pad = pipeline.get_by_name("last").get_static_pad("src")
            counted = frame_times.FrameTimes(Gst, pad, "test", "frames")
            pipeline.set_state(Gst.State.PLAYING)
            frames = Gst.BufferList.new()
            for time in 0, 0, 80:
                buffer = Gst.Buffer.new_wrapped(bytes(64 * 64))
                buffer.pts = time * MS
                frames.insert(-1, buffer)
            pipeline.get_by_name("in").emit("push-buffer-list", frames)
            pipeline.get_by_name("in").emit("end-of-stream")
            pipeline.get_bus().timed_pop_filtered(60 * Gst.SECOND, Gst.MessageType.EOS)
            pipeline.set_state(Gst.State.NULL)
            self.assertEqual(counted.frames, 3, element)

    def test_a_pause_is_no_jump(self):
        """The frames that waited meanwhile come at once, with their own times."""
        self.assertEqual(self.through([0, 40, 80, 120], True, [0, 40, 12000, 0]), [0, 40, 80, 120])
        self.assertEqual(self.through([0, 40, 12040, 12080], True, [0, 40, 12000, 40]),
                         [0, 40, 12040, 12080])
        self.assertEqual(self.said, [])


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
