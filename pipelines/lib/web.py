# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of pipelines/stream --web: the picture and its tracks over HTTP, and clicks that add and remove points.

GET /live is one answer without an end, made of records: what it is (a byte), how long its content is (4 bytes), its frame's time (8 bytes, µs of
running time), big-endian, and the content: `H`, JSON of what follows; `I`, the head of the video; `V`, a frame (fragments.py); `T`, its line of
csdtrackenc; `K`, nothing, so that who is gone is noticed. A frame and its line have the same time.

POST /points, JSON: {"x", "y", "time"} adds a point, pixels of the frame of that time; {"remove"} removes the one of that id.
"""

import collections
import http.server
import ipaddress
import json
import pathlib
import socket
import statistics
import struct
import sys
import threading
import urllib.parse

from pipelines.lib import command, fragments
from pipelines.lib.caps import first_structure

HERE = pathlib.Path(__file__).resolve().parent
# whose markers and colours these are
REPORT = HERE.parents[1] / "core" / "programs" / "report" / "page"
FILES = {
    "/": (HERE / "web" / "index.html", "text/html"),
    "/live.js": (HERE / "web" / "live.js", "text/javascript"),
    "/overlay.js": (REPORT / "overlay.js", "text/javascript"),
    "/report.css": (REPORT / "report.css", "text/css")
}
HEADERS = {
    # Nothing from elsewhere, and nobody else's page may show this one: a click there would be one
    # here.
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; media-src blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store"
}

MOST = 16           # who look at a time
CONNECTIONS = 64    # at a time
PATIENCE = 5        # seconds for one record, or for a request: who takes longer is left
SILENCE = 5         # seconds without a record, then one is sent
HELD = 1_000_000    # µs that are held for one who is slow, as for RTSP
UNSENT = 1 << 18    # bytes that the system may hold for one besides
LINES = 250         # of the newest frames: of those a click can be
NEIGHBOURS = 5      # points by whose motion that of a new one is guessed
REQUEST = 200       # bytes of a POST


def record(kind, time, content=b""):
    return struct.pack(">cIQ", kind, len(content), time) + content


class Client:
    """What is on its way to one who looks: never more than HELD of it. Who is slower than that goes on from the next keyframe."""

    def __init__(self):
        self._records = collections.deque()
        self._there = threading.Condition()
        self._waits = True  # for a keyframe
        self._over = False

    def add(self, content, time, keyframe=None, head=b""):
        """`keyframe`: of a frame of video, whether it is one; None for what belongs to no other. `head`: goes before a keyframe that was waited for."""
        with self._there:
            if self._records and time - self._records[0][0] > HELD:
                self._records.clear()
                self._waits = True
            if keyframe is not None:
                if self._waits and not keyframe:
                    return
                if self._waits:
                    content = head + content
                self._waits = False
            self._records.append((time, content))
            self._there.notify()

    def restart(self):
        """What follows is another picture."""
        with self._there:
            self._waits = True

    def end(self):
        with self._there:
            self._over = True
            self._there.notify()

    def take(self):
        """What is there: bytes, b"" if nothing comes, None at the end."""
        with self._there:
            self._there.wait_for(lambda: self._records or self._over, SILENCE)
            content = b"".join(content for _, content in self._records)
            self._records.clear()
            return None if self._over and not content else content

    @property
    def held(self):
        with self._there:
            return sum(len(content) for _, content in self._records)


class Refused(Exception):
    """Its arguments: the status and what to tell."""


class Page:
    """`track`: the csdtrack that clicks go to. `ask_keyframe`: called for one who comes."""

    def __init__(self, address, port, track, ask_keyframe):
        self.address, self._track, self._ask_keyframe = address, track, ask_keyframe
        self._lock = threading.Lock()
        self._clients = set()
        self._lines = collections.OrderedDict()  # by time
        # the frame that waits for the next: that is how long it lasts
        self._caps = self._head = self._waiting = None
        self._number = 0
        try:
            self._server = Server((address, port), self)
        except OSError as error:  # socket.gaierror is one
            raise command.Failure(
                f"can't serve the page at {address}, port {port}: it is taken, or the address is not this machine's; "
                "choose others with --address and --web=PORT") from error
        self.port = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    @property
    def url(self):
        return f"http://{f'[{self.address}]' if ':' in self.address else self.address}:{self.port}/"

    # ---- what comes from the pipeline: nothing here waits for anybody who looks ----

    def push_line(self, sample, time):
        content, time = bytes_of(sample.get_buffer()).rstrip(b"\n"), time // 1000
        with self._lock:
            self._lines[time] = content
            while len(self._lines) > LINES:
                self._lines.popitem(last=False)
            for client in self._clients:
                client.add(record(b"T", time, content), time)

    def push_video(self, sample, time, keyframe):
        time = time // 1000
        caps = sample.get_caps()
        with self._lock:
            if caps.to_string() != self._caps:
                self._describe(caps, time)
            before, self._waiting = self._waiting, (time, keyframe, bytes_of(sample.get_buffer())
                                                    if self._clients else None)
            if not before or before[2] is None or time <= before[0]:
                return
            begin, key, frame = before
            self._number += 1
            content = record(
                b"V", begin,
                fragments.fragment(self._number & 0xffffffff, begin, min(time - begin, 0xffffffff),
                                   key, frame))
            for client in self._clients:
                client.add(content, begin, key, self._head)

    def _describe(self, caps, time):
        picture = first_structure(caps)
        configuration = bytes_of(picture.get_value("codec_data"))
        about = {"type": fragments.media_type(configuration)}
        self._head = record(b"H", time, json.dumps(about).encode()) + \
            record(b"I", time, fragments.head(picture.get_value("width"), picture.get_value("height"), configuration))
        self._caps, self._waiting = caps.to_string(), None
        for client in self._clients:
            client.restart()

    def end(self):
        with self._lock:
            for client in self._clients:
                client.end()
        self._server.shutdown()
        self._server.server_close()

    # ---- who looks ----

    def join(self):
        client = Client()
        with self._lock:
            if len(self._clients) >= MOST:
                raise Refused(503, f"{MOST} look at a time, and no more can: close another page")
            self._clients.add(client)
        self._ask_keyframe()
        return client

    def leave(self, client):
        with self._lock:
            self._clients.discard(client)

    # ---- clicks ----

    def _features(self, content):
        return {f["id"]: f for f in json.loads(content)["features"] if f["state"] != "ended"}

    def answer(self, click):
        """Does what a click asks for; what to answer. Raises Refused."""
        with self._lock:
            newest = next(reversed(self._lines.values()), None)
            clicked = self._lines.get(click.get("time"))
        if set(click) == {"remove"}:
            if newest is None or click["remove"] not in self._features(newest):
                raise Refused(404, "that point is there no more")
            removed = int(click["remove"])
            self._track.emit("remove-point", removed)
            return {"removed": removed}
        if set(click) != {"x", "y", "time"}:
            raise Refused(400, "neither a point to add nor one to remove")
        if clicked is None:
            raise Refused(409, "the picture that was clicked is too old: click again")
        line, (x, y) = json.loads(clicked), (click["x"], click["y"])
        if not (-0.5 <= x < line["width"] - 0.5 and -0.5 <= y < line["height"] - 0.5):
            raise Refused(400, "outside the picture")
        # The tissue has moved on since that frame: as its nearest points have.
        then, now = self._features(clicked), self._features(newest)
        both = [(then[i], now[i])
                for i in then
                if i in now and then[i]["state"] in ("learning",
                                                     "tracked") and now[i]["state"] in ("learning",
                                                                                        "tracked")]
        near = sorted(both, key=lambda pair: (pair[0]["x"] - x)**2 +
                      (pair[0]["y"] - y)**2)[:NEIGHBOURS]
        if near:
            x, y = (start + statistics.median(b[axis] - a[axis]
                                              for a, b in near)
                    for axis, start in (("x", x), ("y", y)))
        added = self._track.emit("add-point", x, y)
        if added == 0xffffffff:
            raise Refused(409, "no more points can be added")
        return {"added": added, "x": x, "y": y}


def bytes_of(buffer):
    return buffer.extract_dup(0, buffer.get_size())


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address, page):
        self.page = page
        self._free = threading.BoundedSemaphore(CONNECTIONS)
        family, *_, where = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0]
        self.address_family = family
        super().__init__(where[:2], Handler)

    def server_bind(self):
        # HTTPServer's asks for the machine's name, which may take long
        http.server.socketserver.TCPServer.server_bind(self)

    def process_request(self, request, client_address):
        if not self._free.acquire(blocking=False):
            self.shutdown_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request, client_address):
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, _request, _client_address):
        if not isinstance(sys.exc_info()[1], OSError):  # who is gone, or too slow
            super().handle_error(_request, _client_address)


class Handler(http.server.BaseHTTPRequestHandler):
    timeout = PATIENCE
    server_version, sys_version = "csdtrack", ""

    def log_message(self, *_):
        pass

    def do_GET(self):
        self._answer(self._get)

    def do_POST(self):
        self._answer(self._post)

    def _answer(self, do):
        try:
            self._check_host()
            do()
        except Refused as refused:
            self._send(refused.args[0], "text/plain", refused.args[1].encode())

    def _send(self, status, kind, content):
        self.send_response(status)
        self._headers(kind)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def _headers(self, kind):
        self.send_header("Content-Type",
                         f"{kind}; charset=utf-8" if kind.startswith("text/") else kind)
        for name, value in HEADERS.items():
            self.send_header(name, value)

    def _check_host(self):
        """A name that another's server gives to this machine's address would let that one's page read this one: only addresses, and names
        that nobody else gives."""
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

    def _get(self):
        path = self.path.partition("?")[0]
        if path == "/live":
            self._live()
        elif path in FILES:
            file, kind = FILES[path]
            self._send(200, kind, file.read_bytes())
        else:
            raise Refused(404, "there is no such page")

    def _live(self):
        page = self.server.page
        client = page.join()
        try:
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNSENT)
            self.connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.send_response(200)
            self._headers("application/octet-stream")
            self.end_headers()
            while (content := client.take()) is not None:
                self.connection.sendall(content or record(b"K", 0))
        except TimeoutError:
            # What it didn't take is of no use any more, and the system need not keep it.
            self.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        finally:
            page.leave(client)

    def _post(self):
        if self.path != "/points":
            raise Refused(404, "there is no such page")
        # A browser names the page that asks, and asks before another's page sends JSON, which
        # nothing here permits.
        origin = self.headers.get("Origin")
        if origin is not None and origin.partition("://")[2] != self.headers[
                "Host"] or self.headers.get_content_type() != "application/json":
            raise Refused(403, "points are added from this page only")
        client = ipaddress.ip_address(self.client_address[0].partition("%")[0])
        if not (getattr(client, "ipv4_mapped", None) or client).is_loopback:
            raise Refused(403,
                          "points are added on the machine itself only, or through a tunnel to it")
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or len(length) > 9 or int(length) > REQUEST:
            raise Refused(400, "too long")
        try:
            click = json.loads(self.rfile.read(int(length)))
        except ValueError as error:
            raise Refused(400, "no JSON") from error
        if not isinstance(click, dict) or not all(
                type(value) in (int, float) for value in click.values()):
            raise Refused(400, "neither a point to add nor one to remove")
        self._send(200, "application/json", json.dumps(self.server.page.answer(click)).encode())
