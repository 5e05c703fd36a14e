# SPDX-License-Identifier: LGPL-2.1-or-later
"""Where the picture of pipelines/live, record and the like comes from."""

import os
import pathlib
import stat

from pipelines.lib import command

LISTED = """
SOURCE is one of

  /dev/videoN                    a camera or capture card of Video4Linux
  decklink, decklink:N           a DeckLink card (the first, or number N from 0)
  rtsp://…, srt://…, http://…    a stream, anything that GStreamer's uridecodebin plays
  FILE                           a video file
  simulate, simulate:SCENARIO    simulated tissue (mixed; docs/simulator.md)
  test:UYVY, test:v210           a test picture as a capture card gives it, 1920×1080
"""


def begin(text):
    """The begin of the pipeline, up to raw video. Raises command.Failure, and command.Misuse of what is no source anywhere."""
    kind, _, rest = text.partition(":")
    # also /dev/fd/63, as bash calls <(…)
    if os.path.exists(text) and stat.S_ISFIFO(os.stat(text).st_mode):
        raise command.Failure(f"'{text}' {command.PIPE}")
    if text.startswith("/dev/"):
        if not os.path.exists(text):
            there = sorted(str(p) for p in pathlib.Path("/dev").glob("video*"))
            raise command.Failure(f"there is no device {text}: " + (
                f"there are {', '.join(there)}" if there else "no camera is connected"))
        if not stat.S_ISCHR(os.stat(text).st_mode):
            raise command.Failure(f"{text} is no camera")
        return f"v4l2src device={command.quoted(text)} ! decodebin"
    if kind == "decklink":
        if rest and not rest.isdecimal():
            raise command.Misuse(f"decklink:{rest}: give the card's number, from 0")
        return f"decklinkvideosrc device-number={rest or 0}"
    if kind == "simulate":
        from pipelines.lib import properties  # GStreamer, which no other source needs here
        scenarios = properties.choices(properties.Gst.ElementFactory.make("csdsimsrc"), "scenario")
        if (rest or "mixed") not in scenarios:
            raise command.Misuse(
                f"there is no simulate:{rest}: the scenarios are {', '.join(scenarios)}")
        return f"csdsimsrc is-live=true scenario={rest or 'mixed'} ! video/x-raw,width=640,height=480,framerate=25/1"
    if kind == "test":
        if rest not in ("UYVY", "v210"):
            raise command.Misuse(f"there is no test:{rest}: test:UYVY or test:v210")
        return f"videotestsrc is-live=true pattern=smpte horizontal-speed=2 ! video/x-raw,format={rest},width=1920,height=1080,framerate=25/1"
    if "://" in text:
        return f"uridecodebin uri={command.quoted(text)} caps=video/x-raw"
    if os.path.isdir(text):
        raise command.Failure(f"'{text}' is a folder: give a video file")
    if not os.path.isfile(text):
        raise command.Failure(f"there is no file '{text}', and it is no source: see --help")
    return f"filesrc location={command.quoted(text)} ! decodebin"
