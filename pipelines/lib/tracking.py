# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks a video: one GStreamer pipeline from a video to the same video with markers and its tracks.

    filesrc ! decodebin ! csdtrack overlay=draw ! tee ─ queue ! x264enc ─┐
                 │ sound, copied or encoded as AAC ! queue ────────────── mp4mux ! overlay.mp4
                 tee ─ queue ! csdtrackenc ! tracks.jsonl
                 tee ─ queue ! csdtrackenc ! tracks.csv

Without a file, csdsimsrc stands instead of filesrc and decodebin, a branch as those of the tracks writes truth.jsonl, and one before
csdtrack writes clean.mp4, the video without markers, for the page.
A video that its file wants turned (as phones write them) is turned behind csdtrack: mp4mux 1.22 can't write that wish.
"""

import signal
import threading
import time

import gi

from pipelines.lib import command
from pipelines.lib.caps import first_structure
from pipelines.lib.failure import NO_VIDEO, Failure, Misuse, no_video, of_filesink
from pipelines.lib.properties import check_start, choices, set_from_text, settable

gi.require_version("Gst", "1.0")
from gi.repository import GLib, GObject, Gst  # noqa: E402

Gst.init(None)

# Encoded sound that mp4mux takes: caps name and fields, and the parser that brings it into mp4's
# form.
COPIED = (
    ("audio/mpeg, mpegversion=(int)4", "aacparse"),
    ("audio/mpeg, mpegversion=(int)1, layer=(int)3", "mpegaudioparse"),
    ("audio/x-ac3", "ac3parse"),
    ("audio/x-opus, channel-mapping-family=(int)0", "opusparse"),
    ("audio/x-alac", None),
)


PRESET = {"overlay": "draw", "learning": "sync"}
# No --set: the results depend on these.
KEPT = ("attach-meta", "overlay")

SIMULATED = "video/x-raw, width=640, height=480, framerate=25/1"

SILENCE = 60  # seconds without a stream, after which none is waited for


class Simulation:
    """What stands instead of a file: settings of csdsimsrc, each NAME=VALUE, num-buffers among them."""

    def __init__(self, settings):
        self.settings = settings
        self.name = f"simulated tissue, {', '.join(settings)}"


class Job:
    """One run over one video. After run(): frames, seconds, stats and the like say what happened."""

    def __init__(self, video, out, folder, properties):
        """video: a path or a Simulation; out: what the user calls the folder of the results; folder: where they are
        made."""
        self.simulated = isinstance(video, Simulation)
        self.video, self.out, self.folder = video, out, folder
        self.frames = 0
        self.position = 0  # ns in the video, end of the newest frame
        self.duration = 0  # ns, of the file as it says itself; 0 if it doesn't
        self.picture = ""
        self.turned = False  # overlay.mp4 is, as the file asks; the tracks are not
        self.sound = []
        self.seconds = 0.0
        self.stats = None
        self.warnings = []  # of csdtrack, each a line
        self.cut_short = ""  # why the tracks end before the video does
        self._missing = []
        self._segment = Gst.Segment()
        self._feeds = []  # sink pads that decodebin feeds
        self._loop = GLib.MainLoop()
        self._failure = None
        self._started = 0.0
        self._ending = False
        if not self.simulated and lacks_index(video):
            raise Failure(no_index(video))
        self._build(properties)

    # ---- the pipeline
    # ----------------------------------------------------------------------------------------------

    def _make(self, factory, **properties):
        element = Gst.ElementFactory.make(factory)
        if element is None:
            raise Failure(
                f"GStreamer has no element '{factory}': run without --no-install, or install its package"
            )
        for name, value in properties.items():
            element.set_property(name.strip("_").replace("_", "-"), value)
        self.pipeline.add(element)
        return element

    def _chain(self, *elements):
        for a, b in zip(elements, elements[1:]):
            if not a.link(b):
                raise Failure(
                    f"{a.get_factory().get_name()} and {b.get_factory().get_name()} do not fit together"
                )

    def _build(self, properties):
        self.pipeline = Gst.Pipeline.new()
        self.track = self._make("csdtrack")
        for name, value in PRESET.items():
            Gst.util_set_object_arg(self.track, name, value)
        for assignment in properties:
            name, value = assignment.split("=", 1)
            if name in KEPT:
                raise Misuse(
                    f"{name} can't be set here, quickstart needs it as it is: leave that --set out")
            set_from_text(self.track, name, value)
        check_start(self.track)
        if self.simulated:
            self._simulate()
        else:
            self._decode()
        tee = self._make("tee")
        self._chain(self.track, tee)

        # Four frames are enough for the threads to overlap; more would only hold memory.
        self.crop = self._make("videocrop")
        self.size = self._make("capsfilter")
        upright = self._make("videoflip")
        Gst.util_set_object_arg(upright, "video-direction", "auto")
        encoder = self._encoder()
        self.mux = self._make("mp4mux")
        # async=false: no sink waits for the others to start, for x264enc says nothing before its
        # look-ahead is full.
        sink = self._make("filesink", location=str(self.folder / "overlay.mp4"), async_=False)
        self._chain(tee, self._make("queue", max_size_buffers=4), self.crop,
                    self._make("videoconvert"), self._make("videoscale"), self.size, upright,
                    encoder, self._make("queue"), self.mux, sink)
        texts = [("tracks.jsonl", "track", "application/x-ndjson"),
                 ("tracks.csv", "track", "text/csv")]
        if self.simulated:
            texts.append(("truth.jsonl", "truth", "application/x-ndjson"))
        for name, role, caps in texts:
            sink = self._make("filesink", location=str(self.folder / name), async_=False)
            Gst.util_set_object_arg(sink, "buffer-mode", "unbuffered")
            writer = self._make("csdtrackenc")
            Gst.util_set_object_arg(writer, "role", role)
            self._chain(tee, self._make("queue", max_size_buffers=4), writer,
                        self._make("capsfilter", caps=Gst.Caps.from_string(caps)), sink)

        self.track.get_static_pad("sink").add_probe(Gst.PadProbeType.EVENT_DOWNSTREAM, self._event)
        self.track.get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER, self._frame)

    def _encoder(self):
        encoder = self._make("x264enc", quantizer=21, key_int_max=50)
        Gst.util_set_object_arg(encoder, "pass", "qual")
        Gst.util_set_object_arg(encoder, "speed-preset", "veryfast")
        return encoder

    def _simulate(self):
        """The points to track, or how many to look for, are the truth's, and csdtrack has them from there."""
        source = self._make("csdsimsrc")
        for assignment in self.video.settings:
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
        self._chain(source, self._make("capsfilter", caps=caps), tee, self.track)
        self._chain(tee, self._make("queue", max_size_buffers=4), self._make("videoconvert"),
                    self._encoder(), self._make("queue"), self._make("mp4mux"),
                    self._make("filesink", location=str(self.folder / "clean.mp4"), async_=False))
        self._feeds.append(tee.get_static_pad("sink"))

    def _decode(self):
        source, decode = self._make("filesrc", location=str(self.video)), self._make("decodebin")
        self._chain(source, decode)
        decode.connect("autoplug-continue", self._decode_further)
        decode.connect("pad-added", self._stream)
        decode.connect("no-more-pads", self._streams_known)

    def _decode_further(self, _decodebin, _pad, caps):
        """False where the sound, once parsed, can be copied into the mp4 as it is."""
        structure = first_structure(caps)
        parsed = any(
            structure.has_field(f) and structure.get_boolean(f)[1] for f in ("framed", "parsed"))
        needs_parsing = structure.get_name() in ("audio/mpeg", "audio/x-ac3")
        return not (copied(caps) and (parsed or not needs_parsing))

    def _stream(self, _decodebin, pad):
        """decodebin shows all streams of the file before it lets data flow, so mp4mux learns of all in time."""
        try:
            caps = pad.get_current_caps() or pad.query_caps(None)
            name = first_structure(caps).get_name()
            if name == "video/x-raw" and not self.track.get_static_pad("sink").is_linked():
                self._video_stream(pad, caps)
            elif name.startswith("audio/"):
                self._audio_stream(pad, caps)
        except Failure as failure:
            self._fail(str(failure))

    def _feed(self, pad, element):
        sink = element.get_static_pad("sink")
        if pad.link(sink) != Gst.PadLinkReturn.OK:
            raise Failure(
                f"'{self.video}' has a stream that can't be used: {pad.get_current_caps().to_string()}"
            )
        self._feeds.append(sink)

    def _video_stream(self, pad, caps):
        known, over, under = first_structure(caps).get_fraction("pixel-aspect-ratio")
        # avidemux makes -1/1 of some files, which no encoder takes
        if known and (over <= 0 or under <= 0):
            convert = self._make("capssetter",
                                 caps=Gst.Caps.from_string("video/x-raw, pixel-aspect-ratio=1/1"))
        elif caps.can_intersect(self.track.get_static_pad("sink").query_caps(None)):
            return self._feed(pad, self.track)
        else:
            convert = self._make("videoconvert")
        self._chain(convert, self.track)
        self._feed(pad, convert)
        convert.sync_state_with_parent()

    def _audio_stream(self, pad, caps):
        parser = copied(caps)
        if parser:
            chain = [self._make(parser[1])] if parser[1] else []
            self.sound.append("copied")
        else:
            chain = [
                self._make("audioconvert"),
                self._make("audioresample"),
                self._make("avenc_aac", bitrate=160000),
                self._make("aacparse")
            ]
            self.sound.append("encoded as AAC")
        # Sound waits for the encoder's look-ahead, which in a slow video is minutes: bounded by
        # bytes alone.
        chain.append(
            self._make("queue", max_size_time=0, max_size_buffers=0, max_size_bytes=64 << 20))
        self._chain(*chain, self.mux)
        self._feed(pad, chain[0])
        for element in reversed(chain):
            element.sync_state_with_parent()

    def _streams_known(self, _decodebin):
        if not self.track.get_static_pad("sink").is_linked():
            if self._missing:
                self._fail(
                    f"'{self.video}' needs a {self._missing[0]} that this machine does not have: install it, or "
                    "convert the video to H.264")
            else:
                self._fail(f"'{self.video}' has no video stream: give a file with a picture")

    def _event(self, _pad, info):
        event = info.get_event()
        if event.type == Gst.EventType.TAG:
            known, orientation = event.parse_tag().get_string(Gst.TAG_IMAGE_ORIENTATION)
            self.turned = self.turned or known and orientation != "rotate-0"
        if event.type == Gst.EventType.SEGMENT:
            event.copy_segment(self._segment)
        if event.type == Gst.EventType.CAPS and not self.picture:
            structure = first_structure(event.parse_caps())
            width, height = structure.get_int("width")[1], structure.get_int("height")[1]
            self.picture = f"{width}×{height} {structure.get_string('format')}"
            if min(width, height) < 16:
                self._fail(
                    f"'{self.video}' has {width}×{height} pixels, and overlay.mp4 can't have fewer than 16×16"
                )
            # H.264 4:2:0 has even sizes only: the last column or row stays out of overlay.mp4, not
            # out of the tracks.
            self.crop.set_property("right", width % 2)
            self.crop.set_property("bottom", height % 2)
            self.size.set_property(
                "caps",
                Gst.Caps.from_string(
                    f"video/x-raw, format=I420, width={max(2, width & ~1)}, height={max(2, height & ~1)}"
                ))
        return Gst.PadProbeReturn.OK

    def _frame(self, pad, info):
        self.frames += 1
        buffer = info.get_buffer()
        if buffer.pts != Gst.CLOCK_TIME_NONE:
            length = buffer.duration if buffer.duration != Gst.CLOCK_TIME_NONE else 0
            end = self._segment.to_stream_time(Gst.Format.TIME, buffer.pts + length)
            if end != Gst.CLOCK_TIME_NONE:
                self.position = max(self.position, end)
        return Gst.PadProbeReturn.OK

    # ---- running it
    # ------------------------------------------------------------------------------------------------

    def run(self, progress):
        """Tracks the whole file. Raises Failure if nothing came of it."""
        bus = self.pipeline.get_bus()
        bus.add_signal_watch()
        bus.connect("message", self._message)
        for number in (signal.SIGINT, signal.SIGTERM, *command.heard(signal.SIGHUP)):
            GLib.unix_signal_add(GLib.PRIORITY_DEFAULT, number, self._interrupted)
        GLib.timeout_add(200, self._tick, progress)
        self._started = started = time.monotonic()
        self.pipeline.set_state(Gst.State.PLAYING)
        self._loop.run()
        self.seconds = time.monotonic() - started
        self.stats = self.track.get_property("stats")
        self._ask_duration()
        self.pipeline.set_state(Gst.State.NULL)
        bus.remove_signal_watch()
        if self._failure is None and self.frames == 0:
            self._failure = no_frame(self.video)
        if self._failure is not None:
            raise Failure(self._failure)
        self.cut_short = self.cut_short or breaks_off(self.video, self.position, self.duration)
        if not self.cut_short:
            progress.done(self.frames)

    def _tick(self, progress):
        # decodebin drops an error that comes while it plugs elements together (seen with qtdemux, 1
        # run in 10 of a file without an index), and then nothing ever happens.
        if not self._feeds and not self._ending and time.monotonic() - self._started > SILENCE:
            self._fail(
                f"'{self.video}' shows no stream: check that it plays, or convert it to H.264")
        self._ask_duration()
        # frames may be without timestamps
        known = self.duration and (self.position or not self.frames)
        progress.show(self.position / self.duration if known else None, self.frames)
        return True

    def _ask_duration(self):
        known, duration = self.pipeline.query_duration(Gst.Format.TIME)
        if known and duration > 0:
            self.duration = duration

    def _fail(self, text):
        self._failure = self._failure or text
        GLib.idle_add(self._loop.quit)

    def _interrupted(self):
        if self.frames == 0:
            self._fail("ended before the first frame, as you asked: nothing was made")
        self._end("ended early, as you asked")
        return True

    def _end(self, why):
        """Lets what is under way come to a proper end: each file is closed as if the video ended here."""
        if self._ending:
            return
        self._ending = True
        self.cut_short = why
        for pad in self._feeds:  # a pad takes an event only between two buffers, so this may wait
            threading.Thread(target=pad.send_event, args=(Gst.Event.new_eos(), ),
                             daemon=True).start()
        GLib.timeout_add_seconds(30, self._fail, "the files could not be closed: try again")

    def _message(self, _bus, message):
        if message.type == Gst.MessageType.EOS:
            self._loop.quit()
        elif message.type == Gst.MessageType.ERROR:
            self._error(message)
        elif message.type == Gst.MessageType.WARNING and message.src == self.track:
            self.warnings.append(f"csdtrack: {message.parse_warning()[0].message}")
        elif message.type == Gst.MessageType.ELEMENT and message.has_name("missing-plugin"):
            self._missing.append(message.get_structure().get_string("name"))

    def _error(self, message):
        error, debug = message.parse_error()
        factory = message.src.get_factory() if isinstance(message.src, Gst.Element) else None
        name = factory.get_name() if factory else ""
        text = explain(self.video, self.out,
                       self.track.get_factory().get_name(), name, error, debug or "", self._missing)
        ours = name in ("filesink", "mp4mux", "x264enc", "csdsimsrc", "csdtrack", "csdtrackenc")
        if self.frames > 0 and not ours:
            self._end(
                f"'{self.video}' is damaged from frame {self.frames} on ({error.message.rstrip('.')}): "
                "the tracks end there")
        elif not self._ending:
            self._fail(text)


