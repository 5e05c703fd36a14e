#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of pipelines/stream --web, in headless Chromium and over plain HTTP.

web_test.py REPOSITORY BUILD"""

import contextlib
import http.client
import json
import math
import os
import pathlib
import select
import signal
import socket
import struct
import subprocess
import sys
import time
import unittest
import urllib.parse

import browser
import harness
from pipelines.lib import web

try:
    from selenium.webdriver.common.action_chains import ActionChains
except ImportError:
    pass  # browser.begin() skips

SOURCE, BUILD = map(pathlib.Path, sys.argv[1:3])
ENVIRONMENT = {**os.environ, "CSDTRACK_BUILD": str(BUILD)}
WIDTH, HEIGHT = 320, 240
PERIOD, ROUNDS = 250, 16  # the motion's period in frames, and how often it is repeated
LEVELS = 10  # of brightness: they code a frame's number modulo this
TRACKED = (86, 180, 233)  # the colour of docs/elements.md


def motion(t):
    return (round(14 * math.sin(2 * math.pi * t * 8 / PERIOD)),
            round(5 * math.cos(2 * math.pi * t * 5 / PERIOD)))


def picture(scene, number):
    made = scene.picture(number).copy()
    made[:40, :40] = 20 + number % LEVELS * 20
    return made


def command(*arguments):
    return [SOURCE / "pipelines" / "stream", "--no-install", *map(str, arguments)]


class Records(unittest.TestCase):
    def test_what_waits_for_a_slow_client_is_bounded(self):
        client, frame = web.Viewer(), bytes(100_000)
        most = 0
        for number in range(1000):
            client.add(b"T" * 1000, number * 40_000)
            client.add(frame, number * 40_000, number % 25 == 0, b"head")
            most = max(most, client.queued)
        self.assertLess(most, 30 * (len(frame) + 1000))
        # Whatever it has missed, it continues with the head and a key frame.
        client.add(b"", 10**9, False)
        self.assertEqual(client.take(), b"")
        client.add(b"delta", 10**9 + 1, False)
        client.add(b"key", 10**9 + 2, True, b"head ")
        client.add(b" delta", 10**9 + 3, False)
        self.assertEqual(client.take(), b"head key delta")
        client.end()
        self.assertIsNone(client.take())


class Served(harness.Case):
    """A stream with a page, of a video that moves as a whole. The brightness of a corner gives the
    frame's number."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        scene = harness.Scene(motion=motion)
        once = harness.encode(cls.tmp / "once.mkv", (picture(scene, n) for n in range(PERIOD)),
                              *harness.H264, "-bf", "0")
        video = cls.video = cls.tmp / "numbers.mkv"
        subprocess.run(["ffmpeg", "-v", "error", "-stream_loop", str(ROUNDS - 1), "-i", once, "-c",
                        "copy", video], check=True)
        cls.sent = cls.tmp / "sent.jsonl"
        process = subprocess.Popen(
            list(map(str, command("--port", 0, "--web=0", "--bitrate", 20000, "--tracks", cls.sent,
                                  "--set", "max-features=20", video))), env=ENVIRONMENT,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True)
        cls.process = process
        cls.addClassCleanup(process.stdout.close)
        cls.addClassCleanup(process.wait)
        cls.addClassCleanup(process.kill)
        process.stdout.readline()
        cls.url = process.stdout.readline().strip()
        cls.host = urllib.parse.urlsplit(cls.url).netloc
        for _ in range(600):  # ended before the first line, it would report that no picture came
            if cls.sent.exists() and cls.sent.stat().st_size:
                break
            time.sleep(0.1)

    @classmethod
    def tearDownClass(cls):
        os.killpg(cls.process.pid, signal.SIGINT)
        said = cls.process.stdout.read()
        assert cls.process.wait(60) == 0 and said.count("\n") == 1, said  # no traceback
        super().tearDownClass()

    def lines(self):
        return harness.read_lines(self.sent, torn=True) if self.sent.exists() else []

    def await_line(self, of):
        """Waits for the first line for which of(line) is true. Returns both."""
        for _ in range(600):
            for line in self.lines():
                if found := of(line):
                    return line, found
            time.sleep(0.1)
        self.fail("there is no such line")

    def await_point(self, number, *states):
        return self.await_line(lambda line: next(
            (f for f in line["features"] if f["id"] == number and f["state"] in states), None))

    def ask(self, method, path, content=None, host=None, **headers):
        """Sends a request. Returns the status and the answer."""
        with contextlib.closing(http.client.HTTPConnection(host or self.host,
                                                           timeout=60)) as connection:
            if content is not None:
                headers = {"Content-Type": "application/json",
                           "Origin": f"http://{host or self.host}", **headers}
            connection.request(method, path, content, headers)
            answer = connection.getresponse()
            # At most this much, which is more than any file: /live has no end.
            return answer.status, answer.read(100_000).decode()

    def post(self, order, **more):
        return self.ask("POST", "/points", order if isinstance(order, str) else json.dumps(order),
                        **more)


