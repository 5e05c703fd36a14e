#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of csd-report, opened from disk in headless Chromium. Its screenshots are compared with
the tracks.

report_test.py REPOSITORY BUILD"""

import io
import json
import math
import pathlib
import struct
import subprocess
import sys
import time

import cv2
import numpy as np

import browser
import harness
from reports import (BAR, BITS, BUILD, ENVIRONMENT, FPS, PROGRAM, WIDTH, ReportCase, features,
                     picture, position, report, state_of, write_tracks)

# As in docs/elements.md, from the palette of Okabe and Ito.
COLOURS = {"learning": (240, 228, 66), "tracked": (86, 180, 233), "occluded": (230, 159, 0)}

try:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
except ImportError:
    pass  # browser.begin() skips


def turned(mp4, matrix):
    """An mp4 of ffmpeg's with this matrix: a, b, c, d, x, y show a point at ax + cy + x,
    bx + dy + y."""
    a, b, c, d, x, y = (n << 16 for n in matrix)
    plain = struct.pack(">9i", 1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30)
    # The track's header has it, behind the movie's.
    head, tail = mp4[:mp4.index(b"tkhd")], mp4[mp4.index(b"tkhd"):]
    assert plain in tail
    return head + tail.replace(plain, struct.pack(">9i", a, b, 0, c, d, 0, x, y, 1 << 30), 1)


class Page(ReportCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser = browser.begin(cls)
        done = report(cls.video, cls.tracks, cls.tmp / "page")
        assert done.returncode == 0, done.stderr

    def tearDown(self):
        self.assertEqual([m for m in self.browser.get_log("browser") if m["level"] == "SEVERE"], [])

    def js(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def state(self):
        return self.js("return csdReport.state()")

    def until(self, text, *arguments):
        """Waits until a condition of the page holds."""
        for _ in range(400):
            if self.js(f"return {text}", *arguments):
                return
            time.sleep(0.05)
        self.fail(f"never: {text}; "
                  f"{self.js('return JSON.stringify({...csdReport.state(), curve: 0})')}")

    def open(self, name="page"):
        self.browser.get((self.tmp / name / "index.html").as_uri())
        self.until("document.getElementById('video').readyState >= 2 && csdReport.state().frame "
                   "!== null")

    def go(self, frame, fps=FPS):
        self.js("csdReport.seek(arguments[0])", frame / fps)
        self.until(f"csdReport.state().frame === {frame} && "
                   "!document.getElementById('video').seeking")

    def stage(self):
        """The part of a screenshot with the video and its points: H×W×3, RGB."""
        shot = cv2.imdecode(np.frombuffer(self.browser.get_screenshot_as_png(), np.uint8),
                            cv2.IMREAD_COLOR)[:, :, ::-1]
        box = self.js("const b = document.getElementById('stage').getBoundingClientRect(); return "
                      "[b.left, b.top, b.right, b.bottom]")
        left, top, right, bottom = map(round, box)
        self.assertTrue(0 <= left < right <= 1280 and 0 <= top < bottom <= 720, box)
        return shot[top:bottom, left:right].astype(int)

    def assert_shows(self, frame):
        """Checks that the screen shows this frame, by its bars, and the markers of its tracks, each
        in its place."""
        seen = self.stage()
        scale = seen.shape[1] / WIDTH
        bars = [seen[round(10 * scale), round((bit + 0.5) * BAR * scale)].mean() > 145
                for bit in range(BITS)]
        self.assertEqual(sum(on << bit for bit, on in enumerate(bars)), frame,
                         "another frame is on the screen")
        for feature in features(frame):
            # The share of each pixel that has the colour, as edges are blended.
            share = np.clip(1 - np.abs(seen - COLOURS[feature["state"]]).max(axis=2) / 100, 0, 1)
            rows, columns = np.indices(share.shape)
            expected = ((feature["x"] + 0.5) * scale - 0.5, (feature["y"] + 0.5) * scale - 0.5)
            share[np.hypot(columns - expected[0], rows - expected[1]) > 14] = 0
            self.assertGreater(share.sum(), 10, f"no marker of {feature}")
            found = (np.average(columns, weights=share), np.average(rows, weights=share))
            self.assertLess(math.dist(found, expected), 0.75, feature)
        for state, colour in COLOURS.items():
            if state not in [f["state"] for f in features(frame)]:
                self.assertEqual((np.abs(seen - colour).max(axis=2) < 20).sum(), 0,
                                 f"a marker is shown as {state}, but no feature is")

    def test_the_tracks_of_the_shown_frame_are_drawn(self):
        self.open()
        self.browser.find_element(By.ID, "ids").click()
        for frame in (0, 1, 230, 249, 250, 349, 499, 500, 749):  # chunks are of 250
            self.go(frame)
            self.assert_shows(frame)
        # Frame by frame with keys, across the border of two chunks.
        self.go(500)
        for frame in (499, 498):
            self.browser.find_element(By.TAG_NAME, "body").send_keys(Keys.ARROW_LEFT)
            self.until(f"csdReport.state().frame === {frame} && "
                       "!document.getElementById('video').seeking")
            self.assert_shows(frame)
        drawn = {f["id"]: f for f in self.state()["drawn"]}
        self.assertEqual(sorted(drawn), [0, 1])
        for feature in features(498):
            self.assertLess(math.dist((drawn[feature["id"]]["x"], drawn[feature["id"]]["y"]),
                                      (feature["x"], feature["y"])), 1 / 64)
            self.assertAlmostEqual(drawn[feature["id"]]["confidence"], feature["confidence"],
                                   delta=1 / 255)
            self.assertEqual(drawn[feature["id"]]["state"], feature["state"])

    def test_playing_draws_each_frames_tracks(self):
        self.open()
        self.js("""window.seen = [];
                   const video = document.getElementById('video');
                   const note = (_, {mediaTime}) => {
                     const {frame, drawn} = csdReport.state();
                     seen.push([mediaTime, frame, drawn]);
                     video.requestVideoFrameCallback(note);
                   };
                   video.requestVideoFrameCallback(note);""")
        self.browser.find_element(By.ID, "play").click()
        self.until("seen.length > 30 && seen.at(-1)[1] > 40")
        self.browser.find_element(By.ID, "play").click()
        self.assertTrue(self.js("return document.getElementById('video').paused"))
        seen = self.js("return seen")
        self.assertGreater(len({frame for _, frame, _ in seen}), 10)
        for media_time, frame, drawn in seen:
            self.assertEqual(frame, round(media_time * FPS))
            self.assertEqual([f["id"] for f in drawn], [f["id"] for f in features(frame)])
            for got, feature in zip(drawn, features(frame)):
                self.assertLess(math.dist((got["x"], got["y"]), (feature["x"], feature["y"])),
                                1 / 64)

    def test_a_click_selects_a_feature_and_shows_its_motion(self):
        self.open()
        self.go(350)
        one = next(f for f in self.state()["drawn"] if f["id"] == 1)
        overlay = self.browser.find_element(By.ID, "overlay")
        size = overlay.size

        def click(left, top):
            ActionChains(self.browser).move_to_element_with_offset(
                overlay, round(left - size["width"] / 2),
                round(top - size["height"] / 2)).click().perform()

        click(one["left"] + 5, one["top"] - 4)
        self.until("csdReport.state().selected === 1 && csdReport.state().curve.length === 725")
        self.assertEqual(self.browser.find_element(By.ID, "what").text, "Feature 1")
        self.assertEqual(self.js("return [...document.querySelectorAll('#rows tr.chosen')].map((r) "
                                 "=> r.dataset.id)"), ["1"])
        start = position(1, 0)
        for at, (when, dx, dy) in enumerate(self.state()["curve"]):
            self.assertAlmostEqual(when, at / FPS, places=5)
            if state_of(1, at) == "occluded":
                self.assertEqual((dx, dy), (None, None))
            else:
                x, y = position(1, at)
                self.assertLess(math.dist((dx, dy), (x - start[0], y - start[1])), 1 / 64)
        self.assert_rhythms(1)
        self.browser.find_element(By.CSS_SELECTOR, "#rows tr[data-id='2']").click()
        self.until("csdReport.state().selected === 2 && csdReport.state().curve.length === 101")
        self.assertEqual(self.browser.find_element(By.ID, "chosen").text.count("No rhythm"), 1)
        click(5, size["height"] - 5)
        self.until("csdReport.state().selected === null && csdReport.state().curve.length === 750")
        self.assert_rhythms(None)

    def assert_rhythms(self, number):
        """Checks that the panel has the rhythms of csd-motion, and that these are the simulated
        heart and breath."""
        told = json.loads(subprocess.run(
            [BUILD / "core" / "programs" / "csd-motion", "--json", self.tracks],
            capture_output=True, text=True, check=True, stdin=subprocess.DEVNULL).stdout)
        expected = told["scene"]["rhythms"] if number is None else next(
            f for f in told["features"] if f["id"] == number)["rhythms"]
        rows = [[cell.text for cell in row.find_elements(By.TAG_NAME, "td")]
                for row in self.browser.find_elements(By.CSS_SELECTOR, "#rhythms tbody tr")]
        self.assertEqual([row[:4] for row in rows],
                         [[r["usual_name"], f"{r['per_minute']:.1f}", f"{r['period']:.2f}",
                           f"{r['amplitude']:.2f}"] for r in expected])
        by_name = {row[0]: row for row in rows}
        for name, rate in (("heart", 75), ("breath", 15)):
            self.assertAlmostEqual(float(by_name[name][1]), rate, delta=0.02 * rate)
        # The simulated heart moves in an ellipse of 3 and 5 px.
        self.assertAlmostEqual(float(by_name["heart"][3]), 5, delta=0.3)

    def test_the_list_of_features(self):
        self.open()

        def ids():
            return [int(row.get_attribute("data-id"))
                    for row in self.browser.find_elements(By.CSS_SELECTOR, "#rows tr[data-id]")]

        self.assertEqual(ids(), [0, 1, 2])
        cells = [c.text
                 for c in self.browser.find_elements(By.CSS_SELECTOR, "#rows tr[data-id='1'] td")]
        self.assertEqual((cells[0], cells[1], cells[3]), ("tracked", "1", "90 %"))
        self.assertEqual(
            self.browser.find_element(By.CSS_SELECTOR, "#rows tr[data-id='2'] td").text, "not here")
        self.go(230)
        self.assertEqual(
            self.browser.find_element(By.CSS_SELECTOR, "#rows tr[data-id='1'] td").text, "occluded")
        self.browser.find_element(By.CSS_SELECTOR, "th[data-by=id]").click()
        self.assertEqual(ids(), [2, 1, 0])
        self.browser.find_element(By.ID, "here").click()
        self.assertEqual(ids(), [1, 0])

    def test_the_page_fits_1280_by_720_and_needs_no_network(self):
        self.open()
        self.assertEqual(self.js("return [document.documentElement.scrollWidth, "
                                 "document.documentElement.scrollHeight]"), [1280, 720])
        events = [json.loads(entry["message"])["message"]
                  for entry in self.browser.get_log("performance")]
        # Without requests of the browser's own pages.
        asked = [e["params"]["request"]["url"] for e in events
                 if e["method"] == "Network.requestWillBeSent" and
                 e["params"]["documentURL"].startswith("file:")]
        self.assertIn((self.tmp / "page" / "data" / "tracks-00000.js").as_uri(), asked)
        self.assertEqual([url for url in asked if not url.startswith(("file:", "data:"))], [])

    def test_points_are_in_place_in_any_video(self):
        """A point at the centre of a disc on black. The videos are turned, mirrored, of an odd
        size, with pixels that aren't square, or with times that begin late."""
        x, y, width, height = 90, 140, 321, 241
        disc = np.zeros((height, width, 3), np.uint8)
        cv2.circle(disc, (x, y), 24, (255, 255, 255), cv2.FILLED)
        even = disc[:240, :320]

        def tracks(name, *size):
            return write_tracks(self.tmp / name, 20,
                                lambda frame: [{"id": 7, "x": x, "y": y,
                                                "state": "lost" if frame == 19 else "tracked",
                                                "confidence": 1}], *size)

        whole, cut = tracks("even.jsonl", 320, 240), tracks("odd.jsonl", width, height)
        plain = harness.encode(self.tmp / "plain.mp4", [even] * 20, *harness.H264)
        videos = [(harness.encode(self.tmp / "odd.mkv", [disc] * 20, "-c:v", "ffv1"), cut),
                  (harness.encode(self.tmp / "wide.mp4", [even] * 20, *harness.H264, "-aspect",
                                  "2:1"), whole),
                  (harness.encode(self.tmp / "late.ts", [even] * 20, *harness.H264,
                                  "-output_ts_offset", "100"), whole)]
        # Where a point of the stored picture is shown, as fractions of the shown one.
        u, v = (x + 0.5) / 320, (y + 0.5) / 240
        places = {}
        for name, (turn, place) in {
                "turned-90": ((0, 1, -1, 0, 240, 0), (1 - v, u)),
                "turned-180": ((-1, 0, 0, -1, 320, 240), (1 - u, 1 - v)),
                "turned-270": ((0, -1, 1, 0, 0, 320), (v, 1 - u)),
                "mirrored": ((-1, 0, 0, 1, 320, 0), (1 - u, v)),
                "flipped": ((1, 0, 0, -1, 0, 240), (u, 1 - v)),
                "transposed": ((0, 1, 1, 0, 0, 0), (v, u)),
                "transversed": ((0, -1, -1, 0, 240, 320), (1 - v, 1 - u))}.items():
            one = self.tmp / f"{name}.mp4"
            one.write_bytes(turned(plain.read_bytes(), turn))
            videos.append((one, whole))
            places[one] = place
        for video, lines in videos:
            with self.subTest(video.name):
                self.make(video, lines, self.tmp / f"page-{video.name}")
                self.open(f"page-{video.name}")
                self.browser.find_element(By.ID, "ids").click()
                self.go(10)
                [drawn] = self.state()["drawn"]
                rows, columns = np.nonzero(self.stage().max(axis=2) > 100)
                self.assertGreater(len(rows), 1500)
                self.assertLess(math.dist((columns.mean() + 0.5, rows.mean() + 0.5),
                                          (drawn["left"], drawn["top"])), 1.2)
                if video in places:
                    size = self.stage().shape[1::-1]
                    self.assertLess(math.dist((drawn["left"] / size[0], drawn["top"] / size[1]),
                                              places[video]), 0.01)

    def times_of(self, video):
        """The lines of a file as GStreamer times them, without features."""
        lines = self.tmp / "timed.jsonl"
        harness.launch("filesrc", f"location={video}", "!", "decodebin", "!", "csdtrackenc", "!",
                       "filesink", f"location={lines}").check_returncode()
        return [json.loads(line) for line in lines.read_text().splitlines()]

    def assert_frames_match(self, video, first, count, least_repeats=0):
        """Checks the page of a part of the video of bars, of which GStreamer shows `count` frames
        from `first` on, with the tracks of these."""
        lines = self.times_of(video)
        self.assertEqual(len(lines), count)
        times = [line["stream_time"] for line in lines]
        self.assertGreaterEqual(sum(a == b for a, b in zip(times, times[1:])), least_repeats)
        tracks = self.tmp / f"{video.name}.jsonl"
        with open(tracks, "w") as file:
            for frame, line in enumerate(lines, first):
                line |= {"frame": frame, "source": "csdtrack0", "algorithm": "csd",
                         "features": features(frame)}
                file.write(json.dumps(line) + "\n")
        done = self.make(video, tracks, self.tmp / f"page-{video.name}")
        self.assertNotIn("warning", done.stderr)
        self.open(f"page-{video.name}")
        self.browser.find_element(By.ID, "ids").click()
        for at in (1, 2, count // 2, count - 2, count - 1):
            self.js("csdReport.seek(csdReport.about.times[arguments[0]])", at)
            self.until(f"csdReport.state().frame === {first + at} && "
                       "!document.getElementById('video').seeking")
            self.assert_shows(first + at)

    def test_frames_of_the_same_time_have_their_own_tracks(self):
        """B-frames in AVI: GStreamer has two frames of one time at a key frame, and is late from
        then on."""
        for name, codec in (("mpeg4.avi", ("mpeg4", "-vtag", "XVID")),
                            ("mpeg2.avi", ("mpeg2video",))):
            with self.subTest(name):
                self.assert_frames_match(
                    harness.encode(self.tmp / name, (picture(i) for i in range(100)), "-c:v",
                                   *codec, "-qscale:v", "2", "-bf", "2", "-g", "24", rate=FPS),
                    0, 100, 1)

    def test_a_first_frame_that_an_edit_list_clips(self):
        cut = self.tmp / "cut.mp4"
        subprocess.run(["ffmpeg", "-v", "error", "-ss", "1.02", "-t", "2", "-i", self.video, "-c",
                        "copy", cut], check=True, stdin=subprocess.DEVNULL)
        self.assertLess(self.times_of(cut)[1]["stream_time"], 0.9e9 / FPS)
        self.assert_frames_match(cut, 25, len(self.times_of(cut)))

    def test_an_hour_of_video(self):
        """csd-report keeps no positions in memory, and the page only a few chunks of them."""
        fps, seconds, count = 5, 3600, 30
        video, tracks = self.tmp / "hour.mp4", self.tmp / "hour.jsonl"
        subprocess.run(["ffmpeg", "-v", "error", "-f", "lavfi", "-i",
                        f"color=gray:size=160x120:rate={fps}:duration={seconds}", "-c:v", "libx264",
                        "-preset", "ultrafast", "-pix_fmt", "yuv420p", "-g", "50", video],
                       check=True, stdin=subprocess.DEVNULL)

        def where(number, frame):
            return (round(10 + 5 * number % 140 + 3 * math.sin(frame / 3 + number), 3),
                    round(20 + number * 3 + 2 * math.cos(frame / 4), 3))

        def of(frame):
            return [dict(zip(("id", "x", "y", "state", "confidence"),
                             (n, *where(n, frame), "tracked", 1))) for n in range(count)]

        write_tracks(tracks, fps * seconds, of, 160, 120, fps)
        with subprocess.Popen([PROGRAM, video, tracks, self.tmp / "hour"], env=ENVIRONMENT,
                              stdin=subprocess.DEVNULL) as run:
            most = 0  # kB, of csd-report itself
            while run.poll() is None:
                for line in io.StringIO(pathlib.Path(f"/proc/{run.pid}/status").read_text()):
                    if line.startswith("VmHWM:"):
                        most = max(most, int(line.split()[1]))
                time.sleep(0.05)
        self.assertEqual(run.returncode, 0)
        # As objects of Python the positions alone would take more than 200 MB.
        self.assertTrue(20e3 < most < 100e3, f"{most} kB")
        self.open("hour")
        for frame in range(0, fps * seconds, 911):
            self.go(frame, fps)
            if frame % 3 == 0:
                self.js("csdReport.select(arguments[0])", frame % count)
                self.until("csdReport.state().curve.length === arguments[0]", fps * seconds)
        state = self.state()
        self.assertLessEqual(state["chunks"], 9)
        self.assertLess(self.js("return document.scripts.length"), 12)
        for feature in state["drawn"]:
            self.assertLess(math.dist((feature["x"], feature["y"]), where(feature["id"], frame)),
                            1 / 64)
        self.assertEqual(len(state["drawn"]), count)


if __name__ == "__main__":
    del sys.argv[1:3]
    harness.main()
