#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Checks that each link of the documentation to a file here, or to a heading in one, leads
somewhere."""

import pathlib
import re
import sys
from collections.abc import Iterator

ROOT = pathlib.Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^```.*?^```", re.M | re.S)
LINK = re.compile(r"\]\((?!\w+:)([^)#\s]*)(?:#([^)]+))?\)")  # file, heading


def text_of(page: pathlib.Path) -> str:
    """The page without its blocks of code."""
    return FENCE.sub("", page.read_text())


def anchors(page: pathlib.Path) -> set[str]:
    """Of the headings, as GitHub names them."""
    titles = re.findall(r"^#+ (.+)$", text_of(page), re.M)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", title) for title in titles)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in plain}


def broken(page: pathlib.Path) -> Iterator[str]:
    for target, heading in LINK.findall(text_of(page)):
        file = (page.parent / target) if target else page
        in_page = heading and file.suffix == ".md"
        if not file.exists() or (in_page and heading not in anchors(file)):
            yield f"{page.relative_to(ROOT)}: {target}{'#' + heading if heading else ''}"


def main() -> int:
    pages = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    links = [link for page in pages for link in broken(page)]
    print("\n".join(links))
    return int(bool(links))


if __name__ == "__main__":
    sys.exit(main())
