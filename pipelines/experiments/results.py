# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads the pages of docs/results/: their tables, and single figures in their text."""

import pathlib
import re
from collections.abc import Sequence

from pipelines.experiments import page
from pipelines.lib.failure import Failure

Row = dict[str, str]  # cell by column


class Results:
    """A page of docs/results/."""

    def __init__(self, name: str, folder: pathlib.Path = page.RESULTS) -> None:
        self.path = folder / f"{name}.md"
        try:
            self.text = self.path.read_text()
        except OSError as error:
            raise Failure(f"{self.path}: {error.strerror}") from error

    def rows(self, header: Sequence[str], after: str = "") -> list[Row]:
        """The first table after this text whose header begins with these cells."""
        begin = self.text.find(after)
        at = self.text.find(f"\n| {' | '.join(header)} |", begin) if begin >= 0 else -1
        if at < 0:
            below = f" below {after.strip()!r}" if after else ""
            raise Failure(f"{self.path} has no table '{' | '.join(header)}'{below}")
        table = re.match(r"(?:\|.*\n?)+", self.text[at + 1:])
        assert table
        head, _, *lines = table[0].splitlines()
        columns = cells(head)
        return [dict(zip(columns, cells(line))) for line in lines]

    def groups(self, pattern: str) -> tuple[str, ...]:
        """The groups of the only match. Raises Failure if there are none or several."""
        places = list(re.finditer(pattern, self.text, re.M))
        if len(places) != 1:
            raise Failure(f"{self.path} has {len(places)} places like '{pattern}', not one")
        return places[0].groups()

    def commit(self) -> str:
        return self.groups(r"^\| csdtrack \| ([^ ;]+)[^|]*\|$")[0]


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip("|").split("|")]


def first(cell: str) -> str:
    """A figure without its interval."""
    return cell.split(" ")[0]


def both(sensitivity: str, k: str) -> str:
    return f"{first(sensitivity)} / {first(k)}"


def figure(pattern: str, cell: str) -> float:
    """The figure that the pattern's group finds in a cell; 0 if there is none."""
    found = re.search(pattern, cell)
    return float(found[1]) if found else 0
