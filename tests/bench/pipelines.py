#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Measures what csdtrack costs whole pipelines: a 720p recording, a live 720p source, the element
by itself, and stopping.

usage: tests/bench/pipelines.py [--quick | --end | --large]

  --quick   a few frames each
  --end     only how long a pipeline takes to stop while learners are busy
  --large   only 2160 lines, tracked at full size and by a small copy

Nothing is asserted. The picture is a swaying coloured texture; one recording is of
cholecystectomy.mp4 in $CSDTRACK_CLIPS. Frames are made before anything is timed, and pushed by
reference.
"""

import os
import pathlib
import statistics
import sys
import time
import typing
from collections.abc import Mapping, Sequence

import cv2
import gi
import numpy as np

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402

WIDTH, HEIGHT, RATE = 1280, 720, 30
CAPS = f"video/x-raw,format=I420,width={WIDTH},height={HEIGHT},framerate={RATE}/1,colorimetry=bt709"
SOURCE = f"appsrc name=in format=time block=true max-buffers=4 caps={CAPS}"
QUEUE = "queue max-size-buffers=8 max-size-bytes=0 max-size-time=0"
ENCODER = "x264enc speed-preset=veryfast key-int-max=60"

Frames = Sequence[Gst.Buffer]


def i420(picture: typing.Any) -> Gst.Buffer:
    return Gst.Buffer.new_wrapped(cv2.cvtColor(picture, cv2.COLOR_BGR2YUV_I420).tobytes())


def make_frames(count: int = 32, height: int | None = None) -> list[Gst.Buffer]:
    """I420 frames of a texture that sways by some pixels, scaled to `height` lines.

    It has the contrast of tissue: a standard deviation of about 16.
    """
    random = np.random.default_rng(5)
    noise = random.normal(size=(HEIGHT + 80, WIDTH + 80, 3)).astype(np.float32)
    fine, coarse = (cv2.GaussianBlur(noise, (0, 0), sigma) for sigma in (3, 9))
    texture = 120 * fine + 250 * coarse + (90, 100, 150)
    frames = []
    for i in range(count):
        phase = 2 * np.pi * i / count
        shift = np.array([[1, 0, -40 + 8 * np.sin(phase)], [0, 1, -40 + 5 * np.cos(phase)]],
                         np.float32)
        moved = cv2.warpAffine(texture, shift, (WIDTH, HEIGHT))
        moved = moved + random.normal(scale=2, size=(HEIGHT, WIDTH, 3))
        picture = np.clip(moved, 0, 255).astype(np.uint8)
        if height:
            interpolation = cv2.INTER_AREA if height < HEIGHT else cv2.INTER_CUBIC
            picture = cv2.resize(picture, (height * WIDTH // HEIGHT, height),
                                 interpolation=interpolation)
        frames.append(i420(picture))
    return frames


def clip_frames() -> list[Gst.Buffer]:
    """I420 frames of a real operation, forward and then backward; none without the clip."""
    file = pathlib.Path(os.environ.get("CSDTRACK_CLIPS", "/nowhere")) / "cholecystectomy.mp4"
    if not file.exists():
        return []
    video = cv2.VideoCapture(str(file))
    frames: list[Gst.Buffer] = []
    while True:
        there, picture = video.read()
        if not there:
            return frames + frames[-2:0:-1]
        frames.append(i420(picture))


def stamped(frames: Frames, i: int) -> Gst.Buffer:
    buffer = frames[i % len(frames)].copy()  # the memory is shared
    buffer.pts = i * Gst.SECOND // RATE
    buffer.duration = Gst.SECOND // RATE
    return buffer


def wait(pipeline: Gst.Pipeline) -> None:
    message = pipeline.get_bus().timed_pop_filtered(600 * Gst.SECOND,
                                                    Gst.MessageType.EOS | Gst.MessageType.ERROR)
    if message is None:
        sys.exit("no end within ten minutes")
    if message.type == Gst.MessageType.ERROR:
        sys.exit(message.parse_error()[0].message)


def push(source: Gst.Element, frames: Frames, count: int) -> None:
    for i in range(count):
        source.emit("push-buffer", stamped(frames, i))
    source.emit("end-of-stream")


def record(frames: Frames, element: str, count: int) -> float:
    """Frames a second through [element !] x264enc, as fast as they go."""
    pipeline = Gst.parse_launch(f"{SOURCE} ! {element} {QUEUE} ! {ENCODER} ! fakesink")
    source = pipeline.get_by_name("in")
    pipeline.set_state(Gst.State.PLAYING)
    start = time.monotonic()
    push(source, frames, count)
    wait(pipeline)
    seconds = time.monotonic() - start
    pipeline.set_state(Gst.State.NULL)
    return count / seconds


def live(frames: Frames, element: str, seconds: int) -> tuple[int, int]:
    """How many frames a live source made, and how many it dropped.

    It drops frames that the pipeline does not take in time; two may wait.
    """
    pipeline = Gst.parse_launch(
        "appsrc name=in format=time is-live=true leaky-type=downstream max-buffers=2 max-bytes=0 "
        f"caps={CAPS} ! {element} {QUEUE} ! {ENCODER} tune=zerolatency ! "
        "fakesink name=out sync=false")
    source = pipeline.get_by_name("in")
    passed = 0

    def count(_pad: Gst.Pad, _info: Gst.PadProbeInfo) -> Gst.PadProbeReturn:
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


def element_cost(frames: Frames, properties: str, count: int) -> list[float]:
    """p50 and p95 of csdtrack's own time a frame in ms, from its stats.

    The source is faster than csdtrack.
    """
    pipeline = Gst.parse_launch(f"{SOURCE} ! csdtrack name=t {properties} ! fakesink")
    source, track = pipeline.get_by_name("in"), pipeline.get_by_name("t")
    pipeline.set_state(Gst.State.PLAYING)
    push(source, frames, count)
    wait(pipeline)
    stats = track.get_property("stats")
    pipeline.set_state(Gst.State.NULL)
    return [stats.get_value(name) / 1e6 for name in ("time-p50", "time-p95")]


def times_to_stop(frames: Frames, properties: str, rounds: int) -> tuple[list[float], list[int]]:
    """Milliseconds from PLAYING to NULL, each time while learning jobs wait; and the number of
    waiting jobs."""
    times, waiting = [], []
    for _ in range(rounds):
        pipeline = Gst.parse_launch(
            f"appsrc name=in format=time block=true max-buffers=2 caps={CAPS} ! "
            f"csdtrack name=t {properties} ! fakesink")
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


def end(frames: Frames, rounds: int) -> None:
    print("end: milliseconds from PLAYING to NULL while learners are busy, "
          f"{WIDTH}x{HEIGHT}, {rounds} times: p50 / p99 / most")
    for properties in ("algorithm=csd max-features=1000", "algorithm=csd-2012 max-features=200",
                       "algorithm=csd-2012 max-features=200 n-threads=4"):
        times, waiting = times_to_stop(frames, properties, rounds)
        p50, p99 = np.percentile(times, (50, 99))
        print(f"  {properties:50} {p50:6.1f} / {p99:6.1f} / {max(times):6.1f}, "
              f"{min(waiting)} jobs and more waited")


def processor_time(text: str, sources: Mapping[str, Frames], count: int) -> float:
    """Processor time a frame of all threads in ms, without that of making the frames.

    sources: the frames of each appsrc, by its name.
    """
    pipeline = Gst.parse_launch(text)
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


def large(count: int, rounds: int) -> None:
    """What remains for the processor where a GPU holds the frames and scales them.

    Memory that is not touched costs the same as system memory.
    """
    heights = {"large": 2160, "small": 540}
    frames = {name: make_frames(16, height) for name, height in heights.items()}

    def source(name: str) -> str:
        height = heights[name]
        return (f"appsrc name={name} format=time block=true max-buffers=4 max-bytes=0 "
                f"caps=video/x-raw,format=I420,width={height * WIDTH // HEIGHT},height={height},"
                f"framerate={RATE}/1")

    ways = {
        "csdtrack on 2160 lines": (f"{source('large')} ! csdtrack ! fakesink", ["large"]),
        "csdtrack on 540 lines": (f"{source('small')} ! csdtrack ! fakesink", ["small"]),
        "the same ! csdtrackenc ! csdtrackdec": (
            f"{source('large')} ! csdtrackdec name=r ! fakesink "
            f"{source('small')} ! csdtrack ! csdtrackenc ! application/x-ndjson ! r.text",
            ["large", "small"]),
    }
    spent: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, (text, needs) in ways.items():
            spent[name].append(processor_time(text, {need: frames[need] for need in needs}, count))
    print(f"large: processor time a frame, ms, {count} frames, in alternation, medians of {rounds}")
    for name, values in spent.items():
        print(f"  {name:38} {statistics.median(values):7.2f}")


def recordings(frames: Frames, elements: Mapping[str, str], count: int, rounds: int) -> None:
    for what, pictures in (("I420", frames), ("cholecystectomy.mp4", clip_frames())):
        if not pictures:
            print(f"record: no {what} in $CSDTRACK_CLIPS")
            continue
        print(f"record: {WIDTH}x{HEIGHT} {what} ! x264enc speed-preset=veryfast, {count} frames, "
              f"in alternation, medians of {rounds}")
        rates: dict[str, list[float]] = {name: [] for name in elements}
        for _ in range(rounds):
            for name, element in elements.items():
                rates[name].append(record(pictures, element, count))
        for name, values in rates.items():
            kept = statistics.median(r / b for r, b in zip(values, rates["without csdtrack"]))
            print(f"  {name:30} {statistics.median(values):7.1f} fps  {100 * kept:5.1f} % kept")


def main() -> int:
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
    recordings(frames, elements, count, rounds)
    print(f"live: {WIDTH}x{HEIGHT} I420 at {RATE} fps ! "
          f"x264enc speed-preset=veryfast tune=zerolatency, {seconds} s")
    for name, element in elements.items():
        made, dropped = live(frames, element, seconds)
        print(f"  {name:30} {dropped:4} of {made} frames dropped at the source")

    print("element: csdtrack's own time a frame, ms p50 / p95, algorithm=lk, 100 features "
          "(the rest is what is switched on)")
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
