# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of pipelines/stream --web: picture and tracks over HTTP, and clicks for points.

GET /live is one endless answer of records. A record has a header: its kind (a byte), the length of
its content (4 bytes), and its frame's time (8 bytes, µs of running time), big-endian. The kinds:

  H  JSON about what follows
  I  the header of the video (fragments.py)
  V  a frame
  T  a frame's line of csdtrackenc, with the same time as its frame
  K  nothing: without it, a viewer that is gone would not be noticed

POST /points takes JSON: {"x", "y", "time"} adds a point, in pixels of the frame of that time;
{"remove"} removes the point of that id.
"""

import collections
import http.server
import ipaddress
import json
import pathlib
import socket
import socketserver
import statistics
import struct
import sys
import threading
import urllib.parse
from collections.abc import Callable, Mapping
from typing import Any

from pipelines.lib import command, fragments
from pipelines.lib.caps import first_structure

HERE = pathlib.Path(__file__).resolve().parent
# The report's page has the same markers and colours.
REPORT = HERE.parents[1] / "core" / "programs" / "report" / "page"
FILES = {
    "/": (HERE / "web" / "index.html", "text/html"),
    "/live.js": (HERE / "web" / "live.js", "text/javascript"),
    "/overlay.js": (REPORT / "overlay.js", "text/javascript"),
    "/report.css": (REPORT / "report.css", "text/css")
}
HEADERS = {
    # Nothing is loaded from elsewhere. No other page may embed this one: a click there would be a
    # click here.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src data:; media-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store"
}

MAX_VIEWERS = 16       # at a time
MAX_CONNECTIONS = 64   # at a time
TIMEOUT = 5            # seconds for one record, or for a request, before a client is disconnected
SILENCE = 5            # seconds without a record, after which an empty one is sent
MAX_QUEUED = 1_000_000  # µs that may wait for a slow viewer, as for RTSP
SEND_BUFFER = 1 << 18  # bytes that the system may queue besides
LINES = 250            # that are kept: a click can be on these frames
NEIGHBOURS = 5         # points from whose motion a new point's is estimated
MAX_REQUEST = 200      # bytes of a POST
NO_MORE_POINTS = 0xffffffff  # what csdtrack's add-point returns then


def record(kind: bytes, time: int, content: bytes = b"") -> bytes:
    return struct.pack(">cIQ", kind, len(content), time) + content


class Viewer:
    """Queues at most MAX_QUEUED for one viewer. A slower one continues from the next keyframe."""

    def __init__(self) -> None:
        self._records: collections.deque[tuple[int, bytes]] = collections.deque()
        self._changed = threading.Condition()
        self._needs_keyframe = True
        self._ended = False

    def add(self, content: bytes, time: int, keyframe: bool | None = None,
            head: bytes = b"") -> None:
        """`keyframe`: whether a frame is one; None for a record that needs no other.

        `head`: is sent before a keyframe that this viewer waited for.
        """
        with self._changed:
            if self._records and time - self._records[0][0] > MAX_QUEUED:
                self._records.clear()
                self._needs_keyframe = True
            if keyframe is not None:
                if self._needs_keyframe and not keyframe:
                    return
                if self._needs_keyframe:
                    content = head + content
                self._needs_keyframe = False
            self._records.append((time, content))
            self._changed.notify()

    def restart(self) -> None:
        """The following frames are of another picture, so the next one must be a keyframe."""
        with self._changed:
            self._needs_keyframe = True

    def end(self) -> None:
        with self._changed:
            self._ended = True
            self._changed.notify()

    def take(self) -> bytes | None:
        """Waits for records. Returns b"" if none arrive, and None at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self._records or self._ended, SILENCE)
            content = b"".join(content for _, content in self._records)
            self._records.clear()
            return None if self._ended and not content else content

    @property
    def queued(self) -> int:
        """Bytes."""
        with self._changed:
            return sum(len(content) for _, content in self._records)


class Refused(Exception):
    """A request that gets an error."""

    def __init__(self, status: int, text: str) -> None:
        super().__init__(status, text)
        self.status, self.text = status, text


