# SPDX-License-Identifier: LGPL-2.1-or-later
"""Shared by the pipeline tests: makes videos with known motion, runs pipelines, reads tracks."""

import contextlib
import fcntl
import json
import math
import os
import pathlib
import pty
import signal
import subprocess
import sys
import tempfile
import termios
import time
import unittest

import cv2
import gi
import numpy as np

gi.require_version("Gst", "1.0")
gi.require_version("GstVideo", "1.0")
from gi.repository import Gst  # noqa: E402

Gst.init(None)

ROOT = pathlib.Path(__file__).resolve().parents[2]
TIMEOUT = 60  # seconds: far more than any pipeline here takes
FRAME = Gst.SECOND // 25
STATES = ("learning", "tracked", "occluded", "lost", "out", "ended")
CLAIMS = ("learning", "tracked")  # the states that claim a position
LINE_FIELDS = ["schema", "source", "role", "algorithm", "frame", "pts", "duration", "running_time",
               "stream_time", "reference", "width", "height", "pixel_aspect", "features"]
# x264 (164) reads memory that it has not written. Unless new memory always holds the same bytes, it
# sometimes encodes other bits on a busy machine, with csdtrack or without.
SAME_MEMORY = {"MALLOC_PERTURB_": "165"}


class Case(unittest.TestCase):
    """Has a folder of its own, self.tmp, and shows differences in full."""

    maxDiff = None

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="csdtrack-")
        cls.addClassCleanup(folder.cleanup)
        cls.tmp = pathlib.Path(folder.name)
        assert Gst.ElementFactory.find("csdtrack"), "no csdtrack: is GST_PLUGIN_PATH_1_0 set?"

    def check_refused(self, done, code, words):
        """A command has failed with one line (code 1) or was used wrongly (code 2)."""
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(words, done.stderr)
        self.assertNotRegex(done.stderr, "Traceback|Warning")
        if code == 1:
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)


def structure_text(structure):
    """The text of what an event's get_structure() returned, or None. In python3-gst-1.0 of 1.26
    that can be read only inside `with`."""
    if hasattr(structure, "__enter__"):
        with structure as opened:
            return opened and opened.to_string()
    return structure and structure.to_string()


def formats(template):
    """The raw formats of a pad template, in its order. Every caps feature must have the same."""
    caps, found = template.get_caps(), {}
    for i in range(caps.get_size()):
        found.setdefault(caps.get_features(i).to_string(), []).extend(caps[i].get_value("format"))
    one, *others = found.values()
    assert all(other == one for other in others), found
    return one


# ---- Made-up videos ------------------------------------------------------------------------------


def texture(width, height, seed=1, sigma=2.5):
    """Smoothed noise in colour: corners everywhere, large enough to survive encoding. H×W×3, RGB,
    8 bit."""
    noise = np.random.default_rng(seed).standard_normal((height, width, 3))
    grey = noise[:, :, :1]
    noise = cv2.GaussianBlur(0.8 * grey + 0.4 * noise, (0, 0), sigma)
    noise = 128 + 45 * noise / noise.std()
    return np.clip(np.round(noise), 16, 240).astype(np.uint8)


class Scene:
    """A texture that moves as a whole. At time t, in frames (halves are fields), each point is at
    its start + motion(t)."""

    MARGIN = 40

    def __init__(self, width=320, height=240, motion=None, seed=1, sigma=2.5):
        self.width, self.height = width, height
        self.motion = motion or (lambda t: (round(6 * math.sin(t / 5)), round(5 * math.sin(t / 7))))
        self._all = texture(width + 2 * self.MARGIN, height + 2 * self.MARGIN, seed, sigma)

    def picture(self, t):
        """Motion is by whole pixels, so that pictures are exact, without interpolation."""
        dx, dy = self.motion(t)
        assert dx == int(dx) and dy == int(dy) and max(abs(dx), abs(dy)) <= self.MARGIN, (
            f"motion must be whole pixels, at most {self.MARGIN}")
        x, y = self.MARGIN - int(dx), self.MARGIN - int(dy)
        return self._all[y:y + self.height, x:x + self.width]


def encode(path, pictures, *options, rate=25):
    """Writes pictures (H×W×3, RGB) with ffmpeg."""
    pictures = list(pictures)
    height, width = pictures[0].shape[:2]
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                    f"{width}x{height}", "-r", str(rate), "-i", "-", *map(str, options), str(path)],
                   input=b"".join(np.ascontiguousarray(p).tobytes() for p in pictures), check=True)
    return path


