# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays a part of a video forward and then backward, with identical frames and in bounded memory.

No decoder runs backward. So the way back is decoded again, in pieces: first the last frames, as
many as fit into memory, shown in reverse; then those before them. A seek finds each piece. A
checksum of each frame, taken on the way forward, tells whether the frames are the same. Where they
differ (an index that is wrong, frames that depend on more than the key frame before them), the
piece is decoded from the beginning of the part.
"""

import array
import contextlib
import itertools
import pathlib
import time
import zlib
from collections.abc import Iterator

import gi

from pipelines.lib import tracking, video_errors
from pipelines.lib.caps import first_structure
from pipelines.lib.failure import Failure

gi.require_version("GstVideo", "1.0")
from gi.repository import Gst, GstVideo  # noqa: E402

MISSED = 32  # a seek may come so many frames too early


class Picture:
    """How a frame lies in memory: I420 with GStreamer's usual strides."""

    def __init__(self, caps: Gst.Caps) -> None:
        self.info = GstVideo.VideoInfo.new_from_caps(caps)
        rate = (self.info.fps_n, self.info.fps_d) if self.info.fps_n > 0 else (25, 1)
        self.period = Gst.SECOND * rate[1] // rate[0]  # ns, for frames without a timestamp
        colours = first_structure(caps).get_string("colorimetry")
        # Interlaced frames stay whole: backward, their fields would come in the wrong order.
        self.caps = (f"video/x-raw,format=I420,width={self.info.width},height={self.info.height},"
                     f"framerate={rate[0]}/{rate[1]},interlace-mode=progressive"
                     f"{f',colorimetry={colours}' if colours else ''}")

    def checksum(self, frame: bytes) -> int:
        """Of the visible pixels only: the padding between rows may hold anything."""
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
    """Decodes the file once. Iterating gives (stream time or None, caps, bytes of the frame)."""

    def __init__(self, path: pathlib.Path, since: int) -> None:
        """Leaves out the frames before `since` (ns), even in a file without an index to seek by."""
        self._path, self._since = path, since
        self._missing: list[str] = []
        self._no_video = self._video = False
        self._pipeline = Gst.parse_launch(
            "filesrc name=file ! decodebin name=decode  videoconvert name=convert ! "
            "video/x-raw,format=I420 ! appsink name=sink sync=false max-buffers=2")
        self._pipeline.get_by_name("file").set_property("location", str(path))
        self._sink = self._pipeline.get_by_name("sink")
        decode = self._pipeline.get_by_name("decode")
        self._signals = [(decode, decode.connect("pad-added", self._stream)),
                         (decode, decode.connect("no-more-pads", self._streams_known))]
        self._bus = self._pipeline.get_bus()

    def __enter__(self) -> "Decoding":
        self._pipeline.set_state(Gst.State.PAUSED)
        patience = time.monotonic() + tracking.SILENCE
        while not self._check(Gst.SECOND // 10, Gst.MessageType.ASYNC_DONE):
            if time.monotonic() > patience:
                raise Failure(
                    f"'{self._path}' shows no stream: check that it plays, or convert it to H.264")
        if self._since:
            self._pipeline.seek_simple(Gst.Format.TIME,
                                       Gst.SeekFlags.FLUSH | Gst.SeekFlags.ACCURATE, self._since)
        self._pipeline.set_state(Gst.State.PLAYING)
        return self

    def __exit__(self, *_: object) -> None:
        self._pipeline.set_state(Gst.State.NULL)
        # The signals hold this object, which holds the pipeline.
        while self._signals:
            element, signal = self._signals.pop()
            element.disconnect(signal)

    def duration(self) -> int:
        """In ns; 0 if the file doesn't say."""
        return max(0, self._pipeline.query_duration(Gst.Format.TIME)[1])

    def __iter__(self) -> Iterator[tuple[int | None, Gst.Caps, bytes]]:
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

    def _stream(self, _decodebin: Gst.Element, pad: Gst.Pad) -> None:
        sink = self._pipeline.get_by_name("convert").get_static_pad("sink")
        name = first_structure(pad.get_current_caps() or pad.query_caps(None)).get_name()
        if name == "video/x-raw" and not sink.is_linked():
            self._video = pad.link(sink) == Gst.PadLinkReturn.OK

    def _streams_known(self, _decodebin: Gst.Element) -> None:
        self._no_video = not self._video

    def _check(self, wait: int, kinds: Gst.MessageType = Gst.MessageType.ERROR) -> bool:
        """Whether a message of these kinds comes within `wait` ns. Raises Failure on an error."""
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
                break  # the file has sound only, which no element takes
            element = video_errors.factory_name(message.src)
            raise Failure(
                video_errors.explain(self._path, "", "csdtrack", element, error, debug or "",
                                     self._missing))
        if self._no_video and self._missing:
            raise Failure(video_errors.missing_decoder(self._path, self._missing[0]))
        if self._no_video:
            raise Failure(f"'{self._path}' has no video stream: give a file with a picture")
        return False


class Mirror:
    """At most `most` images from `since` ns on, forward and then backward.

    N images give 2N − 1 frames: the last image is shown once.
    """

    def __init__(self, path: pathlib.Path, since: int, most: int, memory: int) -> None:
        """memory: how many bytes of frames are held on the way back."""
        if video_errors.lacks_index(path):
            raise Failure(video_errors.no_index(path))
        self.path, self._since, self._most, self._memory = path, since, most, memory
        # How many images are expected; after the way forward, how many there are.
        self.images = most
        self._picture: Picture | None = None  # known with the first frame
        self.pieces = 0  # of the way back
        self.decoded_anew = 0  # pieces that no seek found
        # A message if the file ends before it should; known after the way forward.
        self.cut_short = ""
        self._begin = 0  # stream time of the first frame
        # For each image: ns since the first, and checksum. Nothing else grows with the video.
        self._times, self._sums = array.array("q"), array.array("L")

    @property
    def picture(self) -> Picture:
        assert self._picture, "before the first frame"
        return self._picture

    def __iter__(self) -> Iterator[tuple[int, bytes]]:
        """Gives (ns since the first frame, bytes of the frame)."""
        yield from self._forward()
        for index, frame in self._backward():
            yield 2 * self._times[-1] - self._times[index], frame

    def _forward(self) -> Iterator[tuple[int, bytes]]:
        first_caps = None
        with Decoding(self.path, self._since) as decoding:
            for at, caps, frame in decoding:
                if first_caps is None:
                    self._first(at, caps, decoding.duration())
                    first_caps = caps
                elif not caps.is_equal(first_caps):
                    raise Failure(f"'{self.path}': the picture's format changes after "
                                  f"{len(self._sums)} frames: take fewer (--frames), or begin "
                                  "after the change (--from)")
                yield self._note(at, frame), frame
                if len(self._sums) == self._most:
                    break
            else:
                if self._times:
                    end = self._begin + self._times[-1] + self.picture.period
                    self.cut_short = video_errors.breaks_off(self.path, end, decoding.duration())
        self.images = len(self._sums)
        if self.images < 2:
            raise Failure(
                f"'{self.path}' has {self.images or 'no'} frame{'s' * (self.images != 1)} from "
                f"{self._since / Gst.SECOND:g} s on, and 2 are needed: begin earlier (--from)")

    def _first(self, at: int | None, caps: Gst.Caps, duration: int) -> None:
        self._picture = Picture(caps)
        self._begin = self._since if at is None else at
        if duration:
            expected = (duration - self._begin) // self.picture.period
            self.images = max(2, min(self._most, expected))

    def _note(self, at: int | None, frame: bytes) -> int:
        """Remembers a frame of the way forward. Returns the time when it is shown."""
        last = self._times[-1] if self._times else -self.picture.period
        shown = last + self.picture.period if at is None else at - self._begin
        if shown <= last:
            shown = last + self.picture.period
        self._times.append(shown)
        self._sums.append(self.picture.checksum(frame))
        return shown

    def _backward(self) -> Iterator[tuple[int, bytes]]:
        """Gives (index, frame) from the last image but one to the first."""
        at_once = max(1, self._memory // self.picture.info.size)
        for end in range(self.images - 1, 0, -at_once):
            begin = max(0, end - at_once)
            piece = self._piece(begin, end)
            while piece:
                yield begin + len(piece) - 1, piece.pop()

    def _piece(self, begin: int, end: int) -> list[bytes]:
        """The frames of these images."""
        self.pieces += 1
        piece = None
        with contextlib.suppress(Failure):
            with Decoding(self.path, self._begin + self._times[begin]) as decoding:
                piece = self._identical_frames(begin, end, iter(decoding), MISSED)
        if piece is None:
            self.decoded_anew += 1
            with Decoding(self.path, self._since) as decoding:
                frames = itertools.islice(decoding, begin, None)
                piece = self._identical_frames(begin, end, frames, 0)
        if piece is None:
            raise Failure(f"'{self.path}' does not decode to the same frames each time: convert it "
                          "to a lossless format (ffmpeg -i VIDEO -c:v ffv1 lossless.mkv)")
        return piece

    def _identical_frames(self, begin: int, end: int,
                          frames: Iterator[tuple[int | None, Gst.Caps, bytes]],
                          surplus: int) -> list[bytes] | None:
        """The next frames if they are these images; None if they differ.

        Up to `surplus` other frames may come before them.
        """
        piece: list[bytes] = []
        for _at, _caps, frame in frames:
            if self.picture.checksum(frame) == self._sums[begin + len(piece)]:
                piece.append(frame)
                if len(piece) == end - begin:
                    return piece
            elif piece or surplus == 0:
                return None
            else:
                surplus -= 1
        return None
