# SPDX-License-Identifier: LGPL-2.1-or-later
"""Writes the tracks of video that comes over the network: see --help.

A stream without tracks, as from a recorder, is tracked here:

    rtspsrc │ srtsrc ! decodebin ! queue (leaky) ! csdtrack ! tee ─ queue ! csdtrackenc ! TRACKS
                                                              tee ─ queue ! videoconvert ! WINDOW

One that brings its tracks along, as from pipelines/stream, is not:

    rtspsrc ─ rtpgstdepay ! tee ─ queue ! TRACKS
                            tee ─ queue ! csdtrackdec.text
            ─ decodebin ! queue ! csdtrackdec ! videoconvert ! WINDOW

With --klv tsdemux stands beside rtspsrc, and rtpklvdepay or nothing in rtpgstdepay's place.
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

from pipelines.lib import command, klv
from pipelines.lib.caps import first_structure

EPILOG = """
URL is one of

  rtsp://HOST[:PORT]/PATH    over one TCP connection, which loses nothing; rtspu:// is over UDP, which may lose frames and lines
  srt://HOST:PORT            a transport stream; srt://:PORT?mode=listener waits for the sender. Keys and the like are in the URL

TRACKS gets a line of JSON for each frame (docs/metadata.md). If the stream brings tracks along, as that of pipelines/stream does, its lines are
written as they were sent, byte for byte, and nothing is tracked; their times are then the sender's. Else csdtrack tracks here. KLV is in many
streams that know nothing of csdtrack: with --klv, and only then, it is what brings the tracks.

What csdtrack is told: the preset live-low-latency (docs/pipelines.md). To record the video too, give the URL to pipelines/record.

An RTSP server that isn't up yet is waited for, ten seconds. When it ends, so does this.

