#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""pipelines/stream and pipelines/receive: video and tracks over the network, by RTSP and SRT."""

import argparse
import contextlib
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.parse
from unittest import mock

import numpy as np

import harness
from harness import Gst
from pipelines.lib import receive

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
ENVIRONMENT = {**os.environ, "CSDTRACK_BUILD": str(BUILD)}
LEVELS = 12  # of brightness: they code a frame's number modulo this

# A recorder that serves video and sound by RTSP, without tracks. Prints its port.
RECORDER = """
import gi
gi.require_version("Gst", "1.0")
gi.require_version("GstRtspServer", "1.0")
from gi.repository import GLib, Gst, GstRtspServer
Gst.init(None)
server, factory = GstRtspServer.RTSPServer(service="0"), GstRtspServer.RTSPMediaFactory(shared=True)
factory.set_launch("( audiotestsrc is-live=true ! audioconvert ! rtpL16pay name=pay0 pt=96 "
                   "csdsimsrc is-live=true ! video/x-raw,width=320,height=240,framerate=25/1 ! "
                   "x264enc tune=zerolatency key-int-max=10 ! rtph264pay name=pay1 pt=97 )")
server.get_mount_points().add_factory("/live", factory)
server.attach(None)
print(server.get_bound_port(), flush=True)
GLib.MainLoop().run()
"""


def command(name, *arguments):
    return [SOURCE / "pipelines" / name, "--no-install", *map(str, arguments)]


def run(name, *arguments):
    return subprocess.run(command(name, *arguments), capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, timeout=180, env=ENVIRONMENT)


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Relay:
    """Passes bytes on between a receiver and its sender, from a port of its own. It can break the
    connection; with `at_once` it calls that on itself at the receiver's PLAY."""

    def __init__(self, test, to, at_once=None):
        self._to, self._at_once = to, at_once
        self._server = socket.create_server(("127.0.0.1", 0))
        self._client = None
        self.port = self._server.getsockname()[1]
        test.addCleanup(self._server.close)
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):  # the end of the test
            while True:
                self._client = self._server.accept()[0]
                sender = socket.create_connection(("127.0.0.1", self._to))
                threading.Thread(target=self._pass_on, args=(self._client, sender),
                                 daemon=True).start()
                threading.Thread(target=self._pass_on, args=(sender, self._client),
                                 daemon=True).start()

    def _pass_on(self, source, target):
        with contextlib.suppress(OSError):
            while data := source.recv(1 << 16):
                if self._at_once and data.startswith(b"PLAY"):
                    self._at_once(self)
                target.sendall(data)
            source.close()

    def reset(self):
        self._client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self._client.shutdown(socket.SHUT_RD)  # else a reading thread keeps it open
        self._client.close()

    def close(self):
        self._client.shutdown(socket.SHUT_RDWR)


class Describing:
    """An RTSP server that answers DESCRIBE with `session`, and refuses to set it up."""

    def __init__(self, test, session):
        self._session = session
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"rtsp://127.0.0.1:{self._server.getsockname()[1]}/x"
        test.addCleanup(self._server.close)
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        with contextlib.suppress(OSError):  # the end of the test
            while True:
                threading.Thread(target=self._answer, args=(self._server.accept()[0],),
                                 daemon=True).start()

    def _answer(self, client):
        with client, client.makefile("rwb") as wire, contextlib.suppress(OSError):
            while method := wire.readline().split(b" ")[0]:
                headers = dict(line.strip().split(b": ", 1)
                               for line in iter(wire.readline, b"\r\n"))
                described = (b"Content-Type: application/sdp\r\nContent-Length: %d\r\n\r\n%b" %
                             (len(self._session), self._session))
                known = {b"OPTIONS": b"Public: DESCRIBE, SETUP, PLAY, TEARDOWN\r\n\r\n",
                         b"DESCRIBE": described}
                status = b"200 OK" if method in known else b"404 Not Found"
                rest = known.get(method, b"\r\n")
                wire.write(b"RTSP/1.0 %b\r\nCSeq: %b\r\n%b" % (status, headers[b"CSeq"], rest))
                wire.flush()


