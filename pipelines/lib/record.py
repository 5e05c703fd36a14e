# SPDX-License-Identifier: LGPL-2.1-or-later
"""Records video in segments, with the tracks of each beside it: see --help.

    SOURCE ! tee ─ queue ! x264enc ! h264parse ! splitmuxsink          00000.mkv, 00001.mkv, …
             tee ─ queue ! csdtrack ! tee ─ queue ! csdtrackenc        00000.jsonl, 00001.jsonl, …
                                      tee ─ queue ! appsink ──► appsrc ! videoconvert ! DISPLAY

The recording is clean, and nothing that happens to the tracks can harm it: csdtrack looks at the same buffers in a branch of its own, whose
queue drops what is too old where the source is live, and whose lines this program writes, not an element whose error would stop the pipeline.
The window is a pipeline of its own, for the same reason.
"""

import argparse
import collections
import contextlib
import os
import pathlib
import queue
import re
import sys
import threading
import time

from pipelines.lib import command, even, sources
from pipelines.lib.caps import first_structure

EPILOG = sources.LISTED + """
OUT is a folder; it gets 00000.mkv, 00001.mkv, … and beside each its tracks: 00000.jsonl holds a line of JSON for each frame of 00000.mkv
(docs/metadata.md). The files' times go on from one to the next, and a line's stream_time is its frame's. Numbers go on where OUT or DIR has
some: nothing is overwritten. A picture that changes its size begins a new file. Another recorder can't work in OUT or DIR at the same time: it is
refused, and told whose they are.

A file is recorded as fast as that goes, any other source as its pictures come.

The tracks can't harm the recording: if their disk is full, gone or stands still there is one warning, and the recording goes on; if tracking
is too slow for a live source, frames are recorded that were not tracked. A line is written as soon as its frame was tracked: a killed recorder
leaves those of all frames that it recorded and tracked, and of some that were still in the encoder. In the end it says how many were tracked,
and if a live source gave fewer than its rate promises.

What csdtrack is told: the preset laparoscopy-1080p (docs/pipelines.md), so on-error=pass.

Exit code: 0 if all was recorded, 1 if not, or if the source broke off (one line says why; what came until then is there), 2 for wrong use.
"""

