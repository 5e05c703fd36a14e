# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs what has not been run yet, several at a time, and shows the progress."""

import csv
import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import typing
from collections.abc import Sequence as Rows

from pipelines.experiments import builds, sequences
from pipelines.experiments.sequences import Plan, Sequence
from pipelines.lib.failure import Failure

HERE = pathlib.Path(__file__).resolve().parent
WHOLE = "whole.json"  # there if all runs of a plan were made in one go

Cost = dict[str, list[tuple[float, float, float]]]


def folder_of(out: pathlib.Path, sequence: Sequence, seed: int) -> pathlib.Path:
    return out / f"{sequence.name}-{seed}"


def finished(out: pathlib.Path, sequence: Sequence, seed: int, plan: Plan) -> bool:
    """Whether this run is there, of this build and with all its trackers."""
    folder = folder_of(out, sequence, seed)
    try:
        made = json.loads((folder / "run.json").read_text())
    except (OSError, ValueError):
        return False
    return made["identity"] == builds.identity(sequence, seed, plan) and all(
        (folder / f"{name}.jsonl").exists() for share in plan.shares_of(sequence, seed)
        for name in (f"truth-{share.name}", *share.trackers))


def minutes(seconds: float) -> str:
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


def described(plan: Plan, out: pathlib.Path) -> list[dict[str, typing.Any]]:
    """The run.json of each run."""
    return [json.loads((folder_of(out, *run) / "run.json").read_text()) for run in plan.runs()]


def spent(plan: Plan, out: pathlib.Path) -> tuple[float, float]:
    """Seconds that all runs of the plan took: of wall-clock time and of processor time."""
    runs = described(plan, out)
    return (sum(run.get("seconds", 0) for run in runs),
            sum(run.get("processor_seconds", 0) for run in runs))


def versions(plan: Plan, out: pathlib.Path) -> dict[str, str]:
    """The versions that the runs were made with, all of them where they differ.

    For older runs, which do not record them, the present ones.
    """
    now = {**builds.versions(), "these": "when this page was written, not when all was run"}
    found: dict[str, list[str]] = {}
    for run in described(plan, out):
        for name, version in run.get("versions", now).items():
            found.setdefault(name, []).append(version)
    return {name: "; ".join(dict.fromkeys(each)) for name, each in found.items()}


def by_the_clock(plan: Plan, out: pathlib.Path) -> tuple[float, int] | None:
    """How many seconds all runs took, and how many ran at a time; None unless they were made in
    one go."""
    try:
        whole = json.loads((out / WHOLE).read_text())
    except OSError:
        return None
    if whole["runs"] != [f"{sequence.name}-{seed}" for sequence, seed in plan.runs()]:
        return None
    return whole["seconds"], whole["jobs"]


class Progress:
    """A line that changes on a terminal; elsewhere a line for each finished run."""

    def __init__(self, plan: Plan, runs: Rows[tuple[Sequence, int]]) -> None:
        self._cost = {(sequence.name, seed): plan.cost(sequence, seed) for sequence, seed in runs}
        self._share = dict.fromkeys(self._cost, 0.0)
        self._began = time.monotonic()
        self._terminal = sys.stderr.isatty()

    def say(self, name: str, seed: int, share: float) -> None:
        self._share[name, seed] = share
        cost_done = sum(self._cost[run] * part for run, part in self._share.items())
        done = cost_done / sum(self._cost.values())
        over = sum(part == 1 for part in self._share.values())
        passed = time.monotonic() - self._began
        left = f", about {minutes(passed / done - passed)} left" if done > 0.02 else ""
        text = f"{over} of {len(self._cost)} runs, {100 * done:.0f} %, {minutes(passed)}{left}"
        if self._terminal:
            print(f"\r{text}\033[K", end="\n" if over == len(self._cost) else "", file=sys.stderr,
                  flush=True)
        elif share == 1:
            print(text, file=sys.stderr, flush=True)


