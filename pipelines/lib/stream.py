# SPDX-License-Identifier: LGPL-2.1-or-later
"""Serves video and its tracks by RTSP, as two streams of one session; with --web also as a page.

    SOURCE ! queue (leaky) ! csdtrack ! tee
      tee ─ queue ! x264enc ! h264parse ! appsink ──► appsrc ! rtph264pay
      tee ─ queue ! tee ─ csdtrackenc ! appsink ────► appsrc ! rtpgstpay (--klv: rtpklvpay)
                    tee ─ csdtrackenc ! queue ! TRACKS
      tee ─ csdtrackenc ! queue ! appsink ──► web.py, with the H.264 (--web)

On the left is this program's own pipeline. On the right is the pipeline that gst-rtsp-server makes
for its clients and removes when the last one leaves. So tracking goes on and ids stay, and errors
of the source are reported at once, whether or not there are clients.
"""

import argparse
import pathlib
import re
import sys
import threading
import time
from collections.abc import Callable
from types import ModuleType
from typing import TYPE_CHECKING, Any

from pipelines.lib import command, even_size, sources, web

if TYPE_CHECKING:
    from pipelines.lib.runner import Run

EPILOG = sources.HELP + """
A client gets two streams of one session: H.264, and a stream of encoding name X-GST (rtpgstpay)
with the tracks, the lines of csdtrackenc byte for byte (docs/metadata.md). A frame and its line
have the same time. pipelines/receive writes the lines; players that don't know X-GST show the
video. With --klv the lines are in packets of KLV (SMPTE 336), encoding name SMPTE336M, which other
programs know; pipelines/receive then needs --klv, too. Tracking begins with this program, whether
or not there are clients: ids are the same for all.

Only this machine is served. --address 0.0.0.0 serves all machines that can reach this one. There is
no password and no encryption: the network has to protect the picture.

--web also serves a page at the same address, for any browser that plays H.264: the picture with the
tracks drawn over it. A click adds a point, a click with the right button removes the nearest. Only
clicks from this machine count, or through a tunnel to it; others can look.

csdtrack runs with the preset live-low-latency (docs/pipelines.md). A file is served once, at its
own pace, from the start of this program on.

Exit code: 0 if a picture was served and each tracked frame has its line in FILE, 1 if not (one line
says why), 2 for wrong use.
"""

KEYFRAME_INTERVAL = 25  # frames, at most
CLEANUP_INTERVAL = 10   # seconds, between two checks for dead sessions
MAX_QUEUED = 10**9      # ns of a stream that may wait for the network
PATIENCE = 1            # seconds for clients to leave after the streams' end


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="pipelines/stream", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog=EPILOG,
        description="Serves video, and the tracks of points on the tissue in it, by RTSP.")
    parser.add_argument("source", nargs="?", default="simulate", metavar="SOURCE",
                        help="where the picture comes from (simulate)")
    parser.add_argument("--address", default="127.0.0.1", metavar="IP",
                        help="of this machine, where it is served (127.0.0.1)")
    parser.add_argument("--port", type=int, default=8554, metavar="N",
                        help="where it is served (8554; 0: any that is free)")
    parser.add_argument("--path", default="csdtrack", metavar="NAME", help="of the URL (csdtrack)")
    parser.add_argument("--web", type=int, metavar="PORT",
                        help="also serve a page with the picture, where clicks add points; "
                        "--web=PORT: there (8080; 0: any that is free)")
    parser.add_argument("--bitrate", type=int, default=4000, metavar="KBIT",
                        help="of the video, kbit/s (4000)")
    parser.add_argument("--klv", action="store_true",
                        help="send the tracks as KLV (SMPTE 336), not as X-GST")
    parser.add_argument("--overlay", action="store_true",
                        help="draw the tracks into the picture that is served")
    parser.add_argument("--tracks", type=pathlib.Path, metavar="FILE",
                        help="also write the tracks here, a line of JSON a frame; "
                        "a file that holds tracks already is refused")
    command.add_tracking(parser)
    options = parser.parse_args(arguments)
    for name, port in ("--port", options.port), ("--web", options.web):
        if not 0 <= (port or 0) <= 65535:
            parser.error(f"{name}: {port} is not from 0 to 65535")
    if not re.fullmatch(r"[A-Za-z0-9_-]+", options.path):
        parser.error(f"--path: '{options.path}' is more than letters, digits, _ and -")
    if not 1 <= options.bitrate <= 2_000_000:
        parser.error(f"--bitrate: {options.bitrate} is not from 1 to 2000000")
    if options.tracks:
        command.check_new_tracks(parser, options.tracks)
    return options


