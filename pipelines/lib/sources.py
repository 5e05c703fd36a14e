# SPDX-License-Identifier: LGPL-2.1-or-later
"""The video sources that pipelines/live, record and the like take."""

import os
import pathlib
import stat

from pipelines.lib import command

HELP = """
SOURCE is one of

  /dev/videoN                    a camera or capture card of Video4Linux
  decklink, decklink:N           a DeckLink card (the first, or number N from 0)
  rtsp://…, srt://…, http://…    a stream, anything that GStreamer's uridecodebin plays
  FILE                           a video file; of several pictures in it the largest counts
  simulate, simulate:SCENARIO    simulated tissue (mixed; docs/simulator.md)
  test:UYVY, test:v210           a test picture as a capture card gives it, 1920×1080
"""


def launch(source: str) -> str:
    """The beginning of a pipeline's description, up to raw video.

    Raises Misuse for a source that no machine can have, and Failure for one that is missing here.
    """
    kind, _, rest = source.partition(":")
    # Also /dev/fd/63, which bash makes of <(…).
    if os.path.exists(source) and stat.S_ISFIFO(os.stat(source).st_mode):
        raise command.Failure(f"'{source}' {command.NOT_A_FILE}")
    if source.startswith("/dev/"):
        if not os.path.exists(source):
            devices = sorted(str(path) for path in pathlib.Path("/dev").glob("video*"))
            raise command.Failure(f"there is no device {source}: " + (
                f"there are {', '.join(devices)}" if devices else "no camera is connected"))
        if not stat.S_ISCHR(os.stat(source).st_mode):
            raise command.Failure(f"{source} is no camera")
        return f"v4l2src device={command.quoted(source)} ! decodebin"
    if kind == "decklink":
        if rest and not rest.isdecimal():
            raise command.Misuse(f"decklink:{rest}: give the card's number, from 0")
        return f"decklinkvideosrc device-number={rest or 0}"
    if kind == "simulate":
        from pipelines.lib import properties  # loads GStreamer, which only this source needs here
        scenarios = properties.choices(properties.Gst.ElementFactory.make("csdsimsrc"), "scenario")
        if (rest or "mixed") not in scenarios:
            raise command.Misuse(
                f"there is no simulate:{rest}: the scenarios are {', '.join(scenarios)}")
        return (f"csdsimsrc is-live=true scenario={rest or 'mixed'} ! "
                "video/x-raw,width=640,height=480,framerate=25/1")
    if kind == "test":
        if rest not in ("UYVY", "v210"):
            raise command.Misuse(f"there is no test:{rest}: test:UYVY or test:v210")
        return ("videotestsrc is-live=true pattern=smpte horizontal-speed=2 ! "
                f"video/x-raw,format={rest},width=1920,height=1080,framerate=25/1")
    if "://" in source:
        return f"uridecodebin uri={command.quoted(source)} caps=video/x-raw"
    if os.path.isdir(source):
        raise command.Failure(f"'{source}' is a folder: give a video file")
    if not os.path.isfile(source):
        raise command.Failure(f"there is no file '{source}', and it is no source: see --help")
    return f"filesrc location={command.quoted(source)} ! decodebin"
