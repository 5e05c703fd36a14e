# SPDX-License-Identifier: LGPL-2.1-or-later
"""The video of a page: what a browser plays, and when its frames are shown."""

import array
import errno
import json
import os
import shutil
import statistics
import subprocess

import failure
from failure import Failure, Progress

# What Chromium, Firefox and Safari play: 8 bits, 4:2:0.
PIXELS = ("yuv420p", "yuvj420p")
VIDEO = {"mp4": ("h264", "vp9", "av1"), "webm": ("vp8", "vp9", "av1")}
SOUND = {"mp4": ("aac", "mp3", "opus"), "webm": ("opus", "vorbis")}


def probe(path, *what):
    """ffprobe's output, as text. Raises Failure with what ffprobe says."""
    try:
        # file: else a colon in the name makes a protocol of it.
        done = subprocess.run(["ffprobe", "-v", "error", *what, f"file:{path}"],
                              capture_output=True, text=True, errors="replace",
                              stdin=subprocess.DEVNULL)
    except FileNotFoundError:
        raise Failure("there is no ffprobe: install ffmpeg") from None
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ["ffprobe failed"])[-1].split(": ")[-1]
        raise Failure(f"'{path}' is no video that ffmpeg can read ({why}): give a video file")
    return done.stdout


class Video:
    """width, height: as stored; turn: degrees clockwise by which players turn it; fps: mean."""

    def __init__(self, path):
        self.path = path
        about = json.loads(probe(path, "-show_streams", "-show_format", "-of", "json"))
        streams = [s for s in about.get("streams", ()) if s.get("codec_type") == "video"
                   and not s.get("disposition", {}).get("attached_pic")]
        if not streams or not streams[0].get("width"):
            raise Failure(f"'{path}' has no video stream: give a file with a picture")
        stream = streams[0]
        self.index = stream["index"]
        self.codec, self.pixels = stream.get("codec_name", ""), stream.get("pix_fmt", "")
        self.width, self.height = stream["width"], stream["height"]
        self.turn = next((round(-float(data["rotation"])) % 360
                          for data in stream.get("side_data_list", ())
                          if "rotation" in data), 0)
        over, _, under = stream.get("avg_frame_rate", "0/0").partition("/")
        self.fps = int(over) / int(under) if int(under or 0) else 0
        self.sound = [
            s.get("codec_name", "") for s in about["streams"] if s.get("codec_type") == "audio"
        ]
        self.seconds = float(about["format"].get("duration", 0))
        self.start = max(0.0, float(about["format"].get("start_time", 0)))
        self.container = self._container(about["format"])

    def _container(self, about):
        """mp4, webm or "" for what browsers don't all open."""
        if "mp4" in about["format_name"].split(","):
            return "" if about.get("tags", {}).get("major_brand", "").strip() == "qt" else "mp4"
        if "webm" in about["format_name"].split(","):
            with open(self.path, "rb") as file:
                return "webm" if b"webm" in file.read(64) else ""
        return ""

    def times(self):
        """When each frame is shown, in seconds from the media timeline's 0, ascending. Browsers begin it with the first sound or picture."""
        text = probe(self.path, "-select_streams", str(self.index), "-show_entries",
                     "packet=pts_time", "-of", "csv=p=0")
        found = array.array(
            "d",
            (float(word) - self.start for word in text.replace(",", " ").split() if word != "N/A"))
        if not found:
            raise Failure(f"'{self.path}' has no frames with times")
        return array.array("d", sorted(found))


def interval_of(times):
    """The median time from a frame to the next, s."""
    return statistics.median(b - a for a, b in zip(times, times[1:])) if len(times) > 1 else 0.04


def prepare(video, folder, wanted):
    """Puts into `folder` what a browser plays. Returns its path and the columns and rows that were cut off to make their
    numbers even. Raises Failure."""
    plays = video.pixels in PIXELS
    if plays and video.container and video.codec in VIDEO[video.container] and all(
            s in SOUND[video.container] for s in video.sound):
        path = folder / f"video.{video.container}"
        shutil.copyfile(video.path, path)
        return path, (0, 0)
    path = folder / "video.mp4"
    cut = (0, 0)
    if plays and video.codec in VIDEO["mp4"]:
        how, what = ["-c:v", "copy"], "putting the video into mp4"
    else:
        width, height = (video.height, video.width) if video.turn % 180 else (video.width,
                                                                              video.height)
        cut = (width % 2, height % 2)
        # A keyframe every other second, to step backwards quickly. Each frame keeps its time.
        how = [
            "-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-pix_fmt", "yuv420p", "-g",
            "50", "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0", "-fps_mode", "passthrough",
            "-enc_time_base", "-1"
        ]
        what = "converting the video to H.264"
        wanted = True
    sound = ["-c:a", "copy" if all(s in SOUND["mp4"] for s in video.sound) else "aac"]
    command = [
        "ffmpeg", "-v", "error", "-nostdin", "-y", "-progress", "pipe:1", "-i",
        f"file:{video.path}", "-map", f"0:{video.index}", "-map", "0:a:0?", *how, *sound,
        "-movflags", "+faststart", f"file:{path}"
    ]
    log = failure.log()
    try:
        with Progress(what, wanted) as progress, subprocess.Popen(command, stdin=subprocess.DEVNULL,
                                                                  stdout=subprocess.PIPE,
                                                                  stderr=log, text=True) as run:
            try:
                for line in run.stdout:
                    name, _, value = line.partition("=")
                    if name == "out_time_us" and value.strip().lstrip(
                            "-").isdigit() and video.seconds:
                        progress.show(int(value) / 1e6 / video.seconds)
                if run.wait() == 0:
                    progress.show(1)
            except BaseException:
                run.kill()
                raise
    except FileNotFoundError:
        raise Failure(
            "there is no ffmpeg, and this video has to be converted: install ffmpeg") from None
    with log:
        log.seek(0)
        said = log.read().strip()
    if os.strerror(errno.ENOSPC) in said:  # ffmpeg may end with 0 even so
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    if run.returncode:
        why = (said.splitlines() or ["ffmpeg failed"])[-1]
        raise Failure(f"'{video.path}' can't be converted ({why})")
    return path, cut
