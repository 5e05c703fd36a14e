# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the tracks of video that arrives over the network: see --help.

A stream without tracks, as from a recorder, is tracked here:

    rtspsrc │ srtsrc ! decodebin ! queue (leaky) ! csdtrack ! tee ─ queue ! csdtrackenc ! TRACKS
                                                              tee ─ queue ! videoconvert ! WINDOW

A stream with tracks, as from pipelines/stream, is not:

    rtspsrc ─ rtpgstdepay ! tee ─ queue ! TRACKS
                            tee ─ queue ! csdtrackdec.text
            ─ decodebin ! queue ! csdtrackdec ! videoconvert ! WINDOW

With --klv, rtpklvdepay replaces rtpgstdepay. With SRT, tsdemux is the source of both.
"""

import argparse
import base64
import pathlib
import re
import socket
import sys
import threading
import time
import urllib.parse
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pipelines.lib import command, counts, klv
from pipelines.lib.caps import first_structure

if TYPE_CHECKING:
    from pipelines.lib.runner import Run

EPILOG = """
URL is one of

  rtsp://HOST[:PORT]/PATH    over one TCP connection, which loses nothing; rtspu:// is over UDP,
                             which may lose frames and lines
  srt://HOST:PORT            a transport stream; srt://:PORT?mode=listener waits for the sender.
                             Keys and the like are in the URL

TRACKS gets a line of JSON for each frame (docs/metadata.md). If the stream contains tracks, as that
of pipelines/stream does, its lines are written as they were sent, byte for byte, with the sender's
times, and nothing is tracked. Otherwise csdtrack tracks here. Many streams contain KLV that is not
csdtrack's: so it is read as tracks only with --klv.

csdtrack runs with the preset live-low-latency (docs/pipelines.md). To record the video too, give
the URL to pipelines/record.

If the sender isn't up yet, this waits for it, ten seconds. When it ends, so does this. SRT can't
tell the end from a lost connection: both are five seconds of silence.

Exit code: 0 if a picture came, 1 if not, if the connection was lost, or if the file lacks a line
(one line says why; the lines that came before are there), 2 for wrong use.
"""


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/receive", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        description="Receives video, and writes the tracks of points on the tissue in it.")
    parser.add_argument("url", metavar="URL", help="where it comes from")
    parser.add_argument("tracks", type=pathlib.Path, metavar="TRACKS",
                        help="the file of the tracks, .jsonl; "
                        "a file that holds tracks already is refused")
    parser.add_argument("--display", metavar="SINK",
                        help="also a window with the tracks drawn in; without =SINK autovideosink")
    parser.add_argument("--klv", action="store_true",
                        help="the stream contains its tracks as KLV (SMPTE 336), "
                        "as from stream --klv, or csdtrackenc ! mpegtsmux")
    parser.add_argument("--latency", type=int, default=200, metavar="MS",
                        help="how long late packets are waited for (200)")
    command.add_tracking(parser)
    options = parser.parse_args(arguments)
    if not re.match(r"(rtsp[uth]?|rtsps[uth]?|srt)://.", options.url):
        parser.error(f"'{options.url}' is neither rtsp://… nor srt://…: "
                     "pipelines/live and pipelines/record take other sources")
    if not 0 <= options.latency <= 60_000:
        parser.error(f"--latency: {options.latency} is not from 0 to 60000")
    command.check_new_tracks(parser, options.tracks)
    command.check_sink(parser, "--display", options.display)
    return options


PATIENCE = 10  # seconds to wait for a sender that isn't up yet

# Old frames are of no use, as in pipelines/live.
FRAMES = f"{command.FRAME_QUEUE} leaky=downstream"


def source(options: argparse.Namespace) -> str:
    """The beginning of the pipeline's description."""
    url = command.quoted(options.url)
    if options.url.startswith("srt:"):
        demux = "tsdemux name=in " if options.klv else ""
        return f"srtsrc name=srt uri={url} latency={options.latency} ! {demux}"
    # buffer-mode=none keeps the sender's times, so those of a frame and its line stay equal. Other
    # modes adapt each stream by itself to this machine's clock: in the first second they were up to
    # 0.2 s apart.
    tcp = "protocols=tcp" if re.match("rtsps?:", options.url) else ""
    return f"rtspsrc name=in location={url} latency={options.latency} buffer-mode=none {tcp} "


