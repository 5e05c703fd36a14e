# SPDX-License-Identifier: LGPL-2.1-or-later
"""Puts a page together: OUT/index.html, what it shows and what it needs."""

import bisect
import errno
import html
import os
import pathlib
import shutil
import tempfile

import script
import motion
import tracks as track_file
import video as video_file
from failure import Failure, Progress

HERE = pathlib.Path(__file__).resolve().parent
INDEX = "data/index.js"
LIBRARY = ("dygraph.min.js", "dygraph.min.css")


def library():
    """The folder with dygraphs."""
    shares = (os.environ.get("XDG_DATA_DIRS") or "/usr/local/share:/usr/share").split(":")
    for folder in (pathlib.Path(share) / "javascript" / "dygraphs" for share in shares if share):
        if all((folder / name).is_file() for name in LIBRARY):
            return folder
    raise Failure("there is no dygraphs, which draws the curves: install libjs-dygraphs")


def check(video, tracks, out):
    for file, what in ((video, "the path of a video"), (tracks, "the path of its tracks")):
        if file.is_dir():
            raise Failure(f"'{file}' is a folder: give {what}")
        if not file.is_file():
            raise Failure(f"there is no file '{file}': give {what}")
        if out.resolve() in file.resolve().parents:
            raise Failure(f"'{file}' is in '{out}', which is replaced: give another OUT")
    if out.exists() and not out.is_dir():
        raise Failure(f"'{out}' is a file, and the page needs a folder: give another OUT")
    if out.is_dir() and any(out.iterdir()) and not (out / INDEX).is_file():
        raise Failure(f"'{out}' holds what is no report: give another OUT")


def origin_of(times, shown):
    """What to take from stream times (s) so that they are the page's: 0, or if the stream began elsewhere, so much that the first frames
    fall together. And the share of the times that then fall on a frame."""
    near = max(0.0015, 0.1 * video_file.interval_of(shown))  # Matroska rounds to a millisecond

    def share(origin):
        hits = 0
        for time in times:
            at = bisect.bisect_left(shown, time - origin)
            hits += any(
                abs(shown[i] - time + origin) <= near for i in (at - 1, at) if 0 <= i < len(shown))
        return hits / len(times)

    return max(((origin, share(origin)) for origin in (0.0, times[0] - shown[0])),
               key=lambda found: found[1])


def described(number, feature, told, chunk_of, origin):
    """A feature of the index. `told`: what csd-motion says of it, None if it was never claimed."""
    return {
        "id": number, "from": feature.first - origin, "to": feature.last - origin,
        "counts": feature.counts, "strip": feature.strip(), **({
            "chunk": chunk_of,
            **{k: told[k] for k in ("claimed", "farthest", "speed", "start")}, "rhythms": [
                rhythm(r) for r in told["rhythms"]
            ]
        } if told else {"rhythms": []})
    }


def rhythm(told):
    return {name: value for name, value in told.items() if name != "rates"}


def make(video, tracks, out, title, wanted):
    """Makes the folder `out`. `wanted`: tell progress. Returns notes. Raises Failure and OSError."""
    check(video, tracks, out)
    parts = library()
    motion.program()
    source = video_file.Video(video)
    parent = out.absolute().parent
    try:
        parent.mkdir(parents=True, exist_ok=True)
        folder = pathlib.Path(tempfile.mkdtemp(prefix=".unfinished-", dir=parent))
    except OSError as error:
        raise Failure(
            f"can't write into '{parent}' ({error.strerror}): give another OUT") from error
    try:
        folder.chmod(0o777 & ~umask())
        notes = fill(folder, parts, source, tracks, title, wanted)
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
        # It may name the file that was copied.
        raise Failure(f"can't write into '{out}' (the disk is full): make room or give another OUT"
                      ) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return notes


def umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


def fill(folder, parts, source, tracks_path, title, wanted):
    data = folder / "data"
    data.mkdir()
    with motion.Motion(tracks_path, data, wanted) as moved:
        return fill_by(moved, folder, data, parts, source, tracks_path, title, wanted)


