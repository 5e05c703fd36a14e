# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pipelines of benchmarks, played to their end."""

import pathlib
import sys
import typing

import gi

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402


def refuse(message: object) -> typing.NoReturn:
    sys.exit(f"{pathlib.Path(sys.argv[0]).stem}: {message}")


def play(text: str, seconds: int) -> Gst.Structure:
    """Plays the pipeline to its end.

    Returns the stats of the csdtrack that is called `track`, None without one.
    """
    pipeline = Gst.parse_launch(text)
    pipeline.set_state(Gst.State.PLAYING)
    message = pipeline.get_bus().timed_pop_filtered(seconds * Gst.SECOND,
                                                    Gst.MessageType.EOS | Gst.MessageType.ERROR)
    stats = track.get_property("stats") if (track := pipeline.get_by_name("track")) else None
    pipeline.set_state(Gst.State.NULL)
    if not message:
        refuse(f"no end within {seconds} s: {text}")
    if message.type == Gst.MessageType.ERROR:
        refuse(message.parse_error()[0].message)
    return stats
