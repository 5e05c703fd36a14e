# SPDX-License-Identifier: LGPL-2.1-or-later
"""Stands in for csdtrackenc role=truth until that is there: writes the truth meta as it will."""

import json

from gi.repository import Gst


def attach(pad, path):
    file = open(path, "w")

    def write(_, info):
        if info.type & Gst.PadProbeType.BUFFER:
            buffer = info.get_buffer()
            s = buffer.get_custom_meta("GstCsdTruthMeta").get_structure()
            features = [{"id": f.get_value("id"), "x": round(f.get_value("x"), 3), "y": round(f.get_value("y"), 3),
                         "state": f.get_value("state"), "confidence": f.get_value("confidence")} for f in s.get_value("features")]
            file.write(json.dumps({"schema": 1, "source": "csdsimsrc0", "role": "truth", "algorithm": "truth",
                                   "frame": s.get_value("frame"), "pts": buffer.pts, "duration": buffer.duration,
                                   "running_time": buffer.pts, "stream_time": buffer.pts, "reference": None,
                                   "width": s.get_value("width"), "height": s.get_value("height"),
                                   "features": features}, separators=(",", ":")) + "\n")
        elif info.get_event().type == Gst.EventType.EOS:
            file.close()
        return Gst.PadProbeReturn.OK

    pad.add_probe(Gst.PadProbeType.BUFFER | Gst.PadProbeType.EVENT_DOWNSTREAM, write)