class Page:
    """Hands the pipeline's samples to the viewers, and their clicks to csdtrack."""

    def __init__(self, address: str, port: int, track: Any,
                 request_keyframe: Callable[[], None]) -> None:
        """`request_keyframe`: is called for each new viewer."""
        self.address, self._track, self._request_keyframe = address, track, request_keyframe
        self._lock = threading.Lock()
        self._viewers: set[Viewer] = set()
        self._lines: collections.OrderedDict[int, bytes] = collections.OrderedDict()  # by time
        self._caps = ""  # of the video
        self._head = b""
        # Time, keyframe and content of a frame. It waits for the next one, which ends it. Without
        # viewers there is no content.
        self._waiting: tuple[int, bool, bytes | None] | None = None
        self._number = 0
        try:
            self._server = Server((address, port), self)
        except OSError as error:  # also socket.gaierror
            raise command.Failure(
                f"can't serve the page at {address}, port {port}: it is taken, or the address is "
                "not this machine's; choose others with --address and --web=PORT") from error
        self.port = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    @property
    def url(self) -> str:
        host = f"[{self.address}]" if ":" in self.address else self.address
        return f"http://{host}:{self.port}/"

    # ---- From the pipeline: nothing here waits for a viewer ----

    def push_line(self, sample: Any, time: int) -> None:
        content, time = bytes_of(sample.get_buffer()).rstrip(b"\n"), time // 1000
        with self._lock:
            self._lines[time] = content
            while len(self._lines) > LINES:
                self._lines.popitem(last=False)
            line = record(b"T", time, content)
            for viewer in self._viewers:
                viewer.add(line, time)

    def push_video(self, sample: Any, time: int, keyframe: bool) -> None:
        time = time // 1000
        caps = sample.get_caps()
        with self._lock:
            if caps.to_string() != self._caps:
                self._on_caps(caps, time)
            before = self._waiting
            content = bytes_of(sample.get_buffer()) if self._viewers else None
            self._waiting = time, keyframe, content
            if not before or before[2] is None or time <= before[0]:
                return
            begin, key, frame = before[0], before[1], before[2]
            self._number += 1
            fragment = fragments.fragment(self._number & 0xffffffff, begin,
                                          min(time - begin, 0xffffffff), key, frame)
            video = record(b"V", begin, fragment)
            for viewer in self._viewers:
                viewer.add(video, begin, key, self._head)

    def _on_caps(self, caps: Any, time: int) -> None:
        picture = first_structure(caps)
        configuration = bytes_of(picture.get_value("codec_data"))
        about = {"type": fragments.media_type(configuration)}
        header = fragments.header(picture.get_value("width"), picture.get_value("height"),
                                  configuration)
        self._head = record(b"H", time, json.dumps(about).encode()) + record(b"I", time, header)
        self._caps, self._waiting = caps.to_string(), None
        for viewer in self._viewers:
            viewer.restart()

    def end(self) -> None:
        with self._lock:
            for viewer in self._viewers:
                viewer.end()
        self._server.shutdown()
        self._server.server_close()

    # ---- Viewers ----

    def join(self) -> Viewer:
        viewer = Viewer()
        with self._lock:
            if len(self._viewers) >= MAX_VIEWERS:
                raise Refused(
                    503, f"{MAX_VIEWERS} look at a time, and no more can: close another page")
            self._viewers.add(viewer)
        self._request_keyframe()
        return viewer

    def leave(self, viewer: Viewer) -> None:
        with self._lock:
            self._viewers.discard(viewer)

    # ---- Clicks ----

    def on_click(self, click: Mapping[str, Any]) -> dict[str, Any]:
        """Adds or removes a point, and returns the answer. Raises Refused."""
        with self._lock:
            newest = next(reversed(self._lines.values()), None)
            clicked = self._lines.get(click.get("time", -1))
        if set(click) == {"remove"}:
            if newest is None or click["remove"] not in features(newest):
                raise Refused(404, "that point is there no more")
            removed = int(click["remove"])
            self._track.emit("remove-point", removed)
            return {"removed": removed}
        if set(click) != {"x", "y", "time"}:
            raise Refused(400, "neither a point to add nor one to remove")
        if clicked is None or newest is None:
            raise Refused(409, "the picture that was clicked is too old: click again")
        line, x, y = json.loads(clicked), click["x"], click["y"]
        if not (-0.5 <= x < line["width"] - 0.5 and -0.5 <= y < line["height"] - 0.5):
            raise Refused(400, "outside the picture")
        x, y = moved(x, y, features(clicked), features(newest))
        added = self._track.emit("add-point", x, y)
        if added == NO_MORE_POINTS:
            raise Refused(409, "no more points can be added")
        return {"added": added, "x": x, "y": y}


def features(line: bytes) -> dict[int, Any]:
    """The line's features by their ids, without those that ended."""
    return {f["id"]: f for f in json.loads(line)["features"] if f["state"] != "ended"}