H264 = ("-c:v", "libx264", "-pix_fmt", "yuv420p", "-preset", "veryfast", "-crf", "18", "-threads",
        "1")


def scene_video(path, frames=60, *options, **scene):
    made = Scene(**scene)
    return encode(path, (made.picture(t) for t in range(frames)), *(options or H264))


def odd_rates(folder, frames):
    """Videos of 25 frames a second: one says that it has 1000, one says 0 as it doesn't know."""
    made = Scene()
    pictures = [made.picture(t) for t in range(frames)]
    times = ("-vf", "settb=1/1000,setpts=N*40", "-fps_mode", "passthrough", "-enc_time_base",
             "1/1000", "-r", "1000")
    unknown = encode(folder / "0.webm", pictures, *times, "-c:v", "libvpx", "-b:v", "2M",
                     "-deadline", "realtime", "-live", "1")
    high = folder / "1000.mkv"
    launch("filesrc", f"location={unknown}", "!", "decodebin", "!", "capssetter",
           "caps=video/x-raw,framerate=1000/1", "!", "x264enc", "tune=zerolatency", "!",
           "matroskamux", "!", "filesink", f"location={high}").check_returncode()
    return {1000: high, 0: unknown}


def decoded_frames(path):
    """How many frames ffmpeg decodes from a file: a count that does not depend on GStreamer."""
    out = subprocess.run(["ffprobe", "-v", "quiet", "-count_frames", "-select_streams", "v:0",
                          "-show_entries", "stream=nb_read_frames", "-of", "csv=p=0", str(path)],
                         capture_output=True, text=True).stdout
    return int(out.split()[0].strip(","))


def clips():
    folder = pathlib.Path(os.environ.get("CSDTRACK_CLIPS") or
                          pathlib.Path(__file__).resolve().parents[2] / ".." / "shared" / "clips")
    found = sorted(p for p in folder.glob("*") if p.suffix in (".mkv", ".mp4"))
    if not found:
        raise unittest.SkipTest(f"no clips in {folder}")
    return found


# ---- Running -------------------------------------------------------------------------------------


class PipelineError(Exception):
    def __init__(self, error, debug):
        super().__init__(f"{error.message} ({debug})")
        self.error = error


class Hangs(AssertionError):
    """Nothing came on a pipeline's bus for TIMEOUT seconds."""


class Run:
    """A pipeline from a launch line. `feed`, an iterable of buffers, feeds the appsrc `in`."""

    def __init__(self, launch, feed=None, caps=None):
        self.pipeline = Gst.parse_launch(launch)
        self.messages = []  # structures of csdtrack's messages
        self.warnings = []
        self._seen = {}
        if feed is not None:
            source = self.element("in")
            source.set_property("format", Gst.Format.TIME)
            if caps:
                source.set_property("caps", Gst.Caps.from_string(caps))
            self._feed = iter(feed)
            source.connect("need-data", self._push)

    def element(self, name):
        return self.pipeline.get_by_name(name)

    def _push(self, source, _length):
        try:
            item = next(self._feed, None)
        except Exception:
            source.emit("end-of-stream")  # else the pipeline waits for ever
            raise
        if item is None:
            source.emit("end-of-stream")
        elif isinstance(item, Gst.Buffer):
            source.emit("push-buffer", item)
        else:
            source.emit("push-sample", item)

    def collect(self, name, of):
        """Calls `of` on each buffer that fakesink `name` gets. Returns the list of results, which
        grows as the pipeline runs."""
        result = []
        sink = self.element(name)
        sink.set_property("signal-handoffs", True)
        sink.connect("handoff", lambda _sink, buffer, _pad: result.append(of(buffer)))
        return result

    def until(self, kinds):
        """Waits for a message of these kinds. Keeps csdtrack's messages and warnings. Raises
        errors, and Hangs if nothing comes."""
        bus = self.pipeline.get_bus()
        while True:
            message = bus.timed_pop(TIMEOUT * Gst.SECOND)
            if message is None:
                raise Hangs(f"the pipeline hangs: nothing on the bus for {TIMEOUT} s")
            if message.type == Gst.MessageType.ERROR:
                raise PipelineError(*message.parse_error())
            if message.type == Gst.MessageType.WARNING:
                self.warnings.append((message.src.get_name(), message.parse_warning()[0].message))
            if message.type == Gst.MessageType.ELEMENT and message.has_name("csdtrack"):
                self.messages.append(message.get_structure().copy())
            # Extended types are numbers, not flags: STREAMS_SELECTED has EOS's bit.
            if message.type & kinds and not message.type & Gst.MessageType.EXTENDED:
                return message

    def to_end(self):
        """Plays to EOS."""
        try:
            self.pipeline.set_state(Gst.State.PLAYING)
            self.until(Gst.MessageType.EOS)
        finally:
            self.pipeline.set_state(Gst.State.NULL)
        return self


