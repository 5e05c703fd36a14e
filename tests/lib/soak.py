#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays each clip through csdtrack again and again in one process; memory must not grow: soak.py CLIPS SECONDS"""

import pathlib
import sys
import time

import gi

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402


def resident():
    """MiB."""
    for line in open("/proc/self/status"):
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    raise RuntimeError("no VmRSS")


def play(clip):
    pipeline = Gst.parse_launch("filesrc name=f ! decodebin ! csdtrack overlay=draw ! csdtrackenc ! fakesink sync=false")
    pipeline.get_by_name("f").set_property("location", str(clip))
    pipeline.set_state(Gst.State.PLAYING)
    message = pipeline.get_bus().timed_pop_filtered(600 * Gst.SECOND, Gst.MessageType.EOS | Gst.MessageType.ERROR)
    pipeline.set_state(Gst.State.NULL)
    if message is None or message.type == Gst.MessageType.ERROR:
        raise SystemExit(f"error: {clip}: {message.parse_error() if message else 'hangs'}")


Gst.init(None)
clips = sorted(c for c in pathlib.Path(sys.argv[1]).iterdir() if c.suffix in (".mkv", ".mp4"))
if not clips:
    raise SystemExit(f"error: no clips in {sys.argv[1]}")
end = time.monotonic() + float(sys.argv[2])
rounds = []
while time.monotonic() < end or len(rounds) < 4:
    for clip in clips:
        play(clip)
    rounds.append(resident())
    print(f"round {len(rounds)}: {rounds[-1]:.0f} MiB", flush=True)
# The first two rounds fill caches and pools; from then on the last may not need a tenth more.
if rounds[-1] > rounds[1] * 1.1 + 16:
    raise SystemExit(f"error: memory grew from {rounds[1]:.0f} to {rounds[-1]:.0f} MiB in {len(rounds)} rounds")
