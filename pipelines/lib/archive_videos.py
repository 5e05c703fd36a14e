# SPDX-License-Identifier: LGPL-2.1-or-later
"""Finds the videos of an archive, and which of them have still to be tracked."""

import argparse
import os
import pathlib
from collections.abc import Mapping
from typing import Any

from pipelines.lib import archive_index, archive_progress, command

VIDEOS = (".3gp .avi .flv .m2ts .m4v .mkv .mov .mp4 .mpeg .mpg .mts .mxf .ogv .ts .vob .webm "
          ".wmv").split()


def walk(base: str, out: str) -> list[str]:
    """The paths of a folder's videos, each folder and file once, without the folder `out`.

    Links come last. They may lead to a file of the same folder, which keeps its own name.
    """
    paths: list[str] = []
    starts, links = [base], []
    first_names: dict[tuple[int, int], str] = {}
    repeated: list[tuple[str, str]] = []

    def is_new(path: str) -> bool:
        try:
            found = os.stat(path)
        except OSError:
            return True  # a broken link is reported later
        first = first_names.setdefault((found.st_dev, found.st_ino), path)
        if first != path:
            repeated.append((path, first))
        return first == path

    for start in starts:  # the list grows meanwhile
        for folder, folders, files in os.walk(start):
            if not is_new(folder):
                folders.clear()
                continue
            folders[:] = sorted(name for name in folders if not name.startswith(".") and
                                os.path.join(folder, name) != out)
            starts += filter(os.path.islink, (os.path.join(folder, name) for name in folders))
            for file in sorted(files):
                path = os.path.join(folder, file)
                if file.startswith(".") or os.path.splitext(file)[1].lower() not in VIDEOS:
                    continue
                if os.path.islink(path):
                    links.append(path)
                elif is_new(path):
                    paths.append(path)
    paths += filter(is_new, links)
    if repeated:
        path, first = (archive_index.printable(command.escaped(path)) for path in repeated[0])
        more = f", and {len(repeated) - 1} more of the kind" if repeated[1:] else ""
        archive_progress.warn(f"left out, for it is '{first}' again: '{path}'{more}")
    return paths


def read_list(source: pathlib.Path, base: pathlib.Path) -> list[str]:
    """The paths that a text file names. Relative ones are below `base`."""
    advice = "give a folder of videos, or a text file with their paths"
    try:
        with open(source, encoding="utf-8", errors="surrogateescape") as file:
            text = file.read(100_000)
            # The beginning shows whether it is text: a video may be long.
            text += "" if "\0" in text else file.read()
    except OSError as error:
        raise command.Failure(f"can't read '{source}' ({error.strerror}): {advice}") from error
    if "\0" in text:
        raise command.Failure(f"'{source}' is no text: {advice}")
    lines = [line for line in text.split("\n") if line.strip() and not line.startswith("#")]
    paths = [os.path.abspath(os.path.join(base, line)) for line in lines]
    if paths and not any(map(os.path.exists, paths)):
        example = archive_index.printable(command.escaped(paths[0]))
        raise command.Failure(f"'{source}' is no list of videos: none of the files that its lines "
                              f"name is there, such as '{example}'")
    return paths


def find(source: pathlib.Path, out: pathlib.Path) -> dict[str, str]:
    """The videos' paths by their names. A name is the path below LIST, or else the whole path."""
    if source.is_dir():
        base = pathlib.Path(os.path.abspath(source))
        paths = walk(str(base), str(out))
    else:
        base = pathlib.Path(os.path.abspath(source.parent))
        paths = read_list(source, base)
    if not paths:
        raise command.Failure(f"'{source}' names no video: see --help")
    return {
        os.path.relpath(path, base)
        if pathlib.Path(path).is_relative_to(base) else path.lstrip("/"): path for path in paths
    }


def why_impossible(path: str, found: tuple[int, int] | None) -> str | None:
    """Why the video at this path, of this size and time, can't be tracked."""
    escaped = command.escaped(path)
    if escaped != path:
        return f"'{escaped}' is no UTF-8: rename it"
    if not found:
        return f"there is no file '{path}': correct the list, or bring it back"
    if command.is_pipe_or_device(path):
        return f"'{path}' {command.NOT_A_FILE}"
    if not found[0]:
        return f"'{path}' is empty: copy it again, or remove it"
    return None


def compare(options: argparse.Namespace, index: archive_index.Index, version: str,
            settings: str) -> tuple[list[str], list[dict[str, Any]], list[archive_index.Row]]:
    """The names of all videos of LIST, the jobs to do, and the rows that the index lacks."""
    names: list[str] = []
    jobs: list[dict[str, Any]] = []
    rows: list[archive_index.Row] = []
    for name, path in find(options.videos, options.out).items():
        found, escaped = archive_index.size_and_mtime(path), command.escaped(name)
        size, mtime = found or (None, None)
        identity = {"version": version, "settings": settings, "size": size, "mtime": mtime}
        names.append(escaped)
        known = current_row(options.out, index, escaped, command.escaped(path), identity)
        if known and known is not index.rows.get(escaped):
            rows.append(known)
        if known and options.redo not in ("all", known["status"]):
            continue
        why = why_impossible(path, found)
        if not why:
            jobs.append({"name": name, "video": path, "size": size})
        rows.append(
            dict.fromkeys(archive_index.COLUMNS) | identity | {
                "name": escaped, "video": command.escaped(path), "status":
                "failed" if why else "unfinished", "error": why or "not yet tracked"
            })
    return names, jobs, rows


def current_row(out: pathlib.Path, index: archive_index.Index, name: str, path: str,
                identity: Mapping[str, Any]) -> archive_index.Row | None:
    """What is known of a video that hasn't changed, from the index or its result file."""
    known = index.rows.get(name)
    if known and known["video"] != path and os.path.exists(known["video"]):
        raise command.Failure(
            f"'{out}' has tracks of another '{name}', of '{known['video']}': give another OUT")
    if not archive_index.is_current(out, known, identity):
        known = archive_index.read_result(out, name)
    return known if archive_index.is_current(out, known, identity) else None