def fill_by(moved, folder, data, parts, source, tracks_path, title, wanted):
    with Progress("reading the tracks", wanted) as progress:
        tracks = track_file.Tracks(tracks_path, data, source.seconds, progress.show)
    aspect, stored = tracks.width / tracks.height, source.width / source.height
    if abs(aspect / stored - 1) > 0.02:
        raise Failure(
            f"the tracks are of a picture of {tracks.width}×{tracks.height}, the video has {source.width}×{source.height}: "
            "are they of this video?")
    path, cut = video_file.prepare(source, folder, wanted)
    shown = video_file.Video(path).times()
    origin, share = origin_of(tracks.times, shown)
    if share < 0.5:
        raise Failure(
            f"of the {len(tracks.times)} lines of '{tracks_path}' {share:.0%} have the time of a frame of the video: "
            "are they of this video?")
    notes = []
    begin, end = tracks.times[0] - origin, tracks.times[-1] - origin
    doubts = []
    if (tracks.width, tracks.height) != (source.width, source.height):
        doubts.append(
            f"they are of a picture of {tracks.width}×{tracks.height}, the video has {source.width}×{source.height}"
        )
    if share < 0.99:
        doubts.append(
            f"{share:.0%} of the lines have the time of a frame, the others are not shown")
    if max(begin - shown[0], abs(end - shown[-1])) > 1:
        doubts.append(
            f"they are from {begin:.1f} to {end:.1f} s, the video is from {shown[0]:.1f} to {shown[-1]:.1f} s"
        )
    if doubts:
        notes.append(f"warning: the tracks may be another video's: {'; '.join(doubts)}")
    if origin:
        notes.append(
            f"note: the tracks begin at {tracks.times[0]:.2f} s; they are shown from the video's begin on"
        )
    if tracks.untimed:
        notes.append(f"note: {tracks.untimed} lines have no stream_time and are left out")

    def page_time(seconds):
        index = tracks.by_pts.get(round(1e6 * seconds))
        return float("nan") if index is None else tracks.times[index] - origin

    claimed = sum(any(f.counts[:track_file.CLAIMS]) for f in tracks.features.values())
    with Progress("writing displacements", wanted) as progress:
        moved.series(page_time, lambda done: progress.show(done / max(claimed, 1)))
    told = {f["id"]: f for f in moved.head["features"]}
    turned = source.turn % 180 != 0
    picture = (tracks.height, tracks.width) if turned else (tracks.width, tracks.height)
    whole = (source.height, source.width) if turned else (source.width, source.height)
    script.write(
        folder / INDEX,
        "index",
        {
            "title": title,
            "video": path.name,
            "tracks": tracks_path.name,
            "width": tracks.width,
            "height": tracks.height,
            "turn": source.turn,
            # What the video shows of the turned picture, in pixels of the tracks.
            "shown": [p * (w - c) / w for p, w, c in zip(picture, whole, cut)],
            "algorithm": tracks.algorithm,
            "role": tracks.role,
            "states": track_file.STATES,
            "frames": len(tracks.times),
            "interval": video_file.interval_of(shown),
            "begin": begin,
            "end": end,
            "left": tracks.left,
            "top": tracks.top,
            "step": tracks.step,
            "chunks": [tracks.times[i] - origin for i in tracks.chunks],
            "bins": track_file.BINS,
            "scene": [rhythm(r) for r in moved.head["scene"]["rhythms"]],
            "window": moved.head["window"],
            "features": [
                described(number, feature, told.get(number), moved.chunk_of.get(number), origin)
                for number, feature in sorted(tracks.features.items())
            ],
            "notes": notes + moved.head["notes"]
        })
    for name in ("report.css", "data.js", "overlay.js", "plot.js", "report.js"):
        shutil.copyfile(HERE / "page" / name, folder / name)
    page = (HERE / "page" / "index.html").read_text(encoding="utf-8")
    (folder / "index.html").write_text(
        page.replace("@TITLE@", html.escape(title)).replace("@VIDEO@", path.name), encoding="utf-8",
        errors="backslashreplace")
    for name in LIBRARY:
        shutil.copyfile(parts / name, folder / name)
    return notes
