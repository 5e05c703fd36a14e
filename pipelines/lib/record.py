# SPDX-License-Identifier: LGPL-2.1-or-later
"""Records video in segments, with the tracks of each beside it: see --help.

    SOURCE ! tee ─ queue ! x264enc ! h264parse ! splitmuxsink          00000.mkv, 00001.mkv, …
             tee ─ queue ! csdtrack ! tee ─ queue ! csdtrackenc        00000.jsonl, 00001.jsonl, …
                                      tee ─ queue ! videoconvert ! DISPLAY

The recording is clean, and nothing that happens to the tracks can harm it: csdtrack looks at the same buffers in a branch of its own, whose
queue drops what is too old where the source is live, and whose lines this program writes, not an element whose error would stop the pipeline.
"""

import argparse
import collections
import os
import pathlib
import re
import sys
import threading

import command
import sources

EPILOG = sources.LISTED + """
OUT is a folder; it gets 00000.mkv, 00001.mkv, … and beside each its tracks: 00000.jsonl holds a line of JSON for each frame of 00000.mkv
(docs/metadata.md). The files' times go on from one to the next, and a line's stream_time is its frame's. Numbers go on where OUT has some.

The tracks can't harm the recording: if their disk is full or gone there is one warning, and the recording goes on; if tracking is too slow for
a live source, frames are recorded that were not tracked. A line is written when it is sure into which file its frame goes: a killed recorder
lacks the lines of those frames alone that its recording lacks too.

What csdtrack is told: the preset laparoscopy-1080p (docs/elements.md), so on-error=pass.

Exit code: 0 if all was recorded, 1 if not (one line says why; what was recorded until then is there), 2 for wrong use.
"""

LATENCY = 5  # seconds of raw video that may wait for the encoder's look-ahead (2 s) and a busy disk


