# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs a pipeline of these commands until it ends, is told to, or fails."""

import re
import signal
import sys
import threading
import time

import gi

from pipelines.lib import command, supervisor
from pipelines.lib.failure import NO_VIDEO, no_video, one_line
from pipelines.lib.properties import check_start, set_from_text

gi.require_version("Gst", "1.0")
from gi.repository import GLib, Gst  # noqa: E402

Gst.init(None)

# What rtspsrc says of a sender that has ended without a word of farewell, and of a connection that
# was reset or timed out, or that it could not make again.
GONE = ("The server closed the connection",)
LOST = ("Could not receive message", "Could not connect to server")

PATIENCE = 3  # seconds for the source to end, once it was told to
# seconds in which nothing has moved, after which what is still in the pipeline is given up
END = 10


def configure(track, preset, properties, wished):
    """A preset, then these properties, then what the user wishes: [(name, value)]. Raises command.Misuse, and
    command.Failure where it can't start."""
    if preset and not track.load_preset(preset):
        raise command.Misuse(
            f"there is no preset '{preset}': {', '.join(track.get_preset_names())}")
    for name, value in [*properties.items(), *wished]:
        set_from_text(track, name, value)
    check_start(track)


def say_cost(track, came=None):
    """`came`: how many frames there were, where not each was tracked."""
    stats = track.get_property("stats")
    frames = stats.get_value("frames")
    tracked = f"{frames} frames" if came in (None,
                                             frames) else f"{frames} of {came} frames were tracked"
    command.told(
        f"{tracked}; tracking cost {stats.get_value('time-p50') / 1e6:.1f} ms a frame (p50), "
        f"{stats.get_value('time-p95') / 1e6:.1f} ms (p95)", sys.stdout)


def says(text, parts):
    return any(part in (text or "") for part in parts)


