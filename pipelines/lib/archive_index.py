# SPDX-License-Identifier: LGPL-2.1-or-later
"""The index of an archive, OUT/index.sqlite, and the results beside the tracks that it is gathered from.

One process writes the index: SQLite's locks can't be relied on over NFS. Who tracks a video leaves a result file beside its tracks.
"""

import errno
import json
import os
import secrets
import sqlite3

from pipelines.lib import command

# A row of the index, and the fields of a result file.
COLUMNS = {
    "name": "TEXT PRIMARY KEY",  # of the video; its tracks are OUT/NAME.jsonl
    "video": "TEXT",             # path
    # done; failed: the video's fault; unfinished: not the video's, done again by the next run
    "status": "TEXT",
    "error": "TEXT",             # why it isn't done
    "note": "TEXT",              # what is strange about a video that is done
    "version": "TEXT",           # of csdtrack
    "settings": "TEXT",          # of csdtrack: all that are not the default
    "size": "INTEGER",           # of the video, bytes
    "mtime": "INTEGER",          # of the video, s since 1970
    "host": "TEXT",              # where it was tracked
    "started": "TEXT",           # UTC
    "seconds": "REAL",           # that it took
    "width": "INTEGER",          # of the picture, at its end
    "height": "INTEGER",
    "duration": "REAL",          # s of video
    "frames": "INTEGER",
    "features": "INTEGER",       # that claimed a position at least once
    "claimed": "INTEGER",        # frames in which some feature claims a position
    "tracks_size": "INTEGER",    # of the tracks, bytes
    "tracks_mtime": "INTEGER",   # of the tracks, s since 1970
}
# what a result depends on: if one of them changes, it is out of date
IDENTITY = ("version", "settings", "size", "mtime")


NO_ROOM = (errno.ENOSPC, errno.EDQUOT)


def failure(error, out):
    """What to say of an OSError."""
    return command.Full(out) if error.errno in NO_ROOM else command.Failure(
        f"'{error.filename or out}': {error.strerror}")


def tracks_of(out, name):
    return out / f"{name}.jsonl"


def result_of(out, name):
    return out / f"{name}.json"


def unfinished(path):
    """A new file beside `path`, open for writing, that gets its name when it is whole. Its own says who is at work on it, but nobody can know it
    before and put a link there. Not tempfile's: those can be read by their owner alone."""
    return open(
        path.with_name(
            f".{path.name}.{secrets.token_hex(4)}.{os.uname().nodename}-{os.getpid()}.unfinished"),
        "x", encoding="utf-8")


def whole(path, text):
    """Writes a file whole or not at all."""
    with unfinished(path) as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(file.name, path)


def read_result(out, name):
    """None if there is none that could be in the index."""
    try:
        with open(result_of(out, name), encoding="utf-8") as file:
            found = json.load(file)
    except (OSError, ValueError):
        return None
    if not isinstance(found, dict):
        return None
    row = {column: found.get(column) for column in COLUMNS}
    return row if row["name"] == name and all(fits(row, *column)
                                              for column in COLUMNS.items()) else None


def fits(row, column, kind):
    """Whether a field is what the index and its readers take."""
    value = row[column]
    if value is None:
        return column != "error" if row["status"] == "failed" else column in ("error", "note")
    return isinstance(value, {"TEXT": str, "INTE": int, "REAL": (int, float)}[kind[:4]])