Exit code: 0 if a picture came, 1 if not, or if the connection was lost (one line says why; the lines that came until then are there), 2 for
wrong use.
"""


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="pipelines/receive", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        description="Receives video, and writes the tracks of points on the tissue in it.")
    parser.add_argument("url", metavar="URL", help="where it comes from")
    parser.add_argument(
        "tracks", type=pathlib.Path, metavar="TRACKS",
        help="the file of the tracks, .jsonl; one that holds some already is refused")
    parser.add_argument("--display", metavar="SINK",
                        help="also a window with the tracks drawn in; without =SINK autovideosink")
    parser.add_argument(
        "--klv", action="store_true", help=
        "the stream brings its tracks as KLV (SMPTE 336), as from stream --klv, or csdtrackenc ! mpegtsmux"
    )
    parser.add_argument("--latency", type=int, default=200, metavar="MS",
                        help="how long packets are waited for (200)")
    parser.add_argument("--preset", default="live-low-latency", metavar="NAME",
                        help="of csdtrack (live-low-latency)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    if not re.match(r"(rtsp[uth]?|rtsps[uth]?|srt)://.", options.url):
        parser.error(
            f"'{options.url}' is neither rtsp://… nor srt://…: pipelines/live and pipelines/record take other sources"
        )
    if not 0 <= options.latency <= 60_000:
        parser.error(f"--latency: {options.latency} is not from 0 to 60000")
    command.check_unwritten(parser, options.tracks)
    if options.display and not re.fullmatch(r"[a-z0-9]+", options.display):
        parser.error(f"--display: '{options.display}' is no name of an element")
    return options


PATIENCE = 10  # seconds, with a sender that isn't there yet

# What is too old is of no use, as in pipelines/live.
FRAMES = f"{command.FRAMES} leaky=downstream"


def source(options):
    if options.url.startswith("srt:"):
        return f"srtsrc uri={command.quoted(options.url)} latency={options.latency} ! " + (
            "tsdemux name=in " if options.klv else "")
    # buffer-mode=none: times are the sender's, so those of a frame and of its line stay the same.
    # Other modes bend those of each stream to this machine's clock, each by itself: seen to be up
    # to 0.2 s apart in the first second.
    tcp = "protocols=tcp" if re.match("rtsps?:", options.url) else ""
    return f"rtspsrc name=in location={command.quoted(options.url)} latency={options.latency} buffer-mode=none {tcp} "


def consumers(options, carried):
    """What comes behind the frames, beginning with the element `picture`, and behind the lines if the stream carries them, with `lines`."""
    file = f"{command.lines_file(options.tracks)} name=file sync=false"
    window = f"videoconvert ! {options.display}"
    if not carried:
        text = f"csdtrack name=picture ! tee name=t t. ! {command.LINES} leaky=downstream ! csdtrackenc ! application/x-ndjson ! {file}"
        return text + (f" t. ! {FRAMES} ! {window}" if options.display else "")
    if options.klv:
        first = "rtpklvdepay" if options.url.startswith("rtsp") else "identity"
        text = f"{first} name=lines ! tee name=l l. ! {command.LINES} ! appsink name=packets emit-signals=true sync=false async=false " \
               f"appsrc name=unpacked format=bytes ! {file}"
    else:
        text = f"rtpgstdepay name=lines ! application/x-ndjson ! tee name=l l. ! {command.LINES} ! {file}"
    if not options.display:
        return f"{text} fakesink name=picture sync=false async=false"
    # A frame waits for its line, but not so long that it comes late itself.
    return f"{text} csdtrackdec name=picture overlay=draw ! {window} l. ! {command.LINES} ! picture.text"


def await_sender(url):
    """Who starts sender and receiver together need not know which is up first."""
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
                raise command.Failure(
                    f"nobody serves RTSP at {address[0]}:{address[1]}: start the sender, or give its URL"
                ) from error
            time.sleep(0.2)
        except OSError as error:
            raise command.Failure(
                f"{address[0]}:{address[1]} can't be reached ({error.strerror or error})"
            ) from error


def holds_lines(told):
    """Whether a stream's caps, as rtpgstpay tells them (base64), are those of lines. They are the server's words, and may be anything."""
    try:
        return base64.b64decode(told or "").startswith(b"application/x-ndjson")
    except ValueError:
        return False


class Receiver:
    """Builds what comes behind the source once it is known what the source brings."""

    def __init__(self, runner, run, options):
        self._runner, self._run, self._options = runner, run, options
        self._streams = {}   # kind -> number of the stream of the session
        self._built = None
        self._lock = threading.Lock()
        self.lines = 0       # that were carried
        self.track = None    # csdtrack, if it tracks here

    def select(self, _source, number, caps):
        """Which streams of a session are wanted: the first video, the first tracks. Sound is not."""
        what = first_structure(caps)
        kind = {"video": "picture"}.get(what.get_string("media"))
        if self._options.klv:
            kind = "lines" if what.get_string("encoding-name") == "SMPTE336M" else kind
        elif what.get_string("encoding-name") == "X-GST" and holds_lines(what.get_string("caps")):
            kind = "lines"
        return kind is not None and self._streams.setdefault(kind, number) == number

    def pad_added(self, _source, pad):
        # All streams of a session have been selected before one of them has a pad.
        with self._lock:  # each stream's is added from a thread of its own
            built = self.build()
        what = first_structure(pad.get_current_caps())
        # tsdemux: video/x-h264, meta/x-klv
        media = what.get_string("media") or what.get_name().partition("/")[0]
        target = {"video": self._run.element("video").get_static_pad("sink"),
                  "audio": None}.get(media, built.get_static_pad("lines"))
        if target and not target.is_linked():
            pad.link(target)

    def no_more_pads(self, _source):
        if self._options.klv and not (self._built and self._built.get_static_pad("lines") and
                                      self._built.get_static_pad("lines").is_linked()):
            self._run.fail("it brings no KLV: leave out --klv, and it is tracked here")

    def build(self):
        Gst = self._runner.Gst
        if self._built:
            return self._built
        carried = "lines" in self._streams or self._options.klv and self._options.url.startswith(
            "srt")
        self._built = built = Gst.parse_bin_from_description(consumers(self._options, carried),
                                                             False)
        for name in ("picture", "lines") if carried else ("picture",):
            built.add_pad(Gst.GhostPad.new(name, built.get_by_name(name).get_static_pad("sink")))
        if carried:
            built.get_by_name("file").get_static_pad("sink").add_probe(
                Gst.PadProbeType.BUFFER, self._count)
            if self._options.klv:
                self._unpack(built.get_by_name("packets"), built.get_by_name("unpacked"))
        else:
            self.track = built.get_by_name("picture")
            configure(self._runner, self.track, self._options)
        self._run.pipeline.add(built)
        self._run.element("frames").get_static_pad("src").link(built.get_static_pad("picture"))
        built.sync_state_with_parent()
        return built

    def _unpack(self, packets, unpacked):
        Gst, lines = self._runner.Gst, klv.Lines()

        def sample(sink):
            buffer = sink.emit("pull-sample").get_buffer()
            for line in lines.take(buffer.extract_dup(0, buffer.get_size())):
                unpacked.emit("push-buffer", Gst.Buffer.new_wrapped(line))
            return Gst.FlowReturn.OK

        packets.connect("new-sample", sample)
        packets.connect("eos", lambda _: unpacked.emit("end-of-stream"))

    def _count(self, _pad, _info):
        self.lines += 1
        return self._runner.Gst.PadProbeReturn.OK


def configure(runner, track, options):
    runner.configure(track, options.preset, {"overlay": "draw" if options.display else "none"},
                     options.set)


def main():
    options = command.options(parse)
    from pipelines.lib import runner
    Gst = runner.Gst
    # what is wrong is said before a connection is made
    configure(runner, Gst.ElementFactory.make("csdtrack"), options)
    if options.display and not Gst.ElementFactory.find(options.display):
        raise command.Failure(
            f"there is no element '{options.display}' for the window: give another with --display")
    command.check_window(options.display, "--display")
    if options.url.startswith("rtsp"):
        await_sender(options.url)
    run = runner.Run(
        "receive", f"{source(options)} decodebin name=video ! video/x-raw ! {FRAMES} name=frames",
        counted=("frames", ))
    receiver = Receiver(runner, run, options)
    session = run.element("in")
    if session:
        if options.url.startswith("rtsp"):
            session.connect("select-stream", receiver.select)
        session.connect("pad-added", receiver.pad_added)
        session.connect("no-more-pads", receiver.no_more_pads)
    else:
        receiver.build()
    run.play(options.url, options.seconds, harmless=("window was closed",))
    if run.over:
        command.told("the sender's stream ended", sys.stdout)
    if receiver.track:
        runner.say_cost(receiver.track)
    else:
        uneven = " (at the begin and the end one can come without the other)" if run.frames != receiver.lines else ""
        command.told(
            f"{run.frames} frames; {receiver.lines} lines of tracks came with them{uneven}",
            sys.stdout)


if __name__ == "__main__":
    command.run("receive", main)
