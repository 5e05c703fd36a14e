# SPDX-License-Identifier: LGPL-2.1-or-later
"""Feeds frames to many trackers at once: csdtrack's in one pipeline, csd-peers' through pipes."""

import contextlib
import json
import pathlib
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence

import gi

from pipelines.experiments import builds, sequences
from pipelines.experiments.mirror import Picture
from pipelines.lib.failure import Failure

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

AHEAD = 4  # frames that wait for the slowest tracker
QUEUE = f"queue max-size-buffers={AHEAD} max-size-bytes=0 max-size-time=0"
SINK = "sync=false async=false"


class Pipeline:
    """A pipeline behind an appsrc. locations: the paths of its file sinks, by element."""

    def __init__(self, description: str, caps: str, locations: Mapping[str, pathlib.Path]) -> None:
        try:
            self._pipeline = Gst.parse_launch(
                f"appsrc name=in format=time max-buffers=0 max-bytes=0 ! {description}")
        except GLib.Error as error:
            raise Failure(f"{error.message}: is a plugin of GStreamer missing?") from None
        self._source, self._bus = self.element("in"), self._pipeline.get_bus()
        self._source.set_property("caps", Gst.Caps.from_string(caps))
        for name, path in locations.items():
            self.element(name).set_property("location", str(path))
        self._pipeline.set_state(Gst.State.PLAYING)

    def element(self, name: str) -> Gst.Element:
        return self._pipeline.get_by_name(name)

    def push(self, time: int, frame: bytes) -> None:
        """Waits while the trackers are busy."""
        while self._source.get_property("current-level-buffers") >= AHEAD:
            self.check(Gst.SECOND // 100)
        buffer = Gst.Buffer.new_wrapped(frame)
        buffer.pts = time
        self._source.emit("push-buffer", buffer)

    def check(self, wait: int, kinds: Gst.MessageType = Gst.MessageType.ERROR) -> Gst.Message:
        """Waits for a message of these kinds and returns it, None if none comes in time.

        Raises Failure if it is an error. wait: ns.
        """
        message = self._bus.timed_pop_filtered(wait, kinds | Gst.MessageType.ERROR)
        if message is not None and message.type == Gst.MessageType.ERROR:
            error, _debug = message.parse_error()
            raise Failure(f"{message.src.get_name()}: {error.message}")
        return message

    def end(self, waiting: Callable[[], None]) -> None:
        """Returns when the trackers have processed everything that was pushed."""
        self._source.emit("end-of-stream")
        while self.check(Gst.SECOND // 5, Gst.MessageType.EOS) is None:
            waiting()

    def close(self) -> None:
        self._pipeline.set_state(Gst.State.NULL)


def detect(picture: Picture, frame: bytes, features: int) -> str:
    """The features that csdtrack finds in a frame, as the value of its property `points`.

    Every tracker begins with these.
    """
    description = (f"csdtrack algorithm=lk learning=sync max-features={features} ! csdtrackenc ! "
                   f"appsink name=out {SINK}")
    with contextlib.closing(Pipeline(description, picture.caps, {})) as pipeline:
        pipeline.push(0, frame)
        # Pull before the end of the stream: appsink never ends while it holds a line.
        while (sample := pipeline.element("out").emit("try-pull-sample", Gst.SECOND // 10)) is None:
            pipeline.check(0)
        line = sample.get_buffer()
    found = json.loads(line.extract_dup(0, line.get_size()))["features"]
    return ";".join(f"{feature['x']:.3f},{feature['y']:.3f}" for feature in found)


class Peer:
    """csd-peers, which reads its video from a pipe."""

    def __init__(self, name: str, points: str, options: Sequence[str],
                 folder: pathlib.Path) -> None:
        self.name = name
        self._messages = tempfile.TemporaryFile("w+")
        self._process = subprocess.Popen(
            [
                builds.program("csd-peers"), "-t", name, "-p", points, "-o",
                folder / f"{name}.jsonl", *options, "-"
            ],
            stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self._messages,
            env={**builds.environment(), "OPENCV_FOR_THREADS_NUM": "1"}, start_new_session=True)
        assert self._process.stdin
        self.pipe = self._process.stdin

    def check(self) -> None:
        if self._process.poll():
            self._messages.seek(0)
            raise Failure(self._messages.read().strip() or
                          f"csd-peers --tracker {self.name} failed")

    def finish(self, waiting: Callable[[], None]) -> None:
        self.pipe.close()
        while self._process.poll() is None:
            waiting()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._process.wait(0.2)
        self.check()

    def close(self) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        self._messages.close()


def description(trackers: Iterable[str], points: str, peers: Iterable[Peer]) -> str:
    branches = [
        f'csdtrack name={name} algorithm={name} points="{points}" learning=sync n-threads=1 '
        f"post-messages=none ! csdtrackenc ! filesink name=to-{name} {SINK}" for name in trackers
    ]
    text = "tee name=t allow-not-linked=true " + " ".join(f"t. ! {QUEUE} ! {branch}"
                                                          for branch in branches)
    sinks = [
        f"y. ! {QUEUE} ! fdsink name={peer.name} {SINK} fd={peer.pipe.fileno()}" for peer in peers
    ]
    if sinks:
        text += f" t. ! {QUEUE} ! y4menc ! tee name=y " + " ".join(sinks)
    return text


def follow(frames: Iterable[tuple[int, bytes]], picture: Picture, points: str,
           trackers: Sequence[str], slow_features: int, folder: pathlib.Path,
           progress: Callable[[int], None]) -> None:
    """Writes TRACKER.jsonl into the folder for each tracker.

    frames: of (ns, bytes), with the caps of `picture`. progress: called with the number of frames
    so far.
    """
    with contextlib.ExitStack() as stack:
        peers = []
        for name in trackers:
            if name not in sequences.PLUGIN:
                few = ["--features", str(slow_features)] if name in sequences.SLOW_RIVALS else []
                peer = Peer(name, points, few, folder)
                peers.append(stack.enter_context(contextlib.closing(peer)))
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
        except Failure:
            for peer in peers:  # if its pipe broke, csd-peers knows better why
                peer.check()
            raise
        for peer in peers:
            peer.finish(lambda: progress(pushed))
    for name in trackers:
        with open(folder / f"{name}.jsonl", "rb") as file:
            lines = sum(1 for _ in file)
        if lines != pushed:
            raise Failure(f"{name} wrote {lines} lines for {pushed} frames")