def stamp(path):
    """Size and whole seconds of the last change (some file systems keep no more); None without the file."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_size, int(found.st_mtime)


def holds(out, row, identity):
    """Whether a row or result says of a video of this identity that it is done, with the tracks that are there, or that it failed."""
    if not row or any(row[key] != identity[key] for key in IDENTITY):
        return False
    return row["status"] == "failed" or row["status"] == "done" and stamp(
        tracks_of(out, row["name"])) == (row["tracks_size"], row["tracks_mtime"])


class Index:
    def __init__(self, out, make=True):
        path = out / "index.sqlite"
        try:
            if not make and not path.is_file():
                raise command.Failure(
                    f"there is no index in '{out}': give the OUT of an earlier run")
        except OSError as error:
            raise failure(error, out) from error
        self._path = path
        try:
            self._base = sqlite3.connect(
                path if make else
                f"file:{path.absolute().as_posix().replace('%', '%25').replace('?', '%3f').replace('#', '%23')}?mode=ro",
                uri=not make)
            self._base.row_factory = sqlite3.Row
            if make:
                self._base.execute(
                    f"CREATE TABLE IF NOT EXISTS videos ({', '.join(f'{name} {kind}' for name, kind in COLUMNS.items())})"
                )
            self.rows = {
                row["name"]: dict(row) for row in self._base.execute(
                    f"SELECT {', '.join(COLUMNS)} FROM videos ORDER BY name")
            }
        except sqlite3.Error as error:
            raise self._failure(error) from error

    def put(self, rows):
        rows = list(rows)
        self._change(
            f"INSERT OR REPLACE INTO videos VALUES ({', '.join(':' + name for name in COLUMNS)})",
            rows)
        self.rows.update((row["name"], row) for row in rows)

    def forget(self, out, names):
        """Away with what is none of these names and has neither video nor tracks any more."""
        gone = [
            name for name in self.rows.keys() - names
            if not stamp(self.rows[name]["video"]) and not stamp(tracks_of(out, name))
        ]
        self._change("DELETE FROM videos WHERE name = ?", [(name,) for name in gone])
        for name in gone:
            del self.rows[name]

    def _change(self, statement, rows):
        if not rows:
            return
        try:
            with self._base:
                self._base.executemany(statement, rows)
        except sqlite3.Error as error:
            raise self._failure(error) from error

    def _failure(self, error):
        return command.Failure(
            f"can't use '{self._path}' ({error}): make room, or remove it; it is made again from the results beside the tracks"
        )


# ---- What people read
# ----------------------------------------------------------------------------------------------


def shown(text):
    """A name on one line."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def clock(seconds):
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{seconds:02}"


def share(part, all_of_it):
    return f"{100 * part / all_of_it:.1f} %" if all_of_it else "–"


def table(rows):
    ways = {}  # each version with its settings, numbered
    lines = [("status", "length", "frames", "fps", "features", "claims", "way", "video")]
    for row in rows:
        way = ways.setdefault((row["version"], row["settings"]), len(ways) + 1)
        # gone, or not mounted
        unseen = row["status"] == "done" and not stamp(
            row["video"]) and "its video can't be seen from here"
        name = shown(row["name"]) + "".join(
            f": {shown(note)}" for note in (row["error"], row["note"], unseen) if note)
        if row["status"] == "done":
            lines.append((row["status"], clock(row["duration"]), str(row["frames"]),
                          f"{row['frames'] / max(row['seconds'], 1e-3):.1f}", str(row["features"]),
                          share(row["claimed"], row["frames"]), str(way), name))
        else:
            lines.append((row["status"], "", "", "", "", "", str(way), name))
    widths = [max(map(len, column)) for column in zip(*lines)]
    for line in lines:
        cells = [
            line[0].ljust(widths[0]),
            *(text.rjust(width) for text, width in zip(line[1:-1], widths[1:-1])), line[-1]
        ]
        yield "  ".join(cells).rstrip()
    for (version, settings), way in ways.items():
        yield f"way {way}: csdtrack {version} {settings}"


def troubles(rows):
    """A line for each video that isn't done, or is shorter than it says."""
    for row in rows:
        if row["error"] or row["note"]:
            yield f"{row['status']}: {shown(row['name'])}: {shown(row['error'] or row['note'])}"


def statistics(rows):
    rows = list(rows)
    done = [row for row in rows if row["status"] == "done"]
    states = ", ".join(
        f"{sum(row['status'] == state for row in rows)} {state}" for state in ("done", "failed",
                                                                               "unfinished"))

    def total(key):
        return sum(row[key] for row in done)

    yield f"{len(rows)} videos: {states}"
    if done:
        yield f"{clock(total('duration'))} of video, {total('frames')} frames; {total('frames') / max(total('seconds'), 1e-3):.1f} frames a second and job"
        yield f"{total('features')} features tracked; {share(total('claimed'), total('frames'))} of the frames have a feature that claims a position"
