# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs a command's pipeline until it ends, is stopped by a signal, or fails."""

import dataclasses
import pathlib
import re
import signal
import sys
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import gi

from pipelines.lib import command, counts, supervisor
from pipelines.lib.caps import first_structure
from pipelines.lib.failure import NO_VIDEO, no_video, one_line
from pipelines.lib.properties import check_start, set_from_text
from pipelines.lib.video_errors import factory_name

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

Gst.init(None)

# rtspsrc's messages when the sender closes the connection, and when the connection is reset, times
# out, or can't be made again.
CLOSED = ("The server closed the connection",)
LOST = ("Could not receive message", "Could not connect to server")

PATIENCE = 3  # seconds for the source to end after it was asked to
STALLED = 10  # seconds without any movement, after which the rest of the pipeline is given up


def configure(track: Gst.Element, preset: str | None, properties: Mapping[str, str],
              settings: Iterable[tuple[str, str]]) -> None:
    """Sets csdtrack's preset, then these properties, then the user's settings.

    Raises Misuse for wrong values, and Failure if csdtrack can't start.
    """
    if preset and not track.load_preset(preset):
        raise command.Misuse(
            f"there is no preset '{preset}': {', '.join(track.get_preset_names())}")
    for name, value in [*properties.items(), *settings]:
        set_from_text(track, name, value)
    check_start(track)


def print_cost(track: Gst.Element, received: int | None = None) -> None:
    """`received`: how many frames arrived, if not each of them was tracked."""
    stats = track.get_property("stats")
    frames = stats.get_value("frames")
    tracked = counts.plural(frames, "frame")
    if received not in (None, frames):
        tracked = f"{frames} of {received} frames were tracked"
    command.print_line(
        f"{tracked}; tracking cost {stats.get_value('time-p50') / 1e6:.1f} ms a frame (p50), "
        f"{stats.get_value('time-p95') / 1e6:.1f} ms (p95)", sys.stdout)


def contains_any(text: str | None, parts: Iterable[str]) -> bool:
    return any(part in (text or "") for part in parts)


@dataclasses.dataclass
class Lines:
    """What went into a file of tracks."""
    pad: Any  # of the filesink
    path: pathlib.Path
    came: int = 0       # to the filesink
    in_flight: int = 0  # of these, when the pipeline was stopped


