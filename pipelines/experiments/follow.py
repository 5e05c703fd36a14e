# SPDX-License-Identifier: LGPL-2.1-or-later
"""Feeds frames to many trackers at once: those of csdtrack in one pipeline, csd-peers through pipes."""

import contextlib
import json
import subprocess
import tempfile

import builds
import gi
import sequences

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

AHEAD = 4  # frames that wait for the slowest tracker
QUEUE = f"queue max-size-buffers={AHEAD} max-size-bytes=0 max-size-time=0"
SINK = "sync=false async=false"


class Pipeline:
    """An appsrc and what hangs on it. locations: of its files, by element."""

    def __init__(self, description, caps, locations):
        try:
            self._pipeline = Gst.parse_launch(
                f"appsrc name=in format=time max-buffers=0 max-bytes=0 ! {description}")
        except GLib.Error as error:
            raise builds.Failure(f"{error.message}: is a plugin of GStreamer missing?") from None
        self._source, self._bus = self.element("in"), self._pipeline.get_bus()
        self._source.set_property("caps", Gst.Caps.from_string(caps))
        for name, path in locations.items():
            self.element(name).set_property("location", str(path))
        self._pipeline.set_state(Gst.State.PLAYING)

    def element(self, name):
        return self._pipeline.get_by_name(name)

    def push(self, time, frame):
        """Waits while the trackers are busy."""
        while self._source.get_property("current-level-buffers") >= AHEAD:
            self.check(Gst.SECOND // 100)
        buffer = Gst.Buffer.new_wrapped(frame)
        buffer.pts = time
        self._source.emit("push-buffer", buffer)

    def check(self, wait, kinds=Gst.MessageType.ERROR):
        """A message of these kinds, if one comes in this time. Raises builds.Failure of an error."""
        message = self._bus.timed_pop_filtered(wait, kinds | Gst.MessageType.ERROR)
        if message is not None and message.type == Gst.MessageType.ERROR:
            error, _debug = message.parse_error()
            raise builds.Failure(f"{message.src.get_name()}: {error.message}")
        return message

    def end(self, waiting):
        """Until all that was pushed has been dealt with."""
        self._source.emit("end-of-stream")
        while self.check(Gst.SECOND // 5, Gst.MessageType.EOS) is None:
            waiting()

    def close(self):
        self._pipeline.set_state(Gst.State.NULL)


def detect(picture, frame, features):
    """What csdtrack finds in a frame, as its property `points`: every tracker begins with these."""
    with contextlib.closing(
            Pipeline(
                f"csdtrack algorithm=lk learning=sync max-features={features} ! csdtrackenc ! "
                f"appsink name=out {SINK}", picture.caps, {})) as pipeline:
        pipeline.push(0, frame)
        # Not to the end first: with a line that nobody takes, appsink never ends.
        while (sample := pipeline.element("out").emit("try-pull-sample", Gst.SECOND // 10)) is None:
            pipeline.check(0)
        line = sample.get_buffer()
    found = json.loads(line.extract_dup(0, line.get_size()))["features"]
    return ";".join(f"{f['x']:.3f},{f['y']:.3f}" for f in found)


class Peer:
    """csd-peers on a pipe."""

    def __init__(self, name, points, options, folder):
        self.name, self._said = name, tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen([
            builds.program("csd-peers"), "-t", name, "-p", points, "-o", folder / f"{name}.jsonl",
            *options, "-"
        ], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._said,
                                        env={**builds.environment(), "OPENCV_FOR_THREADS_NUM": "1"},
                                        start_new_session=True)

    def check(self):
        if self.process.poll():
            self._said.seek(0)
            raise builds.Failure(self._said.read().strip() or
                                 f"csd-peers --tracker {self.name} failed")

    def finish(self, waiting):
        self.process.stdin.close()
        while self.process.poll() is None:
            waiting()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(0.2)
        self.check()

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self._said.close()


def description(trackers, points, peers):
    branches = [
        f'csdtrack name={name} algorithm={name} points="{points}" learning=sync n-threads=1 post-messages=none ! '
        f"csdtrackenc ! filesink name=to-{name} {SINK}" for name in trackers
    ]
    text = "tee name=t allow-not-linked=true " + " ".join(f"t. ! {QUEUE} ! {branch}"
                                                          for branch in branches)
    if peers:
        text += f" t. ! {QUEUE} ! y4menc ! tee name=y " + " ".join(
            f"y. ! {QUEUE} ! fdsink name={peer.name} {SINK} fd={peer.process.stdin.fileno()}"
            for peer in peers)
    return text


def follow(frames, picture, points, trackers, slow_features, folder, progress):
    """Leaves TRACKER.jsonl in the folder for each of them. frames: of (ns, bytes); picture: that of their caps."""
    with contextlib.ExitStack() as stack:
        peers = []
        for name in trackers:
            if name not in sequences.PLUGIN:
                few = ["--features", str(slow_features)] if name in sequences.SLOW_RIVALS else []
                peers.append(
                    stack.enter_context(contextlib.closing(Peer(name, points, few, folder))))
        ours = [name for name in trackers if name in sequences.PLUGIN]
        pipeline = stack.enter_context(
            contextlib.closing(
                Pipeline(description(ours, points, peers), picture.caps,
                         {f"to-{name}": folder / f"{name}.jsonl" for name in ours})))
        pushed = 0
        try:
            for time, frame in frames:
                pipeline.push(time, frame)
                pushed += 1
                progress(pushed)
            pipeline.end(lambda: progress(pushed))
        except builds.Failure:
            for peer in peers:  # it knows better why its pipe broke
                peer.check()
            raise
        for peer in peers:
            peer.finish(lambda: progress(pushed))
    for name in trackers:
        with open(folder / f"{name}.jsonl", "rb") as file:
            lines = sum(1 for _ in file)
        if lines != pushed:
            raise builds.Failure(f"{name} wrote {lines} lines for {pushed} frames")
