# SPDX-License-Identifier: LGPL-2.1-or-later
"""Crops pictures of odd width or height, as H.264 in 4:2:0 needs even ones."""

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pipelines.lib import command
from pipelines.lib.caps import first_structure

if TYPE_CHECKING:
    from pipelines.lib.runner import Run

# How many columns and rows share a colour, of the subsampled formats that x264enc takes. Any other
# format is converted to 4:4:4 where the encoder may use that, and 4:4:4 can have any size.
SUBSAMPLING = {
    "I420": (2, 2), "YV12": (2, 2), "NV12": (2, 2), "I420_10LE": (2, 2), "Y42B": (2, 1),
    "I422_10LE": (2, 1)
}

# videocrop 1.22 rejects P010 and other formats that its caps allow, even with nothing to crop. So
# these elements are linked only when they are needed, behind a conversion to one of these formats.
FORMATS = ",".join([
    *SUBSAMPLING, "Y444", "Y444_10LE", "YUY2", "UYVY", "GRAY8", "RGB", "BGR", "RGBx", "BGRx",
    "xRGB", "xBGR", "RGBA", "BGRA", "ARGB", "ABGR"
])
ELEMENTS = f"videoconvert name=uneven ! video/x-raw,format={{{FORMATS}}} ! videocrop name=crop"


def crop(run: "Run", name: str, source: str, before_name: str, after_name: str,
         subsampling: Callable[[str], tuple[int, int] | None] = SUBSAMPLING.get) -> None:
    """Crops the last column or row between two elements of the run's pipeline.

    That is before the picture is encoded and tracked, so that the tracks fit the picture that is
    shown. The pipeline's description holds ELEMENTS. `subsampling`: how many columns and rows of a
    format share a colour, or None.
    """
    from pipelines.lib.runner import Gst
    convert, videocrop = run.element("uneven"), run.element("crop")
    before, after = run.element(before_name), run.element(after_name)

    def on_event(_pad: Gst.Pad, info: Gst.PadProbeInfo) -> Any:
        event = info.get_event()
        if event.type != Gst.EventType.CAPS:
            return Gst.PadProbeReturn.OK
        caps = first_structure(event.parse_caps())
        width, height = caps.get_int("width")[1], caps.get_int("height")[1]
        columns, rows = subsampling(caps.get_string("format")) or (1, 1)
        right, bottom = width % columns, height % rows
        if (right or bottom) and convert.get_static_pad("sink").get_peer() is None:
            before.unlink(after)
            before.link(convert)
            videocrop.link(after)
        if (right, bottom) == (videocrop.get_property("right"), videocrop.get_property("bottom")):
            return Gst.PadProbeReturn.OK
        videocrop.set_property("right", right)
        videocrop.set_property("bottom", bottom)
        if right or bottom:
            gone = "column and row are" if right and bottom else "column is" if right else "row is"
            command.print_line(
                f"{name}: {source}: {width}×{height} is no even size, which H.264 wants: "
                f"the last {gone} left out", sys.stderr)
        return Gst.PadProbeReturn.OK

    before.get_static_pad("sink").add_probe(Gst.PadProbeType.EVENT_DOWNSTREAM, on_event)