def parse(arguments):
    parser = argparse.ArgumentParser(prog="pipelines/record", formatter_class=argparse.RawDescriptionHelpFormatter, epilog=EPILOG,
                                     description="Records video in segments, with the tracks of points on the tissue beside each.")
    parser.add_argument("source", metavar="SOURCE", help="where the picture comes from")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT", help="the folder of the recording")
    parser.add_argument("--tracks", type=pathlib.Path, metavar="DIR", help="another folder for the tracks, on another disk say")
    parser.add_argument("--segment", type=command.positive, default=600, metavar="SECONDS", help="length of a file at most, whole groups of pictures (600)")
    parser.add_argument("--bitrate", type=int, default=8000, metavar="KBIT", help="of the video, kbit/s (8000)")
    parser.add_argument("--display", nargs="?", const="autovideosink", metavar="SINK", help="also a window with the tracks drawn in (autovideosink)")
    parser.add_argument("--preset", default="laparoscopy-1080p", metavar="NAME", help="of csdtrack (laparoscopy-1080p)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if not 1 <= options.bitrate <= 2_000_000:
        parser.error(f"--bitrate: {options.bitrate} is not from 1 to 2000000")
    if options.display and not re.fullmatch(r"[a-z0-9]+", options.display):
        parser.error(f"--display: '{options.display}' is no name of an element")
    return options


class Sidecar:
    """Lines of tracks, into the file beside the one that their frame was recorded in.

    A group of pictures goes into a file as a whole. When one begins, splitmuxsink has decided about all but the last one before. So a line
    waits until the group after its own has ended; that is some seconds of lines at most.
    """

    def __init__(self, folder):
        self._folder = folder
        self._waiting = collections.deque()  # (running time, line)
        self._files = collections.deque()    # (first running time, name), of which the first is open
        self._groups = (0, 0)                # begin of this group and of the one before
        self._file = None
        self._lock = threading.Lock()
        self.failure = None

    def line(self, time, text):
        with self._lock:
            if not self.failure:
                self._waiting.append((time, text))

    def opened(self, time, name):
        """A file of the recording begins with the frame of this running time."""
        with self._lock:
            self._files.append((time, pathlib.Path(name).with_suffix(".jsonl").name))

    def group(self, time):
        """A group of pictures begins."""
        with self._lock:
            self._groups = (time, self._groups[0])
            self._write(self._groups[1])

    def end(self):
        with self._lock:
            self._write(float("inf"))
            if self._file is not None:
                os.close(self._file)

    def _write(self, until):
        """What is earlier. A file that can't be written ends the tracks, and nothing else."""
        try:
            while self._waiting and self._waiting[0][0] < until and self._files and not self.failure:
                while len(self._files) > 1 and self._waiting[0][0] >= self._files[1][0]:
                    self._files.popleft()
                    self._close()
                if self._file is None:
                    self._file = os.open(self._folder / self._files[0][1], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
                rest = self._waiting[0][1]
                while rest:  # unbuffered: what a killed recorder wrote is there
                    rest = rest[os.write(self._file, rest):]
                self._waiting.popleft()
        except OSError as error:
            self.failure = f"'{error.filename or self._folder}': {error.strerror}"
            self._waiting.clear()
            print(f"record: warning: the tracks end here, the recording goes on: {self.failure}", file=sys.stderr, flush=True)

    def _close(self):
        if self._file is not None:
            os.close(self._file)
            self._file = None


def first_number(folder):
    numbers = [int(path.stem) for path in folder.glob("*.mkv") if path.stem.isdecimal()]
    return max(numbers, default=-1) + 1


def main():
    options = command.options(parse)
    begin = sources.begin(options.source)
    command.make_folder(options.out)
    tracks = options.tracks or options.out
    command.make_folder(tracks)
    import runner
    Gst = runner.Gst
    bounded = f"queue max-size-buffers=0 max-size-bytes=0 max-size-time={LATENCY}000000000"
    # key-int-max: a group of pictures of two seconds at 25 frames a second; a file ends with one. No keyframes are asked for where files
    # begin: when such a wish arrives depends on the load, and then so do the bits that are recorded.
    # A file needs no buffer model, and with one x264's threads make the bits depend on how busy the machine is.
    encoder = f"x264enc speed-preset=veryfast bitrate={options.bitrate} vbv-buf-capacity=0 key-int-max=50"
    text = f"{begin} ! tee name=in " \
           f"in. ! {bounded} name=raw ! videoconvert ! {encoder} ! h264parse ! " \
           f"splitmuxsink name=files muxer=matroskamux max-size-time={round(options.segment * 1e9)} " \
           f"in. ! {command.FRAMES} name=look ! csdtrack name=csdtrack ! tee name=t " \
           f"t. ! {bounded} ! csdtrackenc ! application/x-ndjson ! appsink name=lines sync=false async=false max-buffers=0 emit-signals=true"
    if options.display:
        text += f" t. ! {command.FRAMES} leaky=downstream ! videoconvert ! {options.display}"
    run = runner.Run("record", text)
    track, files = run.element("csdtrack"), run.element("files")
    runner.configure(track, options.preset, {"overlay": "draw" if options.display else "none"}, options.set)
    sidecar, number = Sidecar(tracks), first_number(options.out)

    files.connect("format-location", lambda _, fragment: str(options.out / f"{number + fragment:05}.mkv"))

    def line(sink):
        sample = sink.emit("pull-sample")
        buffer = sample.get_buffer()
        sidecar.line(sample.get_segment().to_running_time(Gst.Format.TIME, buffer.pts), buffer.extract_dup(0, buffer.get_size()))
        return Gst.FlowReturn.OK

    run.element("lines").connect("new-sample", line)

    def group(pad, info):
        buffer = info.get_buffer()
        if not buffer.has_flags(Gst.BufferFlags.DELTA_UNIT):
            segment = pad.get_sticky_event(Gst.EventType.SEGMENT, 0).parse_segment()
            sidecar.group(segment.to_running_time(Gst.Format.TIME, buffer.pts))
        return Gst.PadProbeReturn.OK

    files.get_static_pad("video").add_probe(Gst.PadProbeType.BUFFER, group)

    def opened(_, message):
        what = message.get_structure()
        if message.type == Gst.MessageType.ELEMENT and what.get_name() == "splitmuxsink-fragment-opened":
            sidecar.opened(what.get_value("running-time"), what.get_value("location"))
        return Gst.BusSyncReply.PASS

    run.pipeline.get_bus().set_sync_handler(opened)
    try:
        run.play(options.source, options.seconds, on_live=lambda: run.element("look").set_property("leaky", "downstream"))
    finally:
        sidecar.end()
    runner.say_cost(track)


command.run("record", main)