class Plain(Served):
    def test_the_page_is_served_on_loopback_and_is_complete(self):
        self.assertRegex(self.url, r"^http://127\.0\.0\.1:\d+/$")
        status, page = self.ask("GET", "/")
        self.assertEqual(status, 200)
        self.assertNotRegex(page, "https?://|src=\"//")
        for name in ("live.js", "overlay.js", "report.css"):
            self.assertEqual(self.ask("GET", f"/{name}")[0], 200)
        self.assertEqual(self.ask("GET", "/../stream.py")[0], 404)

    def test_requests_of_other_pages_and_hosts_are_refused(self):
        point = {"x": 100, "y": 100, "time": 0}
        # As after DNS rebinding.
        self.assertEqual(self.ask("GET", "/", Host="evil.example")[0], 403)
        self.assertEqual(self.post(point, Host="evil.example")[0], 403)
        self.assertEqual(self.post(point, Origin="http://evil.example")[0], 403)
        self.assertEqual(self.post(point, Origin="null")[0], 403)
        self.assertEqual(self.ask("POST", "/points", json.dumps(point),
                                  **{"Content-Type": "text/plain"})[0], 403)
        self.assertEqual(self.ask("GET", "/", Host=f"localhost:{self.host.rpartition(':')[2]}")[0],
                         200)

    def test_wrong_orders_are_refused(self):
        self.await_line(lambda line: line["frame"] > 0)
        now = self.lines()[-1]["running_time"] // 1000
        for order, status in (
                (" ", 400), ("[1]", 400), ('{"x": 1, "y": "1", "time": 1}', 400),
                ({"x": 1, "y": 1}, 400), ({"x": 1, "y": 1, "time": 1}, 409),
                ({"x": -1, "y": 1, "time": now}, 400), ({"x": 1, "y": HEIGHT, "time": now}, 400),
                (f'{{"x": NaN, "y": 1, "time": {now}}}', 400),
                ({"remove": 4_000_000_000}, 404), ("[" * 200, 400), ("x" * 2000, 400)):
            with self.subTest(order):
                self.assertEqual(self.post(order)[0], status)
        self.assertEqual(self.post({}, **{"Content-Length": "9" * 5000})[0], 400)

    def test_a_new_point_begins_where_the_tissue_has_moved_to(self):
        """The picture that was clicked is older than the newest frame."""
        for _ in range(600):
            *before, newest = self.lines()[-40:] or [None]
            old = next((line for line in before
                        if motion(newest["frame"])[0] - motion(line["frame"])[0] > 20), None)
            if old:
                break
            time.sleep(0.1)
        status, answer = self.post({"x": 150, "y": 120, "time": old["running_time"] // 1000})
        self.assertEqual(status, 200, answer)
        line, point = self.await_point(json.loads(answer)["added"], "learning", "tracked")
        dx, dy = (a - b for a, b in zip(motion(line["frame"]), motion(old["frame"])))
        self.assertLess(math.dist((point["x"], point["y"]), (150 + dx, 120 + dy)), 8,
                        (old["frame"], line["frame"]))
        self.assertEqual(self.post({"remove": point["id"]}),
                         (200, json.dumps({"removed": point["id"]})))
        self.await_point(point["id"], "ended")

    def test_other_machines_may_not_add_points(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.connect(("192.0.2.1", 9))  # nothing is sent
            except OSError:
                self.skipTest("this machine has no address but its own")
            address = probe.getsockname()[0]
        process = subprocess.Popen(
            list(map(str, command("--port", 0, "--web=0", "--address", address, "simulate"))),
            env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        process.stdout.readline()
        host = urllib.parse.urlsplit(process.stdout.readline()).netloc.strip()
        self.assertEqual(self.ask("GET", "/", host=host)[0], 200)
        self.assertEqual(self.post({"remove": 0}, host=host),
                         (403,
                          "points are added on the machine itself only, or through a tunnel to it"))

    def stalled(self):
        """A client of /live that reads only the status. It waits for a place, as clients of an
        earlier test may still have all."""
        host, _, port = self.host.rpartition(":")
        until = time.monotonic() + harness.TIMEOUT
        while time.monotonic() < until:
            client = socket.socket()
            self.addCleanup(client.close)
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            client.connect((host, int(port)))
            client.sendall(f"GET /live HTTP/1.0\r\nHost: {self.host}\r\n\r\n".encode())
            status = client.recv(12, socket.MSG_WAITALL)
            if status.endswith(b"200"):
                return client
            client.close()
            time.sleep(0.2)
        raise AssertionError(f"no client is accepted: {status}")

    def test_a_client_that_reads_nothing_delays_nobody_and_is_dropped(self):
        stalled = self.stalled()
        gone = select.poll()
        gone.register(stalled, select.POLLERR)
        with contextlib.closing(http.client.HTTPConnection(self.host, timeout=60)) as connection:
            connection.request("GET", "/live")
            answer = connection.getresponse()
            times, lines, left = [], [], False
            while not (left and len(times) > 100):
                kind, size, when = struct.unpack(">cIQ", answer.read(13))
                content = answer.read(size)
                if kind == b"V":
                    times.append(when)
                elif kind == b"T":
                    lines.append(content)
                left = left or bool(gone.poll(0))
                self.assertLess(len(times), 1500, "it is never dropped")
        self.assertEqual([b - a for a, b in zip(times, times[1:])], [40_000] * (len(times) - 1),
                         "frames are missing")
        self.await_line(lambda line: line["frame"] > json.loads(lines[-1])["frame"])
        self.assertIn(b"\n".join(lines), self.sent.read_bytes())

    def test_the_number_of_clients_is_limited(self):
        clients = [self.stalled() for _ in range(web.MAX_VIEWERS)]
        for client in clients:
            self.assertTrue(client.recv(1))
        status, text = self.ask("GET", "/live")
        self.assertEqual((status, text),
                         (503, f"{web.MAX_VIEWERS} look at a time, and no more can: close another "
                          "page"))

    def test_wrong_options_are_refused(self):
        for arguments, code, words in ((["--web=70000"], 2, "--web: 70000 is not from 0 to 65535"),
                                       (["--web=x"], 2, "--web"),
                                       ([f"--web={self.host.rpartition(':')[2]}"], 1,
                                        "can't serve the page at 127.0.0.1, port")):
            with self.subTest(arguments):
                done = subprocess.run(command("--port", 0, *arguments, "simulate"),
                                      capture_output=True, text=True, stdin=subprocess.DEVNULL,
                                      timeout=60, env=ENVIRONMENT)
                self.check_refused(done, code, words)


class Page(Served):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = browser.begin(cls)

    def setUp(self):
        if self.browser.current_url != self.url:
            self.browser.get(self.url)

    def tearDown(self):
        self.assertEqual([m for m in self.browser.get_log("browser") if m["level"] == "SEVERE"], [])

    def js(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def until(self, text):
        for _ in range(600):
            if found := self.js(f"return {text}"):
                return found
            time.sleep(0.1)
        state = self.js("return [csdLive.state(), document.getElementById('trouble').textContent]")
        self.fail(f"never: {text}; {state}")

    def test_the_tracks_of_the_shown_frame_are_drawn(self):
        self.until("csdLive.state().drawn.length > 5")
        self.js("""
            document.getElementById('ids').click();
            const video = document.getElementById('video');
            const overlay = document.getElementById('overlay');
            const small = document.createElement('canvas');
            [small.width, small.height] = [20, 20];
            const look = small.getContext('2d', {willReadFrequently: true});
            window.seen = [];
            const note = () => {
              const {frame, drawn} = csdLive.state();
              look.drawImage(video, 10, 10, 20, 20, 0, 0, 20, 20);
              const level = look.getImageData(10, 10, 1, 1).data[0];
              const dots = drawn.filter((f) => f.state === 'tracked').map((f) => {
                const x = Math.round((f.x + 0.5) / 320 * overlay.width - 0.5);
                const y = Math.round((f.y + 0.5) / 240 * overlay.height - 0.5);
                return [...overlay.getContext('2d').getImageData(x, y, 1, 1).data];
              });
              seen.push([video.currentTime, frame, level, drawn, dots]);
              video.requestVideoFrameCallback(note);
            };
            video.requestVideoFrameCallback(note);""")
        self.until("seen.length > 30")
        seen = self.js("document.getElementById('ids').click(); return seen")
        self.assertGreater(seen[-1][0], seen[0][0])
        frames = [frame for _, frame, *_ in seen]
        self.assertEqual(frames, sorted(frames))
        lines = self.lines()
        levels = [(frame % LEVELS, round((level - 20) / 20)) for _, frame, level, *_ in seen]
        dots = []
        for _, frame, _, drawn, places in seen:
            self.assertEqual(drawn, [f for f in lines[frame]["features"] if f["state"] != "ended"])
            dots += [max(abs(a - b) for a, b in zip(place, TRACKED)) < 60 for place in places]
        self.assertEqual([a for a, _ in levels], [b for _, b in levels])
        self.assertGreater(sum(dots), 0.8 * len(dots), "the markers are not where the points are")

    def test_a_click_adds_a_point_and_another_removes_it(self):
        self.until("csdLive.state().drawn.length > 5")
        place = self.js("""window.clicked = null;
            const overlay = document.getElementById('overlay');
            const box = overlay.getBoundingClientRect();
            overlay.addEventListener('click', () => (window.clicked = csdLive.state().frame),
                                     {once: true, capture: true});
            return [box.left + 200.5 / 320 * box.width, box.top + 150.5 / 240 * box.height]""")
        actions = ActionChains(self.browser, duration=0)
        actions.w3c_actions.pointer_action.move_to_location(*map(round, place)).click()
        actions.perform()
        told = self.until("csdLive.state().told")
        self.assertIn("added", told)
        self.assertEqual(self.js("return document.getElementById('told').textContent"),
                         f"Point {told['added']} is added.")
        frame = self.js("return clicked")
        line, point = self.await_point(told["added"], "learning", "tracked")
        dx, dy = (a - b for a, b in zip(motion(line["frame"]), motion(frame)))
        self.assertLess(math.dist((point["x"], point["y"]), (200 + dx, 150 + dy)), 8,
                        (frame, line["frame"]))
        # By an event in the page: until WebDriver had clicked, the point would be elsewhere.
        self.until(f"csdLive.state().drawn.find(({{id}}) => id === {told['added']})")
        self.js("""const overlay = document.getElementById('overlay');
            const box = overlay.getBoundingClientRect();
            const {x, y} = csdLive.state().drawn.find(({id}) => id === arguments[0]);
            overlay.dispatchEvent(new MouseEvent('contextmenu', {
              cancelable: true, clientX: box.left + (x + 0.5) / 320 * box.width,
              clientY: box.top + (y + 0.5) / 240 * box.height}))""", told["added"])
        self.until(f"csdLive.state().told.removed === {told['added']}")
        self.await_point(told["added"], "ended")

    def test_what_the_page_keeps_is_bounded(self):
        begun = self.until("csdLive.state().kept > 1 && "
                           "document.getElementById('video').buffered.start(0)")
        self.until(f"document.getElementById('video').buffered.start(0) > {begun}")
        self.assertLess(self.js("return csdLive.state().kept"), 7)

    def served(self, *arguments):
        process = subprocess.Popen(list(map(str, command("--port", 0, *arguments))),
                                   env=ENVIRONMENT, stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        process.stdout.readline()
        return process, process.stdout.readline().strip()

    def test_the_page_shows_a_new_size(self):
        with open(self.tmp / "sizes.h264", "wb") as file:
            for size in (320, 240), (160, 120):
                part = harness.scene_video(self.tmp / "part.h264", 150, *harness.H264, "-bf", "0",
                                           width=size[0], height=size[1])
                file.write(part.read_bytes())
        self.browser.get(self.served("--web=0", self.tmp / "sizes.h264")[1])
        for width in 320, 160:
            self.until(f"document.getElementById('video').videoWidth === {width} && "
                       f"document.getElementById('facts').textContent.startsWith('{width}×')")
        self.until("csdLive.state().drawn.some(({state}) => state === 'tracked')")

    def test_the_page_reconnects_to_a_restarted_stream(self):
        with socket.create_server(("127.0.0.1", 0)) as probe:
            port = probe.getsockname()[1]
        for begin in range(2):
            process, _ = self.served(f"--web={port}", *["--klv"] * begin, self.video)
            if not begin:
                self.browser.get(f"http://127.0.0.1:{port}")
            self.until(f"csdLive.state().connection > {begin} && csdLive.state().drawn.length > 5 "
                       "&& document.getElementById('trouble').hidden")
            process.send_signal(signal.SIGINT)
            self.until("document.getElementById('trouble').textContent.endsWith('; trying again')")
            process.wait(60)
        self.browser.get_log("browser")  # drops the errors that nobody answered


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