def consumers(options: argparse.Namespace, has_tracks: bool) -> str:
    """What follows the source: from the element `picture`, and from `lines` if it has tracks."""
    file = f"{command.line_sink(options.tracks)} sync=false"
    window = f"videoconvert ! {options.display}"
    if not has_tracks:
        text = (f"csdtrack name=picture ! tee name=t t. ! {command.LINE_QUEUE} leaky=downstream ! "
                f"csdtrackenc ! application/x-ndjson ! {file}")
        return text + (f" t. ! {FRAMES} ! {window}" if options.display else "")
    if options.klv:
        first = "rtpklvdepay" if options.url.startswith("rtsp") else "identity"
        text = (f"{first} name=lines ! tee name=l l. ! {command.LINE_QUEUE} ! "
                "appsink name=packets emit-signals=true sync=false async=false "
                f"appsrc name=unpacked format=bytes ! {file}")
    else:
        text = ("rtpgstdepay name=lines ! application/x-ndjson ! tee name=l "
                f"l. ! {command.LINE_QUEUE} ! {file}")
    if not options.display:
        return f"{text} fakesink name=picture sync=false async=false"
    # A frame waits for its line, but not so long that it would be late.
    return (f"{text} csdtrackdec name=picture overlay=draw ! {window} "
            f"l. ! {command.LINE_QUEUE} ! picture.text")


def wait_for_server(url: str) -> None:
    """Users may start sender and receiver together."""
    at = urllib.parse.urlsplit(url)
    try:
        address = at.hostname, at.port or (322 if at.scheme.startswith("rtsps") else 554)
    except ValueError as error:
        raise command.Failure(f"'{url}': {error}") from error
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return socket.create_connection(address, timeout=PATIENCE).close()
        except ConnectionRefusedError as error:
            if time.monotonic() > end:
                raise command.Failure(f"nobody serves RTSP at {address[0]}:{address[1]}: "
                                      "start the sender, or give its URL") from error
            time.sleep(0.2)
        except OSError as error:
            raise command.Failure(f"{address[0]}:{address[1]} can't be reached "
                                  f"({error.strerror or error})") from error


def are_lines(caps: str | None) -> bool:
    """Whether caps, as rtpgstpay sends them (base64), are those of lines.

    They come from the server and may be anything.
    """
    try:
        return base64.b64decode(caps or "").startswith(b"application/x-ndjson")
    except ValueError:
        return False


class Receiver:
    """Builds the rest of the pipeline when the source's streams are known."""

    def __init__(self, runner: ModuleType, run: "Run", options: argparse.Namespace) -> None:
        self._runner, self._run, self._options = runner, run, options
        self._streams: dict[str, int] = {}  # number of a stream of the session, by its kind
        self._built: Any = None
        self._lock = threading.Lock()
        self.track: Any = None  # csdtrack, if it tracks here

    def select(self, _source: Any, number: int, caps: Any) -> bool:
        """Selects a session's first video and its first tracks, and no sound."""
        structure = first_structure(caps)
        encoding = structure.get_string("encoding-name")
        kind = {"video": "picture"}.get(structure.get_string("media"))
        if self._options.klv:
            kind = "lines" if encoding == "SMPTE336M" else kind
        elif encoding == "X-GST" and are_lines(structure.get_string("caps")):
            kind = "lines"
        return kind is not None and self._streams.setdefault(kind, number) == number

    def on_pad_added(self, _source: Any, pad: Any) -> None:
        # By now all streams of the session have been selected.
        with self._lock:  # each stream's pad is added from a thread of its own
            built = self.build()
        structure = first_structure(pad.get_current_caps())
        # tsdemux: video/x-h264, meta/x-klv
        media = structure.get_string("media") or structure.get_name().partition("/")[0]
        target = {"video": self._run.element("video").get_static_pad("sink"),
                  "audio": None}.get(media, built.get_static_pad("lines"))
        if target and not target.is_linked():
            pad.link(target)

    def on_no_more_pads(self, _source: Any) -> None:
        lines = self._built and self._built.get_static_pad("lines")
        # A session's pads are added by a thread each, so this may come before its lines are linked
        # (seen on a busy machine).
        has_lines = "lines" in self._streams or lines and lines.is_linked()
        if self._options.klv and not has_lines:
            self._run.fail("it contains no KLV: leave out --klv, and it is tracked here")

    def build(self) -> Any:
        Gst = self._runner.Gst
        if self._built:
            return self._built
        srt = self._options.url.startswith("srt")
        has_tracks = "lines" in self._streams or self._options.klv and srt
        self._built = built = Gst.parse_bin_from_description(
            consumers(self._options, has_tracks), False)
        for name in ("picture", "lines") if has_tracks else ("picture",):
            built.add_pad(Gst.GhostPad.new(name, built.get_by_name(name).get_static_pad("sink")))
        if has_tracks:
            if self._options.klv:
                self._unpack(built.get_by_name("packets"), built.get_by_name("unpacked"))
        else:
            self.track = built.get_by_name("picture")
            configure(self._runner, self.track, self._options)
        self._run.watch_lines(built.get_by_name("file"), self._options.tracks)
        self._run.pipeline.add(built)
        self._run.element("frames").get_static_pad("src").link(built.get_static_pad("picture"))
        built.sync_state_with_parent()
        return built

    def _unpack(self, packets: Any, unpacked: Any) -> None:
        Gst, lines = self._runner.Gst, klv.Lines()

        def on_sample(sink: Any) -> Any:
            buffer = sink.emit("pull-sample").get_buffer()
            for line in lines.take(buffer.extract_dup(0, buffer.get_size())):
                unpacked.emit("push-buffer", Gst.Buffer.new_wrapped(line))
            return Gst.FlowReturn.OK

        packets.connect("new-sample", on_sample)
        packets.connect("eos", lambda _: unpacked.emit("end-of-stream"))


