# SPDX-License-Identifier: LGPL-2.1-or-later
"""A part of a video, forward and then backward, to the bit the same frames, in bounded memory.

No decoder runs backward. So the way back is decoded again, in pieces: the last frames first, as many as fit into memory, shown in
reverse; then those before them. A piece is found by a seek; a checksum of each frame, taken on the way forward, tells whether it is the
very same. Where it isn't (an index that lies, frames that depend on more than the key frame before them), the piece is
decoded from the beginning of the part.
"""

import array
import contextlib
import itertools
import time
import zlib

import builds
import gi
import tracking  # of pipelines/lib
from caps import first_structure  # of pipelines/lib

gi.require_version("GstVideo", "1.0")
from gi.repository import Gst, GstVideo  # noqa: E402

MISSED = 32  # frames that a seek may come too early


class Picture:
    """How a frame lies in memory: I420 with GStreamer's usual strides."""

    def __init__(self, caps):
        self.info = GstVideo.VideoInfo.new_from_caps(caps)
        rate = (self.info.fps_n, self.info.fps_d) if self.info.fps_n > 0 else (25, 1)
        self.period = Gst.SECOND * rate[1] // rate[0]  # ns, where timestamps don't say it
        colours = first_structure(caps).get_string("colorimetry")
        # Whole frames, also where they are interlaced: backward, the fields would come in the wrong
        # order.
        self.caps = (
            f"video/x-raw,format=I420,width={self.info.width},height={self.info.height},framerate={rate[0]}/{rate[1]},"
            f"interlace-mode=progressive{f',colorimetry={colours}' if colours else ''}")

    def checksum(self, frame):
        """Of what is seen: between the rows there may be anything."""
        view, crc = memoryview(frame), 0
        for plane in range(3):
            width, height = self.info.width, self.info.height
            if plane:
                width, height = (width + 1) // 2, (height + 1) // 2
            at, stride = self.info.offset[plane], self.info.stride[plane]
            for row in range(at, at + stride * height, stride):
                crc = zlib.crc32(view[row:row + width], crc)
        return crc


