# SPDX-License-Identifier: LGPL-2.1-or-later
"""Even sizes, which H.264 in 4:2:0 wants, of pictures that have others."""

import sys

from pipelines.lib import command
from pipelines.lib.caps import first_structure

# Of what x264enc takes: columns and rows that share a colour. Of anything else videoconvert makes
# 4:4:4, if it may, of which any size will do.
HALVED = {
    "I420": (2, 2), "YV12": (2, 2), "NV12": (2, 2), "I420_10LE": (2, 2), "Y42B": (2, 1),
    "I422_10LE": (2, 1)
}

# Into the text of a pipeline. It stands aside until it is needed: videocrop 1.22 refuses P010 and
# others that it says it takes, even if it has nothing to do.
TAKEN = ",".join([
    *HALVED, "Y444", "Y444_10LE", "YUY2", "UYVY", "GRAY8", "RGB", "BGR", "RGBx", "BGRx", "xRGB",
    "xBGR", "RGBA", "BGRA", "ARGB", "ABGR"
])
CROP = f"videoconvert name=uneven ! video/x-raw,format={{{TAKEN}}} ! videocrop name=crop"


def crop(Gst, run, name, source, before, after, shared=HALVED.get):
    """Leaves the last column or row out between these two elements of the run, that is before the picture is encoded and tracked: the tracks must be
    of the picture that is shown. `shared`: how many columns and rows of a format share a colour, or None."""
    uneven, cut = run.element("uneven"), run.element("crop")
    before, after = run.element(before), run.element(after)

    def look(_pad, info):
        event = info.get_event()
        if event.type != Gst.EventType.CAPS:
            return Gst.PadProbeReturn.OK
        caps = first_structure(event.parse_caps())
        width, height = caps.get_int("width")[1], caps.get_int("height")[1]
        across, down = shared(caps.get_string("format")) or (1, 1)
        right, bottom = width % across, height % down
        if (right or bottom) and uneven.get_static_pad("sink").get_peer() is None:
            before.unlink(after)
            before.link(uneven)
            cut.link(after)
        if (right, bottom) == (cut.get_property("right"), cut.get_property("bottom")):
            return Gst.PadProbeReturn.OK
        cut.set_property("right", right)
        cut.set_property("bottom", bottom)
        if right or bottom:
            gone = "column and row are" if right and bottom else "column is" if right else "row is"
            command.told(
                f"{name}: {source}: {width}×{height} is no even size, which H.264 wants: the last {gone} left out",
                sys.stderr)
        return Gst.PadProbeReturn.OK

    before.get_static_pad("sink").add_probe(Gst.PadProbeType.EVENT_DOWNSTREAM, look)