def configure(runner: ModuleType, track: Any, options: argparse.Namespace) -> None:
    runner.configure(track, options.preset, {"overlay": "draw" if options.display else "none"},
                     options.set)


def end_with_sender(Gst: Any, srt: Any, frames: Any) -> None:
    """Ends the stream when an SRT sender is gone.

    srtsrc reconnects until the sender is up. After the first frame it must not, or it would try for
    ever.
    """

    def first_frame(_pad: Any, _info: Any) -> Any:
        srt.set_property("auto-reconnect", False)
        return Gst.PadProbeReturn.REMOVE

    frames.get_static_pad("sink").add_probe(Gst.PadProbeType.BUFFER, first_frame)


def main() -> None:
    options = command.parse_options(parse)
    from pipelines.lib import runner
    Gst = runner.Gst
    # Wrong settings are reported before a connection is made.
    configure(runner, Gst.ElementFactory.make("csdtrack"), options)
    if options.display and not Gst.ElementFactory.find(options.display):
        raise command.Failure(
            f"there is no element '{options.display}' for the window: give another with --display")
    command.check_window(options.display, "--display")
    if options.url.startswith("rtsp"):
        wait_for_server(options.url)
    run = runner.Run(
        "receive", f"{source(options)} decodebin name=video ! video/x-raw ! {FRAMES} name=frames",
        counted=("frames",))
    receiver = Receiver(runner, run, options)
    session = run.element("in")
    if session:
        if options.url.startswith("rtsp"):
            session.connect("select-stream", receiver.select)
        session.connect("pad-added", receiver.on_pad_added)
        session.connect("no-more-pads", receiver.on_no_more_pads)
    else:
        receiver.build()
    if srt := run.element("srt"):
        end_with_sender(Gst, srt, run.element("frames"))
    run.play(options.url, options.seconds, harmless=("window was closed",), through="frames")
    if run.source_ended:
        command.print_line("the sender's stream ended", sys.stdout)
    lines = run.lines("file")
    if receiver.track:
        runner.print_cost(receiver.track)
        due = receiver.track.get_property("stats").get_value("frames")
    else:
        due, uneven = lines, ""
        if run.frames != lines:
            uneven = " (at the beginning and the end one can come without the other)"
        command.print_line(
            f"{counts.plural(run.frames, 'frame')}; {counts.plural(lines, 'line')} of "
            f"tracks came with them{uneven}", sys.stdout)
    if lost := run.lost_lines("file", due):
        raise command.Failure(lost)


if __name__ == "__main__":
    command.run("receive", main)
