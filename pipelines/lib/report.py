# SPDX-License-Identifier: LGPL-2.1-or-later
"""What quickstart shows: progress, contact sheet, page, table, score."""

import csv
import json
import os
import shutil
import subprocess
import sys
import textwrap
import time

from pipelines.lib import command

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
    """A bar on a terminal; on anything else a line as each quarter has passed. Only done() says 100 %: behind the last
    tracked frame there is still the encoder."""

    WIDTH = 30

    def __init__(self, name):
        self._name = name
        self._started = time.monotonic()
        self._bar = sys.stderr.isatty()
        self._told = 0

    def __enter__(self):
        if not self._bar:
            command.told(f"tracking {self._name}", sys.stderr)
        return self

    def __exit__(self, *_):
        if self._bar:
            command.told("\r\033[K", sys.stderr, end="")

    def show(self, share, frames):
        """share: of the video done, 0…1, or None if its length is unknown."""
        left = ""
        if share is not None:
            share = min(share, 0.99)
            if share > 0.02:
                left = f", {clock((time.monotonic() - self._started) * (1 - share) / share)} left"
        self._print(share, frames, left)

    def done(self, frames):
        self._print(1, frames, f", took {clock(time.monotonic() - self._started)}")
        if self._bar:
            command.told("", sys.stderr)

    def _print(self, share, frames, rest):
        fps = frames / max(1e-3, time.monotonic() - self._started)
        speed = f"{frames} frames, {fps:.0f} fps{rest}"
        percent = "" if share is None else f"{int(100 * share):3} %"
        if self._bar:
            bar = "?" * self.WIDTH if share is None else ("#" * int(share * self.WIDTH)).ljust(
                self.WIDTH, ".")
            command.told(f"\r\033[K[{bar}] {percent}  {speed}", sys.stderr, end="")
        elif share is not None and int(share * 4) > self._told:
            self._told = int(share * 4)
            command.told(f"  {percent} ({speed})", sys.stderr)


def clock(seconds):
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02}"