def moved(x: float, y: float, then: Mapping[int, Any],
          now: Mapping[int, Any]) -> tuple[float, float]:
    """Where the tissue at this position is now: it moved as the nearest points did."""
    claims = ("learning", "tracked")
    both = [(before, now[i]) for i, before in then.items()
            if i in now and before["state"] in claims and now[i]["state"] in claims]
    both.sort(key=lambda pair: (pair[0]["x"] - x)**2 + (pair[0]["y"] - y)**2)
    near = both[:NEIGHBOURS]
    if not near:
        return x, y
    return (x + statistics.median(b["x"] - a["x"] for a, b in near),
            y + statistics.median(b["y"] - a["y"] for a, b in near))


def bytes_of(buffer: Any) -> bytes:
    return buffer.extract_dup(0, buffer.get_size())


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address: tuple[str, int], page: Page) -> None:
        self.page = page
        self._free = threading.BoundedSemaphore(MAX_CONNECTIONS)
        family, *_, where = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0]
        self.address_family = family
        super().__init__(where[:2], Handler)  # type: ignore[arg-type]

    def server_bind(self) -> None:
        # HTTPServer's looks up the machine's name, which may take long.
        socketserver.TCPServer.server_bind(self)

    def process_request(self, request: Any, client_address: Any) -> None:
        if not self._free.acquire(blocking=False):
            self.shutdown_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        if not isinstance(sys.exc_info()[1], OSError):  # the client is gone, or too slow
            super().handle_error(request, client_address)


class Handler(http.server.BaseHTTPRequestHandler):
    server: Server
    timeout = TIMEOUT
    server_version, sys_version = "csdtrack", ""

    def log_message(self, *_: Any) -> None:
        pass

    def do_GET(self) -> None:
        self._answer(self._get)

    def do_POST(self) -> None:
        self._answer(self._post)

    def _answer(self, method: Callable[[], None]) -> None:
        try:
            self._check_host()
            method()
        except Refused as refused:
            self._send(refused.status, "text/plain", refused.text.encode())

    def _send(self, status: int, kind: str, content: bytes) -> None:
        self.send_response(status)
        self._send_headers(kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def _send_headers(self, kind: str) -> None:
        self.send_header("Content-Type",
                         f"{kind}; charset=utf-8" if kind.startswith("text/") else kind)
        for name, value in HEADERS.items():
            self.send_header(name, value)

    def _check_host(self) -> None:
        """Allows addresses, and names that nobody else can define (DNS rebinding).

        If an attacker's name pointed to this machine's address, the attacker's page could read this
        one.
        """
        try:
            name = urllib.parse.urlsplit(f"//{self.headers.get('Host', '')}").hostname or ""
        except ValueError:
            name = ""
        if name in ("localhost", self.server.page.address.lower()):
            return
        try:
            ipaddress.ip_address(name)
        except ValueError:
            raise Refused(403, "open this page by the machine's address, not by a name") from None

    def _get(self) -> None:
        path = self.path.partition("?")[0]
        if path == "/live":
            self._get_live()
        elif path in FILES:
            file, kind = FILES[path]
            self._send(200, kind, file.read_bytes())
        else:
            raise Refused(404, "there is no such page")

    def _get_live(self) -> None:
        page = self.server.page
        viewer = page.join()
        try:
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SEND_BUFFER)
            self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.send_response(200)
            self._send_headers("application/octet-stream")
            self.end_headers()
            while (content := viewer.take()) is not None:
                self.connection.sendall(content or record(b"K", 0))
        except TimeoutError:
            # The system needn't keep the rest, which is of no use any more.
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        finally:
            page.leave(viewer)

    def _post(self) -> None:
        if self.path != "/points":
            raise Refused(404, "there is no such page")
        # A browser sends the Origin of the page. Before another page's JSON it asks for permission,
        # which it never gets here.
        origin = self.headers.get("Origin")
        foreign = origin is not None and origin.partition("://")[2] != self.headers["Host"]
        if foreign or self.headers.get_content_type() != "application/json":
            raise Refused(403, "points are added from this page only")
        client = ipaddress.ip_address(self.client_address[0].partition("%")[0])
        if not (getattr(client, "ipv4_mapped", None) or client).is_loopback:
            raise Refused(403,
                          "points are added on the machine itself only, or through a tunnel to it")
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or len(length) > 9 or int(length) > MAX_REQUEST:
            raise Refused(400, "too long")
        try:
            click = json.loads(self.rfile.read(int(length)))
        except ValueError as error:
            raise Refused(400, "no JSON") from error
        if not isinstance(click, dict) or not all(
                type(value) in (int, float) for value in click.values()):
            raise Refused(400, "neither a point to add nor one to remove")
        self._send(200, "application/json", json.dumps(self.server.page.on_click(click)).encode())
