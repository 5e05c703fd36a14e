#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The Python module: frames of every layout, arguments, and the same tracks as the element's."""

import ast
import gc
import inspect
import pathlib
import subprocess
import sys
import threading
import time
import tracemalloc
import unittest
import warnings

import numpy as np

import harness
from harness import FRAME, Gst

import csdtrack

PACKAGE = pathlib.Path(csdtrack.__file__).parent


def keywords():
    """The keywords of Tracker in the type stub, and their defaults."""
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text())
    tracker, = (n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == "Tracker")
    init = next(n for n in tracker.body if isinstance(n, ast.FunctionDef) and n.name == "__init__")
    return {a.arg: ast.literal_eval(d) for a, d in zip(init.args.kwonlyargs, init.args.kw_defaults)}


def run(frames, **settings):
    tracker = csdtrack.Tracker(**settings)
    return [tracker.process(frame, i * FRAME, FRAME) for i, frame in enumerate(frames)]


class Frames(harness.Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.scene = [harness.Scene().picture(t) for t in range(20)]
        cls.expected = run(cls.scene)
        cls.assertTrue(cls, all(len(rows) >= 10 for rows in cls.expected))

    def assertSame(self, got, expected, text=None):
        self.assertEqual(len(got), len(expected))
        for i, (a, b) in enumerate(zip(got, expected)):
            np.testing.assert_array_equal(a, b, f"{text}, frame {i}")

    def test_gives_the_elements_tracks(self):
        # 322 pixels: GStreamer pads the rows of these formats, but for one.
        for form, colours, algorithm in (("RGB", 3, "csd"), ("BGR", 3, "csd"), ("GRAY8", 1, "csd"),
                                         ("RGB", 3, "csd-2012"), ("BGR", 3, "ms1"),
                                         ("GRAY8", 1, "lk")):
            for height in (240, 600) if (form, algorithm) == ("RGB", "csd") else (240,):
                with self.subTest(form=form, algorithm=algorithm, height=height):
                    settings = {"algorithm": algorithm, "max-features": 12, "learning": "sync",
                                "seed": 5}
                    words = " ".join(f"{k}={v}" for k, v in settings.items())
                    elements = harness.Run(
                        "csdsimsrc num-buffers=30 style=heart effects=heart-strong=1,sway=1 ! "
                        f"video/x-raw,width=322,height={height},framerate=25/1 ! videoconvert ! "
                        f"video/x-raw,format={form} ! csdtrack {words} ! fakesink name=out")

                    def read(buffer):
                        meta = buffer.get_custom_meta("GstCsdTrackMeta").get_structure()
                        features = [tuple(f.get_value(n)
                                          for n in ("id", "x", "y", "state", "confidence", "fresh"))
                                    for f in meta.get_value("features")]
                        return (buffer.extract_dup(0, buffer.get_size()), buffer.pts,
                                buffer.duration, features)

                    buffers = elements.collect("out", read)
                    elements.to_end()
                    self.assertEqual(len(buffers), 30)
                    tracker = csdtrack.Tracker(order="bgr" if form == "BGR" else "rgb",
                                               **{k.replace("-", "_"): v
                                                  for k, v in settings.items()})
                    stride = (322 * colours + 3) // 4 * 4
                    seen = 0
                    for data, pts, duration, features in buffers:
                        padded = np.frombuffer(data, np.uint8).reshape(height, stride)
                        frame = padded[:, :322 * colours]
                        if colours == 3:
                            frame = frame.reshape(height, 322, 3)
                        rows = tracker.process(frame, pts, duration)
                        self.assertEqual(rows.tolist(), features)
                        seen += len(rows)
                    self.assertGreaterEqual(seen, 30 * 8)

    def test_any_strides(self):
        def through(memory, view):
            """The frames, laid out by `memory` and seen as before through `view`."""
            for frame in self.scene:
                seen = view(memory(frame))
                np.testing.assert_array_equal(seen, frame)
                yield seen

        def inside(frame):
            whole = np.full((3 * frame.shape[0] + 5, 2 * frame.shape[1] + 7, 5), 77, np.uint8)
            whole[2:-3:3, 3:-4:2, 1:4] = frame
            return whole

        copy = np.ascontiguousarray
        for name, memory, view in (
                ("upside down", lambda f: copy(f[::-1]), lambda m: m[::-1]),
                ("mirrored", lambda f: copy(f[:, ::-1]), lambda m: m[:, ::-1]),
                ("all reversed", lambda f: copy(f[::-1, ::-1, ::-1]),
                 lambda m: m[::-1, ::-1, ::-1]),
                ("columns first", np.asfortranarray, lambda m: m),
                ("planes", lambda f: copy(f.transpose(2, 0, 1)), lambda m: m.transpose(1, 2, 0)),
                ("a part of something larger", inside, lambda m: m[2:-3:3, 3:-4:2, 1:4]),
                ("four to a pixel", lambda f: np.dstack([f, f[..., 0]]), lambda m: m[..., :3])):
            with self.subTest(name):
                self.assertSame(run(through(memory, view)), self.expected, name)

    def test_order_of_colours(self):
        reversed_colours = [frame[..., ::-1] for frame in self.scene]
        self.assertSame(run(reversed_colours, order="bgr"), self.expected)
        other = run(reversed_colours)
        self.assertTrue(any(len(a) != len(b) or (a != b).any()
                            for a, b in zip(other, self.expected)), "the order makes no difference")

    def test_gray_strides(self):
        gray = [frame[..., 1] for frame in self.scene]  # every third byte
        expected = run([np.ascontiguousarray(frame) for frame in gray])
        self.assertGreaterEqual(len(expected[0]), 10)
        self.assertSame(run(gray), expected)
        self.assertSame(run([np.ascontiguousarray(f[::-1])[::-1] for f in gray]), expected)

    def test_flat_frames_have_no_features(self):
        for frame in (np.broadcast_to(np.uint8(90), (240, 320)),
                      np.broadcast_to(np.uint8([90, 40, 30]), (240, 320, 3))):
            self.assertEqual(frame.strides[:2], (0, 0))
            self.assertEqual(len(csdtrack.Tracker().process(frame)), 0)

    def test_a_frame_is_not_copied_changed_or_kept(self):
        # 3.7 MB, in an order of memory that numpy would copy
        frame = np.kron(self.scene[0], np.ones((4, 4, 1), np.uint8))[::-1, ::-1]
        before, count = frame.copy(), sys.getrefcount(frame)
        frame.flags.writeable = False
        tracker = csdtrack.Tracker()
        tracemalloc.start()  # numpy reports its arrays to it
        try:
            start = tracemalloc.get_traced_memory()[0]
            tracemalloc.reset_peak()
            rows = tracker.process(frame)
            peak = tracemalloc.get_traced_memory()[1] - start
        finally:
            tracemalloc.stop()
        self.assertGreater(len(rows), 0)
        self.assertLess(peak, frame.nbytes / 20)
        self.assertEqual(sys.getrefcount(frame), count)
        np.testing.assert_array_equal(frame, before)

    def test_results_outlive_the_next_frame_and_the_tracker(self):
        tracker = csdtrack.Tracker()
        first = tracker.process(self.scene[0], 0, FRAME)
        kept = first.copy()
        tracker.process(self.scene[1], FRAME, FRAME)
        del tracker
        gc.collect()
        np.testing.assert_array_equal(first, kept)
        first["x"] = 0  # it belongs to the caller

    def test_fields(self):
        rows = self.expected[-1]
        self.assertEqual(rows.dtype.names, ("id", "x", "y", "state", "confidence", "fresh"))
        self.assertEqual([rows.dtype[n].str for n in rows.dtype.names],
                         ["<u4", "<f8", "<f8", "<U8", "<f8", "|b1"])
        self.assertEqual(csdtrack.STATES, harness.STATES)
        self.assertLessEqual(set(rows["state"]), set(csdtrack.STATES))
        np.testing.assert_array_equal(np.isin(rows["state"], harness.CLAIMS),
                                      rows["confidence"] >= 0.5)

    def test_motion_equals_the_scenes(self):
        scene = harness.Scene()
        points = np.array([[100, 80], [160.5, 120]])
        for i, rows in enumerate(run(self.scene, points=points)):
            np.testing.assert_allclose(np.stack([rows["x"], rows["y"]], 1),
                                       points + scene.motion(i), atol=0.05)

    def test_other_threads_run_during_process_but_may_not_call_it(self):
        frame = np.kron(self.scene[0], np.ones((5, 5, 1), np.uint8))
        tracker, refused = csdtrack.Tracker(algorithm="sift"), []
        thread = threading.Thread(target=lambda: [tracker.process(frame) for _ in range(3)])
        thread.start()
        while thread.is_alive():
            try:
                tracker.process(self.scene[0])
            except RuntimeError as error:
                refused.append(str(error))
                self.assertGreaterEqual(tracker.stats["frames"], 0)  # does not wait for the frame
                time.sleep(0.001)
            else:
                time.sleep(0.001)
        thread.join()
        self.assertGreater(len(refused), 0, "process() never ran beside this thread")
        self.assertRegex(refused[0], "another thread.*use one for each")
        self.assertGreater(len(tracker.process(self.scene[0])), 0)

    def test_two_trackers_in_threads_do_not_affect_each_other(self):
        results = [None, None]

        def work(i):
            results[i] = run(self.scene)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for result in results:
            self.assertSame(result, self.expected)


class Stream(harness.Case):
    def setUp(self):
        self.frame = harness.Scene().picture(0)

    def learning_frames(self, *times):
        """The number of frames, with these arguments, until a point is no longer learning."""
        tracker = csdtrack.Tracker(points=[[100, 80]], training_time=400_000_000)
        for i, arguments in enumerate(times):
            if tracker.process(self.frame, *arguments)["state"][0] == "tracked":
                return i
        return None

    def test_learning_ends_by_time(self):
        self.assertEqual(self.learning_frames(*[(None,)] * 20), 10)  # 40 ms each
        self.assertEqual(self.learning_frames(*[(None, 20_000_000)] * 30), 20)
        self.assertEqual(self.learning_frames(*[(i * 80_000_000,) for i in range(20)]), 5)
        self.assertEqual(self.learning_frames(*[(np.int64(i * 80_000_000),) for i in range(20)]), 5)

    def test_after_a_discont_to_another_picture_nothing_is_claimed(self):
        other = harness.Scene(seed=9).picture(0)
        tracker = csdtrack.Tracker(points=[[100, 80], [200, 150]])
        for i in range(20):
            rows = tracker.process(self.frame, i * FRAME)
        self.assertEqual(list(rows["state"]), ["tracked"] * 2)
        rows = tracker.process(other, 20 * FRAME, discont=True)
        self.assertFalse(set(rows["state"]) & set(harness.CLAIMS))
        for i in range(21, 46):
            rows = tracker.process(self.frame, i * FRAME)
        self.assertEqual(list(rows["state"]), ["tracked"] * 2)

    def test_points_come_and_go(self):
        tracker = csdtrack.Tracker(points=[[100, 80], [200, 150]])
        self.assertEqual(tracker.process(self.frame)["id"].tolist(), [0, 1])
        self.assertEqual(tracker.add_point(50, 60.5), 2)
        self.assertTrue(tracker.remove_point(0))
        self.assertFalse(tracker.remove_point(77))
        rows = tracker.process(self.frame)
        self.assertEqual(rows[["id", "state"]].tolist(),
                         [(0, "ended"), (1, "learning"), (2, "learning")])
        self.assertEqual(rows["y"][2], 60.5)
        tracker.reset()
        rows = tracker.process(self.frame)
        self.assertEqual(rows[["id", "state"]].tolist(),
                         [(1, "ended"), (2, "ended"), (3, "learning"), (4, "learning")])
        self.assertEqual(rows["x"][2:].tolist(), [100, 200])
        rows = tracker.process(self.frame[:200])
        self.assertEqual(rows["id"][rows["state"] == "learning"].tolist(), [5, 6],
                         "a new size starts anew")
        self.assertEqual(tracker.process(self.frame[:200])["id"].tolist(), [5, 6])

    def test_more_than_10000_points_are_refused(self):
        tracker = csdtrack.Tracker(algorithm="lk", points=np.full((10000, 2), -5.0))
        with self.assertRaisesRegex(RuntimeError, "10000 features.*remove one"):
            tracker.add_point(1, 1)

    def test_region_and_max_features_limit_detection(self):
        tracker = csdtrack.Tracker(max_features=7, region=np.array([40, 30, 200, 100]))
        rows = tracker.process(self.frame)
        self.assertEqual(len(rows), 7)
        self.assertTrue(
            ((rows["x"] >= 39) & (rows["x"] <= 240) & (rows["y"] >= 29) & (rows["y"] <= 130)).all())
        self.assertEqual(len(csdtrack.Tracker(max_features=0).process(self.frame)), 0)

    def test_stats(self):
        tracker = csdtrack.Tracker(points=[[100, 80], [2000, 150]])
        for _ in range(3):
            tracker.process(self.frame)
        stats = tracker.stats
        self.assertEqual({k: stats[k] for k in ("frames", "learning", "out", "lost", "detected")},
                         {"frames": 3, "learning": 1, "out": 1, "lost": 0, "detected": 2})
        element = Gst.ElementFactory.make("csdtrack").get_property("stats")
        names = {element.nth_field_name(i).replace("-", "_") for i in range(element.n_fields())}
        self.assertEqual(set(stats), names - {"failed_frames", "time_p50", "time_p95", "time_max"})

    def test_a_frame_that_is_too_small_warns_once(self):
        tracker = csdtrack.Tracker()
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            for _ in range(3):
                self.assertEqual(len(tracker.process(self.frame[:8, :8])), 0)
        self.assertEqual([w.category for w in caught], [RuntimeWarning])
        self.assertRegex(str(caught[0].message), "8×8.*patch_size")
        # The warning names the caller's line: so each caller's first one is shown.
        self.assertEqual(caught[0].filename, __file__)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with self.assertRaises(RuntimeWarning):
                tracker.process(self.frame[:7, :7])
        self.assertGreater(len(tracker.process(self.frame)), 0)

    def test_wrong_frames_and_times_are_refused(self):
        frame, tracker = self.frame, csdtrack.Tracker()
        for wrong, kind, text in (
                (frame.tolist(), TypeError, "frame is a list: give a numpy array of uint8"),
                (None, TypeError, "frame is a NoneType"),
                (bytes(100), TypeError, "frame is a bytes"),
                (frame.astype(float), TypeError, "array of float64: give uint8"),
                (frame.astype(np.int8), TypeError, "array of int8"),
                (frame > 9, TypeError, "array of bool"),
                (frame[..., :2], ValueError, r"\(240, 320, 2\): give H×W"),
                (np.dstack([frame, frame[..., 0]]), ValueError, r"frame\[\.\.\., :3\]"),
                (frame[0, 0], ValueError, r"shape \(3,\)"),
                (frame[None], ValueError, r"\(1, 240, 320, 3\)"),
                (frame[:0], ValueError, r"\(0, 320, 3\): give 1…32768"),
                (np.broadcast_to(np.uint8(0), (2, 40000)), ValueError, r"\(2, 40000\)")):
            with self.subTest(text), self.assertRaisesRegex(kind, text):
                tracker.process(wrong)
        for arguments, kind, text in (((0.04,), TypeError,
                                       r"pts is a float.*round\(seconds \* 1e9\), or None"),
                                      ((-1,), ValueError, "pts=-1 is not in"),
                                      ((2**63,), ValueError, "pts=9223372036854775808"),
                                      ((None, -1), ValueError, "duration=-1"),
                                      ((None, "x"), TypeError, "duration is a str")):
            with self.subTest(text), self.assertRaisesRegex(kind, text):
                tracker.process(frame, *arguments)
        self.assertEqual(tracker.stats["frames"], 0)
        self.assertGreater(len(tracker.process(frame)), 0)

    def test_wrong_settings_are_refused(self):
        for name, value, kind, text in (
                ("algorithm", "kcf", ValueError,
                 "none of 'csd', 'csd-2012', 'lk', 'ms1', 'ms2', 'sift', 'csd-forest'"),
                ("algorithm", 3, TypeError, "algorithm=3"),
                ("order", "RGB", ValueError, "'rgb', 'bgr'"),
                ("learning", "no", ValueError, "'async', 'sync'"),
                ("content_area", "", ValueError, "'auto', 'full'"),
                ("points", [], ValueError, "max_features=0"),
                ("points", [[1, 2, 3]], ValueError, r"\(1, 3\)"),
                ("points", "10,20", TypeError, "give N rows"),
                ("points", [[1, np.inf]], ValueError, r"points\[0\] is not finite"),
                ("points", np.zeros((10001, 2)), ValueError, "at most 10000"),
                ("region", (1, 2, 3), ValueError, "four"),
                ("region", "1,2,3,4", TypeError, "region is a str"),
                ("region", (0, 0, 0, 1), ValueError, r"region\[2\]=0"),
                ("region", (0, 0, 1.5, 1), TypeError, r"region\[2\] is a float"),
                ("training_time", 0.5, TypeError, "nanoseconds"),
                ("seed", -1, ValueError, "seed=-1"), ("seed", 2**64, ValueError, "below"),
                ("replenish", "x", TypeError, "replenish"),
                ("max_features", True, TypeError, "max_features is a bool"),
                ("colour", 1, TypeError, "colour")):
            with self.subTest(name=name, value=value), self.assertRaisesRegex(kind, text):
                csdtrack.Tracker(**{name: value})
        for x in (np.nan, np.inf):
            with self.assertRaisesRegex(ValueError, "x=.* is not finite"):
                csdtrack.Tracker().add_point(x, 0)

    def test_errors_about_arguments_are_one_line_and_name_them(self):
        tracker = csdtrack.Tracker()
        for call, text in (
                (lambda: csdtrack.Tracker("lk"), "positional"),
                (lambda: csdtrack.Tracker(colour=1), "unexpected keyword argument 'colour'"),
                (lambda: csdtrack.Tracker(replenish="no"), "replenish is a str, not a bool"),
                (lambda: csdtrack.Tracker(replenish=None), "replenish is a NoneType"),
                (lambda: tracker.process(), "'frame'"),
                (lambda: tracker.process(self.frame, discont="no"), "discont is a str, not a bool"),
                (lambda: tracker.add_point("1", 2), "x is a str, not a number"),
                (lambda: tracker.add_point(1, None), "y is a NoneType"),
                (lambda: tracker.add_point((1, 2)), "missing 1 required positional argument: 'y'"),
                (lambda: tracker.remove_point("1"), "id is a str, not an int")):
            with self.subTest(text), self.assertRaisesRegex(TypeError, f"^[^\n]*{text}[^\n]*$"):
                call()
        with self.assertRaises(AttributeError):
            tracker.max_features = 5  # it would change nothing
        self.assertEqual(tracker.add_point(np.float32(1), np.int64(2)), 0)
        self.assertGreater(
            len(csdtrack.Tracker(replenish=np.bool_(False)).process(self.frame, discont=1)), 0)

    def test_repr_and_version(self):
        tracker = csdtrack.Tracker(algorithm="lk", points=[[100, 80], [2000, 150]])
        self.assertEqual(repr(tracker), "<csdtrack.Tracker lk: 0 frames>")
        tracker.process(self.frame)
        self.assertEqual(repr(tracker), "<csdtrack.Tracker lk: 1 frames, 1 tracked, 1 out>")
        self.assertEqual(csdtrack.__version__,
                         Gst.Registry.get().find_plugin("csdtrack").get_version())


class Uninitialised(harness.Case):
    """Trackers without __init__(), or made in another process."""

    CALLS = ("process(frame)", "add_point(1, 2)", "remove_point(0)", "reset()", "stats",
             "__repr__()")

    def test_without_init(self):
        tracker = csdtrack.Tracker.__new__(csdtrack.Tracker)
        names = {"tracker": tracker, "frame": np.zeros((48, 64), np.uint8)}
        for call in (*self.CALLS, "_algorithm"):
            with self.subTest(call), self.assertRaisesRegex(TypeError, r"without __init__\(\)"):
                eval(f"tracker.{call}", names)
        tracker.__init__(algorithm="lk")
        self.assertEqual(repr(tracker), "<csdtrack.Tracker lk: 0 frames>")

    def test_a_tracker_made_before_a_fork_is_refused_in_the_child(self):
        program = f"""
import os, signal, sys, time
import numpy as np
import csdtrack

coarse = np.random.default_rng(1).integers(0, 255, (20, 30)).astype(np.uint8)
frame = np.kron(coarse, np.ones((8, 8), np.uint8))
old, kept = (csdtrack.Tracker(algorithm="csd-2012", learning="sync", points=[[80, 60]])
             for _ in range(2))
for _ in range(20):
    old.process(frame)
time.sleep(0.5)  # docs/python.md: OpenCV's threads may hold a lock until they sleep
if child := os.fork():
    ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    sys.exit(ended or len(old.process(frame)) - 1)
signal.alarm(60)  # ends what hangs
for call in {self.CALLS}:
    try:
        print(call, eval("old." + call))
    except RuntimeError as error:
        print(error)
del old
print(len(csdtrack.Tracker(points=[[80, 60]]).process(frame)))
"""  # `kept` is deleted at the child's end
        # Python 3.12 itself warns of a fork in a process with threads.
        done = subprocess.run([sys.executable, "-W", "ignore:This process:DeprecationWarning", "-c",
                               program],
                              capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        *errors, anew = done.stdout.splitlines()
        self.assertEqual(len(errors), len(self.CALLS))
        for error in errors:
            self.assertRegex(error, r"made before os\.fork\(\).*make one here")
        self.assertEqual(anew, "1")


class Interface(harness.Case):
    """Names, ranges and defaults are the element's, and the type stub has them too."""

    def test_defaults_and_ranges_are_the_elements(self):
        element = Gst.ElementFactory.make("csdtrack")
        specs = {spec.name.replace("-", "_"): spec for spec in element.list_properties()}
        ours = keywords()
        self.assertEqual(set(ours) - set(specs), {"order"})
        # attach-analytics is there only where it is built. The module's points and region are
        # arrays themselves.
        own = {n for n in specs if specs[n].owner_type == element.__gtype__}
        self.assertEqual(own - set(ours) - {"attach_analytics", "points_array", "region_array"},
                         {"overlay", "attach_meta", "attach_roi", "post_messages",
                          "message_interval", "on_error", "navigation", "stats"})
        for name, default in ours.items():
            if name == "order":
                continue
            with self.subTest(name):
                value = element.get_property(name.replace("_", "-"))
                if default is None:
                    self.assertEqual(value, "")
                else:
                    self.assertEqual(default, getattr(value, "value_nick", value))
                if isinstance(default, int) and not isinstance(default, bool):
                    most = specs[name].maximum
                    if name not in ("n_threads",):  # it would start as many threads
                        csdtrack.Tracker(**{name: most})
                    with self.assertRaisesRegex(ValueError, name):
                        csdtrack.Tracker(**{name: most + 1})
                    with self.assertRaisesRegex(ValueError, name):
                        csdtrack.Tracker(**{name: -1})
        self.assertEqual(csdtrack.ALGORITHMS, tuple(
            v.value_nick for v in type(element.props.algorithm).__enum_values__.values()))

    def test_the_stub_has_the_modules_defaults(self):
        theirs = inspect.signature(csdtrack.Tracker).parameters
        self.assertEqual({name: parameter.default for name, parameter in theirs.items()},
                         keywords())

    def test_stubtest(self):
        if subprocess.run([sys.executable, "-c", "import mypy"], capture_output=True).returncode:
            raise unittest.SkipTest("mypy is not installed")
        (self.tmp / "allowed").write_text("csdtrack.Tracker\n")  # its metaclass is pybind11's
        done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "csdtrack",
                               "--ignore-missing-stub", "--allowlist", "allowed"],
                              cwd=self.tmp, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    harness.main()
