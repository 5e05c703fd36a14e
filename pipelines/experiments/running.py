# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs what has not been run yet, two at a time or more, and says how far it is."""

import csv
import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import builds
import sequences

HERE = pathlib.Path(__file__).resolve().parent
WHOLE = "whole.json"  # of a plan that was run in one go


def folder_of(out, sequence, seed):
    return out / f"{sequence.name}-{seed}"


def finished(out, sequence, seed, plan):
    """Whether this run is there, made by this build, with all its trackers."""
    folder = folder_of(out, sequence, seed)
    try:
        made = json.loads((folder / "run.json").read_text())
    except (OSError, ValueError):
        return False
    return made["identity"] == builds.identity(sequence, seed, plan) and all(
        (folder / f"{name}.jsonl").exists() for share in plan.shares_of(sequence, seed)
        for name in (f"truth-{share.name}", *share.trackers))


def minutes(seconds):
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


def spent(plan, out):
    """Seconds that all runs of the plan took, by the clock and of the processors."""
    runs = [json.loads((folder_of(out, *run) / "run.json").read_text()) for run in plan.runs()]
    return tuple(sum(run.get(kind, 0) for run in runs) for kind in ("seconds", "processor_seconds"))


def versions(plan, out):
    """{what: which} that the runs were made with; where they differ, all of them. Of older runs, which don't say it, what is here now."""
    now = {**builds.versions(), "these": "when this page was written, not when all was run"}
    found = {}
    for run in plan.runs():
        for what, which in json.loads(
            (folder_of(out, *run) / "run.json").read_text()).get("versions", now).items():
            found.setdefault(what, []).append(which)
    return {what: "; ".join(dict.fromkeys(which)) for what, which in found.items()}


def by_the_clock(plan, out):
    """(seconds, jobs) that all runs of the plan took, if they were made in one go; else None."""
    try:
        whole = json.loads((out / WHOLE).read_text())
    except OSError:
        return None
    return (whole["seconds"],
            whole["jobs"]) if whole["runs"] == [f"{s.name}-{seed}"
                                                for s, seed in plan.runs()] else None


class Progress:
    """A line on the terminal, a line for each finished run elsewhere."""

    def __init__(self, plan, runs):
        self._cost = {(s.name, seed): plan.cost(s, seed) for s, seed in runs}
        self._share = dict.fromkeys(self._cost, 0.0)
        self._began = time.monotonic()
        self._terminal = sys.stderr.isatty()

    def say(self, name, seed, share):
        self._share[name, seed] = share
        done = sum(self._cost[run] * part
                   for run, part in self._share.items()) / sum(self._cost.values())
        over = sum(part == 1 for part in self._share.values())
        spent = time.monotonic() - self._began
        left = f", about {minutes(spent / done - spent)} left" if done > 0.02 else ""
        text = f"{over} of {len(self._cost)} runs, {100 * done:.0f} %, {minutes(spent)}{left}"
        if self._terminal:
            print(f"\r{text}\033[K", end="\n" if over == len(self._cost) else "", file=sys.stderr,
                  flush=True)
        elif share == 1:
            print(text, file=sys.stderr, flush=True)


def run_all(plan, mode, seeds, out, jobs):
    """All runs of the plan that are not there yet. The others go on where one fails. Raises builds.Failure."""
    todo = [run for run in plan.runs() if not finished(out, *run, plan)]
    kept = len(plan.runs()) - len(todo)
    if kept:
        print(f"{kept} of {len(plan.runs())} runs were there already", file=sys.stderr)
    if not todo:
        return
    (out / WHOLE).unlink(missing_ok=True)
    began = time.monotonic()
    # --will-cite: no notice among the progress. --line-buffer: whole lines of several runs.
    command = [
        "parallel", "--will-cite", "--plain", "--jobs",
        str(jobs), "--line-buffer", "--colsep", " ", "/usr/bin/python3", "-B",
        str(HERE / "run_sequence.py"), mode,
        str(seeds),
        str(out), "{1}", "{2}"
    ]
    progress = Progress(plan, todo)
    with open(out / "errors.txt",
              "w+") as errors, subprocess.Popen(command, stdin=subprocess.PIPE,
                                                stdout=subprocess.PIPE, stderr=errors, text=True,
                                                env=builds.environment(),
                                                start_new_session=True) as process:
        try:
            process.stdin.write("".join(f"{s.name} {seed}\n" for s, seed in todo))
            process.stdin.close()
            for line in process.stdout:
                name, seed, share = line.split()
                progress.say(name, int(seed), float(share))
            code = process.wait()
        except BaseException:
            # parallel passes its first SIGTERM on to nobody; its session holds all that it started.
            os.killpg(process.pid, signal.SIGTERM)
            raise
        errors.seek(0)
        said = errors.read().strip()
    failed = [f"{s.name}, seed {seed}" for s, seed in todo if not finished(out, s, seed, plan)]
    if code or failed:
        raise builds.Failure(
            f"{len(failed)} of {len(todo)} runs failed ({'; '.join(failed)}):\n{said}\n"
            "the same command runs these again")
    if not kept:
        (out / WHOLE).write_text(
            json.dumps({
                "runs": [f"{s.name}-{seed}" for s, seed in todo], "jobs": jobs,
                "seconds": round(time.monotonic() - began, 1)
            }))