class Run:
    SILENCE = 60  # seconds without a first frame; a file may lie on a slow disk
    LIVE_SILENCE = 10  # of a camera or a sender; a simulator computes its frame
    NO_FRAME = "is it connected, and on?"

    def __init__(self, name: str, text: str, counted: Sequence[str] = ("csdtrack",)) -> None:
        """`text`: the pipeline's description; `counted`: the elements that must get a frame."""
        self._name = name
        try:
            self.pipeline = Gst.parse_launch(text)
        except GLib.Error as error:
            raise command.Failure(one_line(error.message)) from error
        self._loop = GLib.MainLoop()
        self._failure: str | None = None
        self._source, self._through = "", ""
        self._harmless: Sequence[str] = ()
        self._seconds: float | None = None
        self.stopped = False  # by a signal
        self.ending: float | None = None  # time.monotonic() at the first request to end
        self.live = False  # known before the first frame
        self._simulated = False
        self.source_ended = False  # by itself
        self.warnings: set[str] = set()
        self.drained = False  # EOS came through
        self._counts = dict.fromkeys(counted, 0)
        self._lines: dict[str, Lines] = {}  # by the filesink's name

    @property
    def frames(self) -> int:
        """How many frames reached the element that got the fewest."""
        return min(self._counts.values())

    def frames_of(self, name: str) -> int:
        """How many frames reached this element, one of those that are counted."""
        return self._counts[name]

    def watch_lines(self, sink: Any, path: pathlib.Path) -> None:
        """Counts the lines that this filesink writes into this file, for lost_lines()."""
        watched = self._lines[sink.get_name()] = Lines(sink.get_static_pad("sink"), path)

        def on_line(_pad: Gst.Pad, _info: Gst.PadProbeInfo) -> Any:
            watched.came += 1
            return Gst.PadProbeReturn.OK

        watched.pad.add_probe(Gst.PadProbeType.BUFFER, on_line)

    def lines(self, name: str) -> int:
        """How many lines came to this filesink, one of those that are watched."""
        return self._lines[name].came if name in self._lines else 0

    def lost_lines(self, name: str, frames: int) -> str:
        """In some words, if the file lacks lines, else "". Call it after play().

        `frames`: how many lines are due. If the run did not end at the end of the stream, fewer may
        have come.
        """
        lines = self._lines[name]
        if self.drained:
            return counts.missing_lines(lines.path, frames)
        return counts.missing_lines(lines.path, lines.came, lines.in_flight)

    def _hold_lines(self) -> None:
        """Waits until the files have taken what came to them, and lets nothing more come.

        Else a line may have come, and been counted, that a stopped sink refuses (seen). The probe
        is at the pad before, which is busy from before a line is counted until it is written.
        """
        end = time.monotonic() + PATIENCE
        waited = []
        for lines in self._lines.values():
            idle = threading.Event()

            def on_idle(_pad: Gst.Pad, _info: Gst.PadProbeInfo, idle: threading.Event) -> Any:
                idle.set()
                return Gst.PadProbeReturn.OK  # it stays blocked

            lines.pad.get_peer().add_probe(
                Gst.PadProbeType(Gst.PadProbeType.IDLE | Gst.PadProbeType.BLOCK), on_idle, idle)
            waited.append((lines, idle))
        for lines, idle in waited:
            lines.in_flight = int(not idle.wait(max(0, end - time.monotonic())))

    def element(self, name: str) -> Any:
        return self.pipeline.get_by_name(name)

    def play(self, source: object, seconds: float | None = None, harmless: Sequence[str] = (),
             through: str = "", leaky: Iterable[str] = ()) -> None:
        """Runs until the stream ends, or for `seconds` from the first frame.

        `source`: the user's name for it, or "" where errors name it themselves. `harmless`: parts
        of error messages that end the run normally. `through`: the element that all frames pass.
        `leaky`: queues that drop old frames if the source is live. A file is read faster than it is
        shown, so they would drop most of its frames.

        If the sender is gone or its connection is lost, the frames that arrived are still written.
        With `through`, so they are after any error upstream of it. Raises Failure after an error,
        and if no frame arrives.
        """
        self._source, self._harmless = str(source), harmless
        self._through, self._seconds = through, seconds
        for name in self._counts:
            self.element(name).get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER,
                                                                self._count, name)
        self._notify_supervisor()
        GLib.timeout_add_seconds(self.LIVE_SILENCE, self._check_first_frame, self.LIVE_SILENCE)
        GLib.timeout_add_seconds(self.SILENCE, self._check_first_frame, self.SILENCE)
        bus = self.pipeline.get_bus()
        bus.add_signal_watch()
        bus.connect("message", lambda _, message: self._handle(message))
        for end in (signal.SIGINT, signal.SIGTERM):
            GLib.unix_signal_add(GLib.PRIORITY_HIGH, end, self._on_signal)
        for hangup in command.not_ignored(signal.SIGHUP):
            GLib.unix_signal_add(GLib.PRIORITY_HIGH, hangup, self._on_hangup)

        def be_live() -> None:
            self.live = True
            for name in leaky:
                self.element(name).set_property("leaky", "downstream")

        def on_element(_pipeline: object, _bin: object, element: Gst.Element) -> None:
            # A camera's MJPEG over HTTP, which GStreamer takes for a file. As there may be more
            # streams, decodebin would wait for 2 MB before it shows this one.
            if factory_name(element) == "multipartdemux":
                element.set_property("single-stream", True)
                be_live()
            elif factory_name(element) == "csdsimsrc":
                self._simulated = True
            # They add all pads before data flows.
            elif factory_name(element) in ("decodebin", "uridecodebin"):
                element.connect("no-more-pads", self._take_largest)

        self.pipeline.connect("deep-element-added", on_element)
        self.pipeline.iterate_elements().foreach(lambda one: on_element(None, None, one))
        paused = self.pipeline.set_state(Gst.State.PAUSED)
        # Only a live source gives no frame before it plays.
        if paused == Gst.StateChangeReturn.NO_PREROLL:
            be_live()
        # If the change is asynchronous, play when it is done. A GstBin that is set to PLAYING
        # earlier may miss that, and then never reports the end of the stream (GStreamer 1.22:
        # gst-launch-1.0 hung in 8 of 20 runs on a busy machine).
        if paused != Gst.StateChangeReturn.ASYNC:
            self.pipeline.set_state(Gst.State.PLAYING)
        try:
            self._loop.run()
        finally:
            self._hold_lines()
            self.pipeline.set_state(Gst.State.NULL)
            bus.remove_signal_watch()
        if not self.frames:
            self.fail("it was stopped before the first picture came" if self.stopped else
                      f"no picture came: {self.NO_FRAME}")
        if self._failure:
            raise command.Failure(self._failure)

    def _check_first_frame(self, seconds: int) -> Any:
        if not self.frames and (self.live and not self._simulated or seconds == self.SILENCE):
            self.fail(f"no picture came in {seconds} s: {self.NO_FRAME}")
        return GLib.SOURCE_REMOVE

    def _notify_supervisor(self) -> None:
        """Counts the source's frames, tracked or not: tracking must not end a recording."""
        received = reported = 0

        def count(_pad: Gst.Pad, _info: Gst.PadProbeInfo) -> Any:
            nonlocal received
            if not received:
                supervisor.notify("READY=1")
            received += 1
            return Gst.PadProbeReturn.OK

        def report() -> Any:
            nonlocal reported
            if received != reported:
                reported = received
                supervisor.notify("WATCHDOG=1")
            return GLib.SOURCE_CONTINUE

        element = self.element(self._through or next(iter(self._counts)))
        element.get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER, count)
        if interval := supervisor.interval():
            GLib.timeout_add(interval, report)

    def end(self) -> Any:
        """Ends the source. The frames that it gave are still written, however long that takes."""
        if not self.ending:
            self.ending = time.monotonic()
            self._drain()
            if not self.pipeline.send_event(Gst.Event.new_eos()):
                self._loop.quit()
            GLib.timeout_add_seconds(PATIENCE, self._cut_source)
        return GLib.SOURCE_REMOVE

    def _elements(self) -> list[Any]:
        """All elements that are not bins."""
        found: list[Any] = []
        self.pipeline.iterate_recurse().foreach(found.append)
        return [element for element in found if not isinstance(element, Gst.Bin)]

    def _cut_source(self) -> Any:
        """Sends EOS behind a source that ignores it, so that the frames it gave are kept.

        avdemux_gif, for one, can't seek and reads on for ever. The source is the element into which
        nothing pushes buffers: a real source, or a demuxer that pulls them.
        """
        for element in self._elements():
            if not all(pad.mode == Gst.PadMode.PULL for pad in element.sinkpads):
                continue
            for pad in element.srcpads:
                if pad.mode == Gst.PadMode.PUSH and not pad.get_sticky_event(
                        Gst.EventType.EOS, 0):
                    # push_event() waits until the current buffer has been taken.
                    threading.Thread(target=pad.push_event, args=(Gst.Event.new_eos(),),
                                     daemon=True).start()
        return GLib.SOURCE_REMOVE

    def _drain(self) -> None:
        """Waits for the end while buffers move: for a slow encoder, but not for a stalled disk."""
        moved = time.monotonic()

        def on_buffer(*_: Any) -> Any:
            nonlocal moved
            moved = time.monotonic()
            return Gst.PadProbeReturn.OK

        def check() -> Any:
            if time.monotonic() - moved < STALLED:
                return GLib.SOURCE_CONTINUE
            self._loop.quit()
            return GLib.SOURCE_REMOVE

        for element in self._elements():
            for pad in element.sinkpads:
                pad.add_probe(Gst.PadProbeType.BUFFER | Gst.PadProbeType.BUFFER_LIST, on_buffer)
        GLib.timeout_add_seconds(1, check)

    def _on_signal(self) -> Any:
        self.stopped = True
        return self.end()

    def _on_hangup(self) -> Any:
        """The terminal is gone. Shell and system both send SIGHUP: the second must not kill."""
        if not self.ending:
            self._on_signal()
        return GLib.SOURCE_CONTINUE

    def fail(self, text: str, name_source: bool = True) -> None:
        """Ends the run with this message. The first one counts."""
        if not self._failure:
            self._failure = f"{self._source}: {text}" if self._source and name_source else text
        self._loop.quit()

    def _count(self, _pad: Gst.Pad, _info: Gst.PadProbeInfo, name: str) -> Any:
        self._counts[name] += 1
        if self._seconds and self.frames:
            seconds, self._seconds = self._seconds, None
            GLib.timeout_add(int(seconds * 1000), self.end)
        return Gst.PadProbeReturn.OK

    def _handle(self, message: Gst.Message) -> None:
        if message.type == Gst.MessageType.EOS:
            self.source_ended, self.drained = not self.ending, True
            self._loop.quit()
        elif message.type == Gst.MessageType.ASYNC_DONE and message.src == self.pipeline:
            self.pipeline.set_state(Gst.State.PLAYING)
        elif message.type == Gst.MessageType.ERROR:
            self._on_error(message.src, *message.parse_error())
        elif message.type == Gst.MessageType.WARNING:
            self._on_warning(message.src, *message.parse_warning())

    def _take_largest(self, decoder: Gst.Element) -> None:
        """Of several pictures the first was linked, and a small one may be a thumbnail."""
        areas = {}
        for pad in decoder.srcpads:
            caps = first_structure(pad.get_current_caps() or pad.query_caps(None))
            if caps.get_name() == "video/x-raw":
                areas[pad] = caps.get_int("width")[1] * caps.get_int("height")[1]
        first = next((pad for pad in areas if pad.is_linked()), None)
        # decodebin in uridecodebin: the pads of this one count.
        if len(areas) < 2 or first is None or decoder.get_parent() != self.pipeline:
            return
        largest, peer = max(areas, key=areas.__getitem__), first.get_peer()
        if largest is not first:
            first.unlink(peer)
            largest.link(peer)
        command.print_line(f"{self._name}: warning: {self._source} has {len(areas)} pictures: the "
                           "largest is taken", sys.stderr)

    def _on_warning(self, element: Gst.Element, warning: Any, debug: str | None) -> None:
        text = one_line(warning.message)
        stream, parse = Gst.StreamError, Gst.ParseError
        if contains_any(debug, CLOSED):
            if not self.frames:
                self.fail("the connection ended before a picture came")
        elif warning.matches(parse.quark(), parse.DELAYED_LINK) and not self.frames:
            self._no_picture(element)
        elif warning.matches(stream.quark(), stream.CODEC_NOT_FOUND) and not re.search(
                "'(video|image)/", text):
            pass  # a sound decoder, say, which isn't needed
        # Once: a window that is too slow warns every second.
        elif text not in self.warnings:
            self.warnings.add(text)
            command.print_line(f"{self._name}: warning: {text}", sys.stderr)

    def _no_picture(self, decoder: Gst.Element) -> None:
        """This decodebin found no stream that could be linked."""
        source = decoder.sinkpads and decoder.sinkpads[0].get_peer().get_parent_element()
        has_location = source and source.find_property("location")
        place = source.get_property("location") if has_location else self._source
        self.fail(f"'{place}' has no picture in it that can be decoded here: give a video",
                  name_source=False)

    def _on_error(self, element: Gst.Element, error: Any, debug: str | None) -> None:
        text = one_line(error.message)
        factory = factory_name(element)
        closed, lost = contains_any(debug, CLOSED), contains_any(debug, LOST)
        if self._failure:  # this is another error with the same cause
            return
        if self.frames and closed or self.ending and lost:
            self.source_ended = not self.ending
            self._loop.quit()
        elif self.frames and (lost or self._is_upstream(element)):
            # EOS follows the frames that are still on their way.
            event = "connection was lost" if lost else f"source broke off ({text})"
            self._failure = f"{self._source}: the {event}"
            self._drain()
        elif contains_any(text, self._harmless):
            self._loop.quit()
        elif no_video(error):
            self.fail(NO_VIDEO)
        elif factory == "filesrc":
            place = element.get_property("location")
            self.fail(text if place in text else f"'{place}' can't be read: {text}",
                      name_source=False)
        elif factory == "filesink":
            place = element.get_property("location")
            self.fail(str(command.of_filesink(place, error, debug)), name_source=False)
        elif factory == "csdtrackdec" and element.get_property("location"):
            self.fail(
                text.partition(" Set location ")[0].rstrip(".") +
                ": give a .jsonl file that csdtrackenc wrote", name_source=False)
        elif not self.frames and not element.sinkpads and (
                "streaming stopped" in (debug or "") or "Could not open resource" in text):
            # souphttpsrc and rtspsrc say no more when there is no server.
            self.fail("nothing can be read from it: is it there?")
        else:
            self.fail(f"{text} ({element.get_name()})")

    def _is_upstream(self, element: Any) -> bool:
        """Whether an element, or the bin around it, is upstream of the one that all frames pass."""
        while element.get_parent() not in (self.pipeline, None):
            element = element.get_parent()
        at = self._through and self.element(self._through)
        while at:
            pad = at.get_static_pad("sink")
            peer = pad and pad.get_peer()
            at = peer and peer.get_parent_element()
            if at == element:
                return True
        return False
