# SPDX-License-Identifier: LGPL-2.1-or-later
"""Serves video and its tracks by RTSP, as two streams of one session, and with --web as a page: see --help.

    SOURCE ! queue (leaky) ! csdtrack ! tee ─ queue ! x264enc ! h264parse ! appsink ──► appsrc ! rtph264pay
                                        tee ─ queue ! tee ─ csdtrackenc ! appsink ────► appsrc ! rtpgstpay (--klv: rtpklvpay)
                                                      tee ─ csdtrackenc ! queue ! TRACKS
                                        tee ─ csdtrackenc ! queue ! appsink ──► web.py, with the H.264 (--web)

On the left is this program's own pipeline, on the right the one that gst-rtsp-server makes when somebody looks, and takes down when nobody
does any more. So tracking goes on, ids stay, and what is wrong with the source is said at once, whoever looks.
"""

import argparse
import pathlib
import re
import sys
import threading

from pipelines.lib import command, even, sources, web

EPILOG = sources.LISTED + """
Who looks gets two streams of one session: H.264, and a stream of encoding name X-GST (rtpgstpay) with the tracks, the lines of csdtrackenc
byte for byte (docs/metadata.md). A frame and its line have the same time. pipelines/receive writes the lines; players that know no X-GST show
the video. With --klv the lines are in packets of KLV (SMPTE 336), encoding name SMPTE336M, which programs of others know; pipelines/receive
wants --klv, too, then. Tracking begins with this program and goes on whoever looks: ids are the same for all.

It is served to this machine alone; --address 0.0.0.0 serves it to all who reach this machine. Neither password nor encryption keeps the
picture from them: that is for the network to do.

--web serves a page besides, at the same address, for any browser that plays H.264: the picture, the tracks drawn over it, and a click adds a
point, one with the right button removes the nearest. Clicks count from this machine only, or through a tunnel to it; others look.

What csdtrack is told: the preset live-low-latency (docs/pipelines.md). A file is served once, at its own pace, from the start of this program on.

Exit code: 0 if a picture was served, 1 if not (one line says why), 2 for wrong use.
"""

KEYFRAMES = 25  # frames from one to the next at most
SWEEP = 10      # seconds between two looks for sessions that are dead
HELD = 10**9    # ns that are held for a network which takes nothing


def parse(arguments):
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
    parser.add_argument(
        "--web", type=int, metavar="PORT", help=
        "also serve a page to look at, with the points to click; --web=PORT: there (8080; 0: any that is free)"
    )
    parser.add_argument("--bitrate", type=int, default=4000, metavar="KBIT",
                        help="of the video, kbit/s (4000)")
    parser.add_argument("--klv", action="store_true",
                        help="send the tracks as KLV (SMPTE 336), not as X-GST")
    parser.add_argument("--overlay", action="store_true",
                        help="draw the tracks into the picture that is served")
    parser.add_argument(
        "--tracks", type=pathlib.Path, metavar="FILE", help=
        "also write the tracks here, a line of JSON a frame; one that holds some already is refused"
    )
    parser.add_argument("--preset", default="live-low-latency", metavar="NAME",
                        help="of csdtrack (live-low-latency)")
    parser.add_argument("--seconds", type=command.positive, metavar="N", help="end after so long")
    command.add_common(parser)
    options = parser.parse_args(arguments)
    for name, port in ("--port", options.port), ("--web", options.web):
        if not 0 <= (port or 0) <= 65535:
            parser.error(f"{name}: {port} is not from 0 to 65535")
    if not re.fullmatch(r"[A-Za-z0-9_-]+", options.path):
        parser.error(f"--path: '{options.path}' is more than letters, digits, _ and -")
    if not 1 <= options.bitrate <= 2_000_000:
        parser.error(f"--bitrate: {options.bitrate} is not from 1 to 2000000")
    if options.tracks:
        command.check_unwritten(parser, options.tracks)
    return options


