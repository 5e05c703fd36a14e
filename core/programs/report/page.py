# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes the page: OUT/index.html, its data, its scripts and its video."""

import array
import bisect
import errno
import html
import math
import os
import pathlib
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from typing import Any

from report import motion, script
from report import tracks as track_file
from report import video as video_file
from report.messages import Progress, ReportError

HERE = pathlib.Path(__file__).resolve().parent
INDEX = "data/index.js"
LIBRARY = ("dygraph.min.js", "dygraph.min.css")
SCRIPTS = ("report.css", "data.js", "overlay.js", "plot.js", "report.js")


def find_library() -> pathlib.Path:
    """The folder with dygraphs."""
    shares = (os.environ.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share").split(":")
    for folder in (pathlib.Path(share) / "javascript" / "dygraphs" for share in shares if share):
        if all((folder / name).is_file() for name in LIBRARY):
            return folder
    raise ReportError("there is no dygraphs, which draws the curves: install libjs-dygraphs")


def check(video: pathlib.Path, tracks: pathlib.Path, out: pathlib.Path) -> None:
    for file, what in ((video, "the path of a video"), (tracks, "the path of its tracks")):
        if file.is_dir():
            raise ReportError(f"'{file}' is a folder: give {what}")
        if not file.is_file():
            raise ReportError(f"there is no file '{file}': give {what}")
        if out.resolve() in file.resolve().parents:
            raise ReportError(f"'{file}' is in '{out}', which is replaced: give another OUT")
    if out.exists() and not out.is_dir():
        raise ReportError(f"'{out}' is a file, and the page needs a folder: give another OUT")
    if out.is_dir() and any(out.iterdir()) and not (out / INDEX).is_file():
        raise ReportError(f"'{out}' holds what is no report: give another OUT")


def make(video: pathlib.Path, tracks: pathlib.Path, out: pathlib.Path, title: str,
         wanted: bool) -> list[str]:
    """Makes the folder `out`, and returns notes. `wanted`: show progress.

    Raises ReportError and OSError.
    """
    check(video, tracks, out)
    library = find_library()
    motion.program()  # raises if there is none
    source = video_file.Video(video)
    parent = out.absolute().parent
    try:
        parent.mkdir(parents=True, exist_ok=True)
        folder = pathlib.Path(tempfile.mkdtemp(prefix=".unfinished-", dir=parent))
    except OSError as error:
        raise ReportError(
            f"can't write into '{parent}' ({error.strerror}): give another OUT") from error
    try:
        folder.chmod(0o777 & ~umask())
        notes = fill(folder, source, tracks, title, wanted)
        copy_files(folder, library)
        if out.exists():
            old = folder.with_name(folder.name + "-old")
            os.replace(out, old)
            os.replace(folder, out)
            shutil.rmtree(old)
        else:
            os.replace(folder, out)
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        # The error itself may name the file that was copied.
        raise ReportError(
            f"can't write into '{out}' (the disk is full): make room or give another OUT"
        ) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return notes


def umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def copy_files(folder: pathlib.Path, library: pathlib.Path) -> None:
    for name in SCRIPTS:
        shutil.copyfile(HERE / "page" / name, folder / name)
    for name in LIBRARY:
        shutil.copyfile(library / name, folder / name)


def read_tracks(moved: motion.Motion, path: pathlib.Path, folder: pathlib.Path, seconds: float,
                wanted: bool) -> track_file.Tracks:
    """Reads the tracks while csd-motion reads them, too: both take as long."""
    try:
        with Progress("reading the tracks", wanted) as progress:
            tracks = track_file.Tracks(path, folder, seconds, progress.show)
    except (OSError, MemoryError):  # not the file's fault
        raise
    except Exception:
        moved.judge()  # if csd-motion refuses the file, its reason is the better one
        raise
    moved.judge()
    return tracks


def fill(folder: pathlib.Path, source: video_file.Video, tracks_path: pathlib.Path, title: str,
         wanted: bool) -> list[str]:
    """Writes the data, the video and index.html into the folder. Returns notes."""
    data = folder / "data"
    data.mkdir()
    with motion.Motion(tracks_path, data, wanted) as moved:
        tracks = read_tracks(moved, tracks_path, data, source.seconds, wanted)
        check_shape(tracks, source)
        path, cut = video_file.prepare(source, folder, wanted)
        shown = video_file.Video(path).times()
        times, notes = compare(tracks, source, shown)

        def page_times(numbers: list[int]) -> Iterator[float]:
            return (times[at] if at >= 0 else math.nan for at in tracks.places(numbers))

        claimed = sum(any(f.counts[:track_file.CLAIMS]) for f in tracks.features.values())
        with Progress("writing displacements", wanted) as progress:
            moved.write_series(page_times, lambda done: progress.show(done / max(claimed, 1)))
    index = {
        "title": title, "video": path.name, "tracks": tracks_path.name,
        "interval": video_file.interval_of(shown), **picture(tracks, source, cut),
        **content(tracks, moved, times), "notes": notes + moved.head["notes"]
    }
    script.write(folder / INDEX, "index", index)
    page = (HERE / "page" / "index.html").read_text(encoding="utf-8")
    (folder / "index.html").write_text(
        page.replace("@TITLE@", html.escape(title)).replace("@VIDEO@", path.name), encoding="utf-8",
        errors="backslashreplace")
    return notes


def sizes(tracks: track_file.Tracks, source: video_file.Video) -> str:
    return (f"of a picture of {tracks.width}×{tracks.height}, "
            f"the video has {source.width}×{source.height}")


def check_shape(tracks: track_file.Tracks, source: video_file.Video) -> None:
    aspect, stored = tracks.width / tracks.height, source.width / source.height
    if abs(aspect / stored - 1) > 0.02:
        raise ReportError(f"the tracks are {sizes(tracks, source)}: are they of this video?")


def is_clipped(times: "array.array[float]", interval: float, near: float) -> bool:
    """Whether the first frame is too short: an edit list begins within it."""
    return len(times) > 1 and near < times[1] - times[0] < interval - near


def find_origin(times: "array.array[float]",
                shown: "array.array[float]") -> tuple[float, float]:
    """The page's origin in the lines' time, s, and the share of times that then match a frame.

    The origin is 0 or, if the stream began elsewhere, the time that makes the first frames match.
    """
    interval = video_file.interval_of(shown)
    near = max(0.0015, 0.1 * interval)  # Matroska rounds to a millisecond

    def share(origin: float, times: "array.array[float]" = times) -> float:
        hits = 0
        for time in times:
            at = bisect.bisect_left(shown, time - origin)
            hits += any(
                abs(shown[i] - time + origin) <= near for i in (at - 1, at) if 0 <= i < len(shown))
        return hits / len(times)

    found = [(origin, share(origin)) for origin in (0.0, times[0] - shown[0])]
    if is_clipped(times, interval, near):  # ffmpeg and Chromium begin with the next frame
        found.append((times[1] - shown[0], share(times[1] - shown[0], times[1:])))
    return max(found, key=lambda one: one[1])


def compare(tracks: track_file.Tracks, source: video_file.Video,
            shown: "array.array[float]") -> tuple["array.array[float]", list[str]]:
    """The lines' times on the page, and notes about how tracks and video differ.

    Raises ReportError if they have little in common.
    """
    origin, share = find_origin(tracks.times, shown)
    if share < 0.5:
        raise ReportError(
            f"of the {len(tracks.times)} lines of '{tracks.path}' {share:.0%} have the time of "
            "a frame of the video: are they of this video?")
    notes, doubts = [], []
    times = array.array("d", (time - origin for time in tracks.times))
    begin, end = times[0], max(times[-1], tracks.until - origin)
    is_apart = max(begin - shown[0], abs(end - shown[-1])) > 1
    repeats = any(a == b for a, b in zip(times, times[1:]))
    # Demuxers that give two frames the same time are wrong from then on. Some don't agree on what
    # an edit list means.
    in_order = (repeats and len(times) <= len(shown) and
                abs(begin - shown[0]) < 1.5 * video_file.interval_of(shown) or
                share < 1 and len(times) == len(shown) and not is_apart)
    if tracks.other_size:
        notes.append(f"note: {tracks.other_size} lines are left out, as the picture's size changes "
                     f"from {tracks.width}×{tracks.height}")
    if (tracks.width, tracks.height) != (source.width, source.height):
        doubts.append(f"they are {sizes(tracks, source)}")
    if share < 0.99 and not in_order:
        doubts.append(
            f"{share:.0%} of the lines have the time of a frame, the others are not shown")
    if is_apart and not in_order:
        doubts.append(f"they are from {begin:.1f} to {end:.1f} s, "
                      f"the video is from {shown[0]:.1f} to {shown[-1]:.1f} s")
    if doubts:
        notes.append(f"warning: the tracks may be another video's: {'; '.join(doubts)}")
    if in_order:
        times = shown[:len(times)]
        notes.append("note: not all lines have the time of a frame of their own: "
                     "they go to the video's frames in their order")
    elif origin == tracks.times[min(1, len(times) - 1)] - shown[0] > tracks.times[0] - shown[0]:
        notes.append("note: the video's edit list begins within its first frame, which browsers "
                     "skip: its line isn't shown")
    elif origin:
        notes.append(f"note: the tracks begin at {tracks.times[0]:.2f} s; "
                     "they are shown from the video's beginning on")
    if tracks.clock != track_file.CLOCKS[0]:
        notes.append(f"note: {track_file.CLOCKS[0]} goes back, so the times are {tracks.clock}")
    if tracks.untimed:
        notes.append(f"note: {tracks.untimed} lines have no {tracks.clock} and are left out")
    return times, notes


def picture(tracks: track_file.Tracks, source: video_file.Video,
            cut: tuple[int, int]) -> dict[str, Any]:
    """The index's members about the picture. `cut`: columns and rows that the video lacks."""
    size, whole = (tracks.width, tracks.height), (source.width, source.height)
    if source.turn % 180:
        size, whole = size[::-1], whole[::-1]
    # The part of the turned picture that the video shows, in pixels of the tracks.
    shown = [p * (w - c) / w for p, w, c in zip(size, whole, cut)]
    return {"width": tracks.width, "height": tracks.height, "turn": source.turn,
            "mirrored": source.mirrored, "shown": shown}


def content(tracks: track_file.Tracks, moved: motion.Motion,
            times: "array.array[float]") -> dict[str, Any]:
    """The index's members about tracks and motion."""
    motions = {f["id"]: f for f in moved.head["features"]}
    return {
        "algorithm": tracks.algorithm, "role": tracks.role, "states": track_file.STATES,
        "frames": len(times), "times": script.packed(times), "begin": times[0], "end": times[-1],
        "left": tracks.left, "top": tracks.top, "step": tracks.step, "chunks": tracks.chunks,
        "bins": track_file.BINS, "scene": [rhythm(r) for r in moved.head["scene"]["rhythms"]],
        "window": moved.head["window"], "features": [
            describe(number, feature, motions.get(number), moved.chunk_of.get(number), times)
            for number, feature in sorted(tracks.features.items())
        ]
    }


def describe(number: int, feature: track_file.Feature, moved: Mapping[str, Any] | None,
             chunk: int | None, times: "array.array[float]") -> dict[str, Any]:
    """A feature in the index. `moved`: csd-motion's result; None if it never claimed a position."""
    found = {
        "id": number, "from": times[feature.first], "to": times[feature.last],
        "counts": feature.counts, "strip": feature.strip()
    }
    if not moved:
        return found | {"rhythms": []}
    return found | {
        "chunk": chunk,
        **{key: moved[key] for key in ("claimed", "farthest", "speed", "start")},
        "rhythms": [rhythm(r) for r in moved["rhythms"]]
    }


def rhythm(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if name != "rates"}
