#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays VIDEO ! ELEMENTS ! appsink and prints the tracks of each frame.

It reads them with GStreamer's bindings only.

    read_meta.py 'filesrc location=in.mp4 ! decodebin ! csdtrack'
"""

import sys
import typing

import gi

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402


def fields(structure: Gst.Structure) -> dict[str, typing.Any]:
    names = map(structure.nth_field_name, range(structure.n_fields()))
    return {name: structure.get_value(name) for name in names}


def tracks(buffer: Gst.Buffer, name: str = "GstCsdTrackMeta") -> dict[str, typing.Any] | None:
    """The fields of the first meta with this name, its features as dicts; None without a meta."""
    meta = buffer.get_custom_meta(name)
    if meta is None:
        return None
    found = fields(meta.get_structure())
    found["features"] = [fields(feature) for feature in found["features"]]
    return found


def main() -> None:
    Gst.init(None)
    pipeline = Gst.parse_launch(sys.argv[1] + " ! appsink name=sink sync=false")
    sink = pipeline.get_by_name("sink")
    pipeline.set_state(Gst.State.PLAYING)
    while (sample := sink.emit("pull-sample")) is not None:
        print(tracks(sample.get_buffer()))
    pipeline.set_state(Gst.State.NULL)


if __name__ == "__main__":
    main()