class Session:
    """What all clients share: the pipeline of gst-rtsp-server, whose sources are fed with what this program's pipeline makes.

    Its running time stands still while it is paused, which it also is for a moment between DESCRIBE and PLAY. What were held meanwhile would
    then have later times than what comes after it: so nothing is. Times go on from where it begins: a source may run slower than any clock.
    """

    def __init__(self, Gst, media, ask_keyframe):
        self._Gst = Gst
        self.media = media
        element = media.get_element()
        self._sources = {name: element.get_by_name(name) for name in ("video", "tracks")}
        self._described = self._played = False
        # running times, of this program's pipeline and of the session's, that are one
        self._begin = None
        self._waits = True  # video, for a keyframe
        self._ask_keyframe = ask_keyframe
        media.connect("prepared", self._prepared)
        media.connect("new-state", self._new_state)
        ask_keyframe()

    def _prepared(self, _media):
        self._described = True

    def _new_state(self, _media, state):
        if state == self._Gst.State.PLAYING:
            self._played = True
            self._ask_keyframe()

    def push(self, name, sample, time):
        """`time`: running time of this program's pipeline. What can't go out is left out, video up to the next keyframe then."""
        Gst, source, buffer = self._Gst, self._sources[name], sample.get_buffer()
        out = source.get_state(0).state != Gst.State.PLAYING or self._described and not self._played
        if out:
            self._begin = None
        elif self._begin is None:
            self._begin = time, source.get_current_running_time()
        out = out or time < self._begin[0] or source.get_property("current-level-time") > HELD
        if name == "video":
            self._waits = out or self._waits and buffer.has_flags(Gst.BufferFlags.DELTA_UNIT)
        if out or name == "video" and self._waits:
            return
        # what copy() gives gst-python 1.26 takes for another's, and lets no time be set
        buffer = buffer.copy_deep()
        buffer.pts, buffer.dts = time - self._begin[0] + self._begin[1], Gst.CLOCK_TIME_NONE
        source.emit("push-sample", Gst.Sample.new(buffer, sample.get_caps(), None, None))

    def end(self):
        for source in self._sources.values():
            source.emit("end-of-stream")


class Server:
    def __init__(self, Gst, GstRtspServer, options, ask_keyframe, every):
        self._Gst, self._ask_keyframe, self._every = Gst, ask_keyframe, every
        self._session = None
        self._lock = threading.Lock()
        self._server = GstRtspServer.RTSPServer()
        self._server.set_address(options.address)
        self._server.set_service(str(options.port))
        factory = GstRtspServer.RTSPMediaFactory()
        source = "appsrc is-live=true format=time block=false max-bytes=0"
        factory.set_launch(
            f"( {source} name=video ! h264parse ! rtph264pay name=pay0 pt=96 config-interval=-1 "
            f"{source} name=tracks ! {'rtpklvpay' if options.klv else 'rtpgstpay'} name=pay1 pt=97 )"
        )
        factory.set_shared(True)
        factory.connect("media-configure", self._begin)
        self._server.get_mount_points().add_factory(f"/{options.path}", factory)

    def attach(self):
        """The port, or None if it can't be had."""
        if not self._server.attach(None):
            return None
        # A client over UDP that dies says nothing: its session ends when it has not been heard of
        # for a minute.
        self._every(SWEEP, lambda: self._server.get_session_pool().cleanup() >= 0)
        return self._server.get_bound_port()

    def _begin(self, _factory, media):
        with self._lock:
            self._session = Session(self._Gst, media, self._ask_keyframe)
        media.connect("unprepared", self._unprepared)

    def _unprepared(self, media):
        with self._lock:
            if self._session and self._session.media is media:
                self._session = None

    def push(self, name, sample, time):
        with self._lock:
            if self._session:
                self._session.push(name, sample, time)

    def end(self):
        with self._lock:
            if self._session:
                self._session.end()


