#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Checks that stock Python can read a meta that C wrote: test_read_meta.py LIBRARY."""

import ctypes
import sys

from tests.check.read_meta import Gst, tracks


def main() -> None:
    Gst.init(None)
    assert Gst.Plugin.load_by_name("csdtrack"), "no plugin: is GST_PLUGIN_PATH set?"
    library = ctypes.CDLL(sys.argv[1])
    library.csd_check_attach.argtypes = [ctypes.c_void_p]
    buffer = Gst.Buffer.new()
    assert tracks(buffer) is None
    assert library.csd_check_attach(hash(buffer))
    expected = {
        "schema": 1, "source": "csdtrack0", "algorithm": "csd-2012", "frame": 5000000000,
        "width": 64, "height": 48, "tracked-width": 128, "tracked-height": 96, "features": [{
            "id": 0, "x": 1.5, "y": -2.25, "state": "tracked", "confidence": 0.5, "fresh": True
        }, {
            "id": 4294967294, "x": 0.0, "y": 0.0, "state": "lost", "confidence": 0.0, "fresh": False
        }]
    }
    assert tracks(buffer) == expected, tracks(buffer)


if __name__ == "__main__":
    main()
