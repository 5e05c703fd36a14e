# SPDX-License-Identifier: LGPL-2.1-or-later
"""Pages that programs write: those of docs/results/ whole, with their figures in a folder beside them; and tables in pages that people write."""

import math
import os
import re
import shutil

import builds

RESULTS = builds.ROOT / "docs" / "results"
WIDEST = 10  # columns of a table; more don't fit a screen


def table(header, rows, keys=1):
    """A wide one becomes several, one below the other; each repeats the first `keys` columns."""
    width = len(header) - keys
    parts = max(1, math.ceil(width / (WIDEST - keys)))
    each = [[
        list(row[:keys]) + list(row[keys + width * i // parts:keys + width * (i + 1) // parts])
        for row in (header, *rows)
    ]
            for i in range(parts)]
    return "\n".join("".join(f"{line}\n"
                             for line in (f"| {' | '.join(head)} |", "|" + "---|" * len(head),
                                          *(f"| {' | '.join(row)} |"
                                            for row in lines)))
                     for head, *lines in each)


def write(path, title, about, command, versions, body, figures=None):
    """A page of docs/results/ with what it is, the command that wrote it, and what that ran on; whole or not at all. Links in `about` and `body`
    are as from docs/. figures: the folder that becomes the page's own (folder_for_figures)."""
    text = (
        f"# {title}\n\n{about}\n[README.md](results/README.md) says what is measured and how to read it. All of this page is written by\n\n    {command}\n\n"
        f"{table(['', ''], versions.items())}\n{body.strip()}\n")
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = aside(path, linked(text, path.parent))
    shutil.rmtree(figures_of(path), ignore_errors=True)
    if figures:
        os.replace(figures, figures_of(path))
    os.replace(unfinished, path)


def linked(text, folder):
    """The text with its links, which are as from docs/, as they are from this folder. An image has no words, and is beside the page."""
    docs = builds.ROOT / "docs"
    return re.sub(r"(?<=[^\[])\]\(([\w./-]+\.(?:md|h))",
                  lambda found: f"]({os.path.relpath(docs / found[1], folder)}", text)


def figures_of(path):
    """The folder of the page's figures."""
    return path.with_suffix("")


def folder_for_figures(path):
    """An empty folder beside the one that it is to replace. How the page links to that: this folder's figures are not there yet."""
    drawn = path.with_name(f".unfinished-{path.stem}")
    shutil.rmtree(drawn, ignore_errors=True)
    drawn.mkdir(parents=True)
    return drawn, path.stem


def aside(path, text):
    """The file beside this one that is to replace it: so it is written whole or not at all."""
    unfinished = path.with_name(f".unfinished-{path.name}")
    unfinished.write_text(text)
    return unfinished


def filled(text, begin, end, body, path):
    """The text with `body` between two lines. Raises builds.Failure unless each is there once, in this order."""
    lines = text.splitlines()
    at = [i for i, line in enumerate(lines) if line in (begin, end)]
    if [lines[i] for i in at] != [begin, end]:
        raise builds.Failure(
            f"{path} must have the lines '{begin}' and '{end}', once each, in this order")
    return "\n".join([*lines[:at[0] + 1], "", *body.strip().splitlines(), "", *lines[at[1]:]
                      ]) + "\n"


def rewrite(path, begin, end, body):
    os.replace(aside(path, filled(path.read_text(), begin, end, body, path)), path)