class Run:
    SILENCE = 10  # seconds without a first picture
    NO_PICTURE = "is it connected, and on?"

    def __init__(self, name, text, counted=("csdtrack",)):
        """`counted`: the elements that must get a picture."""
        self._name = name
        try:
            self.pipeline = Gst.parse_launch(text)
        except GLib.Error as error:
            raise command.Failure(one_line(error.message)) from error
        self._loop = GLib.MainLoop()
        self._failure = None
        self._source, self._harmless, self._through, self._seconds = "", (), "", None
        self.told = False  # by a signal, to end
        self.ending = None  # when it was first told to end, by time.monotonic()
        self.live = False  # known from before the first frame
        self.over = False  # the source ended by itself
        self.warnings = set()
        self._counts = dict.fromkeys(counted, 0)

    @property
    def frames(self):
        """How many came to the element that got the fewest."""
        return min(self._counts.values())

    def element(self, name):
        return self.pipeline.get_by_name(name)

    def play(self, source, seconds=None, harmless=(), through="", leaky=()):
        """Until it ends, or `seconds` after the first picture. `source`: what the user calls it, "" where errors name it themselves. `harmless`:
        parts of the texts of errors that are an end like any other. What has come is still written if the sender is gone or its connection is
        lost; with `through`, the element that all pictures come through, also at any error before that. Raises command.Failure, also if no
        picture comes from the source. `leaky`: the queues that drop frames if the source is live, for what is old is of no use then. A file is
        read faster than it is shown: of that they would drop most."""
        self._source, self._harmless, self._through, self._seconds = str(
            source), harmless, through, seconds
        for name in self._counts:
            self.element(name).get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER,
                                                                self._count, name)

        self._give_signs()

        def listen():
            if not self.frames:
                self.fail(f"no picture came in {self.SILENCE} s: {self.NO_PICTURE}")
            return GLib.SOURCE_REMOVE

        GLib.timeout_add_seconds(self.SILENCE, listen)
        bus = self.pipeline.get_bus()
        bus.add_signal_watch()
        bus.connect("message", lambda _, message: self._handle(message))
        for number in (signal.SIGINT, signal.SIGTERM):
            GLib.unix_signal_add(GLib.PRIORITY_HIGH, number, self._tell)
        for number in command.heard(signal.SIGHUP):
            GLib.unix_signal_add(GLib.PRIORITY_HIGH, number, self._hang_up)
        # A live source has no picture before it plays: that is how it is told from a file.
        paused = self.pipeline.set_state(Gst.State.PAUSED)
        if paused == Gst.StateChangeReturn.NO_PREROLL:
            self.live = True
            for name in leaky:
                self.element(name).set_property("leaky", "downstream")
        # Else when it says that it is paused: a GstBin that is told to play before may forget that
        # it does, and then never tells that the stream has ended (GStreamer 1.22; gst-launch-1.0
        # stood still 8 of 20 times on a busy machine).
        if paused != Gst.StateChangeReturn.ASYNC:
            self.pipeline.set_state(Gst.State.PLAYING)
        try:
            self._loop.run()
        finally:
            self.pipeline.set_state(Gst.State.NULL)
            bus.remove_signal_watch()
        if not self.frames:
            self.fail(f"no picture came: {self.NO_PICTURE}")
        if self._failure:
            raise command.Failure(self._failure)

    def _give_signs(self):
        """To the supervisor, if there is one: of pictures from the source, tracked or not, for tracking must not end a recording."""
        came = told = 0

        def count(_pad, _info):
            nonlocal came
            if not came:
                supervisor.tell("READY=1")
            came += 1
            return Gst.PadProbeReturn.OK

        def tell():
            nonlocal told
            if came != told:
                told = came
                supervisor.tell("WATCHDOG=1")
            return GLib.SOURCE_CONTINUE

        self.element(self._through or next(iter(self._counts))).get_static_pad("sink").add_probe(
            Gst.PadProbeType.BUFFER, count)
        if interval := supervisor.interval():
            GLib.timeout_add(interval, tell)

    def end(self):
        """The source ends. What has come from it is still written, however long that takes."""
        if not self.ending:
            self.ending = time.monotonic()
            self._drain()
            if not self.pipeline.send_event(Gst.Event.new_eos()):
                self._loop.quit()
            GLib.timeout_add_seconds(PATIENCE, self._cut)
        return GLib.SOURCE_REMOVE

    def _elements(self):
        """All that are no bins."""
        found = []
        self.pipeline.iterate_recurse().foreach(
            lambda element: isinstance(element, Gst.Bin) or found.append(element))
        return found

    def _cut(self):
        """A source that doesn't end when told to (avdemux_gif seeks none, it reads on for ever) is cut off where it gives buffers away: what it has
        given is not lost. It is what nothing pushes buffers into: a source, or a demuxer that fetches them."""
        for element in self._elements():
            if all(pad.mode == Gst.PadMode.PULL for pad in element.sinkpads):
                for pad in element.srcpads:
                    if pad.mode == Gst.PadMode.PUSH and not pad.get_sticky_event(
                            Gst.EventType.EOS, 0):
                        # It waits until the buffer is taken that is just given away.
                        threading.Thread(target=pad.push_event, args=(Gst.Event.new_eos(), ),
                                         daemon=True).start()
        return GLib.SOURCE_REMOVE

    def _drain(self):
        """Waits for the end as long as something moves: a slow encoder is waited for, a disk that stands still is not."""
        moved = time.monotonic()

        def move(*_):
            nonlocal moved
            moved = time.monotonic()
            return Gst.PadProbeReturn.OK

        def look():
            if time.monotonic() - moved < END:
                return GLib.SOURCE_CONTINUE
            self._loop.quit()
            return GLib.SOURCE_REMOVE

        for element in self._elements():
            for pad in element.sinkpads:
                pad.add_probe(Gst.PadProbeType.BUFFER | Gst.PadProbeType.BUFFER_LIST, move)
        GLib.timeout_add_seconds(1, look)

    def _tell(self):
        self.told = True
        return self.end()

    def _hang_up(self):
        """The terminal is gone. A shell passes that on and the system says it again: a second time must not end at once."""
        if not self.ending:
            self._tell()
        return GLib.SOURCE_CONTINUE

    def fail(self, text, sources_fault=True):
        self._failure = self._failure or (f"{self._source}: {text}"
                                          if self._source and sources_fault else text)
        self._loop.quit()

    def _count(self, _pad, _info, name):
        self._counts[name] += 1
        if self._seconds and self.frames:
            seconds, self._seconds = self._seconds, None
            GLib.timeout_add(int(seconds * 1000), self.end)
        return Gst.PadProbeReturn.OK

    def _handle(self, message):
        if message.type == Gst.MessageType.EOS:
            self.over = not self.ending
            self._loop.quit()
        elif message.type == Gst.MessageType.ASYNC_DONE and message.src == self.pipeline:
            self.pipeline.set_state(Gst.State.PLAYING)
        elif message.type == Gst.MessageType.ERROR:
            self._error(message.src, *message.parse_error())
        elif message.type == Gst.MessageType.WARNING:
            warning, debug = message.parse_warning()
            text = one_line(warning.message)
            if says(debug, GONE):
                if not self.frames:
                    self.fail("the connection ended before a picture came")
            elif warning.matches(Gst.ParseError.quark(),
                                 Gst.ParseError.DELAYED_LINK) and not self.frames:
                self._no_picture(message.src)
            elif warning.matches(
                    Gst.StreamError.quark(),
                    Gst.StreamError.CODEC_NOT_FOUND) and not re.search("'(video|image)/", text):
                pass  # sound and the like, which nobody asked for
            # Once: a window that is too slow says every second that it is.
            elif text not in self.warnings:
                self.warnings.add(text)
                command.told(f"{self._name}: warning: {text}", sys.stderr)

    def _no_picture(self, decoder):
        """Of what this decodebin has found nothing could be linked."""
        source = decoder.sinkpads and decoder.sinkpads[0].get_peer().get_parent_element()
        place = source.get_property(
            "location") if source and source.find_property("location") else self._source
        self.fail(f"'{place}' has no picture in it that can be decoded here: give a video",
                  sources_fault=False)

    def _error(self, element, error, debug):
        text = one_line(error.message)
        factory = element.get_factory() if isinstance(element, Gst.Element) else None
        if self._failure:  # another error with the same cause
            return
        if self.frames and says(debug, GONE) or self.ending and says(debug, LOST):
            self.over = not self.ending
            self._loop.quit()
        elif self.frames and (says(debug, LOST) or self._before(element)):
            # The end of the stream follows behind what is still on its way.
            self._failure = f"{self._source}: the {'connection was lost' if says(debug, LOST) else f'source broke off ({text})'}"
            self._drain()
        elif says(text, self._harmless):
            self._loop.quit()
        elif no_video(error):
            self.fail(NO_VIDEO)
        elif factory and factory.get_name() == "filesrc":
            place = element.get_property("location")
            self.fail(text if place in text else f"'{place}' can't be read: {text}",
                      sources_fault=False)
        elif factory and factory.get_name() == "filesink":
            self.fail(str(command.of_filesink(element.get_property("location"), error, debug)),
                      sources_fault=False)
        elif factory and factory.get_name() == "csdtrackdec" and element.get_property("location"):
            self.fail(
                text.partition(" Set location ")[0].rstrip(".") +
                ": give a .jsonl file that csdtrackenc wrote", sources_fault=False)
        elif not self.frames and not element.sinkpads and ("streaming stopped" in (debug or "") or
                                                           says(text,
                                                                ("Could not open resource", ))):
            # that is all that souphttpsrc and rtspsrc say of a server that isn't
            self.fail("nothing can be read from it: is it there?")
        else:
            self.fail(f"{text} ({element.get_name()})")

    def _before(self, element):
        """Whether it, or the bin that it is in, is the source or between that and what all pictures come through."""
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
