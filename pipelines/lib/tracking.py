# SPDX-License-Identifier: LGPL-2.1-or-later
"""Quickstart's pipeline: from a video to its tracks, and to the same video with markers.

    filesrc ! decodebin ! csdtrack overlay=draw ! tee ─ queue ! x264enc ─┐
                 │ sound, copied or encoded as AAC ! queue ────────────── mp4mux ! overlay.mp4
                 tee ─ queue ! csdtrackenc ! tracks.jsonl
                 tee ─ queue ! csdtrackenc ! tracks.csv

Without a file, csdsimsrc replaces filesrc and decodebin. Another branch then writes truth.jsonl,
and one before csdtrack writes clean.mp4, the video without markers, for the page.

If the file asks for a rotation, as phones' files do, the video is rotated behind csdtrack: mp4mux
1.22 can't write that into its file.
"""

import pathlib
import signal
import threading
import time
from collections.abc import Sequence
from typing import Any, Protocol

import gi

from pipelines.lib import command, counts, even_size, sound, video_errors
from pipelines.lib.caps import first_structure
from pipelines.lib.failure import Failure, Misuse
from pipelines.lib.frame_times import FrameTimes
from pipelines.lib.properties import check_start, set_from_text

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

Gst.init(None)

PRESET = {"overlay": "draw", "learning": "sync"}
# Properties that --set can't change, as the results depend on them.
FIXED = ("attach-meta", "overlay")

SIMULATED = "video/x-raw, width=640, height=480, framerate=25/1"

CLOSING = 30  # seconds for the files to be closed
SILENCE = 60  # seconds without a stream, after which the run fails


class ProgressDisplay(Protocol):

    def show(self, share: float | None, frames: int) -> None:
        ...

    def done(self, frames: int) -> None:
        ...


class Simulation:
    """Replaces a video file: settings of csdsimsrc, each NAME=VALUE, with num-buffers."""

    def __init__(self, settings: Sequence[str]) -> None:
        self.settings = settings
        self.name = f"simulated tissue, {', '.join(settings)}"


