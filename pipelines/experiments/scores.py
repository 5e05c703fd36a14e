# SPDX-License-Identifier: LGPL-2.1-or-later
"""What csd-score says of the runs."""

import json
import subprocess

import builds
import figures
import running
import sequences
import truth


class Scores:
    """Of some sequences, those of their seeds that a share of the plan has: csd-score's JSON, by tracker."""

    def __init__(self, plan, out, kinds, trackers, share="tracked", resamples=10000):
        self.out, self._truths = out, {}
        self.clips = [(s, seed)
                      for s in kinds
                      for seed in s.seeds
                      if plan.share(share).has(s, seed)]
        arguments = []
        for run in self.clips:
            folder = running.folder_of(out, *run)
            arguments += [
                folder / f"truth-{share}.jsonl", *(folder / f"{t}.jsonl" for t in trackers)
            ]
        done = subprocess.run([
            builds.program("csd-score"), "--json", f"--resamples={resamples}", "--names",
            ",".join(trackers), *arguments
        ], capture_output=True, text=True)
        if done.returncode:
            raise builds.Failure(f"csd-score: {done.stderr.strip()}")
        self.all = json.loads(done.stdout)
        self.trackers = {t["name"]: t for t in self.all["trackers"]}
        self.comparisons = {c["a"]: c for c in self.all["comparisons"]}

    def value(self, tracker, measure):
        found = self.trackers[tracker][measure]
        return found["value"] if isinstance(found, dict) else found

    def of_clips(self, sequence, tracker, measure):
        """Of each seed: a figure, or of a measure by frame the list."""
        return [
            clip[measure]
            for (s, _), clip in zip(self.clips, self.trackers[tracker]["clips"])
            if s is sequence
        ]

    def truths(self, sequence):
        """A truth.Truth for each seed."""
        if sequence not in self._truths:
            self._truths[sequence] = [
                truth.Truth(
                    truth.read(running.folder_of(self.out, sequence, seed) / "truth-tracked.jsonl"))
                for seed in sequence.seeds
            ]
        return self._truths[sequence]

    def change(self, sequence, tracker, windows=lambda scene: truth.fifths(len(scene.hidden))):
        """Sensitivity of a feature in the later of two windows of frames less that in the earlier: mean over features and seeds, and
        its interval, by truth.bootstrap. windows(truth.Truth): two ranges, or None where there is nothing to tell apart."""
        changes = []
        for seed, scene in zip(sequence.seeds, self.truths(sequence)):
            folder = running.folder_of(self.out, sequence, seed)
            if parts := windows(scene):
                changes += truth.change(truth.read(folder / "truth-tracked.jsonl"),
                                        truth.read(folder / f"{tracker}.jsonl"), *parts)
        return truth.bootstrap(changes)

    def of_sequence(self, sequence, tracker, measure):
        return figures.mean(self.of_clips(sequence, tracker, measure))

    def part(self, sequence, tracker, measure, begin, end):
        """Mean over frames begin·length to end·length and the seeds."""
        return figures.mean([v for c in self.of_clips(sequence, tracker, measure)
                             for v in c[round(begin * len(c)):round(end * len(c))]])


def changes_after(out, wet, dry, tracker):
    """truth.aftermath of all seeds."""
    changes = []
    for seed in wet.seeds:
        folders = [running.folder_of(out, sequence, seed) for sequence in (wet, dry)]
        changes += truth.aftermath(*(truth.read(f / "truth-tracked.jsonl") for f in folders),
                                   *(truth.read(f / f"{tracker}.jsonl") for f in folders))
    return changes


class Findings:
    """All scores of the paper's plan."""

    def __init__(self, plan, out):
        def score(kinds, trackers=sequences.REPEATED, **options):
            return Scores(plan, out, kinds, trackers, **options)

        self.simulation = score([plan.sequence("simulation")])
        # On three pictures; for curves alone, which want no intervals.
        self.persistent = score(
            [plan.sequence("simulation"), plan.sequence("more")], sequences.PERSISTENT, resamples=0)
        self.tables = {t: score(plan.of_table(t)) for t in ("table1", "table2", "table3")}
        self.blood = changes_after(out, plan.sequence("irrigation"), plan.sequence("dry"),
                                   "csd-2012")
        # Of the paper's classes alone: dry is a scene of theirs again.
        self.mean_shifts = score(plan.of_tables(), ("ms1", "ms2"))
        self.cost = running.read_learning_cost(out)
