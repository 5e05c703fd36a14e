#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""csdtrack and csdtrackdec in a player: seeks, rates, backwards, pauses, steps, requests for key
frames. A sink must get the same buffers and events as behind identity."""

import hashlib
import threading

import harness
from harness import Gst
from gi.repository import GstVideo

FLUSH, ACCURATE, SEGMENT, KEY_UNIT = (getattr(Gst.SeekFlags, name)
                                      for name in ("FLUSH", "ACCURATE", "SEGMENT", "KEY_UNIT"))
TRICKMODE, KEY_UNITS, NO_FLAGS = (getattr(Gst.SeekFlags, name)
                                  for name in ("TRICKMODE", "TRICKMODE_KEY_UNITS", "NONE"))
BEFORE, AFTER = Gst.SeekFlags.SNAP_BEFORE, Gst.SeekFlags.SNAP_AFTER
STOPS = Gst.MessageType.EOS | Gst.MessageType.SEGMENT_DONE
SEGMENT_FIELDS = ("flags", "rate", "applied_rate", "format", "base", "offset", "start", "stop",
                  "time", "position", "duration")
# These are between neighbouring elements, or depend on a clock or a queue. None is part of the
# stream.
NOT_COMPARED = (Gst.EventType.QOS, Gst.EventType.LATENCY, Gst.EventType.RECONFIGURE)


class Player:
    """Plays a video through `element`. `got` has the buffers and events that reach the sink,
    `asked` the events that come from it."""

    def __init__(self, video, element):
        self.got, self.asked, self.numbers = [], [], {}
        # The buffer with the number `held_at` since the last flush waits for the next flush.
        self.held_at, self.count = None, 0
        self.held, self.flushed, self.ends = (threading.Semaphore(0) for _ in range(3))
        self.run = harness.Run(f"filesrc location={video} ! qtdemux name=demuxer h264parse "
                               f"name=parser ! avdec_h264 name=first max-threads=1 ! {element} ! "
                               "fakesink name=sink sync=false")
        # Here, as gst_parse_launch() links a delayed pad only once.
        self.run.element("demuxer").connect(
            "pad-added", lambda _, pad: pad.link(self.run.element("parser").get_static_pad("sink")))
        kinds = Gst.PadProbeType
        self.run.element("sink").get_static_pad("sink").add_probe(
            kinds.BUFFER | kinds.EVENT_DOWNSTREAM | kinds.EVENT_FLUSH, self.see, self.got)
        self.run.element("first").get_static_pad("src").add_probe(
            kinds.EVENT_UPSTREAM, self.see, self.asked)

    def see(self, _pad, info, kept):
        if info.type & Gst.PadProbeType.BUFFER:
            kept.append(self.describe_buffer(info.get_buffer()))
            self.count += 1
            if self.count == self.held_at:
                self.held.release()
                self.flushed.acquire(timeout=harness.TIMEOUT)
        elif (event := info.get_event()).type not in NOT_COMPARED:
            kept.append(self.describe_event(event))
            if event.type == Gst.EventType.FLUSH_START:
                self.flushed.release()
            elif event.type == Gst.EventType.FLUSH_STOP:
                self.count = 0
            elif event.type in (Gst.EventType.EOS, Gst.EventType.SEGMENT_DONE):
                self.ends.release()
        return Gst.PadProbeReturn.OK

    def describe_buffer(self, buffer):
        with buffer.map(Gst.MapFlags.READ) as memory:
            pixels = hashlib.sha256(memory.data).hexdigest()
        return ("buffer", buffer.pts, buffer.dts, buffer.duration, buffer.offset, buffer.offset_end,
                int(buffer.get_flags()), pixels)

    def describe_event(self, event):
        """Sequence numbers differ from run to run, so they are counted in the order they come."""
        number = self.numbers.setdefault(event.get_seqnum(), len(self.numbers))
        if event.type == Gst.EventType.SEGMENT:
            segment = event.parse_segment()
            said = tuple(getattr(segment, field) for field in SEGMENT_FIELDS)
        elif event.type == Gst.EventType.STREAM_START:
            said = event.parse_stream_start(), event.parse_stream_flags()
        else:
            said = harness.structure_text(event.get_structure())
        return (event.type.value_nick, number, said)

    # ---- The steps of scenarios ----

    def to(self, state):
        self.run.pipeline.set_state(state)
        if state >= Gst.State.PAUSED:
            self.run.until(Gst.MessageType.ASYNC_DONE)

    def seek(self, rate, flags, start, stop=None):
        ends = [-1 if at is None else int(at * Gst.SECOND) for at in (start, stop)]
        event = Gst.Event.new_seek(rate, Gst.Format.TIME, flags, Gst.SeekType.SET, ends[0],
                                   Gst.SeekType.SET, ends[1])
        assert self.run.pipeline.send_event(event)
        if flags & FLUSH:
            self.run.until(Gst.MessageType.ASYNC_DONE)

    def play(self):
        """Plays to the end of the video or of the segment."""
        self.run.pipeline.set_state(Gst.State.PLAYING)
        self.end()

    def end(self):
        """Waits for the event as well: a demuxer posts that a segment is done before it sends
        that."""
        self.run.until(STOPS)
        assert self.ends.acquire(timeout=harness.TIMEOUT)

    def step(self, frames):
        event = Gst.Event.new_step(Gst.Format.BUFFERS, frames, 1.0, True, False)
        assert self.run.pipeline.send_event(event)
        self.run.until(Gst.MessageType.STEP_DONE)

    def pauses(self, times):
        """Pauses so many times, then plays to the end."""
        for _ in range(times):
            self.run.pipeline.set_state(Gst.State.PLAYING)
            self.run.pipeline.get_state(Gst.CLOCK_TIME_NONE)
            self.run.pipeline.set_state(Gst.State.PAUSED)
            self.run.pipeline.get_state(Gst.CLOCK_TIME_NONE)
        self.play()


def seek_and_play(rate, flags, start, stop=None):
    def scenario(player):
        player.to(Gst.State.PAUSED)
        player.seek(rate, flags | FLUSH, start, stop)
        player.play()

    return scenario


def seeks_in_a_row(player):
    player.to(Gst.State.PAUSED)
    for start, stop in ((1.0, 1.5), (0.2, 0.4), (0, None), (1.9, None)):
        player.seek(1, FLUSH | ACCURATE, start, stop)
        player.play()
    player.seek(-1, FLUSH | ACCURATE, 0, 1.0)
    player.play()
    player.seek(2, FLUSH | ACCURATE, 0.5, 1.0)
    player.play()


def seeks_while_it_plays(player):
    """Each seek comes while a frame is on its way to the sink."""
    player.held_at = 4
    player.run.pipeline.set_state(Gst.State.PLAYING)
    for rate, start, stop in ((1, 1.0, None), (2, 0.1, None), (-1, 0, 1.5), (0.5, 0.7, 1.9),
                              (1, 0.4, None)):
        assert player.held.acquire(timeout=harness.TIMEOUT)
        if start == 0.4:
            player.held_at = None
        player.seek(rate, FLUSH | ACCURATE, start, stop)
    player.play()


def a_key_frame_is_asked_for(player):
    player.to(Gst.State.PAUSED)
    for count in (1, 2):
        player.run.pipeline.send_event(
            GstVideo.video_event_new_upstream_force_key_unit(Gst.SECOND, True, count))
    player.play()


def a_loop_of_segments(player):
    player.to(Gst.State.PAUSED)
    player.seek(1, FLUSH | ACCURATE | SEGMENT, 0.4, 0.9)
    player.play()
    for _ in range(2):
        player.seek(1, ACCURATE | SEGMENT, 0.4, 0.9)
        player.end()


def steps(player):
    player.to(Gst.State.PAUSED)
    for frames in (1, 3, 10):
        player.step(frames)
    player.play()


def play_again_after(state):
    def scenario(player):
        for _ in range(2):
            player.to(Gst.State.PAUSED)
            player.seek(1, FLUSH | ACCURATE, 0.5, 1.2)
            player.play()
            player.to(state)
        player.to(Gst.State.PAUSED)
        player.play()

    return scenario


SCENARIOS = {
    "from start to end": Player.play,
    "pauses": lambda player: player.pauses(5),
    "a seek": seek_and_play(1, ACCURATE, 0.73, 1.51),
    "a seek to the key frame before": seek_and_play(1, KEY_UNIT | BEFORE, 1.1),
    "a seek to the key frame after": seek_and_play(1, KEY_UNIT | AFTER, 1.1),
    "half speed": seek_and_play(0.5, ACCURATE, 0.3, 1.7),
    "four times the speed": seek_and_play(4, ACCURATE, 0.3, 1.7),
    "four times the speed, some frames skipped": seek_and_play(4, TRICKMODE, 0.3, 1.7),
    "four times the speed, key frames only": seek_and_play(4, KEY_UNITS, 0),
    "backwards": seek_and_play(-1, ACCURATE, 0.3, 1.7),
    "backwards to the start": seek_and_play(-1, NO_FLAGS, 0, None),
    "backwards at four times the speed, key frames only": seek_and_play(-4, KEY_UNITS, 0, 2),
    "seeks in a row": seeks_in_a_row,
    "seeks while it plays": seeks_while_it_plays,
    "a key frame is asked for": a_key_frame_is_asked_for,
    "a loop of segments": a_loop_of_segments,
    "steps": steps,
    "READY and again": play_again_after(Gst.State.READY),
    "NULL and again": play_again_after(Gst.State.NULL),
}


def told_by(element):
    """What is compared. csdtrackdec has a thread of its own, so that upstream runs ahead by a frame
    or two: then parsers measure another bit rate before a seek, and tell it in tags."""
    if not element.startswith("csdtrackdec"):
        return list

    def without_tags(got):
        numbers, kept = {}, []
        for kind, number, *rest in got:
            if kind not in ("tag", "buffer"):
                number = numbers.setdefault(number, len(numbers))
            if kind != "tag":
                kept.append((kind, number, *rest))
        return kept
    return without_tags


class InAPlayer(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.video, cls.elements = harness.tracked_video(cls.tmp)

    def played(self, element, scenario):
        player = Player(self.video, element)
        try:
            scenario(player)
        finally:
            player.run.pipeline.set_state(Gst.State.NULL)
        return player

    def test_each_scenario_is_as_with_identity(self):
        for name, scenario in SCENARIOS.items():
            plain = self.played("identity", scenario)
            self.assertGreater(sum(kind == "buffer" for kind, *_ in plain.got), 2, name)
            for element in self.elements:
                with self.subTest(f"{name}: {element}"):
                    player = self.played(element, scenario)
                    told = told_by(element)
                    self.assertEqual(told(player.got), told(plain.got))
                    self.assertEqual(told(player.asked), told(plain.asked))
                    self.assertEqual(player.run.warnings, [])

    def test_a_request_for_a_key_frame_reaches_an_encoder(self):
        plain = self.encoded("identity")
        flags = [told[-2] for told in plain if told[0] == "buffer"]
        self.assertEqual(
            [i for i, flag in enumerate(flags) if not flag & Gst.BufferFlags.DELTA_UNIT], [0, 20])
        for element in self.elements:
            with self.subTest(element):
                self.assertEqual(self.encoded(element), plain)

    def encoded(self, element):
        player = Player(self.video, f"{element} ! avenc_mpeg4 gop-size=1000")

        def demand(pad, info):
            if info.get_buffer().pts == 20 * harness.FRAME:
                pad.push_event(GstVideo.video_event_new_downstream_force_key_unit(
                    *[20 * harness.FRAME] * 3, True, 1))
            return Gst.PadProbeReturn.OK

        player.run.element("first").get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER, demand)
        player.run.to_end()
        return player.got


if __name__ == "__main__":
    harness.main()
