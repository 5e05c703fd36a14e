# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes the animation at the top of README."""

import argparse
import collections
import json
import os
import pathlib
import subprocess
import tempfile
import typing
from collections.abc import Iterator, Sequence

import cv2
import numpy

from pipelines.experiments import builds
from pipelines.experiments.truth import CLAIMS
from pipelines.lib.failure import Failure

# GStreamer must know the build's own registry before it starts.
os.environ.update(builds.environment())
from tests.bench.playing import Gst, play, refuse  # noqa: E402

OUT = builds.ROOT / "docs" / "animation.webp"
SCENE = 'effects="tools=1,heart-strong=.6,specular=.3,sway=.3" style=heart seed=5'
WIDTH, HEIGHT = 640, 480
FIRST, LAST, STEP = 58, 130, 2  # a tool comes in, covers points, and leaves them again
TRAIL = 12  # frames, half a second
COLOURS = {  # those of the overlay, in BGR
    "learning": (66, 228, 240), "tracked": (233, 180, 86), "occluded": (0, 159, 230),
}
BITS = 4  # OpenCV's coordinates have this many of a pixel's fraction

Feature = dict[str, typing.Any]  # of a JSON line
Frame = dict[int, Feature]  # by id


def track(folder: pathlib.Path) -> tuple[typing.Any, list[Frame]]:
    """Simulates and tracks the scene. Returns the frames' pixels and their features."""
    pixels, lines = folder / "pixels", folder / "tracks.jsonl"
    play(f"csdsimsrc {SCENE} num-buffers={LAST} ! "
         f"video/x-raw,format=BGR,width={WIDTH},height={HEIGHT} ! csdtrack max-features=40 ! "
         f'tee name=t t. ! queue ! filesink location="{pixels}" '
         f't. ! queue ! csdtrackenc ! filesink location="{lines}" async=false', 300)
    features = [json.loads(line)["features"] for line in lines.read_text().splitlines()]
    video = numpy.fromfile(pixels, numpy.uint8).reshape(-1, HEIGHT, WIDTH, 3)
    return video, [{feature["id"]: feature for feature in frame} for frame in features]


def place(feature: Feature) -> tuple[int, int]:
    return round(feature["x"] * 2**BITS), round(feature["y"] * 2**BITS)


def trails(frames: Sequence[Frame]) -> Iterator[tuple[Feature, Feature]]:
    """The steps of each point that the last frame has, where both ends are claimed."""
    for before, after in zip(frames, frames[1:]):
        for number in frames[-1].keys() & before.keys() & after.keys():
            ends = before[number], after[number]
            if all(end["state"] in CLAIMS for end in ends):
                yield ends


def draw_marker(image: typing.Any, feature: Feature) -> None:
    """A circle for a claim, a square for a hidden point, each on a dark rim."""
    colour = COLOURS.get(feature["state"])
    if not colour:
        return
    x, y = place(feature)
    for ink, thickness in (((0, 0, 0), 4), (colour, 2)):
        if feature["state"] in CLAIMS:
            cv2.circle(image, (x, y), 8 << BITS, ink, thickness, cv2.LINE_AA, BITS)
        else:
            half = 7 << BITS
            cv2.rectangle(image, (x - half, y - half), (x + half, y + half), ink, thickness,
                          cv2.LINE_AA, BITS)


def draw(image: typing.Any, frames: Sequence[Frame]) -> None:
    """Draws the features of the last frame, with their way through the frames before."""
    for ink, thickness in (((0, 0, 0), 4), (COLOURS["tracked"], 2)):
        for begin, end in trails(frames):
            cv2.line(image, place(begin), place(end), ink, thickness, cv2.LINE_AA, BITS)
    for feature in frames[-1].values():
        draw_marker(image, feature)


def make(out: pathlib.Path) -> None:
    """Raises Failure if ffmpeg can't write the file."""
    with tempfile.TemporaryDirectory() as folder:
        video, features = track(pathlib.Path(folder))
    pictures = []
    past: collections.deque[Frame] = collections.deque(maxlen=TRAIL + 1)
    for i, (image, frame) in enumerate(zip(video, features)):
        past.append(frame)
        if i >= FIRST and (i - FIRST) % STEP == 0:
            draw(image, list(past))
            pictures.append(image.tobytes())
    done = subprocess.run([
        "ffmpeg", "-v", "error", "-y", "-f", "rawvideo", "-pix_fmt", "bgr24", "-s",
        f"{WIDTH}x{HEIGHT}", "-r", str(25 / STEP), "-i", "-", "-c:v", "libwebp_anim", "-quality",
        "48", "-loop", "0", out
    ], input=b"".join(pictures), stderr=subprocess.PIPE)
    if done.returncode:
        raise Failure(f"{out}: {done.stderr.decode(errors='replace').strip()}")
    print(f"{out}: {len(pictures)} pictures, {out.stat().st_size} bytes")


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="tests/bench/animation", description="Makes the animation at the top of README: "
        "simulated tissue that beats, a tool, and the points that csd tracks, each with its way "
        "of the last half second. Needs ffmpeg with libwebp.")
    parser.add_argument("out", type=pathlib.Path, nargs="?", default=OUT, metavar="OUT.webp",
                        help="(docs/animation.webp)")
    out = parser.parse_args().out
    try:
        builds.make(install=False, targets=["plugin"], commands=["ffmpeg"])
        Gst.init(None)  # reads the plugin that was just built
        make(out)
    except Failure as failure:
        refuse(failure)


if __name__ == "__main__":
    main()