class Session:
    """The pipeline of gst-rtsp-server that all clients share. This program feeds its sources.

    Its running time stands still while it is paused, as it is between DESCRIBE and PLAY. Buffers
    that were kept meanwhile would then be later than those that follow, so none are kept. Times
    continue from the session's own beginning, as a source may run slower than any clock.
    """

    def __init__(self, Gst: Any, media: Any, request_keyframe: Callable[[], None]) -> None:
        self._Gst = Gst
        self.media = media
        element = media.get_element()
        self._sources = {name: element.get_by_name(name) for name in ("video", "tracks")}
        self._described = self._played = False
        # Running times of this program's pipeline and of the session's, at the same moment.
        self._begin: tuple[int, int] | None = None
        self._needs_keyframe = True
        self._request_keyframe = request_keyframe
        media.connect("prepared", self._on_prepared)
        media.connect("new-state", self._on_new_state)
        request_keyframe()

    def _on_prepared(self, _media: Any) -> None:
        self._described = True

    def _on_new_state(self, _media: Any, state: Any) -> None:
        if state == self._Gst.State.PLAYING:
            self._played = True
            self._request_keyframe()

    def push(self, name: str, sample: Any, time: int) -> None:
        """Sends a buffer, or drops it. After a dropped frame the video waits for a keyframe.

        `time`: running time of this program's pipeline.
        """
        Gst, source, buffer = self._Gst, self._sources[name], sample.get_buffer()
        playing = source.get_state(0).state == Gst.State.PLAYING
        if not playing or self._described and not self._played:
            self._begin = None
        elif self._begin is None:
            self._begin = time, source.get_current_running_time()
        drop = (self._begin is None or time < self._begin[0] or
                source.get_property("current-level-time") > MAX_QUEUED)
        if name == "video":
            delta = buffer.has_flags(Gst.BufferFlags.DELTA_UNIT)
            self._needs_keyframe = drop or self._needs_keyframe and delta
            drop = self._needs_keyframe
        if drop or self._begin is None:
            return
        # gst-python 1.26 lets no time be set on the result of copy().
        buffer = buffer.copy_deep()
        buffer.pts, buffer.dts = time - self._begin[0] + self._begin[1], Gst.CLOCK_TIME_NONE
        source.emit("push-sample", Gst.Sample.new(buffer, sample.get_caps(), None, None))

    def end(self) -> None:
        for source in self._sources.values():
            source.emit("end-of-stream")


class Server:
    """The RTSP server, with one session or none."""

    def __init__(self, Gst: Any, GstRtspServer: Any, options: argparse.Namespace,
                 request_keyframe: Callable[[], None], GLib: Any) -> None:
        self._Gst, self._GLib, self._request_keyframe = Gst, GLib, request_keyframe
        self._session: Session | None = None
        self._lock = threading.Lock()
        self._server = GstRtspServer.RTSPServer()
        self._server.set_address(options.address)
        self._server.set_service(str(options.port))
        factory = GstRtspServer.RTSPMediaFactory()
        source = "appsrc is-live=true format=time block=false max-bytes=0"
        tracks_payloader = "rtpklvpay" if options.klv else "rtpgstpay"
        factory.set_launch(
            f"( {source} name=video ! h264parse ! rtph264pay name=pay0 pt=96 config-interval=-1 "
            f"{source} name=tracks ! {tracks_payloader} name=pay1 pt=97 )")
        factory.set_shared(True)
        factory.connect("media-configure", self._on_media_configure)
        self._server.get_mount_points().add_factory(f"/{options.path}", factory)

    def start(self) -> int | None:
        """The port; None if it can't be used."""
        if not self._server.attach(None):
            return None
        # A client over UDP sends nothing when it dies. Its session ends after a minute of silence.
        self._GLib.timeout_add_seconds(
            CLEANUP_INTERVAL, lambda: self._server.get_session_pool().cleanup() >= 0)
        return self._server.get_bound_port()

    def _on_media_configure(self, _factory: Any, media: Any) -> None:
        with self._lock:
            self._session = Session(self._Gst, media, self._request_keyframe)
        media.connect("unprepared", self._on_unprepared)

    def _on_unprepared(self, media: Any) -> None:
        with self._lock:
            if self._session and self._session.media is media:
                self._session = None

    def push(self, name: str, sample: Any, time: int) -> None:
        with self._lock:
            if self._session:
                self._session.push(name, sample, time)

    def end(self) -> None:
        """Says to all clients that the streams end, and waits a moment until they are gone.

        A process that leaves with a client's reports unread resets the connection, and for that
        client the sender is lost.
        """
        with self._lock:
            if self._session:
                self._session.end()
        context, end = self._GLib.MainContext.default(), time.monotonic() + PATIENCE
        while self._server.client_filter(None) and time.monotonic() < end:
            if not context.iteration(False):
                time.sleep(0.01)