def lacks_index(path):
    """Whether this is an mp4 (or mov) whose moov box is missing: the recording ended before it was written."""
    boxes = []
    try:
        with open(path, "rb") as file:
            end = file.seek(0, 2)
            at = 0
            while at + 8 <= end and len(boxes) < 1000:
                file.seek(at)
                head = file.read(16)
                size, kind = int.from_bytes(head[:4], "big"), head[4:8]
                if not boxes and kind != b"ftyp":
                    return False
                boxes.append(kind)
                if size == 1 and len(head) == 16:
                    size = int.from_bytes(head[8:16], "big")
                if size < 8:  # 0: up to the end
                    break
                at += size
    except OSError:
        return False  # filesrc says it better
    return bool(boxes) and b"moov" not in boxes


def no_index(video):
    return (
        f"'{video}' has no index, its recording was cut off: repair it with a tool such as untrunc, and record "
        "to .mkv or fragmented mp4")


def copied(caps):
    """The entry of COPIED that these caps fall under, or None."""
    for entry in COPIED:
        if caps.can_intersect(Gst.Caps.from_string(entry[0])):
            return entry
    return None


def settable_properties():
    """For each property of csdtrack that --set takes: name, values, default and what it is, as text."""
    track = Gst.ElementFactory.make("csdtrack")
    for name, spec in settable(track).items():
        if name in KEPT:
            continue
        default, minimum = spec.default_value, getattr(spec, "minimum", None)
        if spec.value_type.is_a(GObject.TYPE_ENUM):
            values = " | ".join(choices(track, name))
            default = track.get_property(name).value_nick  # spec's is a number with PyGObject 3.50
        elif spec.value_type == GObject.TYPE_BOOLEAN:
            values, default = "true | false", str(default).lower()
        elif minimum is not None:
            values = f"{minimum} to {spec.maximum}"
        else:
            values, default = "text", default or "empty"
        if name in PRESET:
            default += f"; quickstart: {PRESET[name]}"
        yield name, values, default, spec.blurb