LATENCY = 5  # seconds of raw video that may wait for the encoder's look-ahead (2 s) and a busy disk
WAITING = 3000  # lines that may wait for a busy disk: two minutes of a camera, some 10 MB
PATIENCE = 10  # seconds with such a disk, when all else is written


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/record", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG, description=
        "Records video in segments, with the tracks of points on the tissue beside each. Sound is not recorded."
    )
    parser.add_argument("source", metavar="SOURCE", help="where the picture comes from")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT", help="the folder of the recording")
    parser.add_argument("--tracks", type=pathlib.Path, metavar="DIR",
                        help="another folder for the tracks, on another disk say")
    parser.add_argument("--segment", type=command.positive, default=600, metavar="SECONDS",
                        help="length of a file at most, whole groups of pictures (600)")
    parser.add_argument("--bitrate", type=int, default=8000, metavar="KBIT",
                        help="of the video, kbit/s (8000)")
    parser.add_argument("--display", metavar="SINK",
                        help="also a window with the tracks drawn in; without =SINK autovideosink")
    parser.add_argument("--preset", default="laparoscopy-1080p", metavar="NAME",
                        help="of csdtrack (laparoscopy-1080p)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if not 1 <= options.bitrate <= 2_000_000:
        parser.error(f"--bitrate: {options.bitrate} is not from 1 to 2000000")
    if options.display and not re.fullmatch(r"[a-z0-9]+", options.display):
        parser.error(f"--display: '{options.display}' is no name of an element")
    return options


class Files:
    """The names of the recording's files. Each is made here, and never one that is there: where a file system knows no locks, another recorder
    may be at work in the folder, and takes numbers meanwhile."""

    def __init__(self, out, first):
        self._out, self._next = out, first
        self._names = {}  # by number of the fragment

    def name(self, fragment):
        if fragment not in self._names:
            self._names[fragment] = self._make()
        return self._names[fragment]

    def end(self):
        """Away with what nothing was recorded into."""
        for name in self._names.values():
            with contextlib.suppress(OSError):
                if not os.path.getsize(name):
                    os.unlink(name)

    def _make(self):
        while True:
            name = self._out / f"{self._next:05}.mkv"
            self._next += 1
            try:
                os.close(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            except FileExistsError:
                continue
            except OSError:
                pass  # the sink says why it can't write there
            return str(name)


class Sidecar:
    """Lines of tracks, into the file beside the one that their frame was recorded in.

    A line is written at once, to the newest file: a killed recorder leaves one for each frame that it has recorded. The encoder holds frames
    back, though, so lines are there before it is known where the next file begins. Then what belongs into that is moved. A group of pictures
    goes into a file as a whole, and when one begins, splitmuxsink has decided about all but the last one before: earlier lines stay.

    A thread of its own does so, for a disk may stand still, and who records must not wait for it. Killed within moments of a file's begin, the
    recorder may leave that file's lines in the one before.
    """

    def __init__(self, folder, first):
        self._folder = folder
        self._name = first           # of the newest file
        self._file = None
        # (running time, offset, line): what may belong into the next file
        self._unsure = collections.deque()
        self._size = 0
        self._group = 0              # begin of the last group of pictures
        self._jobs = queue.Queue(WAITING)
        self._lock = threading.Lock()
        self._failed = False
        # a disk that never answers must not keep the program
        self._thread = threading.Thread(target=self._work, daemon=True)
        self._thread.start()

    def line(self, time, text):
        self._hand_over(self._write, time, text)

    def opened(self, time, name):
        """A file of the recording begins with the frame of this running time."""
        self._hand_over(self._begin_file, time, pathlib.Path(name).with_suffix(".jsonl").name)

    def group(self, time):
        """A group of pictures begins."""
        self._hand_over(self._begin_group, time)

    def end(self):
        """What waits is written, if the disk takes it in time."""
        self._hand_over(None)
        if not self._failed:
            self._thread.join(PATIENCE)
            if self._thread.is_alive():
                self._fail(f"'{self._folder}': its disk stands still")

    def _hand_over(self, *job):
        if self._failed:
            return
        try:
            self._jobs.put_nowait(job)
        except queue.Full:
            self._fail(f"'{self._folder}': its disk stands still, {WAITING} lines wait for it")

    def _fail(self, why):
        """A file that can't be written ends the tracks, and nothing else."""
        with self._lock:
            failed, self._failed = self._failed, True
        if not failed:
            command.told(f"record: warning: the tracks end here, the recording goes on: {why}",
                         sys.stderr)

    def _work(self):
        try:
            try:
                for do, *what in iter(self._jobs.get, (None,)):
                    if self._failed:
                        break
                    do(*what)
            finally:
                if self._file is not None:
                    os.close(self._file)
        except OSError as error:
            self._fail(f"'{error.filename or self._folder}': {error.strerror}")

    def _write(self, time, text):
        if self._file is None:
            self._open(self._name)
        self._put(time, text)

    def _begin_file(self, time, name):
        if name == self._name:
            return
        self._name = name
        moved = [entry for entry in self._unsure if entry[0] >= time]
        before = self._file
        self._unsure.clear()
        self._open(name)
        for begin, _, text in moved:
            self._put(begin, text)
        if before is not None:
            if moved:  # after they were written elsewhere: rather twice than never
                os.ftruncate(before, moved[0][1])
            os.close(before)

    def _begin_group(self, time):
        while self._unsure and self._unsure[0][0] < self._group:
            self._unsure.popleft()
        self._group = time

    def _open(self, name):
        path = self._folder / name
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        except FileExistsError:
            if path.is_file():  # another recorder's
                raise
            self._file = os.open(path, os.O_WRONLY)  # a pipe or a device
        self._size = 0

    def _put(self, time, text):
        self._unsure.append((time, self._size, text))
        while text:  # unbuffered: what a killed recorder wrote is there
            written = os.write(self._file, text)
            self._size += written
            text = text[written:]


class Window:
    """A pipeline of its own: a window that is closed, or has never been there, ends itself and not the recording."""

    def __init__(self, runner, sink):
        self._gst = runner.Gst
        # The newest frames, as they come: a window is for looking, now.
        self._run = runner.Run(
            "record",
            f"appsrc name=in is-live=true format=time do-timestamp=true max-buffers=2 leaky-type=downstream ! "
            f"videoconvert ! {sink} sync=false", counted=())
        self._bus = self._run.pipeline.get_bus()
        self._gone = False
        self._run.pipeline.set_state(self._gst.State.PLAYING)

    def show(self, sample):
        if self._gone:
            return
        if error := self._bus.pop_filtered(self._gst.MessageType.ERROR):
            self._gone = True
            self._run.pipeline.set_state(self._gst.State.NULL)
            command.told(
                f"record: warning: the window is gone, the recording goes on: {error.parse_error()[0].message}",
                sys.stderr)
        else:
            self._run.element("in").emit("push-sample", sample)

    def close(self):
        self._run.pipeline.set_state(self._gst.State.NULL)


class Pace:
    """How many frames a source gave, and in which time."""

    def __init__(self, runner, pad):
        self._gst = runner.Gst
        # ns: end of the newest frame, and of the file as it says itself
        self.position = self.duration = 0
        self.frames = 0
        pad.add_probe(runner.Gst.PadProbeType.BUFFER, self._count)

    def _count(self, pad, info):
        self._end = time.monotonic()
        if not self.frames:
            self._begin = self._end
            # over 0: it varies
            _, *self._rate = first_structure(pad.get_current_caps()).get_fraction("framerate")
            known, duration = pad.peer_query_duration(self._gst.Format.TIME)
            self.duration = duration if known else 0
        self.frames += 1
        buffer = info.get_buffer()
        if buffer.pts != self._gst.CLOCK_TIME_NONE:
            self.position = buffer.pts + (buffer.duration
                                          if buffer.duration != self._gst.CLOCK_TIME_NONE else 0)
        return self._gst.PadProbeReturn.OK

    def say_shortage(self, ending):
        """Where a source gave fewer frames than it says that it does. `ending`: when it was told to end, None if it ended by itself: what
        came last says nothing of one that stopped long before."""
        over, under = self._rate
        seconds = (ending or self._end) - self._begin
        due = round(seconds * over / under) + 1 if over > 0 else 0
        if due - self.frames > max(2, 0.02 * due):  # times of arrival vary
            command.told(
                f"the source gave {self.frames} frames in {seconds:.1f} s, {due} were due at its {over / under:g} a second: "
                "it is too slow, or this machine", sys.stdout)


def say_changes(runner, pad, source):
    """Of the encoded picture's caps: a Matroska file holds one size and one form only."""
    before = None

    def look(_pad, info):
        nonlocal before
        if info.get_event().type == runner.Gst.EventType.CAPS:
            caps = info.get_event().parse_caps().copy()
            what = first_structure(caps)
            size = what.get_int("width")[1], what.get_int("height")[1]
            if before and not before[0].is_equal(caps):
                form = f"size is {size[0]}×{size[1]} now" if size != before[1] else "form changes"
                command.told(f"record: {source}: the picture's {form}: a new file begins",
                             sys.stderr)
            before = caps, size
        return runner.Gst.PadProbeReturn.OK

    pad.add_probe(runner.Gst.PadProbeType.EVENT_DOWNSTREAM, look)


def first_number(out, tracks):
    files = [*out.glob("*.mkv"), *tracks.glob("*.jsonl")]
    numbers = [int(path.stem) for path in files if path.stem.isdecimal() and path.is_file()]
    return max(numbers, default=-1) + 1


def main():
    options = command.options(parse)
    begin = sources.begin(options.source)
    command.check_window(options.display, "--display")
    tracks = options.tracks or options.out
    with command.folders(options.out, tracks):
        record(options, begin, tracks)


def record(options, begin, tracks):
    from pipelines.lib import runner
    from pipelines.lib.tracking import breaks_off
    Gst = runner.Gst
    bounded = f"queue max-size-buffers=0 max-size-bytes=0 max-size-time={LATENCY}000000000"
    # key-int-max: a group of pictures of two seconds at 25 frames a second; a file ends with one.
    # No keyframes are asked for where files begin: when such a wish arrives depends on the load,
    # and then so do the bits that are recorded. A file needs no buffer model, and with one x264's
    # threads make the bits depend on how busy the machine is.
    encoder = f"x264enc speed-preset=veryfast bitrate={options.bitrate} vbv-buf-capacity=0 key-int-max=50"
    # single-segment: frames and lines have the times of the files, which count from the start of
    # the recording. Those of RTSP begin elsewhere.
    text = f"{begin} ! identity name=single single-segment=true ! tee name=in {even.CROP} " \
           f"in. ! {bounded} name=raw ! videoconvert ! {encoder} ! h264parse ! " \
           f"splitmuxsink name=files muxer=matroskamux max-size-time={round(options.segment * 1e9)} " \
           f"in. ! {command.FRAMES} name=look ! csdtrack name=csdtrack ! tee name=t " \
           f"t. ! csdtrackenc ! application/x-ndjson ! {bounded} ! appsink name=lines sync=false async=false max-buffers=0 emit-signals=true"
    if options.display:
        text += f" t. ! {command.FRAMES} leaky=downstream ! appsink name=shown sync=false async=false max-buffers=2 drop=true emit-signals=true"
    run = runner.Run("record", text)
    track, files = run.element("csdtrack"), run.element("files")
    runner.configure(track, options.preset, {"overlay": "draw" if options.display else "none"},
                     options.set)
    even.crop(Gst, run, "record", options.source, "single", "in")
    pace = Pace(runner, run.element("in").get_static_pad("sink"))
    window = Window(runner, options.display) if options.display else None
    made = Files(options.out, first_number(options.out, tracks))
    sidecar = Sidecar(tracks, pathlib.Path(made.name(0)).with_suffix(".jsonl").name)
    files.connect("format-location", lambda _, fragment: made.name(fragment))

    def line(sink):
        sample = sink.emit("pull-sample")
        buffer = sample.get_buffer()
        sidecar.line(sample.get_segment().to_running_time(Gst.Format.TIME, buffer.pts),
                     buffer.extract_dup(0, buffer.get_size()))
        return Gst.FlowReturn.OK

    run.element("lines").connect("new-sample", line)

    def shown(sink):
        window.show(sink.emit("pull-sample"))
        return Gst.FlowReturn.OK

    if window:
        run.element("shown").connect("new-sample", shown)

    def group(pad, info):
        buffer = info.get_buffer()
        if not buffer.has_flags(Gst.BufferFlags.DELTA_UNIT):
            segment = pad.get_sticky_event(Gst.EventType.SEGMENT, 0).parse_segment()
            sidecar.group(segment.to_running_time(Gst.Format.TIME, buffer.pts))
        return Gst.PadProbeReturn.OK

    files.get_static_pad("video").add_probe(Gst.PadProbeType.BUFFER, group)
    say_changes(runner, files.get_static_pad("video"), options.source)

    def heard(_, message):
        if message.type == Gst.MessageType.ELEMENT and message.get_structure().get_name(
        ) == "splitmuxsink-fragment-opened":
            what = message.get_structure()
            sidecar.opened(what.get_value("running-time"), what.get_value("location"))
        # Said by matroskamux. splitmuxsink begins a new file then, but the message is out.
        elif message.type == Gst.MessageType.ERROR and "Caps changes are not supported" in (
                message.parse_error()[1] or ""):
            return Gst.BusSyncReply.DROP
        return Gst.BusSyncReply.PASS

    run.pipeline.get_bus().set_sync_handler(heard)

    # These play from the start: in preroll they would keep the queues before them full, and the
    # decoder waiting for ever, whose ALLOCATION query waits for the queues to be empty. avdec_h264
    # asks after some frames where the width is no multiple of 16.
    playing = [sink for sink in (run.element("lines"), run.element("shown")) if sink]
    for sink in playing:
        sink.set_locked_state(True)
        sink.set_state(Gst.State.PLAYING)
    try:
        run.play(options.source, options.seconds, through="in", leaky=("look",))
    finally:
        for sink in playing:
            sink.set_state(Gst.State.NULL)
        sidecar.end()
        made.end()
        if window:
            window.close()
    runner.say_cost(track, pace.frames)
    if run.live:
        pace.say_shortage(run.ending)
    torn = run.over and not run.live and breaks_off(options.source, pace.position, pace.duration)
    if torn:
        command.told(f"record: {torn}", sys.stderr)


if __name__ == "__main__":
    command.run("record", main)
