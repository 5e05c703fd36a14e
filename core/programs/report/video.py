# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page's video: makes one that browsers play, and reads when its frames are shown."""

import array
import errno
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
from collections.abc import Mapping, Sequence
from typing import Any

from report.messages import Progress, ReportError, memory_file

# Chromium, Firefox and Safari play these: 8 bits, 4:2:0.
PIXELS = ("yuv420p", "yuvj420p")
VIDEO = {"mp4": ("h264", "vp9", "av1"), "webm": ("vp8", "vp9", "av1")}
SOUND = {"mp4": ("aac", "mp3", "opus"), "webm": ("opus", "vorbis")}


def probe(path: pathlib.Path, *what: str) -> str:
    """ffprobe's output. Raises ReportError with ffprobe's message."""
    try:
        # file: otherwise a colon in the name makes a protocol of it.
        done = subprocess.run(["ffprobe", "-v", "error", *what, f"file:{path}"],
                              capture_output=True, text=True, errors="replace",
                              stdin=subprocess.DEVNULL)
    except FileNotFoundError:
        raise ReportError("there is no ffprobe: install ffmpeg") from None
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ["ffprobe failed"])[-1].split(": ")[-1]
        raise ReportError(f"'{path}' is no video that ffmpeg can read ({why}): give a video file")
    return done.stdout


def orientation_of(matrix: str) -> tuple[bool, int]:
    """Video.mirrored and Video.turn of ffprobe's text of a display matrix.

    It has a line `NUMBER: a b u` for x, and one for y: a point x, y is shown at ax + cy, bx + dy.
    """
    (a, b), (c, d) = ([int(word) for word in line.split()[1:3]]
                      for line in matrix.strip().splitlines()[:2])
    mirrored = a * d < b * c
    if mirrored:
        a, b = -a, -b
    return mirrored, round(math.degrees(math.atan2(b, a)) / 90) * 90 % 360


class Video:
    """A video file.

    width, height: as stored; mirrored: whether players mirror it, left to right, before they turn
    it by `turn` degrees clockwise; fps: mean.
    """

    def __init__(self, path: pathlib.Path) -> None:
        self.path = path
        about = json.loads(probe(path, "-show_streams", "-show_format", "-of", "json"))
        streams = [s for s in about.get("streams", ()) if s.get("codec_type") == "video"
                   and not s.get("disposition", {}).get("attached_pic")]
        if not streams or not streams[0].get("width"):
            raise ReportError(f"'{path}' has no video stream: give a file with a picture")
        stream = streams[0]
        self.index: int = stream["index"]
        self.codec, self.pixels = stream.get("codec_name", ""), stream.get("pix_fmt", "")
        self.width: int = stream["width"]
        self.height: int = stream["height"]
        matrices = [data["displaymatrix"] for data in stream.get("side_data_list", ())
                    if "displaymatrix" in data]
        self.mirrored, self.turn = orientation_of(matrices[0]) if matrices else (False, 0)
        over, _, under = stream.get("avg_frame_rate", "0/0").partition("/")
        self.fps = int(over) / int(under) if int(under or 0) else 0
        self.sound: list[str] = [
            s.get("codec_name", "") for s in about["streams"] if s.get("codec_type") == "audio"
        ]
        self.seconds = float(about["format"].get("duration", 0))
        self.start = max(0.0, float(about["format"].get("start_time", 0)))
        self.container = self._container(about["format"])

    def _container(self, about: Mapping[str, Any]) -> str:
        """mp4 or webm; "" for a container that not all browsers open."""
        formats = about["format_name"].split(",")
        if "mp4" in formats:
            return "" if about.get("tags", {}).get("major_brand", "").strip() == "qt" else "mp4"
        if "webm" in formats:
            with open(self.path, "rb") as file:
                return "webm" if b"webm" in file.read(64) else ""
        return ""

    @property
    def is_playable(self) -> bool:
        """Whether browsers play the file as it is. Not all of them mirror it."""
        return (not self.mirrored and self.pixels in PIXELS and bool(self.container) and
                self.codec in VIDEO[self.container] and
                all(sound in SOUND[self.container] for sound in self.sound))

    @property
    def begins_late(self) -> bool:
        return self.start > 1e-3

    def times(self) -> "array.array[float]":
        """When each frame is shown, s, ascending.

        As browsers do, this counts from the first sound or picture, and leaves out what the file's
        edit list cuts off.
        """
        times = [time for time, is_shown in self._packets() if is_shown]
        if not times:
            raise ReportError(f"'{self.path}' has no frames with times")
        return array.array("d", sorted(time - self.start for time in times))

    @property
    def is_cut(self) -> bool:
        """Whether an edit list cuts off frames at the beginning, and only there."""
        packets = self._packets()
        hidden = [time for time, is_shown in packets if not is_shown]
        shown = (time for time, is_shown in packets if is_shown)
        return bool(hidden) and max(hidden) < min(shown, default=0)

    def _packets(self) -> list[tuple[float, bool]]:
        """Of each packet the time, s, and whether its frame is shown."""
        lines = probe(self.path, "-select_streams", str(self.index), "-show_entries",
                      "packet=pts_time,flags", "-of", "csv=p=0").splitlines()
        words = [line.split(",") for line in lines]
        return [(float(time), "D" not in flags) for time, flags, *_ in words if time != "N/A"]


