# SPDX-License-Identifier: LGPL-2.1-or-later
"""The index of an archive, OUT/index.sqlite, and the result files from which it is made.

Only one process writes the index, as SQLite's locks are unreliable over NFS. A job that tracks a
video leaves a result file beside the tracks.
"""

import errno
import json
import os
import pathlib
import secrets
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, TextIO

from pipelines.lib import command

Row = dict[str, Any]  # of the index, by column

# The columns of the index, which are also the fields of a result file.
COLUMNS = {
    "name": "TEXT PRIMARY KEY",  # of the video; its tracks are OUT/NAME.jsonl
    "video": "TEXT",             # path
    # done; failed: because of the video; unfinished: for another reason, so the next run retries
    "status": "TEXT",
    "error": "TEXT",             # why it isn't done
    "note": "TEXT",              # a warning about a video that is done
    "version": "TEXT",           # of csdtrack
    "settings": "TEXT",          # of csdtrack: all that are not the default
    "size": "INTEGER",           # of the video, bytes
    "mtime": "INTEGER",          # of the video, s since 1970
    "host": "TEXT",              # where it was tracked
    "started": "TEXT",           # UTC
    "seconds": "REAL",           # how long tracking took
    "width": "INTEGER",          # of the picture, at its end
    "height": "INTEGER",
    "duration": "REAL",          # s of video
    "frames": "INTEGER",
    "features": "INTEGER",       # that claimed a position at least once
    "claimed": "INTEGER",        # frames in which some feature claims a position
    "tracks_size": "INTEGER",    # of the tracks, bytes
    "tracks_mtime": "INTEGER",   # of the tracks, s since 1970
}
# A result is out of date if one of these has changed.
IDENTITY = ("version", "settings", "size", "mtime")

NO_ROOM = (errno.ENOSPC, errno.EDQUOT)


def failure(error: OSError, out: object) -> command.Failure:
    """The exception for an OSError."""
    if error.errno in NO_ROOM:
        return command.Full(out)
    return command.Failure(f"'{error.filename or out}': {error.strerror}")


def tracks_path(out: pathlib.Path, name: str) -> pathlib.Path:
    return out / f"{name}.jsonl"


def result_path(out: pathlib.Path, name: str) -> pathlib.Path:
    return out / f"{name}.json"


def open_unfinished(path: pathlib.Path) -> TextIO:
    """A new file beside `path`, open for writing, to be renamed to `path` when it is complete.

    Its name says which process writes it. It also has a random part, so that nobody can put a link
    there beforehand. tempfile isn't used, as only their owner can read its files.
    """
    process = f"{os.uname().nodename}-{os.getpid()}"
    unfinished = path.with_name(f".{path.name}.{secrets.token_hex(4)}.{process}.unfinished")
    return open(unfinished, "x", encoding="utf-8")


def write_atomically(path: pathlib.Path, text: str) -> None:
    """Writes a whole file or none."""
    with open_unfinished(path) as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(file.name, path)


def read_result(out: pathlib.Path, name: str) -> Row | None:
    """None if there is no result file, or none that fits the index."""
    try:
        with open(result_path(out, name), encoding="utf-8") as file:
            found = json.load(file)
    except (OSError, ValueError):
        return None
    if not isinstance(found, dict):
        return None
    row = {column: found.get(column) for column in COLUMNS}
    valid = row["name"] == name and all(is_valid(row, *column) for column in COLUMNS.items())
    return row if valid else None


def is_valid(row: Row, column: str, kind: str) -> bool:
    """Whether a field has the type of its column, and is there if it must be."""
    value = row[column]
    if value is None:
        return column != "error" if row["status"] == "failed" else column in ("error", "note")
    types: dict[str, Any] = {"TEXT": str, "INTE": int, "REAL": (int, float)}
    return isinstance(value, types[kind[:4]])


def stamp(found: os.stat_result) -> tuple[int, int]:
    """Size and time of a file. The time is in whole seconds, as some file systems keep no more."""
    return found.st_size, int(found.st_mtime)


def size_and_mtime(path: str | pathlib.Path) -> tuple[int, int] | None:
    """A file's stamp(); None without the file."""
    try:
        return stamp(os.stat(path))
    except OSError:
        return None


def is_current(out: pathlib.Path, row: Row | None, identity: Mapping[str, Any]) -> bool:
    """Whether a row is about a video of this identity, and the video failed or its tracks exist."""
    if not row or any(row[key] != identity[key] for key in IDENTITY):
        return False
    if row["status"] == "done":
        tracks = size_and_mtime(tracks_path(out, row["name"]))
        return tracks == (row["tracks_size"], row["tracks_mtime"])
    return row["status"] == "failed"