def preview(out, frames):
    """Six frames of overlay.mp4, evenly spread, as one picture. Chosen by number, so that a video without timestamps works
    too."""
    if not shutil.which("ffmpeg"):
        command.told("quickstart: no preview.png: there is no ffmpeg", sys.stderr)
        return
    count = min(PREVIEW_FRAMES, frames)
    chosen = [(2 * i + 1) * frames // (2 * count) for i in range(count)]
    select = "+".join(f"eq(n\\,{n})" for n in chosen)
    columns = min(2, count)
    rows = -(-count // columns)
    # Square pixels first, then at most 960 columns each: at 640 the ids in a 720p video can't be
    # read.
    filters = (
        f"select='{select}',scale='trunc(iw*max(sar,0.01)/2)*2':ih,setsar=1,scale='min(960,iw)':-2,"
        f"tile={columns}x{rows}:padding=4")
    # In that folder, for in a path ffmpeg reads a colon as a protocol and a per cent sign as a
    # number's place.
    done = subprocess.run([
        "ffmpeg", "-v", "error", "-y", "-ignore_editlist", "1", "-i", "overlay.mp4", "-an",
        "-vsync", "0", "-vf", filters, "-frames:v", "1", "preview.png"
    ], cwd=out, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          start_new_session=True)  # another Ctrl-C is not for this
    if done.returncode:
        (out / "preview.png").unlink(missing_ok=True)  # torn, on a full disk
        why = done.stderr.strip().splitlines() or ["ffmpeg failed"]
        command.told(f"quickstart: no preview.png: {why[-1]}", sys.stderr)


def page(job, folder, out):
    """The page to look at, in `out`: of the video as it came, for overlay.mp4 has its markers already."""
    video = folder / "clean.mp4" if job.simulated else job.video
    done = subprocess.run(
        [os.environ["CSD_REPORT"], "--title", job.video.name, video, folder / "tracks.jsonl", out],
        # Ctrl-C ends this, and what was tracked stays
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True)
    if done.returncode:
        why = done.stderr.strip().splitlines() or ["ended early"]
        # The folder is still an unfinished one, whose name is nobody's business.
        command.told(
            f"quickstart: no page: {why[-1].removeprefix('csd-report: ').replace(f'{folder}/', '')}",
            sys.stderr)
        # that of another run must not seem to belong to this one
        if (out / "data" / "index.js").is_file():
            shutil.rmtree(out)


def features(path):
    """From tracks.csv: how many rows each state has, how many ids there are, and where those began that began outside
    the picture, which only points that were given can."""
    rows, ids, outside = dict.fromkeys(STATES, 0), set(), []
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            rows[row["state"]] += 1
            if row["id"] not in ids:
                ids.add(row["id"])
                if row["state"] == "out":
                    outside.append(f"{float(row['x']):g},{float(row['y']):g}")
    return rows, len(ids), outside


def results(job):
    """The files that this job leaves."""
    return [name for name in RESULTS if job.simulated or name != "truth.jsonl"]


def score(out):
    """What csd-score says of tracks.jsonl, as (label, text) rows."""
    done = subprocess.run([
        os.environ["CSD_SCORE"], "--json", "--resamples", "0", out / "truth.jsonl",
        out / "tracks.jsonl"
    ], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        why = done.stderr.strip().splitlines() or ["csd-score failed"]
        return [("score", f"none: {why[-1]}")]
    judged = json.loads(done.stdout)
    tracker, tau = judged["trackers"][0], judged["clips"][0]["tau"]

    def known(value, form):
        return form.format(value) if value is not None else "none"

    return [("sensitivity", known(tracker["sensitivity"]["value"], "{:.1%}") +
             f"   of the points that are seen are claimed where they are, within {tau:g} px"),
            ("1−precision", known(tracker["k"]["value"], "{:.1%}") +
             "   of the positions claimed are false: farther off, or of a point that is hidden"),
            ("error", known(tracker["error"]["median"], "{:.2f} px") +
             "   median, of the claims on points that are seen")]


def why_none(track):
    """Why there is no feature at all."""
    if track.get_property("max-features") == 0:
        return "max-features is 0, so none was looked for"
    where = "region" if track.get_property("region") else "picture"
    return f"nothing in the {where} stands out" + (" at that patch-size"
                                                   if track.get_property("patch-size") else "")


def properties(specs):
    """specs: (name, values, default, blurb) of each property."""
    for name, values, default, blurb in specs:
        print(f"{name:17} {values}  (default: {default})")
        print(textwrap.fill(blurb, 100, initial_indent="    ", subsequent_indent="    "))


def table(job, out):
    """Its lines."""

    def number(field):
        return job.stats.get_value(field) if job.stats and job.stats.has_field(field) else None

    def milliseconds(field):
        ns = number(field)
        return "?" if ns is None else f"{ns / 1e6:.2f} ms"

    rows, ids, outside = features(out / "tracks.csv")
    total = sum(rows.values())
    yield (
        f"frames      {job.frames} of {job.picture}, in {job.seconds:.1f} s: {job.frames / job.seconds:.1f} fps with "
        f"{'simulating' if job.simulated else 'decoding'} and encoding")
    tracker = job.track.get_property("algorithm").value_nick
    yield f"tracker     {tracker}" + (
        ", the paper's, as printed; the project's own: --algorithm csd"
        if tracker == "csd-2012" else "")
    yield (f"features    {ids} in all, {total / job.frames:.1f} a frame" if ids else
          f"features    none: {why_none(job.track)}; --points tracks what you choose")
    for state, marker in STATES.items():
        if rows[state]:
            yield f"  {state:9} {rows[state] / total:6.1%}  {rows[state] / job.frames:6.1f} a frame   {marker}"
    if outside:
        yield (
            f"outside     {len(outside)} of {ids} points lie outside the picture of {job.picture.split()[0]}: "
            f"{'; '.join(outside[:5])}{'; …' if len(outside) > 5 else ''}")
    yield f"cost        p50 {milliseconds('time-p50')}, p95 {milliseconds('time-p95')} a frame, tracking and learning"
    if job.simulated:
        for label, text in score(out):
            yield f"{label:11} {text}"
    else:
        yield f"sound       {', '.join(job.sound) or 'none'}"
    if job.turned:
        yield "turned      overlay.mp4 only, as the file asks: tracks are in pixels of the picture as it is stored"
    for name in results(job):
        if (out / name).exists():
            yield f"{out / name}   {RESULTS[name]}"
    if (out / "page").is_dir():
        yield f"{out / 'page' / 'index.html'}   opens in a browser: the video with its points, and how each moves"