class Job:
    """One run over one video. After run(), its members describe the result."""

    def __init__(self, video: pathlib.Path | Simulation, out: pathlib.Path, folder: pathlib.Path,
                 properties: Sequence[str]) -> None:
        """`out`: the user's name of the results' folder; `folder`: where they are made."""
        self.simulated = isinstance(video, Simulation)
        self.video, self.out, self.folder = video, out, folder
        self.name = video.name if isinstance(video, Simulation) else str(video)
        self.frames = 0
        self.position = 0  # ns in the video, end of the newest frame
        self.duration = 0  # ns, as the file says; 0 if it doesn't
        self.picture = ""
        self.turned = False  # overlay.mp4 is rotated, as the file asks, and the tracks are not
        self.sound: list[str] = []
        self.seconds = 0.0
        self.stats: Any = None
        self.warnings: list[str] = []  # of csdtrack, each a line
        self.cut_short = ""  # why the tracks end before the video does
        self._missing: list[str] = []
        self._segment = Gst.Segment()
        self._feeds: list[Any] = []  # sink pads that decodebin feeds
        self._made: list[Any] = []  # elements
        self._pictures: list[tuple[int, Any, Any]] = []  # area, pad, caps of each video stream
        self._loop = GLib.MainLoop()
        self._failure: str | None = None
        self._started = 0.0
        self._ending = False
        if isinstance(video, pathlib.Path) and video_errors.lacks_index(video):
            raise Failure(video_errors.no_index(video))
        self._build(properties)

    # ---- The pipeline ----

    def _make(self, factory: str, **properties: Any) -> Any:
        element = Gst.ElementFactory.make(factory)
        if element is None:
            raise Failure(f"GStreamer has no element '{factory}': run without --no-install, "
                          "or install its package")
        for name, value in properties.items():
            element.set_property(name.strip("_").replace("_", "-"), value)
        self.pipeline.add(element)
        self._made.append(element)
        return element

    def _link(self, *elements: Any) -> None:
        for a, b in zip(elements, elements[1:]):
            if not a.link(b):
                names = [element.get_factory().get_name() for element in (a, b)]
                raise Failure(f"{' and '.join(names)} do not fit together")

    def _build(self, properties: Sequence[str]) -> None:
        self.pipeline = Gst.Pipeline.new()
        self._stated = video_errors.StatedLength(self.pipeline)
        self.track = self._make("csdtrack")
        for name, value in PRESET.items():
            Gst.util_set_object_arg(self.track, name, value)
        for assignment in properties:
            name, value = assignment.split("=", 1)
            if name in FIXED:
                raise Misuse(f"{name} can't be set here, quickstart needs it as it is: "
                             "leave that --set out")
            set_from_text(self.track, name, value)
        check_start(self.track)
        # Frames and lines have running times, which rise where a file's own go back.
        self.first = self._make("identity", single_segment=True)
        self._link(self.first, self.track)
        self._times = FrameTimes(Gst, self.first.get_static_pad("src"), "quickstart",
                                 self.name, rising=False)
        if isinstance(self.video, Simulation):
            self._simulate(self.video)
        else:
            self._decode()
        tee = self._make("tee")
        self._link(self.track, tee)
        self._write_overlay(tee)
        self._write_lines(tee, "tracks.jsonl", "track", "application/x-ndjson")
        self._write_lines(tee, "tracks.csv", "track", "text/csv")
        if self.simulated:
            self._write_lines(tee, "truth.jsonl", "truth", "application/x-ndjson")
        self.track.get_static_pad("sink").add_probe(Gst.PadProbeType.EVENT_DOWNSTREAM,
                                                    self._on_event)
        self.track.get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER, self._on_frame)

    def _write_overlay(self, tee: Gst.Element) -> None:
        # Four frames let the threads overlap; more would only take memory.
        queue = self._make("queue", max_size_buffers=4)
        # videocrop 1.22 refuses formats that its caps allow.
        formats = Gst.Caps.from_string(f"video/x-raw, format={{{even_size.FORMATS}}}")
        plain = self._make("capsfilter", caps=formats)
        self.crop = self._make("videocrop")
        self.size = self._make("capsfilter")
        upright = self._make("videoflip")
        Gst.util_set_object_arg(upright, "video-direction", "auto")
        encoder = self._encoder()
        self.mux = self._make("mp4mux")
        # The lines keep the file's times, so that csdtrackdec finds its frames. mp4 needs others
        # where two are equal.
        FrameTimes(Gst, queue.get_static_pad("src"), "quickstart", self.name)
        self._link(tee, queue, self._make("videoconvert"), plain, self.crop,
                   self._make("videoconvert"), self._make("videoscale"),
                   self.size, upright, encoder, self._make("queue"), self.mux,
                   self._sink("overlay.mp4"))

    def _write_lines(self, tee: Gst.Element, name: str, role: str, caps: str) -> None:
        sink = self._sink(name)
        Gst.util_set_object_arg(sink, "buffer-mode", "unbuffered")
        writer = self._make("csdtrackenc")
        Gst.util_set_object_arg(writer, "role", role)
        self._link(tee, self._make("queue", max_size_buffers=4), writer,
                   self._make("capsfilter", caps=Gst.Caps.from_string(caps)), sink)

    def _sink(self, name: str) -> Any:
        # async=false: no sink waits for the others to start, as x264enc outputs nothing until its
        # look-ahead is full.
        return self._make("filesink", location=str(self.folder / name), async_=False)

    def _encoder(self) -> Any:
        # With B-frames, the times of an x264enc whose frames come unevenly are wrong, and so is
        # mp4mux's edit list: players then leave out the last frames.
        encoder = self._make("x264enc", quantizer=21, key_int_max=50, bframes=0)
        Gst.util_set_object_arg(encoder, "pass", "qual")
        Gst.util_set_object_arg(encoder, "speed-preset", "veryfast")
        return encoder

    def _simulate(self, simulation: Simulation) -> None:
        """The simulator gets the user's points or their number, and csdtrack tracks its points."""
        source = self._make("csdsimsrc")
        for assignment in simulation.settings:
            set_from_text(source, *assignment.split("=", 1))
        points = self.track.get_property("points")
        source.set_property("points", "" if points == "truth" else points)
        source.set_property("features", self.track.get_property("max-features"))
        self.track.set_property("points", "truth")
        caps = Gst.Caps.from_string(SIMULATED)
        _known, over, under = first_structure(caps).get_fraction("framerate")
        self.duration = Gst.util_uint64_scale(source.get_property("num-buffers"),
                                              under * Gst.SECOND, over)
        tee = self._make("tee")
        self._link(source, self._make("capsfilter", caps=caps), tee, self.first)
        self._link(tee, self._make("queue", max_size_buffers=4), self._make("videoconvert"),
                   self._encoder(), self._make("queue"), self._make("mp4mux"),
                   self._sink("clean.mp4"))
        self._feeds.append(tee.get_static_pad("sink"))

    def _decode(self) -> None:
        source, decode = self._make("filesrc", location=str(self.video)), self._make("decodebin")
        self._link(source, decode)
        decode.connect("autoplug-continue", self._on_autoplug_continue)
        decode.connect("pad-added", self._on_pad_added)
        decode.connect("no-more-pads", self._on_no_more_pads)

    def _on_autoplug_continue(self, _decodebin: Gst.Element, _pad: Gst.Pad,
                              caps: Gst.Caps) -> bool:
        """False for sound that can be copied into the mp4 now that it is parsed."""
        structure = first_structure(caps)
        parsed = any(structure.has_field(field) and structure.get_boolean(field)[1]
                     for field in ("framed", "parsed"))
        needs_parsing = structure.get_name() in ("audio/mpeg", "audio/x-ac3")
        return not (sound.copied(caps) and (parsed or not needs_parsing))

    def _on_pad_added(self, _decodebin: Gst.Element, pad: Gst.Pad) -> None:
        """decodebin adds all pads before data flows, so mp4mux gets all its inputs in time."""
        try:
            caps = pad.get_current_caps() or pad.query_caps(None)
            name = first_structure(caps).get_name()
            if name == "video/x-raw":
                size = [first_structure(caps).get_int(side)[1] for side in ("width", "height")]
                self._pictures.append((size[0] * size[1], pad, caps))
            elif name.startswith("audio/"):
                self._add_sound(pad, caps)
        except Failure as failure:
            self._fail(str(failure))

    def _feed(self, pad: Gst.Pad, element: Gst.Element) -> None:
        sink = element.get_static_pad("sink")
        if pad.link(sink) != Gst.PadLinkReturn.OK:
            raise Failure(f"'{self.video}' has a stream that can't be used: "
                          f"{pad.get_current_caps().to_string()}")
        self._feeds.append(sink)

    def _add_video(self, pad: Gst.Pad, caps: Gst.Caps) -> None:
        known, over, under = first_structure(caps).get_fraction("pixel-aspect-ratio")
        # avidemux gives some files -1/1, which no encoder takes.
        if known and (over <= 0 or under <= 0):
            convert = self._make("capssetter",
                                 caps=Gst.Caps.from_string("video/x-raw, pixel-aspect-ratio=1/1"))
        elif caps.can_intersect(self.track.get_static_pad("sink").query_caps(None)):
            self._feed(pad, self.first)
            return
        else:
            convert = self._make("videoconvert")
        self._link(convert, self.first)
        self._feed(pad, convert)
        convert.sync_state_with_parent()

    def _add_sound(self, pad: Gst.Pad, caps: Gst.Caps) -> None:
        entry = sound.copied(caps)
        if entry:
            _, parser = entry
            chain = [self._make(parser)] if parser else []
            self.sound.append("copied")
        else:
            chain = [
                self._make("audioconvert"),
                self._make("audioresample"),
                self._make("avenc_aac", bitrate=160000),
                self._make("aacparse")
            ]
            self.sound.append("encoded as AAC")
        # Sound waits for the encoder's look-ahead, which is minutes of a slow video: so only bytes
        # bound it.
        chain.append(
            self._make("queue", max_size_time=0, max_size_buffers=0, max_size_bytes=64 << 20))
        self._link(*chain, self.mux)
        self._feed(pad, chain[0])
        for element in reversed(chain):
            element.sync_state_with_parent()

    def _on_no_more_pads(self, _decodebin: Gst.Element) -> None:
        if self._pictures:
            # A small one may be a thumbnail. Of equal ones the first counts.
            area, pad, caps = max(self._pictures, key=lambda picture: picture[0])
            if len(self._pictures) > 1:
                self.warnings.append(f"'{self.video}' has {len(self._pictures)} pictures: the "
                                     "largest is tracked")
            try:
                self._add_video(pad, caps)
            except Failure as failure:
                self._fail(str(failure))
        elif self._missing:
            self._fail(video_errors.missing_decoder(self.video, self._missing[0]))
        else:
            self._fail(f"'{self.video}' has no video stream: give a file with a picture")

    def _on_event(self, _pad: Gst.Pad, info: Gst.PadProbeInfo) -> Any:
        event = info.get_event()
        if event.type == Gst.EventType.TAG:
            known, orientation = event.parse_tag().get_string(Gst.TAG_IMAGE_ORIENTATION)
            self.turned = self.turned or known and orientation != "rotate-0"
        if event.type == Gst.EventType.SEGMENT:
            event.copy_segment(self._segment)
        if event.type == Gst.EventType.CAPS and not self.picture:
            self._on_caps(first_structure(event.parse_caps()))
        return Gst.PadProbeReturn.OK

    def _on_caps(self, structure: Gst.Structure) -> None:
        width, height = structure.get_int("width")[1], structure.get_int("height")[1]
        self.picture = f"{width}×{height} {structure.get_string('format')}"
        if min(width, height) < 16:
            self._fail(f"'{self.video}' has {width}×{height} pixels, "
                       "and overlay.mp4 can't have fewer than 16×16")
        # H.264 4:2:0 has even sizes only: overlay.mp4 lacks the last column or row of an odd size.
        # The tracks are of the whole picture.
        self.crop.set_property("right", width % 2)
        self.crop.set_property("bottom", height % 2)
        even = f"width={max(2, width & ~1)}, height={max(2, height & ~1)}"
        # mp4 holds one size and one pixel aspect. Where they change, videoscale adds borders.
        known, over, under = structure.get_fraction("pixel-aspect-ratio")
        aspect = f", pixel-aspect-ratio={over}/{under}" if known else ""
        self.size.set_property("caps",
                               Gst.Caps.from_string(f"video/x-raw, format=I420, {even}{aspect}"))

    def _on_frame(self, _pad: Gst.Pad, info: Gst.PadProbeInfo) -> Any:
        self.frames += 1
        buffer = info.get_buffer()
        if buffer.pts != Gst.CLOCK_TIME_NONE:
            length = buffer.duration if buffer.duration != Gst.CLOCK_TIME_NONE else 0
            end = self._segment.to_stream_time(Gst.Format.TIME, buffer.pts + length)
            if end != Gst.CLOCK_TIME_NONE:
                self.position = max(self.position, end)
        return Gst.PadProbeReturn.OK

    # ---- The run ----

    def run(self, progress: ProgressDisplay) -> None:
        """Tracks the whole file. Raises Failure if there is no result."""
        bus = self.pipeline.get_bus()
        bus.add_signal_watch()
        bus.connect("message", self._on_message)
        for number in (signal.SIGINT, signal.SIGTERM, *command.not_ignored(signal.SIGHUP)):
            GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, number, self._on_signal)
        GLib.timeout_add(200, self._tick, progress)
        self._started = started = time.monotonic()
        self.pipeline.set_state(Gst.State.PLAYING)
        self._loop.run()
        self.seconds = time.monotonic() - started
        self.stats = self.track.get_property("stats")
        self._query_duration()
        self.pipeline.set_state(Gst.State.NULL)
        bus.remove_signal_watch()
        if self._failure is None and self.frames == 0:
            self._failure = video_errors.no_frame(self.video)
        if self._failure is not None:
            raise Failure(self._failure)
        if (self.simulated or self._stated.known) and not self.cut_short:
            self.cut_short = video_errors.breaks_off(self.video, self.position, self.duration)
        if not self.cut_short:
            progress.done(self.frames)

    def differences(self) -> list[str]:
        """What is not as it should be, each in some words: each frame has its packet and line."""
        found = [f"{self._times.frames} frames came, and {self.frames} were tracked"
                 ] if self._times.frames != self.frames else []
        texts = ["tracks.jsonl", "truth.jsonl"] if self.simulated else ["tracks.jsonl"]
        found += [counts.missing_lines(self.folder / name, self.frames) for name in texts]
        videos = ["overlay.mp4", "clean.mp4"] if self.simulated else ["overlay.mp4"]
        for name in videos:
            try:
                packets = counts.packets_in(Gst, self.folder / name)
            except Failure as failure:
                found.append(f"{name} could not be read back: {failure}")
                continue
            if packets != self.frames:
                found.append(f"{name} holds {packets} of {self.frames} frames")
        return [text for text in found if text]

    def _tick(self, progress: ProgressDisplay) -> bool:
        # decodebin drops an error that arrives while it links elements (qtdemux, 1 of 10 runs with
        # a file without an index), and then hangs.
        if not self._feeds and not self._ending and time.monotonic() - self._started > SILENCE:
            self._fail(
                f"'{self.video}' shows no stream: check that it plays, or convert it to H.264")
        self._query_duration()
        # Frames may have no timestamps.
        known = self.duration and (self.position or not self.frames)
        progress.show(self.position / self.duration if known else None, self.frames)
        return True

    def _query_duration(self) -> None:
        known, duration = self.pipeline.query_duration(Gst.Format.TIME)
        if known and duration > 0:
            self.duration = duration

    def _fail(self, text: str) -> None:
        self._failure = self._failure or text
        GLib.idle_add(self._loop.quit)

    def _on_signal(self) -> bool:
        if self.frames == 0:
            self._fail("ended before the first frame, as you asked: nothing was made")
        self._end("ended early, as you asked")
        return True

    def _end(self, why: str) -> None:
        """Ends the streams here, so that each file is closed properly."""
        if self._ending:
            return
        self._ending = True
        self.cut_short = why
        # In threads, as a pad takes an event only between two buffers.
        for pad in self._feeds:
            threading.Thread(target=pad.send_event, args=(Gst.Event.new_eos(),),
                             daemon=True).start()
        GLib.timeout_add_seconds(CLOSING, self._fail,
                                 f"{why}; the files could not be closed in {CLOSING} s")

    def _on_message(self, _bus: Gst.Bus, message: Gst.Message) -> None:
        if message.type == Gst.MessageType.EOS:
            self._loop.quit()
        elif message.type == Gst.MessageType.ERROR:
            self._on_error(message)
        elif message.type == Gst.MessageType.WARNING and message.src == self.track:
            self.warnings.append(f"csdtrack: {message.parse_warning()[0].message}")
        elif message.type == Gst.MessageType.ELEMENT and message.has_name("missing-plugin"):
            self._missing.append(message.get_structure().get_string("name"))

    def _on_error(self, message: Gst.Message) -> None:
        error, debug = message.parse_error()
        name = video_errors.factory_name(message.src)
        text = video_errors.explain(self.video, self.out,
                                    self.track.get_factory().get_name(), name, error, debug or "",
                                    self._missing)
        ours = message.src in self._made and name not in ("filesrc", "decodebin")
        if self.frames > 0 and not ours:
            reason = error.message.rstrip(".")
            self._end(f"'{self.video}' is damaged from frame {self.frames} on ({reason}): "
                      "the tracks end there")
        elif not self._ending:
            self._fail(text)
