# SPDX-License-Identifier: LGPL-2.1-or-later
"""Markdown that programs write: whole pages of docs/results/, and tables in pages for people."""

import math
import os
import pathlib
import re
import shutil
import textwrap
from collections.abc import Iterable, Mapping, Sequence

from pipelines.experiments import builds
from pipelines.lib.failure import Failure

RESULTS = builds.ROOT / "docs" / "results"
WIDEST = 10  # columns of a table; more don't fit a screen
WIDTH = 120  # characters of a line of text


def table(header: Sequence[str], rows: Iterable[Sequence[str]], keys: int = 1) -> str:
    """A table. One that is too wide becomes several below each other; each of them repeats the
    first `keys` columns."""
    lines = [header, *rows]
    width = len(header) - keys
    parts = max(1, math.ceil(width / (WIDEST - keys)))
    tables = []
    for part in range(parts):
        begin, end = keys + width * part // parts, keys + width * (part + 1) // parts
        head, *body = [[*line[:keys], *line[begin:end]] for line in lines]
        rule = "|" + "---|" * len(head)
        cells = [f"| {' | '.join(line)} |" for line in (head, *body)]
        tables.append("\n".join([cells[0], rule, *cells[1:], ""]))
    return "\n".join(tables)


def wrapped(text: str, first: str = "") -> str:
    """A paragraph; `first` stands before its first line, and the others are indented as far."""
    return textwrap.fill(text, WIDTH, initial_indent=first, subsequent_indent=" " * len(first),
                         break_long_words=False, break_on_hyphens=False) + "\n"


def bullets(lines: Iterable[str]) -> str:
    return "".join(wrapped(line, "* ") for line in lines)


def write(path: pathlib.Path, title: str, about: str, command: str, versions: Mapping[str, str],
          body: str, figures: pathlib.Path | None = None) -> None:
    """Writes a page of docs/results/, whole or not at all.

    It says what the page is, which command wrote it, and which versions that ran on. `about` and
    `body` hold links as from docs/. `figures` is the folder that becomes the page's own
    (folder_for_figures).
    """
    text = (f"# {title}\n\n{about}\n"
            "[README.md](results/README.md) says what is measured and how to read it. "
            f"All of this page is written by\n\n    {command}\n\n"
            f"{table(['', ''], list(versions.items()))}\n{body.strip()}\n")
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = write_beside(path, linked(text, path.parent))
    shutil.rmtree(figures_of(path), ignore_errors=True)
    if figures:
        os.replace(figures, figures_of(path))
    os.replace(unfinished, path)


def linked(text: str, folder: pathlib.Path) -> str:
    """Turns the links of a text, which are relative to docs/, into links from this folder.

    Images, whose links have no words, stay: they are beside the page.
    """
    docs = builds.ROOT / "docs"
    return re.sub(r"(?<=[^\[])\]\(([\w./-]+\.(?:md|h))",
                  lambda found: f"]({os.path.relpath(docs / found[1], folder)}", text)


def figures_of(path: pathlib.Path) -> pathlib.Path:
    """The folder of the page's figures."""
    return path.with_suffix("")


def folder_for_figures(path: pathlib.Path) -> tuple[pathlib.Path, str]:
    """An empty folder to draw into, and the name under which the page links to its figures.

    The folder takes that name only when write() replaces the page.
    """
    drawn = path.with_name(f".unfinished-{path.stem}")
    shutil.rmtree(drawn, ignore_errors=True)
    drawn.mkdir(parents=True)
    return drawn, path.stem


def minus(text: str) -> str:
    """With a minus sign in place of each hyphen."""
    return text.replace("-", "−")


def p_value(p: float | None) -> str:
    if p is None:
        return "–"
    return "p < .001" if p < 0.001 else f"p {p:.3f}"


def write_beside(path: pathlib.Path, text: str) -> pathlib.Path:
    """Writes the text into a file beside `path`, which can then replace it in one go.

    Raises Failure if `path` is a device or a folder: it would be replaced, too.
    """
    if path.exists() and not path.is_file():
        raise Failure(f"{path} is no file: not written")
    unfinished = path.with_name(f".unfinished-{path.name}")
    unfinished.write_text(text)
    return unfinished


def replace(path: pathlib.Path, text: str) -> None:
    """Writes a file whole or not at all."""
    os.replace(write_beside(path, text), path)


def filled(text: str, begin: str, end: str, body: str, path: pathlib.Path | str) -> str:
    """The text with `body` between two lines.

    Raises Failure unless the text of `path` has each of these lines once, in this order.
    """
    lines = text.splitlines()
    at = [i for i, line in enumerate(lines) if line in (begin, end)]
    if [lines[i] for i in at] != [begin, end]:
        raise Failure(f"{path} must have the lines '{begin}' and '{end}', once each, in this order")
    filled_in = [*lines[:at[0] + 1], "", *body.strip().splitlines(), "", *lines[at[1]:]]
    return "\n".join(filled_in) + "\n"


def rewrite(path: pathlib.Path, begin: str, end: str, body: str) -> None:
    replace(path, filled(path.read_text(), begin, end, body, path))