def run_all(plan: Plan, mode: str, seeds: int, out: pathlib.Path, jobs: int) -> None:
    """Makes all runs of the plan that are not there yet.

    The others go on if one fails; Failure is raised at the end.
    """
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
        "parallel", "--will-cite", "--plain", "--jobs", str(jobs), "--line-buffer", "--colsep", " ",
        "/usr/bin/python3", "-B", "-P", "-m", "pipelines.experiments.run_sequence", mode,
        str(seeds), str(out), "{1}", "{2}"
    ]
    progress = Progress(plan, todo)
    with open(out / "errors.txt", "w+") as errors, subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True,
            env=builds.environment(), start_new_session=True) as process:
        assert process.stdin and process.stdout
        try:
            process.stdin.write("".join(f"{sequence.name} {seed}\n" for sequence, seed in todo))
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
        messages = errors.read().strip()
    failed = [
        f"{sequence.name}, seed {seed}" for sequence, seed in todo
        if not finished(out, sequence, seed, plan)
    ]
    if code or failed:
        raise Failure(f"{len(failed)} of {len(todo)} runs failed ({'; '.join(failed)}):\n"
                      f"{messages}\nthe same command runs these again")
    if not kept:
        (out / WHOLE).write_text(
            json.dumps({
                "runs": [f"{sequence.name}-{seed}" for sequence, seed in todo],
                "jobs": jobs,
                "seconds": round(time.monotonic() - began, 1),
            }))


def take_pictures() -> None:
    """Keeps the first frames of the clips that are textures of sequences. Raises Failure."""
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
            raise Failure(f"{source}: no frame could be read: {done.stderr.strip()}")
        unfinished.rename(picture)


def palindromes(plan: Plan, out: pathlib.Path) -> dict[str, typing.Any]:
    """csd-score's report on csd, for the clips played forward and backward."""
    path = out / "palindromes.json"
    clips = [sequences.CLIPS / clip for clip in sequences.PALINDROMES]
    identity = {
        "plugin": builds.fingerprint("plugin"),
        "clips": [builds.checksum(clip) for clip in clips],
        "frames": plan.palindrome_frames,
    }
    try:
        kept: dict[str, typing.Any] = json.loads(path.read_text())
        if kept["identity"] == identity:
            return kept
    except (OSError, ValueError, KeyError):
        pass
    print("palindromes", file=sys.stderr)
    done = subprocess.run([
        HERE / "palindrome", "--no-install", "--json", "--trackers", "csd", "--frames",
        str(plan.palindrome_frames), *clips
    ], stdin=subprocess.DEVNULL, capture_output=True, text=True, env=builds.environment())
    if done.returncode:
        raise Failure(done.stderr.strip())
    made = {**json.loads(done.stdout), "identity": identity}
    path.write_text(json.dumps(made))
    return made


def learning_cost(plan: Plan, out: pathlib.Path) -> None:
    """Measures the table of the paper's Fig. 11; nothing else should run meanwhile."""
    path, program = out / "learning-cost.tsv", builds.fingerprint("learning-cost")
    header = f"# {plan.cost_features} {plan.cost_frames} {program}\n"
    if path.exists() and path.read_text().startswith(header):
        return
    print("learning times", file=sys.stderr)
    done = subprocess.run([
        builds.program("learning-cost"), str(plan.cost_features), str(plan.cost_frames),
        str(plan.sequences[0].seeds[0])
    ], capture_output=True, text=True, env=builds.environment())
    if done.returncode:
        raise Failure(done.stderr.strip())
    path.write_text(header + done.stdout)


def read_learning_cost(out: pathlib.Path) -> Cost:
    """By search, for each frame: learning ms, retrained leaves and tracking ms per feature."""
    table: Cost = {}
    with open(out / "learning-cost.tsv") as file:
        file.readline()
        for row in csv.DictReader(file, delimiter="\t"):
            table.setdefault(row["search"], []).append(
                (float(row["learning_ms"]), float(row["retrained"]), float(row["tracking_ms"])))
    return table
