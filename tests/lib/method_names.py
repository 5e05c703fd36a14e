#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Checks that the code has what docs/method.md names in `code`.

Names in its first table must be in the files of their row.
"""

import pathlib
import re
import sys
from collections.abc import Iterable, Iterator

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "method.md"
CODE = re.compile("`([^`]+)`")


def find(*patterns: str) -> list[pathlib.Path]:
    return [path for pattern in patterns for path in ROOT.glob(pattern)]


def code(path: pathlib.Path) -> str:
    """A source without its comments; "" for other files."""
    return re.sub(r"//.*", "", path.read_text()) if path.suffix in (".h", ".cpp") else ""


def missing(name: str, files: Iterable[pathlib.Path]) -> str | None:
    """The part of name, name::member or name=value that none of the files has.

    A member must be in the file of its type.
    """
    texts = list(map(code, files))
    if "::" in name:
        owner, name = name.split("::")
        texts = [text for text in texts if re.search(rf"\b(class|struct) {owner}\b[^;]*{{", text)]
        if not texts:
            return owner
    for part in name.split("="):
        if not any(re.search(rf"(?<![\w-]){re.escape(part)}(?![\w-])", text) for text in texts):
            return part
    return None


def errors_of(line: str) -> Iterator[str]:
    cells = line.strip("|").split("|")
    # paper | what | file | function
    in_table = len(cells) == 4 and cells[2].strip().startswith("`")
    stems = CODE.findall(cells[2]) if in_table else []
    patterns = [f"core/{stem}.*" for stem in stems] if in_table else ["core/**/*.*", "gst/**/*.*"]
    files = find(*patterns)
    for name in CODE.findall(line):
        if "/" in name:  # a file, a program or a room, with or without its ending
            file = name.split()[0].removeprefix("build/").rstrip("/")
            if not find(file, f"{file}.*", f"core/{file}", f"core/{file}.*"):
                yield f"there is no {file}"
        elif part := missing(name, files):
            yield f"no `{part}` in {', '.join(stems) or 'core/ and gst/'}"


def main() -> int:
    errors = [f"error: {PAGE}:{number}: {error}"
              for number, line in enumerate(PAGE.read_text().splitlines(), 1)
              for error in errors_of(line)]
    if errors:
        print("\n".join(errors), file=sys.stderr)
    return int(bool(errors))


if __name__ == "__main__":
    sys.exit(main())
