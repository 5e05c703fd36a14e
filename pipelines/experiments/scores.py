# SPDX-License-Identifier: LGPL-2.1-or-later
"""The scores of the runs, as csd-score computes them."""

import json
import pathlib
import subprocess
import typing
from collections.abc import Callable, Iterable

from pipelines.experiments import builds, figures, running, sequences, truth
from pipelines.experiments.sequences import Plan, Sequence
from pipelines.lib.failure import Failure

Windows = tuple[range, range] | None  # two ranges of frames; None: there is nothing to compare
Changes = list[tuple[float, float | None]]


def first_and_last_fifth(scene: truth.Truth) -> Windows:
    return truth.fifths(len(scene.hidden))


class Scores:
    """csd-score's JSON for some sequences, with those of their seeds that a share of the plan runs
    on."""

    def __init__(self, plan: Plan, out: pathlib.Path, kinds: Iterable[Sequence],
                 trackers: Iterable[str], share: str = "tracked", resamples: int = 10000) -> None:
        self.out = out
        self._truths: dict[Sequence, list[truth.Truth]] = {}
        self.clips = [(sequence, seed) for sequence in kinds for seed in sequence.seeds
                      if plan.share(share).has(sequence, seed)]
        trackers = tuple(trackers)
        files = []
        for run in self.clips:
            folder = running.folder_of(out, *run)
            files += [folder / f"{name}.jsonl" for name in (f"truth-{share}", *trackers)]
        done = subprocess.run([
            builds.program("csd-score"), "--json", f"--resamples={resamples}", "--names",
            ",".join(trackers), *files
        ], capture_output=True, text=True)
        if done.returncode:
            raise Failure(f"csd-score: {done.stderr.strip()}")
        self.all = json.loads(done.stdout)
        self.trackers: dict[str, typing.Any] = {t["name"]: t for t in self.all["trackers"]}
        self.comparisons: dict[str, typing.Any] = {c["a"]: c for c in self.all["comparisons"]}

    def value(self, tracker: str, measure: str) -> typing.Any:
        found = self.trackers[tracker][measure]
        return found["value"] if isinstance(found, dict) else found

    def of_clips(self, sequence: Sequence, tracker: str, measure: str) -> list[typing.Any]:
        """For each seed: a figure, or a list of a measure by frame."""
        return [
            clip[measure]
            for (scored, _), clip in zip(self.clips, self.trackers[tracker]["clips"])
            if scored is sequence
        ]

    def truths(self, sequence: Sequence) -> list[truth.Truth]:
        """One for each seed."""
        if sequence not in self._truths:
            folders = [running.folder_of(self.out, sequence, seed) for seed in sequence.seeds]
            self._truths[sequence] = [
                truth.Truth(truth.read(folder / "truth-tracked.jsonl")) for folder in folders
            ]
        return self._truths[sequence]

    def change(
        self, sequence: Sequence, tracker: str,
        windows: Callable[[truth.Truth], Windows] = first_and_last_fifth
    ) -> truth.Interval | None:
        """How a feature's sensitivity changes from one window of frames to a later one.

        The mean over features and seeds, with its interval (truth.bootstrap).
        """
        changes: list[float] = []
        for seed, scene in zip(sequence.seeds, self.truths(sequence)):
            folder = running.folder_of(self.out, sequence, seed)
            if parts := windows(scene):
                changes += truth.change(truth.read(folder / "truth-tracked.jsonl"),
                                        truth.read(folder / f"{tracker}.jsonl"), *parts)
        return truth.bootstrap(changes)

    def of_sequence(self, sequence: Sequence, tracker: str, measure: str) -> float | None:
        return figures.mean(self.of_clips(sequence, tracker, measure))

    def part(self, sequence: Sequence, tracker: str, measure: str, begin: float,
             end: float) -> float | None:
        """The mean over the seeds and over a part of the frames; 0 is the begin of the video, 1 its
        end."""
        return figures.mean([
            value for curve in self.of_clips(sequence, tracker, measure)
            for value in curve[round(begin * len(curve)):round(end * len(curve))]
        ])


def changes_after(out: pathlib.Path, wet: Sequence, dry: Sequence, tracker: str) -> Changes:
    """truth.aftermath of all seeds."""
    changes: Changes = []
    for seed in wet.seeds:
        folders = [running.folder_of(out, sequence, seed) for sequence in (wet, dry)]
        wet_truth, dry_truth = (truth.read(f / "truth-tracked.jsonl") for f in folders)
        wet_tracks, dry_tracks = (truth.read(f / f"{tracker}.jsonl") for f in folders)
        changes += truth.aftermath(wet_truth, dry_truth, wet_tracks, dry_tracks)
    return changes


class Findings:
    """All scores of the paper's plan."""

    def __init__(self, plan: Plan, out: pathlib.Path) -> None:
        def score(kinds: list[Sequence], trackers: Iterable[str] = sequences.REPEATED,
                  resamples: int = 10000) -> Scores:
            return Scores(plan, out, kinds, trackers, resamples=resamples)

        self.simulation = score([plan.sequence("simulation")])
        # On three pictures. No resamples: these curves have no intervals.
        self.persistent = score(
            [plan.sequence("simulation"), plan.sequence("more")], sequences.PERSISTENT, 0)
        self.tables = {t: score(plan.of_table(t)) for t in ("table1", "table2", "table3")}
        self.blood = changes_after(out, plan.sequence("irrigation"), plan.sequence("dry"),
                                   "csd-2012")
        # Only of the paper's tables: dry repeats one of their scenes.
        self.mean_shifts = score(plan.of_tables(), ("ms1", "ms2"))
        self.cost = running.read_learning_cost(out)