class Index:
    def __init__(self, out: pathlib.Path, make: bool = True) -> None:
        """Opens the index of OUT. `make`: for writing, and makes it if there is none."""
        self._path = out / "index.sqlite"
        try:
            if not make and not self._path.is_file():
                raise command.Failure(
                    f"there is no index in '{out}': give the OUT of an earlier run")
        except OSError as error:
            raise failure(error, out) from error
        try:
            self._base = sqlite3.connect(self._path if make else self._read_only(), uri=not make)
            self._base.row_factory = sqlite3.Row
            if make:
                columns = ", ".join(f"{name} {kind}" for name, kind in COLUMNS.items())
                self._base.execute(f"CREATE TABLE IF NOT EXISTS videos ({columns})")
            rows = self._base.execute(f"SELECT {', '.join(COLUMNS)} FROM videos ORDER BY name")
            self.rows: dict[str, Row] = {row["name"]: dict(row) for row in rows}
        except sqlite3.Error as error:
            raise self._failure(error) from error

    def _read_only(self) -> str:
        path = self._path.absolute().as_posix()
        for character in "%?#":
            path = path.replace(character, f"%{ord(character):02x}")
        return f"file:{path}?mode=ro"

    def put(self, rows: Iterable[Row]) -> None:
        rows = list(rows)
        values = ", ".join(f":{name}" for name in COLUMNS)
        self._change(f"INSERT OR REPLACE INTO videos VALUES ({values})", rows)
        self.rows.update((row["name"], row) for row in rows)

    def forget(self, out: pathlib.Path, names: set[str]) -> None:
        """Removes videos that have none of these names, no file and no tracks any more."""
        gone = [
            name for name in self.rows.keys() - names
            if not size_and_mtime(self.rows[name]["video"]) and
            not size_and_mtime(tracks_path(out, name))
        ]
        self._change("DELETE FROM videos WHERE name = ?", [(name,) for name in gone])
        for name in gone:
            del self.rows[name]

    def _change(self, statement: str, parameters: Sequence[Any]) -> None:
        if not parameters:
            return
        try:
            with self._base:
                self._base.executemany(statement, parameters)
        except sqlite3.Error as error:
            raise self._failure(error) from error

    def _failure(self, error: sqlite3.Error) -> command.Failure:
        return command.Failure(
            f"can't use '{self._path}' ({error}): make room, or remove it; it is made again "
            "from the results beside the tracks")


# ---- What users read ----


def printable(text: str) -> str:
    """A name on one line."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def clock(seconds: float) -> str:
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}"


def percentage(part: float, whole: float) -> str:
    return f"{100 * part / whole:.1f} %" if whole else "–"


def table(rows: Iterable[Row]) -> Iterator[str]:
    """A line for each video, then one for each version with its settings, a numbered `way`."""
    ways: dict[tuple[str, str], int] = {}
    lines = [("status", "length", "frames", "fps", "features", "claims", "way", "video")]
    for row in rows:
        way = ways.setdefault((row["version"], row["settings"]), len(ways) + 1)
        done = row["status"] == "done"
        # It was removed, or its disk isn't mounted.
        unseen = done and not size_and_mtime(row["video"]) and "its video can't be seen from here"
        notes = [note for note in (row["error"], row["note"], unseen) if note]
        name = ": ".join(printable(text) for text in (row["name"], *notes))
        if done:
            fps = f"{row['frames'] / max(row['seconds'], 1e-3):.1f}"
            lines.append(
                (row["status"], clock(row["duration"]), str(row["frames"]), fps,
                 str(row["features"]), percentage(row["claimed"], row["frames"]), str(way), name))
        else:
            lines.append((row["status"], "", "", "", "", "", str(way), name))
    widths = [max(map(len, column)) for column in zip(*lines)]
    for line in lines:
        numbers = [text.rjust(width) for text, width in zip(line[1:-1], widths[1:-1])]
        yield "  ".join([line[0].ljust(widths[0]), *numbers, line[-1]]).rstrip()
    for (version, settings), way in ways.items():
        yield f"way {way}: csdtrack {version} {settings}"


def troubles(rows: Iterable[Row]) -> Iterator[str]:
    """A line for each video that isn't done, or is shorter than its file says."""
    for row in rows:
        if row["error"] or row["note"]:
            reason = printable(row["error"] or row["note"])
            yield f"{row['status']}: {printable(row['name'])}: {reason}"


def statistics(rows: Iterable[Row]) -> Iterator[str]:
    rows = list(rows)
    done = [row for row in rows if row["status"] == "done"]
    states = ", ".join(f"{sum(row['status'] == state for row in rows)} {state}"
                       for state in ("done", "failed", "unfinished"))

    def total(key: str) -> float:
        return sum(row[key] for row in done)

    yield f"{len(rows)} videos: {states}"
    if done:
        frames = total("frames")
        yield (f"{clock(total('duration'))} of video, {frames} frames; "
               f"{frames / max(total('seconds'), 1e-3):.1f} frames a second and job")
        yield (f"{total('features')} features tracked; {percentage(total('claimed'), frames)} "
               "of the frames have a feature that claims a position")
