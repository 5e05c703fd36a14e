# SPDX-License-Identifier: LGPL-2.1-or-later
"""Script files that hand data to the page: one opened from disk can't fetch, but it can load scripts."""

import array
import base64
import json
import sys


def packed(values):
    """An array's bytes, little-endian, as base64."""
    if sys.byteorder == "big":
        values = array.array(values.typecode, values)
        values.byteswap()
    return base64.b64encode(values.tobytes()).decode()


def write(path, function, *arguments):
    """A script that calls csdReport.FUNCTION(ARGUMENTS)."""
    text = ",\n".join(
        json.dumps(a, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
        for a in arguments)
    # A file's name need not be UTF-8: what isn't becomes an escape of JavaScript's.
    path.write_text(f"csdReport.{function}({text});\n", encoding="utf-8", errors="backslashreplace")
