#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""No frame is lost where downstream blocks, the clock jumps, or a reader closes its end."""

import json
import os
import socket
import subprocess
import sys
import threading
import time

import harness
from harness import Gst


class Adverse(harness.Case):
    def live(self, rest, element="csdtrack name=track max-features=5"):
        run = harness.Run("videotestsrc name=source is-live=true pattern=ball ! "
                          "video/x-raw,format=GRAY8,width=160,height=120,framerate=50/1 ! "
                          f"{element} ! {rest}")
        self.addCleanup(run.pipeline.set_state, Gst.State.NULL)
        return run

    def wait_for(self, condition, what):
        end = time.monotonic() + harness.TIMEOUT
        while not condition():
            self.assertLess(time.monotonic(), end, f"{what}: not in {harness.TIMEOUT} s")
            time.sleep(0.01)

    def stop(self, run):
        """Sets the pipeline to NULL, and checks that this does not hang."""
        done = threading.Thread(target=run.pipeline.set_state, args=(Gst.State.NULL,), daemon=True)
        done.start()
        done.join(harness.TIMEOUT)
        self.assertFalse(done.is_alive(), "the pipeline does not stop")

    def test_downstream_blocks_and_continues(self):
        run = self.live("queue max-size-buffers=3 ! fakesink name=out")
        numbers = run.collect("out", lambda buffer: buffer.offset)
        run.pipeline.set_state(Gst.State.PLAYING)
        self.wait_for(lambda: len(numbers) > 10, "frames")
        pad = run.element("out").get_static_pad("sink")
        block = pad.add_probe(Gst.PadProbeType.BLOCK_DOWNSTREAM, lambda *_: Gst.PadProbeReturn.OK)
        time.sleep(1)
        before = len(numbers)
        # csdtrack answers while it is blocked.
        self.assertGreater(run.element("track").get_property("stats").get_value("frames"), 0)
        run.element("track").emit("reset")
        pad.remove_probe(block)
        self.wait_for(lambda: len(numbers) > before + 20, "frames after the block")
        self.stop(run)
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))

    def test_a_pipeline_stops_while_downstream_blocks(self):
        run = self.live("fakesink name=out")
        numbers = run.collect("out", lambda buffer: buffer.offset)
        run.pipeline.set_state(Gst.State.PLAYING)
        self.wait_for(lambda: len(numbers) > 10, "frames")
        run.element("out").get_static_pad("sink").add_probe(
            Gst.PadProbeType.BLOCK_DOWNSTREAM, lambda *_: Gst.PadProbeReturn.OK)
        time.sleep(0.2)
        self.stop(run)

    def test_dropped_frames_cost_no_feature(self):
        """The frame after dropped ones has the flag DISCONT, as after a cut: identity and a leaky
        queue set it."""
        def claimed(dropped):
            tracks = self.tmp / "tracks.jsonl"
            harness.play("csdsimsrc num-buffers=200 seed=7 ! video/x-raw,width=320,height=240 ! "
                         f"identity drop-probability={dropped} ! csdtrack max-features=20 ! "
                         f"csdtrackenc ! filesink location={tracks}")
            states = [feature["state"] for line in harness.read_lines(tracks)
                      for feature in line["features"]]
            return sum(state in harness.CLAIMS for state in states) / len(states)

        whole = claimed(0)
        self.assertGreater(whole, 0.5)
        self.assertGreater(claimed(0.5), 0.8 * whole)

    def test_no_frame_is_lost_when_the_clock_jumps(self):
        run = self.live("fakesink name=out sync=false")
        clock = Gst.SystemClock(clock_type=Gst.ClockType.MONOTONIC, name="jumping")
        run.pipeline.use_clock(clock)
        seen = run.collect("out", lambda buffer: (buffer.offset, buffer.pts))
        run.pipeline.set_state(Gst.State.PLAYING)
        # Seconds. A clock never goes back: after a negative jump it stops until time has caught up.
        for ahead in (3600, -1800, 1):
            count = len(seen)
            self.wait_for(lambda: len(seen) > count + 10, f"frames before a jump by {ahead} s")
            internal, external, rate, per = clock.get_calibration()
            clock.set_calibration(internal, max(0, external + ahead * Gst.SECOND), rate, per)
            time.sleep(0.1)
            if ahead < 0:
                clock.set_calibration(internal, external, rate, per)
        count = len(seen)
        self.wait_for(lambda: len(seen) > count + 10, "frames after the jumps")
        stats = run.element("track").get_property("stats")
        self.stop(run)
        self.assertEqual([number for number, _ in seen], list(range(len(seen))))
        self.assertEqual(stats.get_value("failed-frames"), 0)
        self.assertEqual(run.warnings, [])

    def test_closed_readers_stop_only_their_own_branch(self):
        """The tracks go to a pipe and to a socket, and both readers close. A sink that isolates
        them lets the frames go on."""
        pipe, to_pipe = os.pipe()
        run = self.live("tee name=t t. ! queue ! fakesink name=out t. ! queue ! csdtrackenc ! tee "
                        "name=l l. ! queue leaky=downstream ! appsink name=lines emit-signals=true "
                        "sync=false l. ! queue leaky=downstream ! multifdsink name=pipe")
        numbers = run.collect("out", lambda buffer: buffer.offset)
        lines = []

        def take(sink):
            buffer = sink.emit("pull-sample").get_buffer()
            lines.append(json.loads(buffer.extract_dup(0, buffer.get_size())))
            return Gst.FlowReturn.OK

        run.element("lines").connect("new-sample", take)
        server, client = socket.socketpair()
        run.pipeline.set_state(Gst.State.PLAYING)
        for fd in (to_pipe, server.fileno()):
            run.element("pipe").emit("add", fd)
        self.wait_for(lambda: len(lines) > 10, "lines")
        os.close(pipe)
        client.close()
        count = len(numbers)
        self.wait_for(lambda: len(numbers) > count + 20, "frames after the readers have closed")
        self.stop(run)
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + len(numbers))))
        self.assertEqual([line["frame"] for line in lines], list(range(len(lines))))
        os.close(to_pipe)
        server.close()

    def test_a_decoder_that_hangs_does_not_block_csdsimsrc(self):
        # In a process of its own, which ends while the decoder's thread still runs.
        picture = self.tmp / "hang.jpg"
        # jpegdec of GStreamer 1.22 hangs on these bytes.
        picture.write_bytes(bytes.fromhex("ffd8ffd80000ffe1000861626364ffc40000"))
        program = ("import os, sys, gi; gi.require_version('Gst', '1.0'); "
                   "from gi.repository import Gst; Gst.init(None)\n"
                   "source = Gst.ElementFactory.make('csdsimsrc'); "
                   "source.props.texture = sys.argv[1]\n"
                   "print(source.set_state(Gst.State.PAUSED).value_nick, "
                   "source.set_state(Gst.State.NULL).value_nick, flush=True)\n"
                   "os._exit(0)\n")
        done = subprocess.run([sys.executable, "-c", program, str(picture)], capture_output=True,
                              text=True, timeout=harness.TIMEOUT, check=False)
        self.assertEqual(done.stdout, "failure success\n", done.stderr)


if __name__ == "__main__":
    harness.main()
