# SPDX-License-Identifier: LGPL-2.1-or-later
"""What quickstart shows: progress, contact sheet, page, table, score."""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import textwrap
import time
from collections.abc import Iterable, Iterator
from typing import Any

from pipelines.lib import command
from pipelines.lib.tracking import Job

STATES = {  # and how overlay.mp4 shows them
    "learning": "yellow diamond",
    "tracked": "blue circle",
    "occluded": "orange square",
    "lost": "grey cross",
    "out": "grey triangle",
    "ended": "not shown",
}
RESULTS = {
    "overlay.mp4": "the video with its points",
    "tracks.jsonl": "a line a frame",
    "tracks.csv": "a row a point and frame",
    "preview.png": "six frames of overlay.mp4",
    "truth.jsonl": "a line a frame, where the points truly are",
}
PREVIEW_FRAMES = 6


class Progress:
    """A bar on a terminal; on anything else a line when each quarter has passed.

    Only done() shows 100 %: the encoder still works behind the last tracked frame.
    """

    WIDTH = 30

    def __init__(self, name: str) -> None:
        self._name = name
        self._started = time.monotonic()
        self._bar = sys.stderr.isatty()
        self._quarters = 0  # that have been shown

    def __enter__(self) -> "Progress":
        if not self._bar:
            command.print_line(f"tracking {self._name}", sys.stderr)
        return self

    def __exit__(self, *_: Any) -> None:
        if self._bar:
            command.print_line("\r\033[K", sys.stderr, end="")

    def show(self, share: float | None, frames: int) -> None:
        """share: of the video done, 0…1, or None if its length is unknown."""
        left = ""
        if share is not None:
            share = min(share, 0.99)
            if share > 0.02:
                left = f", {clock((time.monotonic() - self._started) * (1 - share) / share)} left"
        self._print(share, frames, left)

    def done(self, frames: int) -> None:
        self._print(1, frames, f", took {clock(time.monotonic() - self._started)}")
        if self._bar:
            command.print_line("", sys.stderr)

    def _print(self, share: float | None, frames: int, rest: str) -> None:
        fps = frames / max(1e-3, time.monotonic() - self._started)
        speed = f"{frames} frames, {fps:.0f} fps{rest}"
        percent = "" if share is None else f"{int(100 * share):3} %"
        if self._bar:
            bar = "?" * self.WIDTH
            if share is not None:
                bar = ("#" * int(share * self.WIDTH)).ljust(self.WIDTH, ".")
            command.print_line(f"\r\033[K[{bar}] {percent}  {speed}", sys.stderr, end="")
        elif share is not None and int(share * 4) > self._quarters:
            self._quarters = int(share * 4)
            command.print_line(f"  {percent} ({speed})", sys.stderr)


def clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02}"


