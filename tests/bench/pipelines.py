#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""What csdtrack costs whole pipelines: a 720p recording, a live 720p source, the parts a frame passes, and the end.

usage: tests/bench/pipelines.py [--quick | --end | --large]    --end: how long a pipeline takes to stop while learners are busy, alone
                                                               --large: 2160 lines, tracked as they are and by a small copy, alone

Nothing is asserted. The picture is a coloured texture that sways, and one recording is of cholecystectomy.mp4 in $CSDTRACK_CLIPS; frames are made before anything is timed and pushed
by reference.
"""
import os
import pathlib
import statistics
import sys
import time

import gi

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402

import cv2  # noqa: E402
import numpy as np  # noqa: E402

WIDTH, HEIGHT, RATE = 1280, 720, 30
CAPS = f"video/x-raw,format=I420,width={WIDTH},height={HEIGHT},framerate={RATE}/1,colorimetry=bt709"
ENCODER = "x264enc speed-preset=veryfast key-int-max=60"


def make_frames(count=32, height=None):
    """I420 frames of a texture with the contrast of tissue (standard deviation about 16), swaying by some pixels; scaled to `height` lines."""
    random = np.random.default_rng(5)
    noise = random.normal(size=(HEIGHT + 80, WIDTH + 80, 3)).astype(np.float32)
    texture = 120 * cv2.GaussianBlur(noise,
                                     (0, 0), 3) + 250 * cv2.GaussianBlur(noise,
                                                                         (0, 0), 9) + (90, 100, 150)
    frames = []
    for i in range(count):
        phase = 2 * np.pi * i / count
        shift = np.float32([[1, 0, -40 + 8 * np.sin(phase)], [0, 1, -40 + 5 * np.cos(phase)]])
        moved = cv2.warpAffine(texture, shift,
                               (WIDTH, HEIGHT)) + random.normal(scale=2, size=(HEIGHT, WIDTH, 3))
        picture = np.clip(moved, 0, 255).astype(np.uint8)
        if height:
            picture = cv2.resize(
                picture, (height * WIDTH // HEIGHT, height),
                interpolation=cv2.INTER_AREA if height < HEIGHT else cv2.INTER_CUBIC)
        frames.append(
            Gst.Buffer.new_wrapped(cv2.cvtColor(picture, cv2.COLOR_BGR2YUV_I420).tobytes()))
    return frames


def clip_frames():
    """I420 frames of a real operation, there and back; none where the clip is not."""
    file = pathlib.Path(os.environ.get("CSDTRACK_CLIPS", "/nowhere")) / "cholecystectomy.mp4"
    video, frames = cv2.VideoCapture(str(file)) if file.exists() else None, []
    while video:
        there, bgr = video.read()
        if not there:
            break
        frames.append(Gst.Buffer.new_wrapped(cv2.cvtColor(bgr, cv2.COLOR_BGR2YUV_I420).tobytes()))
    return frames + frames[-2:0:-1]


def stamped(frames, i):
    buffer = frames[i % len(frames)].copy()  # the memory is shared
    buffer.pts = i * Gst.SECOND // RATE
    buffer.duration = Gst.SECOND // RATE
    return buffer


def wait(pipeline):
    message = pipeline.get_bus().timed_pop_filtered(600 * Gst.SECOND,
                                                    Gst.MessageType.EOS | Gst.MessageType.ERROR)
    if message is None or message.type == Gst.MessageType.ERROR:
        raise SystemExit(
            message.parse_error()[0].message if message else "no end within ten minutes")


def record(frames, element, count):
    """Frames a second of `count` frames through [element !] x264enc, as fast as they go."""
    pipeline = Gst.parse_launch(
        f"appsrc name=in format=time block=true max-buffers=4 caps={CAPS} ! {element} "
        f"queue max-size-buffers=8 max-size-bytes=0 max-size-time=0 ! {ENCODER} ! fakesink")
    source = pipeline.get_by_name("in")
    pipeline.set_state(Gst.State.PLAYING)
    start = time.monotonic()
    for i in range(count):
        source.emit("push-buffer", stamped(frames, i))
    source.emit("end-of-stream")
    wait(pipeline)
    seconds = time.monotonic() - start
    pipeline.set_state(Gst.State.NULL)
    return count / seconds


def live(frames, element, seconds):
    """Of a live source: frames made, and frames it had to drop because nobody took them in time (2 may wait)."""
    pipeline = Gst.parse_launch(
        f"appsrc name=in format=time is-live=true leaky-type=downstream max-buffers=2 max-bytes=0 caps={CAPS} ! "
        f"{element} queue max-size-buffers=8 max-size-bytes=0 max-size-time=0 ! {ENCODER} tune=zerolatency ! "
        "fakesink name=out sync=false")
    source = pipeline.get_by_name("in")
    passed = 0

    def count(_pad, _info):
        nonlocal passed
        passed += 1
        return Gst.PadProbeReturn.OK

    source.get_static_pad("src").add_probe(Gst.PadProbeType.BUFFER, count)
    pipeline.set_state(Gst.State.PLAYING)
    start, made = time.monotonic(), 0
    while made < seconds * RATE:
        source.emit("push-buffer", stamped(frames, made))
        made += 1
        time.sleep(max(0.0, start + made / RATE - time.monotonic()))
    source.emit("end-of-stream")
    wait(pipeline)
    pipeline.set_state(Gst.State.NULL)
    return made, made - passed


def element_cost(frames, properties, count):
    """p50 and p95 of csdtrack's own time a frame, ms, from its stats; the source is not the limit."""
    pipeline = Gst.parse_launch(
        f"appsrc name=in format=time block=true max-buffers=4 caps={CAPS} ! csdtrack name=t {properties} ! "
        "fakesink")
    source, track = pipeline.get_by_name("in"), pipeline.get_by_name("t")
    pipeline.set_state(Gst.State.PLAYING)
    for i in range(count):
        source.emit("push-buffer", stamped(frames, i))
    source.emit("end-of-stream")
    wait(pipeline)
    stats = track.get_property("stats")
    pipeline.set_state(Gst.State.NULL)
    return [stats.get_value(name) / 1e6 for name in ("time-p50", "time-p95")]