def take_pictures():
    """The first frames of the clips that sequences have as texture. Raises builds.Failure."""
    for *_, clip in sequences.PICTURE_KINDS:
        source, picture = sequences.CLIPS / clip, sequences.first_frame(clip)
        # Once: a second decoding of the same file has been seen to differ.
        if picture.exists() and picture.stat().st_mtime >= source.stat().st_mtime:
            continue
        picture.parent.mkdir(parents=True, exist_ok=True)
        unfinished = picture.with_suffix(".unfinished")
        done = subprocess.run([
            "gst-launch-1.0", "-q", "filesrc", f"location={source}", "!", "decodebin", "!",
            "videoconvert", "!", "pngenc", "snapshot=true", "!", "filesink",
            f"location={unfinished}"
        ], capture_output=True, text=True, env=builds.environment())
        if done.returncode or not unfinished.stat().st_size:
            raise builds.Failure(f"{source}: no frame could be read: {done.stderr.strip()}")
        unfinished.rename(picture)


def palindromes(plan, out):
    """csd on the clips, forward and backward: what csd-score says of it."""
    path, clips = out / "palindromes.json", [
        sequences.CLIPS / clip for clip in sequences.PALINDROMES
    ]
    made_by = {
        "plugin": builds.fingerprint("plugin"), "clips": [builds.checksum(clip) for clip in clips],
        "frames": plan.palindrome_frames
    }
    try:
        made = json.loads(path.read_text())
        if made["identity"] == made_by:
            return made
    except (OSError, ValueError, KeyError):
        pass
    print("palindromes", file=sys.stderr)
    done = subprocess.run([
        HERE / "palindrome", "--no-install", "--json", "--trackers", "csd", "--frames",
        str(plan.palindrome_frames), *clips
    ], stdin=subprocess.DEVNULL, capture_output=True, text=True, env=builds.environment())
    if done.returncode:
        raise builds.Failure(done.stderr.strip())
    made = {**json.loads(done.stdout), "identity": made_by}
    path.write_text(json.dumps(made))
    return made


def learning_cost(plan, out):
    """Fig. 11's table, measured when nothing else runs."""
    path, made_by = out / "learning-cost.tsv", builds.fingerprint("learning-cost")
    header = f"# {plan.cost_features} {plan.cost_frames} {made_by}\n"
    if path.exists() and path.read_text().startswith(header):
        return
    print("learning times", file=sys.stderr)
    done = subprocess.run([
        builds.program("learning-cost"),
        str(plan.cost_features),
        str(plan.cost_frames),
        str(plan.sequences[0].seeds[0])
    ], capture_output=True, text=True, env=builds.environment())
    if done.returncode:
        raise builds.Failure(done.stderr.strip())
    path.write_text(header + done.stdout)


def read_learning_cost(out):
    """{search: [(learning ms, retrained leaves, tracking ms) of each frame, per feature]}"""
    table = {}
    with open(out / "learning-cost.tsv") as file:
        file.readline()
        for row in csv.DictReader(file, delimiter="\t"):
            table.setdefault(row["search"], []).append(
                (float(row["learning_ms"]), float(row["retrained"]), float(row["tracking_ms"])))
    return table