def play(launch, feed=None, caps=None):
    return Run(launch, feed, caps).to_end()


def tracked_video(folder):
    """Makes a video of two seconds, with B-frames and a key frame every 10 frames. Returns it and
    the elements, to be compared with identity, that must not change it."""
    video = scene_video(folder / "scene.mp4", 50, *H264, "-g", "10", "-bf", "2", width=160,
                        height=120)
    tracks = folder / "tracks.jsonl"
    play(f"filesrc location={video} ! decodebin ! csdtrack max-features=8 ! csdtrackenc ! filesink "
         f"location={tracks}")
    return video, ("csdtrack max-features=8", f"csdtrackdec location={tracks}")


def buffers(pictures, stamped=True):
    """Buffers from arrays whose rows have the length that GStreamer expects."""
    for i, picture in enumerate(pictures):
        buffer = Gst.Buffer.new_wrapped(np.ascontiguousarray(picture).tobytes())
        if stamped:
            buffer.pts, buffer.duration = i * FRAME, FRAME
        yield buffer


def rgb_caps(width=320, height=240):
    return f"video/x-raw,format=RGB,width={width},height={height},framerate=25/1"


def launch(*arguments, env=None, timeout=TIMEOUT, **options):
    """Runs gst-launch-1.0 with a pipeline as a user types it, in a process of its own."""
    return subprocess.run(["gst-launch-1.0", *" ".join(map(str, arguments)).split()],
                          capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=timeout,
                          env=dict(os.environ, **(env or {})), **options)


@contextlib.contextmanager
def screen(size="640x480"):
    """A virtual X server with OpenGL, at a free number that it finds itself. Yields its DISPLAY."""
    told, tells = os.pipe()
    with subprocess.Popen(["Xvfb", "-displayfd", str(tells), "-screen", "0", f"{size}x24"],
                          pass_fds=[tells], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True) as server:
        os.close(tells)
        try:
            with open(told, encoding="ascii") as pipe:
                number = pipe.readline().strip()  # written when it is ready; empty if it has ended
            if not number:
                raise AssertionError(f"Xvfb does not start: {server.stderr.read()}")
            yield f":{number}"
        finally:
            server.terminate()


@contextlib.contextmanager
def small_disk(folder, options):
    """Mounts a small file system there, with options of tmpfs. Skips the test where it can't."""
    if subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", folder],
                      capture_output=True).returncode:
        raise unittest.SkipTest("mounting is not allowed here")
    try:
        yield
    finally:
        subprocess.run(["umount", folder], check=True)


def run_python(program, *arguments, timeout=TIMEOUT, **options):
    """Runs a program given as text. Like the tests, it imports from the top of the repository."""
    return subprocess.run([sys.executable, "-c", program, *map(str, arguments)], cwd=ROOT,
                          capture_output=True, text=True, stdin=subprocess.DEVNULL,
                          timeout=timeout, **options)


# Has the commands' runs meet a disk that takes the third line, says nothing, and does not keep it.
SWALLOW = """
from pipelines.lib import runner
play, count = runner.Run.play, 0

def swallow(*_):
    global count
    count += 1
    return runner.Gst.PadProbeReturn.DROP if count == 3 else runner.Gst.PadProbeReturn.OK

def plant(run, *arguments, **options):
    def on_element(_pipeline, _bin, element):
        if element.get_name() == "%s":
            element.sinkpads[0].add_probe(runner.Gst.PadProbeType.BUFFER, swallow)

    run.pipeline.connect("deep-element-added", on_element)
    run.pipeline.iterate_elements().foreach(lambda each: on_element(None, None, each))
    play(run, *arguments, **options)

runner.Run.play = plant
"""


def run_swallowing(name, *arguments, sink="file", **options):
    """Runs a command with SWALLOW before this filesink, on sources of 25 frames."""
    return run_python(SWALLOW % sink + f"""
from pipelines.lib import command, {name}, sources
sources.launch = lambda _: ("videotestsrc num-buffers=25 ! "
                            "video/x-raw,width=160,height=120,framerate=25/1")
command.run("{name}", {name}.main)
""", "--preset", "", *arguments, **options)