def interval_of(times: "array.array[float]") -> float:
    """The median time from a frame to the next, s."""
    return statistics.median(b - a for a, b in zip(times, times[1:])) if len(times) > 1 else 0.04


def prepare(video: Video, folder: pathlib.Path, wanted: bool) -> tuple[pathlib.Path,
                                                                       tuple[int, int]]:
    """Makes a file in `folder` that browsers play. `wanted`: show progress.

    Returns its path, and how many columns and rows were cut off to make their numbers even. Raises
    ReportError.
    """
    playable = video.is_playable
    container = video.container if playable else "mp4"
    path = folder / f"video.{container}"
    # Browsers don't agree about times that begin late, or an edit list that begins within a frame.
    # ffmpeg lets both begin with a frame, at 0.
    if playable and not video.begins_late and not video.is_cut:
        shutil.copyfile(video.path, path)
        return path, (0, 0)
    sound = ["-c:a", "copy" if all(s in SOUND[container] for s in video.sound) else "aac"]
    if playable or (not video.mirrored and video.pixels in PIXELS and
                    video.codec in VIDEO[container]):
        convert(video, path, ["-c:v", "copy", *sound], f"putting the video into {container}",
                wanted)
        return path, (0, 0)
    # A keyframe every other second lets a browser step backwards quickly. Each frame keeps its
    # time.
    encoder = [
        "-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-pix_fmt", "yuv420p", "-g", "50",
        "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0", "-fps_mode", "passthrough", "-enc_time_base",
        "-1"
    ]
    convert(video, path, [*encoder, *sound], "converting the video to H.264", True)
    if Video(path).begins_late:  # an AVI with B-frames
        late = path.rename(folder / "late.mp4")
        convert(Video(late), path, ["-c", "copy"], "putting the video into mp4", wanted)
        late.unlink()
    width, height = video.width, video.height
    if video.turn % 180:
        width, height = height, width
    return path, (width % 2, height % 2)


def convert(video: Video, path: pathlib.Path, codecs: Sequence[str], what: str,
            wanted: bool) -> None:
    """Runs ffmpeg. `what`: the progress's name. Raises ReportError, and OSError on a full disk."""
    command = [
        "ffmpeg", "-v", "error", "-nostdin", "-y", "-progress", "pipe:1", "-i",
        f"file:{video.path}", "-map", f"0:{video.index}", "-map", "0:a:0?", *codecs, "-movflags",
        "+faststart", f"file:{path}"
    ]
    with memory_file() as stderr:
        try:
            with Progress(what, wanted) as progress, subprocess.Popen(
                    command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=stderr,
                    text=True) as run:
                try:
                    assert run.stdout
                    for line in run.stdout:
                        name, _, value = line.partition("=")
                        is_time = name == "out_time_us" and value.strip().lstrip("-").isdigit()
                        if is_time and video.seconds:
                            progress.show(int(value) / 1e6 / video.seconds)
                    if run.wait() == 0:
                        progress.show(1)
                except BaseException:
                    run.kill()
                    raise
        except FileNotFoundError:
            raise ReportError("there is no ffmpeg, and this video has to be converted: "
                              "install ffmpeg") from None
        stderr.seek(0)
        messages = stderr.read().strip()
    if os.strerror(errno.ENOSPC) in messages:  # even so ffmpeg may exit with 0
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    if run.returncode:
        why = (messages.splitlines() or ["ffmpeg failed"])[-1]
        raise ReportError(f"'{video.path}' can't be converted ({why})")
