# SPDX-License-Identifier: LGPL-2.1-or-later
"""Script files with the page's data: a page opened from disk can't fetch, but can load scripts."""

import array
import base64
import json
import pathlib
import sys
from typing import Any


def packed(values: "array.array[Any]") -> str:
    """An array's bytes, little-endian, as base64."""
    if sys.byteorder == "big":
        values = array.array(values.typecode, values)
        values.byteswap()
    return base64.b64encode(values.tobytes()).decode()


def write(path: pathlib.Path, function: str, *arguments: Any) -> None:
    """A script that calls csdReport.FUNCTION(ARGUMENTS)."""
    text = ",\n".join(
        json.dumps(a, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
        for a in arguments)
    # What isn't UTF-8 in a file's name becomes an escape of JavaScript's.
    path.write_text(f"csdReport.{function}({text});\n", encoding="utf-8", errors="backslashreplace")
