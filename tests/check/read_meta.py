#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plays VIDEO ! ELEMENTS ! appsink and prints the tracks of each frame, read with GStreamer's bindings only.

    read_meta.py 'filesrc location=in.mp4 ! decodebin ! csdtrack'
"""
import sys

import gi

gi.require_version("Gst", "1.0")
from gi.repository import Gst  # noqa: E402


def tracks(buffer, name="GstCsdTrackMeta"):
    """The header fields of the first meta called `name` and its features as a list of dicts; None without a meta."""
    meta = buffer.get_custom_meta(name)
    if meta is None:
        return None
    s = meta.get_structure()
    fields = {s.nth_field_name(i): s.get_value(s.nth_field_name(i)) for i in range(s.n_fields())}
    fields["features"] = [{
        f.nth_field_name(i): f.get_value(f.nth_field_name(i)) for i in range(f.n_fields())
    } for f in fields["features"]]
    return fields


def main():
    Gst.init(None)
    pipeline = Gst.parse_launch(sys.argv[1] + " ! appsink name=sink sync=false")
    sink = pipeline.get_by_name("sink")
    pipeline.set_state(Gst.State.PLAYING)
    while (sample := sink.emit("pull-sample")) is not None:
        print(tracks(sample.get_buffer()))
    pipeline.set_state(Gst.State.NULL)


if __name__ == "__main__":
    main()