def breaks_off(video, position, duration):
    """What to say if the picture ends at `position` ns, well before what the file says of itself; else ""."""
    if not position or duration - position <= max(Gst.SECOND, duration // 50):
        return ""
    return (
        f"'{video}' has a picture up to {position / Gst.SECOND:.1f} s only, and says that it lasts "
        f"{duration / Gst.SECOND:.1f} s: is the file complete?")


def no_frame(video):
    return f"'{video}' has no frame that could be decoded: is the file complete?"


def explain(video, out, tracker, element, error, debug, missing):
    """One line for a user, from an error message of GStreamer."""
    if element == "filesink":
        return str(of_filesink(out, error, debug))
    if element == "filesrc":
        return f"'{video}' can't be read ({error.message.rstrip('.')}): check the file and its disk"
    if element in (tracker, "csdsimsrc", "csdtrackenc"):
        return f"{element}: {error.message}"
    if element == "qtdemux" and ("moov" in debug or "incomplete" in error.message):
        return no_index(video)
    # GStreamer 1.26; 1.22 ends such a file like any other
    if element == "decodebin" and "without buffers" in debug:
        return no_frame(video)
    if missing:
        return f"'{video}' needs a {missing[0]} that this machine does not have: install it, or convert the video to H.264"
    if no_video(error):
        return f"'{video}' {NO_VIDEO}"
    return f"'{video}' can't be decoded ({error.message.rstrip('.')}): check that it plays, or convert it to H.264"