def make_preview(folder: pathlib.Path, frames: int) -> None:
    """Six frames of overlay.mp4, evenly spread, as one picture.

    They are chosen by number, so a video without timestamps works, too.
    """
    if not shutil.which("ffmpeg"):
        command.print_line("quickstart: no preview.png: there is no ffmpeg", sys.stderr)
        return
    count = min(PREVIEW_FRAMES, frames)
    chosen = [(2 * i + 1) * frames // (2 * count) for i in range(count)]
    select = "+".join(f"eq(n\\,{n})" for n in chosen)
    columns = min(2, count)
    rows = -(-count // columns)
    # Square pixels first, then at most 960 columns each: at 640 the ids in a 720p video are
    # illegible.
    filters = (f"select='{select}',scale='trunc(iw*max(sar,0.01)/2)*2':ih,setsar=1,"
               f"scale='min(960,iw)':-2,tile={columns}x{rows}:padding=4")
    # In that folder: in a path ffmpeg takes a colon for a protocol, and a per cent sign for the
    # place of a number. In a session of its own: another Ctrl-C must not end it.
    done = subprocess.run([
        "ffmpeg", "-v", "error", "-y", "-ignore_editlist", "1", "-i", "overlay.mp4", "-an",
        "-vsync", "0", "-vf", filters, "-frames:v", "1", "preview.png"
    ], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          start_new_session=True)
    if done.returncode:
        (folder / "preview.png").unlink(missing_ok=True)  # incomplete, on a full disk
        why = done.stderr.strip().splitlines() or ["ffmpeg failed"]
        command.print_line(f"quickstart: no preview.png: {why[-1]}", sys.stderr)


def make_page(job: Job, folder: pathlib.Path, out: pathlib.Path) -> None:
    """csd-report's page, in `out`. It shows the video without the markers of overlay.mp4."""
    video = folder / "clean.mp4" if job.simulated else job.video
    # Ctrl-C ends csd-report too, and the tracks stay.
    done = subprocess.run([
        os.environ["CSD_REPORT"], f"--title={job.video.name}",
        str(video),
        str(folder / "tracks.jsonl"),
        str(out)
    ], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ["ended early"])[-1]
        # The user doesn't know the temporary folder.
        why = why.removeprefix("csd-report: ").replace(f"{folder}/", "")
        command.print_line(f"quickstart: no page: {why}", sys.stderr)
        # An earlier run's page must not look like this one's.
        if (out / "data" / "index.js").is_file():
            shutil.rmtree(out)


def count_features(path: pathlib.Path) -> tuple[dict[str, int], int, list[str]]:
    """From tracks.csv: the rows of each state, the number of ids, and points outside the picture.

    Only points that the user gave can begin outside the picture.
    """
    rows, outside = dict.fromkeys(STATES, 0), []
    ids: set[str] = set()
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            rows[row["state"]] += 1
            if row["id"] not in ids:
                ids.add(row["id"])
                if row["state"] == "out":
                    outside.append(f"{float(row['x']):g},{float(row['y']):g}")
    return rows, len(ids), outside


def results(job: Job) -> list[str]:
    """The files that this job leaves."""
    return [name for name in RESULTS if job.simulated or name != "truth.jsonl"]


def score(out: pathlib.Path) -> list[tuple[str, str]]:
    """csd-score's figures for tracks.jsonl, as (label, text) rows."""
    done = subprocess.run([
        os.environ["CSD_SCORE"], "--json", "--resamples", "0",
        str(out / "truth.jsonl"),
        str(out / "tracks.jsonl")
    ], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        why = done.stderr.strip().splitlines() or ["csd-score failed"]
        return [("score", f"none: {why[-1]}")]
    scores = json.loads(done.stdout)
    tracker, tau = scores["trackers"][0], scores["clips"][0]["tau"]

    def shown(value: float | None, form: str) -> str:
        return form.format(value) if value is not None else "none"

    return [("sensitivity", shown(tracker["sensitivity"]["value"], "{:.1%}") +
             f"   of the points that are seen are claimed where they are, within {tau:g} px"),
            ("1−precision", shown(tracker["k"]["value"], "{:.1%}") +
             "   of the positions claimed are false: farther off, or of a point that is hidden"),
            ("error", shown(tracker["error"]["median"], "{:.2f} px") +
             "   median, of the claims on points that are seen")]


def why_no_feature(track: Any) -> str:
    if track.get_property("max-features") == 0:
        return "max-features is 0, so none was looked for"
    where = "region" if track.get_property("region") else "picture"
    size = " at that patch-size" if track.get_property("patch-size") else ""
    return f"nothing in the {where} stands out{size}"


def print_properties(properties: Iterable[tuple[str, str, str, str]]) -> None:
    """properties: name, values, default and description of each."""
    for name, values, default, description in properties:
        print(f"{name:17} {values}  (default: {default})")
        print(textwrap.fill(description, 100, initial_indent="    ", subsequent_indent="    "))


def table(job: Job, out: pathlib.Path) -> Iterator[str]:
    """The lines that quickstart prints at the end."""

    def milliseconds(field: str) -> str:
        known = job.stats and job.stats.has_field(field)
        ns = job.stats.get_value(field) if known else None
        return "?" if ns is None else f"{ns / 1e6:.2f} ms"

    rows, ids, outside = count_features(out / "tracks.csv")
    total = sum(rows.values())
    source = "simulating" if job.simulated else "decoding"
    yield (f"frames      {job.frames} of {job.picture}, in {job.seconds:.1f} s: "
           f"{job.frames / job.seconds:.1f} fps with {source} and encoding")
    tracker = job.track.get_property("algorithm").value_nick
    paper = (", the paper's; --algorithm csd is the project's own"
             if tracker == "csd-2012" else "")
    yield f"tracker     {tracker}{paper}"
    if ids:
        yield f"features    {ids} in all, {total / job.frames:.1f} a frame"
    else:
        yield f"features    none: {why_no_feature(job.track)}; --points tracks what you choose"
    for state, marker in STATES.items():
        if rows[state]:
            yield (f"  {state:9} {rows[state] / total:6.1%}  "
                   f"{rows[state] / job.frames:6.1f} a frame   {marker}")
    if outside:
        more = "; …" if len(outside) > 5 else ""
        yield (f"outside     {len(outside)} of {ids} points lie outside the picture of "
               f"{job.picture.split()[0]}: {'; '.join(outside[:5])}{more}")
    yield (f"cost        p50 {milliseconds('time-p50')}, p95 {milliseconds('time-p95')} a frame, "
           "tracking and learning")
    if job.simulated:
        for label, text in score(out):
            yield f"{label:11} {text}"
    else:
        yield f"sound       {', '.join(job.sound) or 'none'}"
    if job.turned:
        yield ("turned      overlay.mp4 only, as the file asks: tracks are in pixels of the "
               "picture as it is stored")
    for name in results(job):
        if (out / name).exists():
            yield f"{out / name}   {RESULTS[name]}"
    if (out / "page").is_dir():
        yield (f"{out / 'page' / 'index.html'}   opens in a browser: "
               "the video with its points, and how each moves")
