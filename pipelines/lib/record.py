# SPDX-License-Identifier: LGPL-2.1-or-later
"""Records video in segments, with the tracks of each beside it: see --help.

    SOURCE ! tee ─ queue ! x264enc ! h264parse ! splitmuxsink          00000.mkv, 00001.mkv, …
             tee ─ queue ! csdtrack ! tee ─ queue ! csdtrackenc        00000.jsonl, 00001.jsonl, …
                                      tee ─ queue ! appsink ──► appsrc ! videoconvert ! DISPLAY

The recorded picture has no markers, and trouble with the tracks can't harm it. csdtrack gets the
same buffers in a branch of its own, whose queue drops old frames where the source is live. This
program writes the lines (sidecar.py), as an element's error would stop the pipeline. The window is
a pipeline of its own, for the same reason.
"""

import argparse
import contextlib
import os
import pathlib
import sys
import time
from collections.abc import Mapping
from types import ModuleType
from typing import Any

from pipelines.lib import command, even_size, sources
from pipelines.lib.caps import first_structure
from pipelines.lib.frame_times import FrameTimes
from pipelines.lib.recorded import Recorded
from pipelines.lib.sidecar import Sidecar

EPILOG = sources.HELP + """
OUT is a folder; it gets 00000.mkv, 00001.mkv, … and beside each its tracks: 00000.jsonl holds a
line of JSON for each frame of 00000.mkv (docs/metadata.md). The times continue from one file to the
next, and a line's stream_time is its frame's. The numbers continue where OUT or DIR has files:
nothing is overwritten. If the picture's size changes, a new file begins. Another recorder can't
work in OUT or DIR at the same time: it ends with a message that names this one.

A file is recorded as fast as possible, any other source at its own pace.

The tracks can't harm the recording. If their disk is full, gone or stands still, there is one
warning, the recording goes on, and the exit code is 1. If tracking is too slow for a live source,
frames are recorded that were not tracked. A line is written as soon as its frame was tracked. If
the recorder is killed, the lines of all frames that it recorded and tracked are there, and some of
frames that were still in the encoder. At the end it prints how many frames were tracked, and
whether a live source gave fewer than its rate promises.

csdtrack runs with the preset laparoscopy-1080p (docs/pipelines.md), hence with on-error=pass.

At the end of each file it is read back, and at the end of the run all is compared: the frames that
came, the packets that the muxer got, those that are in the files, and the lines beside them. If
they differ, one line says how many are where, or which file can't be read back, since its disk gave
nothing for ten seconds or a second Ctrl-C ended the reading. From a live source frames may lack a
line, for they came faster than they could be tracked; the last line counts them.

Frames without a time get one: of a live source by their arrival, else by the frame rate. If two
have the same time, the second gets one between its neighbours. If the times jump back, or a live
source's clock is set, they go on from the frame before, and one line says so.

Exit code: 0 if all was recorded, 1 if not: if a frame or a line is missing, if the source broke off
(one line says why; what came before is there), or if there is no picture, also because it was
stopped before the first (no file is left then), 2 for wrong use. A file whose picture ends before
the length that it states is noted, and is no failure.
"""

LATENCY = 5  # seconds of raw video that may wait for the encoder's look-ahead (2 s) and a busy disk


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/record", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        description="Records video in segments, with the tracks of points on the tissue beside "
        "each. Sound is not recorded.")
    parser.add_argument("source", metavar="SOURCE", help="where the picture comes from")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT", help="the folder of the recording")
    parser.add_argument("--tracks", type=pathlib.Path, metavar="DIR",
                        help="another folder for the tracks, on another disk for example")
    parser.add_argument("--segment", type=command.positive, default=600, metavar="SECONDS",
                        help="length of a file at most, in whole groups of pictures (600)")
    parser.add_argument("--bitrate", type=int, default=8000, metavar="KBIT",
                        help="of the video, kbit/s (8000)")
    parser.add_argument("--display", metavar="SINK",
                        help="also a window with the tracks drawn in; without =SINK autovideosink")
    command.add_tracking(parser, "laparoscopy-1080p")
    options = parser.parse_args(arguments)
    if not 1 <= options.bitrate <= 2_000_000:
        parser.error(f"--bitrate: {options.bitrate} is not from 1 to 2000000")
    command.check_sink(parser, "--display", options.display)
    return options