def await_count(process, file, count, read, wanted=b"\n"):
    """Waits until a file has `wanted` so many times. Fails if the process ends before, or a minute
    passes: with what read() gives, which is what it printed."""
    for _ in range(600):
        if file.exists() and file.read_bytes().count(wanted) >= count:
            return
        if process.poll() is not None:
            break
        time.sleep(0.1)
    process.kill()
    raise AssertionError(f"{file.name} has not {count} times {wanted}: {read()}")


class Terminal:
    """A command in a terminal of its own."""

    def __init__(self, test, command, env):
        self._end, there = pty.openpty()

        def begin():
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)
            # Under nohup the tests, and so this process, would ignore it.
            signal.signal(signal.SIGHUP, signal.SIG_DFL)

        self.process = subprocess.Popen(list(map(str, command)), stdin=there, stdout=there,
                                        stderr=there, env=env, start_new_session=True,
                                        preexec_fn=begin)
        os.close(there)
        test.addCleanup(self.process.wait)
        test.addCleanup(self.process.kill)

    def read(self):
        try:
            return os.read(self._end, 1000).decode()
        except OSError:  # the command ended and all that it printed was read
            return ""

    def await_lines(self, path, count):
        await_count(self.process, path, count, self.read)

    def close(self):
        """Closes the terminal as a window closes: the system sends SIGHUP, and so does a shell.
        Returns the exit code."""
        os.close(self._end)
        time.sleep(0.2)
        self.process.send_signal(signal.SIGHUP)
        return self.process.wait(60)


# ---- Tracks --------------------------------------------------------------------------------------


def parse_line(text):
    def refuse(word):
        raise ValueError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


def read_lines(path, torn=False):
    """The objects of a .jsonl file; every line must parse. With `torn` an unfinished last line may
    be there and is left out."""
    text = pathlib.Path(path).read_text(encoding="utf-8")
    if not torn:
        assert text == "" or text.endswith("\n"), f"{path} ends with a torn line"
    return [parse_line(line) for line in text.split("\n")[:-1]]


def check_tracks(test, lines, frames=None, stamped=True, most=None):
    """Checks what holds in every file of tracks: fields, numbers, ids, order. `most` is the largest
    number of features alive at a time."""
    if frames is not None:
        test.assertEqual(len(lines), frames, "as many lines as frames")
    alive, ended, last_pts = set(), set(), -1
    for index, line in enumerate(lines):
        where = f"line {index + 1}"
        test.assertEqual(list(line), LINE_FIELDS, where)
        test.assertEqual((line["schema"], line["role"], line["frame"]), (1, "track", index), where)
        if stamped:
            test.assertGreater(line["pts"], last_pts, where)
            last_pts = line["pts"]
        ids = [f["id"] for f in line["features"]]
        test.assertEqual(ids, sorted(set(ids)), f"{where}: ids must ascend and be unique")
        now = set(ids)
        test.assertFalse(now & ended, f"{where}: an id that had ended is back")
        test.assertFalse(alive - now, f"{where}: an id left the list without having ended")
        new = now - alive
        if new and (alive or ended):
            test.assertGreater(min(new), max(alive | ended),
                               f"{where}: a new id is not above all others")
        for f in line["features"]:
            test.assertIn(f["state"], STATES, where)
            test.assertTrue(math.isfinite(f["x"]) and math.isfinite(f["y"]), where)
            test.assertTrue(0 <= f["confidence"] <= 1 if line["algorithm"] == "csd"
                            else f["confidence"] in (0, 1), f"{where}: {f}")
            test.assertEqual(f["confidence"] >= 0.5, f["state"] in CLAIMS, f"{where}: {f}")
            test.assertLessEqual(set(f), {"id", "x", "y", "state", "confidence", "fresh"}, where)
            if f["state"] in CLAIMS:
                test.assertTrue(-0.5 <= f["x"] < line["width"] and -0.5 <= f["y"] < line["height"],
                                f"{where}: {f}")
        over = {f["id"] for f in line["features"] if f["state"] == "ended"}
        alive, ended = now - over, ended | over
        if most is not None:
            test.assertLessEqual(len(alive), most, where)


def main():
    """Exit code for meson's protocol `exitcode`: 0, 1, or 77 if all tests were skipped."""
    program = unittest.main(module="__main__", exit=False, verbosity=2)
    result = program.result
    for test, why in result.skipped:
        print(f"SKIP: {test}: {why}")
    if not result.wasSuccessful():
        sys.exit(1)
    sys.exit(77 if result.skipped and len(result.skipped) >= result.testsRun else 0)