def times_to_stop(frames, properties, rounds):
    """Milliseconds from PLAYING to NULL, each time while learning jobs wait, and by how many jobs that was."""
    times, waiting = [], []
    for _ in range(rounds):
        pipeline = Gst.parse_launch(
            f"appsrc name=in format=time block=true max-buffers=2 caps={CAPS} ! csdtrack name=t {properties} ! fakesink"
        )
        source, track = pipeline.get_by_name("in"), pipeline.get_by_name("t")
        pipeline.set_state(Gst.State.PLAYING)
        jobs, i = 0, 0
        while jobs == 0 and i < 100:
            source.emit("push-buffer", stamped(frames, i))
            jobs, i = track.get_property("stats").get_value("queue"), i + 1
        start = time.monotonic()
        pipeline.set_state(Gst.State.NULL)
        times.append(1000 * (time.monotonic() - start))
        waiting.append(jobs)
    return times, waiting


def end(frames, rounds):
    print(
        f"end: milliseconds from PLAYING to NULL while learners are busy, {WIDTH}x{HEIGHT}, {rounds} times: p50 / p99 / most"
    )
    for properties in ("algorithm=csd max-features=1000", "algorithm=csd-2012 max-features=200",
                       "algorithm=csd-2012 max-features=200 n-threads=4"):
        times, waiting = times_to_stop(frames, properties, rounds)
        p50, p99 = np.percentile(times, (50, 99))
        print(
            f"  {properties:50} {p50:6.1f} / {p99:6.1f} / {max(times):6.1f}, {min(waiting)} jobs and more waited"
        )


def processor_time(pipeline_text, sources, count):
    """Milliseconds of processor a frame, of all threads, without what makes the frames. `sources`: an appsrc's name and its frames."""
    pipeline = Gst.parse_launch(pipeline_text)
    inputs = [(pipeline.get_by_name(name), frames) for name, frames in sources.items()]
    pipeline.set_state(Gst.State.PLAYING)
    start = time.process_time()
    for i in range(count):
        for source, frames in inputs:
            source.emit("push-buffer", stamped(frames, i))
    for source, _ in inputs:
        source.emit("end-of-stream")
    wait(pipeline)
    spent = time.process_time() - start
    pipeline.set_state(Gst.State.NULL)
    return 1000 * spent / count