def load_rtsp(runner: ModuleType) -> tuple[Any, Any]:
    """GstRtspServer and GstVideo."""
    try:
        runner.gi.require_version("GstVideo", "1.0")
        runner.gi.require_version("GstRtspServer", "1.0")
    except ValueError as error:
        raise command.Failure("there is no GStreamer RTSP server: install "
                              "gir1.2-gst-rtsp-server-1.0, or leave out --no-install") from error
    from gi.repository import GstRtspServer, GstVideo
    return GstRtspServer, GstVideo


def description(options: argparse.Namespace, source: str) -> str:
    """Of this program's pipeline. `source`: its beginning."""
    frames, lines = command.FRAME_QUEUE, f"{command.LINE_QUEUE} leaky=downstream"
    sink = "appsink sync=true emit-signals=true max-buffers=3"
    form = "meta/x-klv" if options.klv else "application/x-ndjson"
    # Frames are dropped only before they are tracked (by `in`, if the source is live): behind it
    # each frame has its line.
    text = (f"{source} ! identity name=came ! {frames} name=in {even_size.ELEMENTS} "
            "in. ! csdtrack name=csdtrack ! tee name=t "
            f"t. ! {frames} ! videoconvert ! x264enc tune=zerolatency speed-preset=veryfast "
            f"bitrate={options.bitrate} key-int-max={KEYFRAME_INTERVAL} ! "
            "video/x-h264,profile=main ! h264parse ! "
            f"video/x-h264,stream-format=avc,alignment=au ! {sink} name=video "
            f"t. ! {frames} ! tee name=l l. ! csdtrackenc ! {form} ! {sink} name=tracks")
    if options.tracks:
        text += (f" l. ! csdtrackenc ! application/x-ndjson ! {lines} ! "
                 f"{command.line_sink(options.tracks)}")
    if options.web is not None:
        # sync=false: a clicked point begins where the newest line has the tissue, and in a file
        # csdtrack is some frames ahead of the picture. Not from `l`, whose thread waits for its
        # other appsink.
        text += (f" t. ! csdtrackenc ! application/x-ndjson ! {lines} ! "
                 "appsink sync=false async=false emit-signals=true max-buffers=3 name=lines")
    return text


def connect(runner: ModuleType, run: "Run", server: Server, page: web.Page | None) -> None:
    """Hands the pipeline's samples to the server and to the page."""
    Gst = runner.Gst

    def on_sample(sink: Any) -> Any:
        sample, name = sink.emit("pull-sample"), sink.get_name()
        buffer = sample.get_buffer()
        time = sample.get_segment().to_running_time(Gst.Format.TIME, buffer.pts)
        if time == Gst.CLOCK_TIME_NONE:
            return Gst.FlowReturn.OK
        if page and name == "lines":
            page.push_line(sample, time)
        else:
            server.push(name, sample, time)
        if page and name == "video":
            page.push_video(sample, time, not buffer.has_flags(Gst.BufferFlags.DELTA_UNIT))
        return Gst.FlowReturn.OK

    for name in ("video", "tracks", "lines") if page else ("video", "tracks"):
        run.element(name).connect("new-sample", on_sample)


def main() -> None:
    options = command.parse_options(parse)
    source = sources.launch(options.source)
    from pipelines.lib import runner
    Gst = runner.Gst
    GstRtspServer, GstVideo = load_rtsp(runner)
    run = runner.Run("stream", description(options, source))
    track = run.element("csdtrack")
    runner.configure(track, options.preset, {"overlay": "draw" if options.overlay else "none"},
                     options.set)
    # profile=main is 4:2:0, whatever the source's format.
    even_size.crop(run, "stream", options.source, "came", "in", lambda _: (2, 2))

    def request_keyframe() -> None:
        run.element("video").get_static_pad("sink").push_event(
            GstVideo.video_event_new_upstream_force_key_unit(Gst.CLOCK_TIME_NONE, True, 0))

    server = Server(Gst, GstRtspServer, options, request_keyframe, runner.GLib)
    port = server.start()
    if not port:
        raise command.Failure(
            f"can't serve at {options.address}, port {options.port}: it is taken, or the address "
            "is not this machine's; choose others with --address and --port")
    page = None
    if options.web is not None:
        page = web.Page(options.address, options.web, track, request_keyframe)
    connect(runner, run, server, page)
    command.print_line(f"rtsp://{options.address}:{port}/{options.path}", sys.stdout)
    if page:
        command.print_line(page.url, sys.stdout)
    if options.tracks:
        run.watch_lines(run.element("file"), options.tracks)
    try:
        run.play(options.source, options.seconds, leaky=("in",))
    finally:
        server.end()
        if page:
            page.end()
    runner.print_cost(track)
    if options.tracks and (lost := run.lost_lines("file", run.frames)):
        raise command.Failure(lost)


if __name__ == "__main__":
    command.run("stream", main)