class Stream(harness.Case):
    def setUp(self):
        self.sent, self.got = self.tmp / "sent.jsonl", self.tmp / "got.jsonl"
        self.got.unlink(missing_ok=True)

    def start(self, *arguments):
        process = subprocess.Popen(list(map(str, arguments)), env=ENVIRONMENT,
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   start_new_session=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def stream(self, *arguments):
        """Starts pipelines/stream. Returns its process and its URL."""
        self.sent.unlink(missing_ok=True)
        process = self.start(*command("stream", "--port", 0, "--tracks", self.sent, *arguments))
        url = process.stdout.readline().strip()
        self.assertRegex(url, r"^rtsp://127\.0\.0\.1:\d+/csdtrack$")
        return process, url

    @staticmethod
    def await_count(process, file, count, wanted=b"\n"):
        harness.await_count(process, file, count, process.stdout.read, wanted)

    def lines_sent(self, sender, newest):
        """What the sender wrote to its file, once `newest` is there: on a busy machine the receiver
        had a line before that file (seen)."""
        self.await_count(sender, self.sent, 1, newest)
        return self.sent.read_bytes()

    def receive(self, lines, *arguments, program="receive"):
        """Runs a receiver until so many lines have come. Returns what it printed."""
        self.got.unlink(missing_ok=True)
        process = self.start(*command(program, *arguments))
        self.await_count(process, self.got, lines)
        if process.poll() is not None:
            self.fail(f"it ended by itself: {process.stdout.read()}")
        os.killpg(process.pid, signal.SIGINT)
        said = process.stdout.read()
        self.assertEqual(process.wait(60), 0, said)
        return said

    def test_closing_the_terminals_ends_both(self):
        self.sent.unlink(missing_ok=True)
        stream = harness.Terminal(
            self, command("stream", "--port", 0, "--tracks", self.sent, "simulate"), ENVIRONMENT)
        url = stream.read().strip()
        receive = harness.Terminal(self, command("receive", url, self.got), ENVIRONMENT)
        receive.await_lines(self.got, 5)
        self.assertEqual(receive.close(), 0)
        self.assertEqual(stream.close(), 0)
        sent = harness.read_lines(self.sent)
        harness.check_tracks(self, sent)
        self.assertGreaterEqual(len(sent), 5)
        self.assertGreaterEqual(len(harness.read_lines(self.got)), 5)

    def test_lines_come_byte_for_byte(self):
        self.check_lines()

    def test_lines_come_byte_for_byte_as_klv(self):
        self.check_lines("--klv")

    def check_lines(self, *form):
        stream, url = self.stream(*form, "simulate:occlusion")
        # Twice: the first session is over when the second begins. The second has a window, for
        # which lines are put back on frames. --latency: on a busy machine the text is more than
        # 200 ms late, and a frame goes on without it (seen).
        for more in ((), ("--display=fakesink",)):
            said = self.receive(30, "--latency", "2000", *form, *more, url, self.got)
            got = self.got.read_bytes().splitlines(keepends=True)
            sent = self.lines_sent(stream, got[-1]).splitlines(keepends=True)
            places = [sent.index(line) for line in got]
            gaps = [place - before for before, place in zip(places, places[1:])
                    if place != before + 1]
            # One gap is allowed: lines between the answer to DESCRIBE, which needs a line, and
            # PLAY.
            self.assertLessEqual(len(gaps), 1, places)
            self.assertTrue(all(gap > 0 for gap in gaps), places)
            self.assertRegex(said, rf"^\d+ frames; {len(got)} lines of tracks came with them( "
                             r"\(at the beginning and the end .*\))?\n$")
        # There was one tracker, which went on while nobody was connected.
        os.killpg(stream.pid, signal.SIGINT)
        self.assertEqual(stream.wait(60), 0)
        harness.check_tracks(self, harness.read_lines(self.sent))

    def test_the_served_video_is_the_same_without_csdtrack(self):
        """Each encoded picture has the same bytes and times with identity in csdtrack's place."""
        program = """
import hashlib, sys
from pipelines.lib import command, runner
plain = sys.argv.pop(1) == "plain"
make = runner.Gst.parse_launch

def seen(_, info):
    buffer = info.get_buffer()
    print(buffer.pts, hashlib.md5(buffer.extract_dup(0, buffer.get_size())).hexdigest())
    return runner.Gst.PadProbeReturn.OK

def parse(text):
    # With more threads, and its buffer model, x264's bytes depend on the load.
    text = text.replace("x264enc", "x264enc threads=1")
    made = make(text.replace("! csdtrack name", "! identity name") if plain else text)
    factory = made.get_by_name("csdtrack").get_factory()
    assert factory.get_name() == ("identity" if plain else "csdtrack")
    made.get_by_name("video").get_static_pad("sink").add_probe(runner.Gst.PadProbeType.BUFFER, seen)
    return made

runner.Gst.parse_launch = parse
if plain:
    runner.configure = runner.print_cost = lambda *_: None
from pipelines.lib import stream
command.run("stream", stream.main)
"""
        video = harness.scene_video(self.tmp / "served.mkv", 50, *harness.H264)
        seen = {}
        for which in ("plain", "tracked"):
            done = harness.run_python(program, which, "--preset", "", "--port", "0", video,
                                      timeout=120, env={**ENVIRONMENT, **harness.SAME_MEMORY})
            self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
            seen[which] = [line for line in done.stdout.splitlines()
                           if len(line.split()) == 2 and len(line.split()[1]) == 32]
        self.assertEqual(len(seen["plain"]), 50)
        self.assertEqual(seen["tracked"], seen["plain"])

    def test_odd_sizes_lose_the_last_row_and_column(self):
        """From any format, as 4:2:0 is served."""
        program = """
from pipelines.lib import command, sources, stream
sources.launch = lambda kind: ("videotestsrc num-buffers=10 ! "
                               f"video/x-raw,format={kind},width=161,height=121")
command.run("stream", stream.main)
"""
        for kind in "I420", "Y444", "P010_10LE":  # videocrop does not take the last
            with self.subTest(kind):
                self.sent.unlink(missing_ok=True)
                done = harness.run_python(program, "--preset", "", "--port", "0", "--tracks",
                                          self.sent, kind, timeout=120, env=ENVIRONMENT)
                self.assertEqual((done.returncode, done.stderr),
                                 (0, f"stream: {kind}: 161×121 is no even size, which H.264 wants: "
                                  "the last column and row are left out\n"))
                self.assertEqual([(line["width"], line["height"])
                                  for line in harness.read_lines(self.sent)], [(160, 120)] * 10)

    def test_a_receiver_waits_for_its_sender(self):
        port = free_port()
        receiver = self.start(*command("receive", "--seconds", 1,
                                       f"rtsp://127.0.0.1:{port}/csdtrack", self.got))
        time.sleep(2)
        self.assertIsNone(receiver.poll())
        self.stream("--port", port, "simulate")
        self.assertEqual(receiver.wait(60), 0)
        self.assertTrue(harness.read_lines(self.got))

    def start_receiver(self, url):
        """Starts a receiver and waits until it has lines and pictures."""
        self.got.unlink(missing_ok=True)
        receiver = self.start(*command("receive", url, self.got))
        self.await_count(receiver, self.got, 26)
        return receiver

    def test_a_sender_that_ends_or_dies_ends_the_receiver(self):
        for how in signal.SIGINT, signal.SIGKILL:
            with self.subTest(how):
                sender, url = self.stream("simulate")
                receiver = self.start_receiver(url)
                os.killpg(sender.pid, how)
                said = receiver.stdout.read()
                # A killed sender with unread data in its socket leaves only a reset.
                if how == signal.SIGKILL and receiver.wait(60):
                    self.assertRegex(said, "^receive: .*: the connection was lost\n$")
                else:
                    self.assertRegex(said, r"^the sender's stream ended\n\d+ frames; .*\n$")
                    self.assertEqual(receiver.wait(60), 0)

    def test_a_lost_connection_is_an_error(self):
        _, url = self.stream("simulate")
        relay = Relay(self, urllib.parse.urlsplit(url).port)
        receiver = self.start_receiver(f"rtsp://127.0.0.1:{relay.port}/csdtrack")
        relay.reset()
        url_of_relay = f"rtsp://127.0.0.1:{relay.port}/csdtrack"
        self.assertEqual(receiver.stdout.read(),
                         f"receive: {url_of_relay}: the connection was lost\n")
        self.assertEqual(receiver.wait(60), 1)
        self.assertTrue(harness.read_lines(self.got))
        self.check_refused(run("receive", f"rtsp://127.0.0.1:{relay.port}/csdtrack", self.got), 2,
                           f"'{self.got}' is there already")
        self.assertTrue(harness.read_lines(self.got))
        self.got.unlink()
        # Before the first picture too the cause is reported, whether it was reset or closed.
        for end in (Relay.reset, Relay.close):
            relay = Relay(self, urllib.parse.urlsplit(url).port, at_once=end)
            done = run("receive", f"rtsp://127.0.0.1:{relay.port}/csdtrack", self.got)
            self.check_refused(done, 1, f"receive: rtsp://127.0.0.1:{relay.port}/csdtrack: ")
            self.assertNotIn("is it connected", done.stderr)

    def test_each_line_has_the_time_of_its_frame(self):
        def picture(number):
            made = scene.picture(number).copy()
            made[:60, :60] = 20 + number % LEVELS * 18
            return made

        scene = harness.Scene()
        video = harness.encode(self.tmp / "numbers.mkv", (picture(n) for n in range(400)),
                               *harness.H264)
        _, url = self.stream("--set", "max-features=5", video)
        # No caps filters on `in.`: two of them would race for its pads (docs/results/strangers.md).
        client = harness.Run(f"rtspsrc name=in location={url} protocols=tcp buffer-mode=none "
                             "latency=200 in. ! rtph264depay ! decodebin ! videoconvert ! "
                             "video/x-raw,format=RGB,width=320 ! "
                             "fakesink name=video sync=false async=false "
                             "in. ! rtpgstdepay ! fakesink name=lines sync=false async=false")
        self.addCleanup(client.pipeline.set_state, Gst.State.NULL)

        def level(buffer):
            rows = np.frombuffer(buffer.extract_dup(0, 50 * 3 * 320), np.uint8).reshape(50, 320, 3)
            return round((rows[10:, 10:50].mean() - 20) / 18)

        frames = client.collect("video", lambda b: (b.pts, level(b)))
        lines = client.collect("lines", lambda b: (
            b.pts, harness.parse_line(b.extract_dup(0, b.get_size()).decode())["frame"]))
        client.pipeline.set_state(Gst.State.PLAYING)
        client.until(Gst.MessageType.EOS)  # the session ends with the file
        client.pipeline.set_state(Gst.State.NULL)
        self.assertEqual(len(dict(lines)), len(lines), "two lines have the same time")
        # The RTP times are the same, but rtpjitterbuffer rounds each stream's to nanoseconds.
        both = [(number % LEVELS, level) for pts, level in frames for time, number in lines
                if abs(time - pts) <= 1]
        self.assertGreater(len(both), 20, (frames[:5], lines[:5]))
        self.assertGreater(len(both), 0.9 * len(frames), (frames[:5], lines[:5]))
        self.assertEqual([number for number, _ in both], [level for _, level in both])

    SIZES = [f"video/x-raw,format=I420,width={width},height={height},framerate=25/1"
             for width, height in ((320, 240), (240, 180))]

    def wait_for_sizes(self, receiver):
        """A generator that first waits for lines of the first size, then for those of the other."""
        for width in 320, 240:
            self.await_count(receiver, self.got, 10, b'"width":%d,' % width)
            yield

    def test_a_new_size_reaches_the_receiver(self):
        program = f"""
from pipelines.lib import command, runner, sources, stream
sources.launch = lambda _: "videotestsrc is-live=true ! capsfilter name=size caps={self.SIZES[0]}"
play = runner.Run.play

def play_and_change(run, *arguments, **options):
    def change():
        run.element("size").set_property("caps", runner.Gst.Caps.from_string("{self.SIZES[1]}"))
        return runner.GLib.SOURCE_REMOVE

    runner.GLib.unix_signal_add(runner.GLib.PRIORITY_HIGH, {int(signal.SIGUSR1)}, change)
    play(run, *arguments, **options)

runner.Run.play = play_and_change
command.run("stream", stream.main)
"""
        stream = subprocess.Popen([sys.executable, "-c", program, "--preset", "", "--port", "0",
                                   "changes"],
                                  cwd=SOURCE, env=ENVIRONMENT, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True)
        self.addCleanup(stream.stdout.close)
        self.addCleanup(stream.wait)
        self.addCleanup(stream.kill)
        receiver = self.start(*command("receive", "--latency", 2000, "--display=fakesink",
                                       stream.stdout.readline().strip(), self.got))
        waits = self.wait_for_sizes(receiver)
        next(waits)
        stream.send_signal(signal.SIGUSR1)
        next(waits)
        # The video has changed its size too: there are as many pictures as lines.
        os.killpg(receiver.pid, signal.SIGINT)
        said = receiver.stdout.read()
        self.assertEqual(receiver.wait(60), 0, said)
        frames, lines = map(int, re.match(r"(\d+) frames; (\d+) lines", said).groups())
        changed = sum(line["width"] == 240 for line in harness.read_lines(self.got))
        self.assertGreaterEqual(changed, 10)
        self.assertGreater(frames, lines - changed, said)
        stream.terminate()
        said = re.sub("tracking cost.*", "", stream.stdout.read())
        self.assertEqual((stream.wait(60), said.count("\n")), (0, 1))

    def test_a_new_size_of_a_stream_without_tracks(self):
        port = free_port(socket.SOCK_DGRAM)
        sender = harness.Run("videotestsrc is-live=true ! capsfilter name=size "
                             f"caps={self.SIZES[0]} ! x264enc tune=zerolatency key-int-max=10 ! "
                             "mpegtsmux ! srtsink wait-for-connection=false "
                             f"uri=srt://127.0.0.1:{port}?mode=listener")
        self.addCleanup(sender.pipeline.set_state, Gst.State.NULL)
        sender.pipeline.set_state(Gst.State.PLAYING)
        receiver = self.start(*command("receive", "--display=fakesink", f"srt://127.0.0.1:{port}",
                                       self.got))
        waits = self.wait_for_sizes(receiver)
        next(waits)
        sender.element("size").set_property("caps", Gst.Caps.from_string(self.SIZES[1]))
        next(waits)
        os.killpg(receiver.pid, signal.SIGINT)
        said = receiver.stdout.read()
        self.assertEqual((receiver.wait(60), said.count("\n")), (0, 1), said)
        self.assertGreaterEqual(sum(line["width"] == 240 for line in harness.read_lines(self.got)),
                                10)

    def test_receiving_srt_ends_when_the_sender_is_gone(self):
        self.got.unlink(missing_ok=True)
        port = free_port(socket.SOCK_DGRAM)
        sender = self.start("gst-launch-1.0", "-q", *(
            "videotestsrc is-live=true ! video/x-raw,width=320,height=240 ! "
            "x264enc tune=zerolatency key-int-max=10 ! mpegtsmux ! srtsink "
            f"wait-for-connection=false uri=srt://127.0.0.1:{port}?mode=listener").split())
        receiver = self.start(*command("receive", f"srt://127.0.0.1:{port}", self.got))
        self.await_count(receiver, self.got, 10, b'"width":320,')
        sender.kill()
        self.assertEqual(receiver.wait(60), 1)
        said = receiver.stdout.read()
        self.assertIn(f"srt://127.0.0.1:{port}: the source broke off", said)
        self.assertGreaterEqual(len(harness.read_lines(self.got)), 10)

    def test_a_stream_without_tracks_is_tracked(self):
        server = self.start("/usr/bin/python3", "-c", RECORDER)
        port = server.stdout.readline().strip()
        srt = free_port(socket.SOCK_DGRAM)
        self.start("gst-launch-1.0", "-q",
                   *("csdsimsrc is-live=true ! video/x-raw,width=320,height=240,framerate=25/1 ! "
                     "x264enc tune=zerolatency key-int-max=10 ! mpegtsmux ! srtsink "
                     f"wait-for-connection=false uri=srt://127.0.0.1:{srt}?mode=listener").split())
        for url, more in ((f"rtsp://127.0.0.1:{port}/live", ()),
                          (f"srt://127.0.0.1:{srt}", ("--display=fakesink",))):
            with self.subTest(url):
                self.assertIn("ms a frame",
                              self.receive(20, "--set", "max-features=10", *more, url, self.got))
                lines = harness.read_lines(self.got)
                harness.check_tracks(self, lines, most=10)
                self.assertEqual((lines[0]["width"], lines[0]["height"]), (320, 240))

    def test_tracks_in_a_transport_stream_are_received(self):
        port = free_port(socket.SOCK_DGRAM)
        wide = "queue max-size-time=5000000000 max-size-buffers=0 max-size-bytes=0"
        self.sent.unlink(missing_ok=True)
        sender = self.start("gst-launch-1.0", "-q", *(
            "csdsimsrc is-live=true ! video/x-raw,width=320,height=240,framerate=25/1 ! csdtrack "
            "max-features=10 ! tee name=t mpegtsmux alignment=7 name=m ! srtsink "
            f"wait-for-connection=false uri=srt://127.0.0.1:{port}?mode=listener t. ! queue ! "
            "x264enc tune=zerolatency key-int-max=10 ! h264parse config-interval=-1 ! m. t. ! "
            f"csdtrackenc ! {wide} ! m. t. ! csdtrackenc ! {wide} ! filesink location={self.sent} "
            "buffer-mode=unbuffered async=false").split())
        for more in (), ("--display=fakesink",):
            said = self.receive(30, "--klv", *more, f"srt://127.0.0.1:{port}", self.got)
            got = self.got.read_bytes()
            self.assertIn(got, self.lines_sent(sender, got.splitlines(keepends=True)[-1]))
            self.assertRegex(said, rf"^\d+ frames; {got.count(10)} lines of tracks came with them( "
                             r"\(at the beginning and the end .*\))?\n$")

    def test_a_stream_without_klv_is_refused(self):
        port = free_port(socket.SOCK_DGRAM)
        self.start("gst-launch-1.0", "-q",
                   *("csdsimsrc is-live=true ! video/x-raw,width=320,height=240,framerate=25/1 ! "
                     "x264enc tune=zerolatency key-int-max=10 ! mpegtsmux ! srtsink "
                     f"wait-for-connection=false uri=srt://127.0.0.1:{port}?mode=listener").split())
        for url in f"srt://127.0.0.1:{port}", self.stream("simulate")[1]:
            self.got.unlink(missing_ok=True)
            self.check_refused(run("receive", "--klv", url, self.got), 1,
                               f"receive: {url}: it contains no KLV")

    def test_klv_is_found_before_its_pad_is_linked(self):
        """rtspsrc may say that there are no more pads before the handler of each has returned."""
        for encodings, refused in (("H264",), 1), (("H264", "SMPTE336M"), 0):
            with self.subTest(encodings):
                run, options = mock.Mock(), argparse.Namespace(klv=True)
                receiver = receive.Receiver(None, run, options)
                for number, encoding in enumerate(encodings):
                    media = "video" if encoding == "H264" else "application"
                    receiver.select(None, number, Gst.Caps.from_string(
                        f"application/x-rtp,media={media},encoding-name={encoding}"))
                receiver.on_no_more_pads(None)
                self.assertEqual(run.fail.call_count, refused)

    def test_live_takes_the_stream(self):
        _, url = self.stream("--overlay", "simulate")
        # It must not warn that the stream of lines is no picture.
        self.assertNotIn("ndjson", self.receive(5, "--sink", "fakesink", "--tracks", self.got, url,
                                                program="live"))

    def test_a_second_receiver_gets_the_same(self):
        stream, url = self.stream("simulate")
        first = self.tmp / "first.jsonl"
        receiver = self.start(*command("receive", url, first))
        self.await_count(receiver, first, 1)
        self.receive(20, url, self.got)
        lines = self.got.read_bytes().splitlines(keepends=True)
        self.await_count(receiver, first, 1, lines[-1])  # it may be a second behind (seen)
        sent, others = self.lines_sent(stream, lines[-1]), first.read_bytes()
        # The ten before the end have no gap: it lies between the answer to DESCRIBE and PLAY.
        self.assertIn(b"".join(lines[-10:]), sent)
        self.assertIn(b"".join(lines[-10:]), others)
        for line in lines:
            self.assertEqual((others.count(line), sent.count(line)), (1, 1), line)

    def test_a_disk_that_swallows_a_line_is_noticed(self):
        self.sent.unlink(missing_ok=True)
        done = harness.run_swallowing("stream", "--port", 0, "--tracks", self.sent, "a")
        self.assertEqual((done.returncode, done.stderr),
                         (1, f"stream: '{self.sent}' holds 24 lines of 25 frames\n"))
        _, url = self.stream("--klv", "simulate")
        for form in (), ("--klv",):  # it is tracked here, or its lines come with it
            self.got.unlink(missing_ok=True)
            done = harness.run_swallowing("receive", *form, "--set", "max-features=8", "--seconds",
                                          1, url, self.got)
            lines = self.got.read_bytes().count(b"\n")
            self.assertEqual((done.returncode, done.stderr),
                             (1, f"receive: '{self.got}' holds {lines} lines of {lines + 1} "
                              "frames\n"))

    def test_any_caps_of_a_server_are_survived(self):
        """They are read in a callback of rtspsrc, which no exception may leave."""
        for caps in b"YQ", b"\xc3\xa4":
            with self.subTest(caps):
                session = (b"v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=x\r\nt=0 0\r\n"
                           b"m=application 0 RTP/AVP 97\r\nc=IN IP4 127.0.0.1\r\n"
                           b"a=rtpmap:97 X-GST/90000\r\na=fmtp:97 caps=" + caps +
                           b"\r\na=control:1\r\n")
                server = Describing(self, session)
                self.check_refused(run("receive", server.url, self.got), 1, "receive: ")

    def test_errors_are_one_line(self):
        taken = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(taken.close)
        port, nobody = taken.getsockname()[1], free_port()
        for name, arguments, code, words in (
                ("stream", ("--port", port), 1, f"port {port}"),
                ("stream", ("--address", "192.0.2.1"), 1, "192.0.2.1"),
                ("stream", ("nothing.mp4",), 1, "no file"),
                ("stream", ("/dev/video99",), 1, "no device"),
                ("stream", ("--port", "x"), 2, "--port"),
                ("stream", ("--port", "65536"), 2, "--port"),
                ("stream", ("--path", "a/b"), 2, "--path"),
                ("stream", ("--bitrate", "0"), 2, "--bitrate"),
                ("stream", ("--tracks", self.tmp), 2, "folder"),
                ("stream", ("--port", 0, "--preset", "fast"), 2, "live-low-latency"),
                ("receive", (f"rtsp://127.0.0.1:{nobody}/x", self.got), 1,
                 f"nobody serves RTSP at 127.0.0.1:{nobody}"),
                ("receive", ("rtsp://x:y/z", self.got), 1, "Port"),
                ("receive", ("in.mkv", self.got), 2, "rtsp://"),
                ("receive", ("rtsp://x/y",), 2, "TRACKS"),
                ("receive", ("rtsp://x/y", self.tmp), 2, "folder"),
                ("receive", ("--set", "foo=1", "rtsp://x/y", self.got), 2, "'foo'"),
                ("receive", ("--latency", "-1", "rtsp://x/y", self.got), 2, "--latency"),
                ("receive", ("--display=nosuchsink", "rtsp://x/y", self.got), 1, "nosuchsink")):
            with self.subTest(name, arguments=arguments):
                self.check_refused(run(name, *arguments), code, words)


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