def large(count, rounds):
    """What is left for the processor where a GPU holds the frames and scales them: memory that is not touched costs what system memory does."""
    heights = {"large": 2160, "small": 540}
    frames = {name: make_frames(16, height) for name, height in heights.items()}

    def source(name):
        size = f"width={heights[name] * WIDTH // HEIGHT},height={heights[name]}"
        return f"appsrc name={name} format=time block=true max-buffers=4 max-bytes=0 caps=video/x-raw,format=I420,{size},framerate={RATE}/1"

    ways = {
        "csdtrack on 2160 lines": (f"{source('large')} ! csdtrack ! fakesink", ["large"]),
        "csdtrack on 540 lines": (f"{source('small')} ! csdtrack ! fakesink", ["small"]),
        "the same ! csdtrackenc ! csdtrackdec": (
            f"{source('large')} ! csdtrackdec name=r ! fakesink {source('small')} ! csdtrack ! csdtrackenc ! "
            "application/x-ndjson ! r.text", ["large", "small"]),
    }
    spent = {name: [] for name in ways}
    for _ in range(rounds):
        for name, (text, needs) in ways.items():
            spent[name].append(processor_time(text, {need: frames[need] for need in needs}, count))
    print(f"large: processor time a frame, ms, {count} frames, in alternation, medians of {rounds}")
    for name, values in spent.items():
        print(f"  {name:38} {statistics.median(values):7.2f}")


def main():
    if sys.argv[1:] not in ([], ["--quick"], ["--end"], ["--large"]):
        print(__doc__)
        return 0 if sys.argv[1:] == ["--help"] else 2
    quick = "--quick" in sys.argv
    Gst.init(None)
    frames = make_frames()
    if "--end" in sys.argv:
        end(frames, 200)
        return 0
    if "--large" in sys.argv:
        large(600, 5)
        return 0
    count, rounds, seconds = (30, 1, 1) if quick else (600, 5, 20)

    elements = {"without csdtrack": ""} | {
        f"csdtrack algorithm={name}": f"csdtrack algorithm={name} !"
        for name in ("csd", "csd-2012", "lk")
    }
    for what, pictures in (("I420", frames), ("cholecystectomy.mp4", clip_frames())):
        if not pictures:
            print(f"record: no {what} in $CSDTRACK_CLIPS")
            continue
        print(
            f"record: {WIDTH}x{HEIGHT} {what} ! x264enc speed-preset=veryfast, {count} frames, in alternation, medians of {rounds}"
        )
        rates = {name: [] for name in elements}
        for _ in range(rounds):
            for name, element in elements.items():
                rates[name].append(record(pictures, element, count))
        for name, values in rates.items():
            kept = statistics.median(r / b for r, b in zip(values, rates["without csdtrack"]))
            print(f"  {name:30} {statistics.median(values):7.1f} fps  {100 * kept:5.1f} % kept")
    print(
        f"live: {WIDTH}x{HEIGHT} I420 at {RATE} fps ! x264enc speed-preset=veryfast tune=zerolatency, {seconds} s"
    )
    for name, element in elements.items():
        made, dropped = live(frames, element, seconds)
        print(f"  {name:30} {dropped:4} of {made} frames dropped at the source")

    print(
        "element: csdtrack's own time a frame, ms p50 / p95, algorithm=lk, 100 features (the rest is what is switched on)"
    )
    base = "algorithm=lk max-features=100"
    for name, properties in (
            ("tracking alone", "attach-meta=false"),
            ("+ metadata", ""),
            ("+ metadata, a message a frame", "post-messages=frame"),
            ("+ metadata, overlay=draw", "overlay=draw")):
        p50, p95 = element_cost(frames, f"{base} {properties}", count)
        print(f"  {name:34} {p50:7.2f} / {p95:7.2f}")
    end(frames, 3 if quick else 200)
    large(*((30, 1) if quick else (600, 5)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