class Files:
    """Creates the recording's files under free numbers.

    Where a file system has no locks, another recorder may take numbers in the same folder
    meanwhile.
    """

    def __init__(self, out: pathlib.Path, first: int) -> None:
        self._out, self._next = out, first
        self._names: dict[int, str] = {}  # by number of the fragment

    def name(self, fragment: int) -> str:
        if fragment not in self._names:
            self._names[fragment] = self._create()
        return self._names[fragment]

    def remove_empty(self, muxed: Mapping[pathlib.Path, int]) -> None:
        """`muxed`: how many packets the muxer got for a file. Without any it wrote its head."""
        for name in self._names.values():
            with contextlib.suppress(OSError):
                if not os.path.getsize(name) or not muxed.get(pathlib.Path(name), 1):
                    os.unlink(name)

    def _create(self) -> str:
        while True:
            name = self._out / f"{self._next:05}.mkv"
            self._next += 1
            try:
                os.close(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            except FileExistsError:
                continue
            except OSError:
                pass  # the sink reports why it can't write there
            return str(name)


class Window:
    """Shows the tracks in a pipeline of its own: if the window fails, the recording goes on."""

    def __init__(self, runner: ModuleType, sink: str) -> None:
        self._gst = runner.Gst
        # A window shows the newest frames, at once.
        self._run = runner.Run(
            "record", "appsrc name=in is-live=true format=time do-timestamp=true max-buffers=2 "
            f"leaky-type=downstream ! videoconvert ! {sink} sync=false", counted=())
        self._bus = self._run.pipeline.get_bus()
        self._gone = False
        self._run.pipeline.set_state(self._gst.State.PLAYING)

    def on_sample(self, appsink: Any) -> Any:
        """Shows a frame of the recording's pipeline."""
        sample = appsink.emit("pull-sample")
        if self._gone:
            return self._gst.FlowReturn.OK
        if error := self._bus.pop_filtered(self._gst.MessageType.ERROR):
            self._gone = True
            self._run.pipeline.set_state(self._gst.State.NULL)
            command.print_line("record: warning: the window is gone, the recording goes on: "
                               f"{error.parse_error()[0].message}", sys.stderr)
        else:
            self._run.element("in").emit("push-sample", sample)
        return self._gst.FlowReturn.OK

    def close(self) -> None:
        self._run.pipeline.set_state(self._gst.State.NULL)


class Pace:
    """Counts a source's frames, and measures the time in which they arrive."""

    def __init__(self, runner: ModuleType, pad: Any) -> None:
        self._gst = runner.Gst
        self.position = 0  # ns, end of the newest frame
        self.duration = 0  # ns, of the file, as it says
        self.frames = 0
        self._begin = self._end = 0.0  # arrival of the first frame and of the last, s
        self._rate = (0, 1)  # numerator and denominator; 0: it varies
        pad.add_probe(runner.Gst.PadProbeType.BUFFER, self._on_frame)

    def _on_frame(self, pad: Any, info: Any) -> Any:
        self._end = time.monotonic()
        if not self.frames:
            self._begin = self._end
            _, over, under = first_structure(pad.get_current_caps()).get_fraction("framerate")
            self._rate = over, under
            known, duration = pad.peer_query_duration(self._gst.Format.TIME)
            self.duration = duration if known else 0
        self.frames += 1
        buffer = info.get_buffer()
        none = self._gst.CLOCK_TIME_NONE
        if buffer.pts != none:
            self.position = buffer.pts + (buffer.duration if buffer.duration != none else 0)
        return self._gst.PadProbeReturn.OK

    def print_shortage(self, ending: float | None) -> None:
        """Prints whether a source gave fewer frames than its rate promises.

        `ending`: when it was asked to end; None if it ended by itself. If a source stopped before
        that, the time without frames counts.
        """
        over, under = self._rate
        seconds = (ending or self._end) - self._begin
        due = round(seconds * over / under) + 1 if over > 0 else 0
        if due - self.frames > max(2, 0.02 * due):  # times of arrival vary
            command.print_line(
                f"the source gave {self.frames} frames in {seconds:.1f} s, {due} were due at its "
                f"{over / under:g} a second: it is too slow, or this machine", sys.stdout)


def split_at_changes(runner: ModuleType, files: Any, source: str) -> None:
    """Begins a new file, and prints why, when the encoded picture's caps change. A Matroska file
    can hold one kind only. matroskamux refuses most changes, but 1.26 takes another size."""
    before = None

    def on_event(_pad: Any, info: Any) -> Any:
        nonlocal before
        if info.get_event().type == runner.Gst.EventType.CAPS:
            caps = info.get_event().parse_caps().copy()
            structure = first_structure(caps)
            size = structure.get_int("width")[1], structure.get_int("height")[1]
            if before and not before[0].is_equal(caps):
                files.emit("split-after")
                change = f"size is {size[0]}×{size[1]} now" if size != before[1] else "form changes"
                command.print_line(f"record: {source}: the picture's {change}: a new file begins",
                                   sys.stderr)
            before = caps, size
        return runner.Gst.PadProbeReturn.OK

    files.get_static_pad("video").add_probe(runner.Gst.PadProbeType.EVENT_DOWNSTREAM, on_event)


def first_number(out: pathlib.Path, tracks: pathlib.Path) -> int:
    files = [*out.glob("*.mkv"), *tracks.glob("*.jsonl")]
    numbers = [int(path.stem) for path in files if path.stem.isdecimal() and path.is_file()]
    return max(numbers, default=-1) + 1


def description(options: argparse.Namespace, source: str) -> str:
    """Of the pipeline. `source`: its beginning."""
    bounded = f"queue max-size-buffers=0 max-size-bytes=0 max-size-time={LATENCY}000000000"
    # key-int-max: a group of pictures of two seconds at 25 frames a second. A file ends with a
    # group. No keyframes are requested where files begin: when such a request arrives, and so which
    # bits are recorded, depends on the load. A file needs no buffer model (vbv), which would also
    # make x264's output depend on the load.
    encoder = (f"x264enc speed-preset=veryfast bitrate={options.bitrate} vbv-buf-capacity=0 "
               "key-int-max=50")
    # single-segment: frames and lines have the times of the files, which count from the start of
    # the recording. RTSP's times begin elsewhere.
    text = (f"{source} ! identity name=single single-segment=true ! tee name=in "
            f"{even_size.ELEMENTS} "
            f"in. ! {bounded} name=raw ! videoconvert ! {encoder} ! h264parse ! "
            "splitmuxsink name=files muxer=matroskamux "
            f"max-size-time={round(options.segment * 1e9)} "
            f"in. ! {command.FRAME_QUEUE} name=look ! csdtrack name=csdtrack ! tee name=t "
            f"t. ! csdtrackenc ! application/x-ndjson ! {bounded} ! "
            "appsink name=lines sync=false async=false max-buffers=0 emit-signals=true")
    if options.display:
        text += (f" t. ! {command.FRAME_QUEUE} leaky=downstream ! appsink name=shown sync=false "
                 "async=false max-buffers=2 drop=true emit-signals=true")
    return text


def write_tracks(runner: ModuleType, run: Any, files: Any, sidecar: Sidecar,
                 recorded: Recorded) -> None:
    """Hands the lines to the sidecar, and when groups of pictures and files begin and end."""
    Gst = runner.Gst

    def on_line(sink: Any) -> Any:
        sample = sink.emit("pull-sample")
        buffer = sample.get_buffer()
        sidecar.add_line(sample.get_segment().to_running_time(Gst.Format.TIME, buffer.pts),
                         buffer.extract_dup(0, buffer.get_size()))
        return Gst.FlowReturn.OK

    def on_picture(pad: Any, info: Any) -> Any:
        buffer = info.get_buffer()
        if not buffer.has_flags(Gst.BufferFlags.DELTA_UNIT):
            segment = pad.get_sticky_event(Gst.EventType.SEGMENT, 0).parse_segment()
            sidecar.begin_group(segment.to_running_time(Gst.Format.TIME, buffer.pts))
        return Gst.PadProbeReturn.OK

    def on_message(_bus: Any, message: Any) -> Any:
        structure = message.get_structure()
        name = structure.get_name() if message.type == Gst.MessageType.ELEMENT else ""
        if name == "splitmuxsink-fragment-opened":
            sidecar.begin_file(structure.get_value("running-time"), structure.get_value("location"))
            recorded.begin_file(structure.get_value("location"))
        elif name == "splitmuxsink-fragment-closed":
            recorded.end_file(structure.get_value("location"))
        # matroskamux's error. splitmuxsink begins a new file, but the error was posted already.
        elif message.type == Gst.MessageType.ERROR and "Caps changes are not supported" in (
                message.parse_error()[1] or ""):
            return Gst.BusSyncReply.DROP
        return Gst.BusSyncReply.PASS

    run.element("lines").connect("new-sample", on_line)
    files.get_static_pad("video").add_probe(Gst.PadProbeType.BUFFER, on_picture)
    run.pipeline.get_bus().set_sync_handler(on_message)


def record(options: argparse.Namespace, source: str, tracks: pathlib.Path) -> None:
    """`source`: the beginning of the pipeline; `tracks`: the folder of the tracks."""
    from pipelines.lib import runner
    from pipelines.lib.video_errors import StatedLength, breaks_off
    Gst = runner.Gst
    run = runner.Run("record", description(options, source))
    track, files = run.element("csdtrack"), run.element("files")
    runner.configure(track, options.preset, {"overlay": "draw" if options.display else "none"},
                     options.set)
    even_size.crop(run, "record", options.source, "single", "in")
    times = FrameTimes(Gst, run.element("single").get_static_pad("src"), "record", options.source,
                       lambda: run.live)
    pace = Pace(runner, run.element("in").get_static_pad("sink"))
    stated = StatedLength(run.pipeline)
    # Before the first file is created: without its sink nothing must be left behind.
    window = Window(runner, options.display) if options.display else None
    created = Files(options.out, first_number(options.out, tracks))
    sidecar = Sidecar(tracks, created.name(0))
    files.connect("format-location", lambda _, fragment: created.name(fragment))
    recorded = Recorded(Gst, files)
    write_tracks(runner, run, files, sidecar, recorded)
    split_at_changes(runner, files, options.source)
    appsinks = [run.element("lines")]
    if window:
        appsinks.append(run.element("shown"))
        run.element("shown").connect("new-sample", window.on_sample)
    # These play from the start. In preroll they would keep the queues before them full. The
    # decoder's ALLOCATION query waits for empty queues, so it would hang. avdec_h264 sends one
    # after some frames where the width is no multiple of 16.
    for sink in appsinks:
        sink.set_locked_state(True)
        sink.set_state(Gst.State.PLAYING)
    failure = ""
    try:
        run.play(options.source, options.seconds, through="in", leaky=("look",))
    except command.Failure as failed:
        failure = str(failed)
        if run.stopped and not times.frames:
            failure += ": nothing was recorded"
    finally:
        for sink in appsinks:
            sink.set_state(Gst.State.NULL)
        sidecar.end()
        recorded.end()
        created.remove_empty(recorded.muxed)
        if window:
            window.close()
    if failure:
        found = [failure, recorded.summary(times.frames, sidecar)]
    else:
        found = list(recorded.differences(times.frames, sidecar, tracks, all_tracked=not run.live))
    if text := "; ".join(filter(None, found)):
        raise command.Failure(text)
    runner.print_cost(track, pace.frames)
    if run.live:
        pace.print_shortage(run.ending)
    elif run.source_ended and stated.known:
        incomplete = breaks_off(options.source, pace.position, pace.duration)
        if incomplete:
            command.print_line(f"record: {incomplete}", sys.stderr)


def main() -> None:
    options = command.parse_options(parse)
    source = sources.launch(options.source)
    command.check_window(options.display, "--display")
    tracks = options.tracks or options.out
    with command.locked_folders(options.out, tracks):
        record(options, source, tracks)


if __name__ == "__main__":
    command.run("record", main)