class Decoding:
    """One pass over the file. Iterating gives (stream time or None, caps, bytes of the frame)."""

    def __init__(self, path, since):
        """since: ns. Frames before it are left out; a file that can't be sought in is decoded up to there."""
        self._path, self._since = path, since
        self._missing, self._no_video, self._video = [], False, False
        self._pipeline = Gst.parse_launch(
            "filesrc name=file ! decodebin name=decode  videoconvert name=convert ! "
            "video/x-raw,format=I420 ! appsink name=sink sync=false max-buffers=2")
        self._pipeline.get_by_name("file").set_property("location", str(path))
        decode, self._sink = self._pipeline.get_by_name("decode"), self._pipeline.get_by_name(
            "sink")
        self._signals = [(decode, decode.connect("pad-added", self._stream)),
                         (decode, decode.connect("no-more-pads", self._streams_known))]
        self._bus = self._pipeline.get_bus()

    def __enter__(self):
        self._pipeline.set_state(Gst.State.PAUSED)
        patience = time.monotonic() + tracking.SILENCE
        while not self._check(Gst.SECOND // 10, Gst.MessageType.ASYNC_DONE):
            if time.monotonic() > patience:
                raise builds.Failure(
                    f"'{self._path}' shows no stream: check that it plays, or convert it to H.264")
        if self._since:
            self._pipeline.seek_simple(Gst.Format.TIME,
                                       Gst.SeekFlags.FLUSH | Gst.SeekFlags.ACCURATE, self._since)
        self._pipeline.set_state(Gst.State.PLAYING)
        return self

    def __exit__(self, *_):
        self._pipeline.set_state(Gst.State.NULL)
        while self._signals:  # they hold this object, and it the pipeline
            element, signal = self._signals.pop()
            element.disconnect(signal)

    def duration(self):
        """ns; 0 if the file doesn't say."""
        return max(0, self._pipeline.query_duration(Gst.Format.TIME)[1])

    def __iter__(self):
        while True:
            sample = self._sink.emit("try-pull-sample", Gst.SECOND // 10)
            self._check(0)
            if sample is None:
                if self._sink.get_property("eos"):
                    return
                continue
            buffer = sample.get_buffer()
            at = sample.get_segment().to_stream_time(Gst.Format.TIME, buffer.pts)
            if at == Gst.CLOCK_TIME_NONE:
                at = None
            if at is None or at >= self._since:
                yield at, sample.get_caps(), buffer.extract_dup(0, buffer.get_size())

    def _stream(self, _decodebin, pad):
        sink = self._pipeline.get_by_name("convert").get_static_pad("sink")
        name = first_structure(pad.get_current_caps() or pad.query_caps(None)).get_name()
        if name == "video/x-raw" and not sink.is_linked():
            self._video = pad.link(sink) == Gst.PadLinkReturn.OK

    def _streams_known(self, _decodebin):
        self._no_video = not self._video

    def _check(self, wait, kinds=Gst.MessageType.ERROR):
        """Whether a message of these kinds came in this time. Raises builds.Failure of an error."""
        while message := self._bus.timed_pop_filtered(
                wait, kinds | Gst.MessageType.ERROR | Gst.MessageType.ELEMENT):
            if message.type == Gst.MessageType.ELEMENT:
                if message.has_name("missing-plugin"):
                    self._missing.append(message.get_structure().get_string("name"))
                continue
            if message.type != Gst.MessageType.ERROR:
                return True
            error, debug = message.parse_error()
            if self._no_video and not self._missing:
                break  # nobody wanted its sound
            factory = message.src.get_factory() if isinstance(message.src, Gst.Element) else None
            raise builds.Failure(
                tracking.explain(self._path, "", "csdtrack",
                                 factory.get_name() if factory else "", error, debug or "",
                                 self._missing))
        if self._no_video and self._missing:
            raise builds.Failure(
                f"'{self._path}' needs a {self._missing[0]} that this machine does not have: install it, or convert "
                "the video to H.264")
        if self._no_video:
            raise builds.Failure(f"'{self._path}' has no video stream: give a file with a picture")
        return False


class Mirror:
    """At most `most` images from `since` ns on, there and back: of N images 2N − 1 frames, the last shown once."""

    def __init__(self, path, since, most, memory):
        """memory: bytes of frames that are held on the way back."""
        if tracking.lacks_index(path):
            raise builds.Failure(tracking.no_index(path))
        self.path, self._since, self._most, self._memory = path, since, most, memory
        # how many are expected; once the way forward is over, how many there are
        self.images = most
        self.picture = None  # known with the first frame
        self.pieces = self.decoded_anew = 0  # of the way back; those that no seek found
        # what to say if the file ends before it should; known once the way forward is over
        self.cut_short = ""
        self._begin = 0  # stream time of the first frame
        # Of each image: ns since the first, checksum. All that grows with the video.
        self._times, self._sums = array.array("q"), array.array("L")

    def __iter__(self):
        """Gives (ns since the first frame, bytes of the frame)."""
        yield from self._forward()
        for index, frame in self._backward():
            yield 2 * self._times[-1] - self._times[index], frame

    def _forward(self):
        with Decoding(self.path, self._since) as decoding:
            for at, caps, frame in decoding:
                if self.picture is None:
                    self._first(at, caps, decoding.duration())
                    first_caps = caps
                elif not caps.is_equal(first_caps):
                    raise builds.Failure(
                        f"'{self.path}': the picture's format changes behind {len(self._sums)} frames: take "
                        "fewer (--frames), or begin behind it (--from)")
                yield self._note(at, frame), frame
                if len(self._sums) == self._most:
                    break
            else:
                if self._times:
                    self.cut_short = tracking.breaks_off(
                        self.path, self._begin + self._times[-1] + self.picture.period,
                        decoding.duration())
        self.images = len(self._sums)
        if self.images < 2:
            raise builds.Failure(
                f"'{self.path}' has {self.images or 'no'} frame{'s' * (self.images != 1)} from "
                f"{self._since / Gst.SECOND:g} s on, and 2 are needed: begin earlier (--from)")

    def _first(self, at, caps, duration):
        self.picture = Picture(caps)
        self._begin = self._since if at is None else at
        if duration:
            expected = (duration - self._begin) // self.picture.period
            self.images = max(2, min(self._most, expected))

    def _note(self, at, frame):
        """Remembers a frame of the way forward. Gives the time when it is shown."""
        last = self._times[-1] if self._times else -self.picture.period
        shown = last + self.picture.period if at is None else at - self._begin
        if shown <= last:
            shown = last + self.picture.period
        self._times.append(shown)
        self._sums.append(self.picture.checksum(frame))
        return shown

    def _backward(self):
        """Gives (index, frame) from the last image but one to the first."""
        at_once = max(1, self._memory // self.picture.info.size)
        for end in range(self.images - 1, 0, -at_once):
            begin = max(0, end - at_once)
            piece = self._piece(begin, end)
            while piece:
                yield begin + len(piece) - 1, piece.pop()

    def _piece(self, begin, end):
        """The frames of these images."""
        self.pieces += 1
        piece = None
        with contextlib.suppress(builds.Failure), Decoding(self.path, self._begin +
                                                           self._times[begin]) as decoding:
            piece = self._the_same(begin, end, decoding, MISSED)
        if piece is None:
            self.decoded_anew += 1
            with Decoding(self.path, self._since) as decoding:
                for _ in itertools.islice(decoding, begin):
                    pass
                piece = self._the_same(begin, end, decoding, 0)
        if piece is None:
            raise builds.Failure(
                f"'{self.path}' does not decode to the same frames each time: convert it to a lossless format "
                "(ffmpeg -i VIDEO -c:v ffv1 lossless.mkv)")
        return piece

    def _the_same(self, begin, end, decoding, surplus):
        """These images from where the decoding stands, or up to `surplus` frames later; None if it gives others."""
        piece = []
        for _at, _caps, frame in decoding:
            if self.picture.checksum(frame) == self._sums[begin + len(piece)]:
                piece.append(frame)
                if len(piece) == end - begin:
                    return piece
            elif piece or surplus == 0:
                return None
            else:
                surplus -= 1
        return None