def main():
    options = command.options(parse)
    begin = sources.begin(options.source)
    from pipelines.lib import runner
    Gst = runner.Gst
    try:
        runner.gi.require_version("GstVideo", "1.0")
        runner.gi.require_version("GstRtspServer", "1.0")
    except ValueError as error:
        raise command.Failure(
            "there is no GStreamer RTSP server: install gir1.2-gst-rtsp-server-1.0, or leave out --no-install"
        ) from error
    from gi.repository import GstRtspServer, GstVideo
    sink = "appsink sync=true emit-signals=true max-buffers=3"
    # Frames are dropped before tracking only (`in`, if the source is live): each frame behind it
    # has its line.
    text = f"{begin} ! identity name=came ! {command.FRAMES} name=in {even.CROP} in. ! csdtrack name=csdtrack ! tee name=t " \
           f"t. ! {command.FRAMES} ! videoconvert ! x264enc tune=zerolatency speed-preset=veryfast bitrate={options.bitrate} key-int-max={KEYFRAMES} ! " \
           f"video/x-h264,profile=main ! h264parse ! video/x-h264,stream-format=avc,alignment=au ! {sink} name=video " \
           f"t. ! {command.FRAMES} ! tee name=l l. ! csdtrackenc ! {'meta/x-klv' if options.klv else 'application/x-ndjson'} ! {sink} name=tracks"
    if options.tracks:
        text += f" l. ! csdtrackenc ! application/x-ndjson ! {command.LINES} leaky=downstream ! {command.lines_file(options.tracks)}"
    if options.web is not None:
        # As soon as they are made: a click's point begins where the tissue is by the newest line,
        # and of a file csdtrack is some frames ahead of what is shown. Not from `l`, whose thread
        # waits for its other appsink.
        text += f" t. ! csdtrackenc ! application/x-ndjson ! {command.LINES} leaky=downstream ! " \
                "appsink sync=false async=false emit-signals=true max-buffers=3 name=lines"
    run = runner.Run("stream", text)
    track = run.element("csdtrack")
    runner.configure(track, options.preset, {"overlay": "draw" if options.overlay else "none"},
                     options.set)
    # profile=main is 4:2:0, whatever comes
    even.crop(Gst, run, "stream", options.source, "came", "in", lambda _: (2, 2))

    def ask_keyframe():
        run.element("video").get_static_pad("sink").push_event(
            GstVideo.video_event_new_upstream_force_key_unit(Gst.CLOCK_TIME_NONE, True, 0))

    server = Server(Gst, GstRtspServer, options, ask_keyframe, runner.GLib.timeout_add_seconds)
    port = server.attach()
    if not port:
        raise command.Failure(
            f"can't serve at {options.address}, port {options.port}: it is taken, or the address is not this machine's; "
            "choose others with --address and --port")
    page = web.Page(options.address, options.web, track,
                    ask_keyframe) if options.web is not None else None

    def sample(sink):
        got = sink.emit("pull-sample")
        time = got.get_segment().to_running_time(Gst.Format.TIME, got.get_buffer().pts)
        if time == Gst.CLOCK_TIME_NONE:
            return Gst.FlowReturn.OK
        if page and sink.get_name() == "lines":
            page.push_line(got, time)
        else:
            server.push(sink.get_name(), got, time)
        if page and sink.get_name() == "video":
            page.push_video(got, time, not got.get_buffer().has_flags(Gst.BufferFlags.DELTA_UNIT))
        return Gst.FlowReturn.OK

    for name in ("video", "tracks", "lines") if page else ("video", "tracks"):
        run.element(name).connect("new-sample", sample)
    command.told(f"rtsp://{options.address}:{port}/{options.path}", sys.stdout)
    if page:
        command.told(page.url, sys.stdout)
    try:
        run.play(options.source, options.seconds, leaky=("in",))
    finally:
        server.end()
        if page:
            page.end()
    runner.say_cost(track)


if __name__ == "__main__":
    command.run("stream", main)
