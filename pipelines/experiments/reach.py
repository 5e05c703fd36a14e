# SPDX-License-Identifier: LGPL-2.1-or-later
"""csd's goals in beyond.json: which of them it reaches, and how it compares with each rival."""

import dataclasses
import json
import pathlib
import typing
from collections.abc import Iterable, Mapping, Sequence as Rows

from pipelines.experiments import page, running, truth
from pipelines.experiments.evaluation import number
from pipelines.experiments.scores import Scores
from pipelines.experiments.sequences import Plan, Sequence, Share

GOALS = json.loads((pathlib.Path(__file__).resolve().parent / "beyond.json").read_text())
WITHIN = 10  # frames that a point has to come back
# A black picture, a cut or a wipe hides at least this share of the points.
TOGETHER = 0.2
ONE = 0.9995  # what prints as 1.000
MEASURES = (("delta_avg", "δavg"), ("aj", "AJ"), ("oa", "OA"))

Value = float | None
Goals = Mapping[str, typing.Any]  # of a row of beyond.json
Scenario = tuple[str, Goals, list[Sequence]]  # title, goals, sequences


@dataclasses.dataclass(frozen=True)
class Criterion:
    name: str
    goal: str  # in words
    found: str
    reached: bool | None  # None: nothing happened that could show it


@dataclasses.dataclass
class Row:
    """A scenario: its sequences, its goals, and csd-score's figures for each share of the plan."""

    title: str
    goals: Goals
    kinds: list[Sequence]
    scores: dict[str, Scores]  # by share

    @property
    def csd(self) -> dict[str, typing.Any]:
        figures: dict[str, typing.Any] = self.scores["tracked"].trackers["csd"]
        return figures


class Standing(typing.NamedTuple):
    """csd beside a rival in one measure."""

    rival: Value
    csd: Value
    p: Value
    result: str


def rows_of(plan: Plan) -> tuple[list[Scenario], list[Scenario]]:
    """All simulated scenarios, and those whose textures are real."""
    simulated = [(goals["title"], goals, plan.of_table(name))
                 for name, goals in GOALS["rows"].items()]
    pictures = [(s.title, GOALS["pictures"][s.name], [s]) for s in plan.of_table("pictures")]
    return simulated, pictures


def score(plan: Plan, out: pathlib.Path, kinds: Iterable[Sequence]) -> dict[str, Scores]:
    """The scores of each share of the plan."""
    kinds = tuple(kinds)
    return {
        share.name: Scores(plan, out, kinds, ["csd", *(t for t in share.trackers if t != "csd")],
                           share.name) for share in plan.shares
    }


def at_most(name: str, goal: float, value: Value, digits: int, found: str = "",
            unit: str = "") -> Criterion:
    return Criterion(name, f"{name} ≤ {goal:g}{unit}", found or number(value, digits),
                     value is not None and value <= goal)


def at_least(name: str, goal: float, value: Value, digits: int, found: str = "") -> Criterion:
    return Criterion(name, f"{name} ≥ {goal:g}", found or number(value, digits),
                     value is not None and value >= goal)


def shown(criterion: Criterion, occasion: bool) -> Criterion:
    """The criterion, left open if there was no occasion that could show it."""
    return criterion if occasion else dataclasses.replace(criterion, reached=None)


def fine(measure: Mapping[str, Value]) -> str:
    """A figure near 0 or 1 with its interval."""
    value, low, high = (number(measure[name], 4) for name in ("value", "low", "high"))
    return f"{value} ({low}–{high})"


def lasting(row: Row) -> Criterion:
    """Whether the last fifth of the frames is as good as the first.

    The interval of a feature's change of sensitivity must reach 0, and contain no loss beyond the
    goal's: a wide interval alone shows nothing.
    """
    (sequence,), scores, loss = row.kinds, row.scores["tracked"], row.goals["lasting"]
    change = scores.change(sequence, "csd")
    first, last = (" / ".join(
        number(scores.part(sequence, "csd", f"{m}_by_frame", *part), 4)
        for m in ("sensitivity", "k")) for part in ((0, 0.2), (0.8, 1)))
    changed = "–"
    if change is not None:
        changed = page.minus("{:+.4f} ({:+.4f} to {:+.4f}) a feature".format(*change))
    error = row.csd["error"]
    return Criterion(
        "last fifth", "last fifth as good as the first, "
        f"no loss of sensitivity beyond {loss:g} within the interval",
        f"first fifth {first}, {number(error['first_fifth'], 2)} px; "
        f"last {last}, {number(error['last_fifth'], 2)} px; sensitivity {changed}",
        change is not None and change[2] >= 0 and change[1] >= -loss)


def back(row: Row, out: pathlib.Path) -> Criterion:
    """Whether points are found again within WITHIN frames after a black picture, a cut or a wipe.

    The worst of these three counts.
    """
    by_sequence: dict[str, list[bool]] = {}
    for sequence in row.kinds:
        found = by_sequence[sequence.title] = []
        for seed in sequence.seeds:
            folder = running.folder_of(out, sequence, seed)
            found += truth.returns(truth.read(folder / "truth-tracked.jsonl"),
                                   truth.read(folder / "csd.jsonl"), WITHIN, TOGETHER)
    shares = [sum(found) / len(found) for found in by_sequence.values() if found]
    counts = "; ".join(
        f"{title} {sum(found)} of {len(found)}" for title, found in by_sequence.items())
    criterion = at_least(f"back within {WITHIN} frames", row.goals["back"],
                         min(shares, default=None), 3, counts)
    return shown(criterion, len(shares) == len(by_sequence))


def soon(row: Row) -> Criterion:
    """Whether csd claims a point soon after it is visible again."""
    recovery = row.csd["recovery"]
    frames = recovery["median_frames"]
    found = (f"{number(frames, 1)} frames "
             f"({recovery['recovered']} of {recovery['returns']} returned)")
    criterion = at_most("median of the return", row.goals["frames_until"], frames, 1, found,
                        " frames")
    return shown(criterion, recovery["returns"] > 0)


def criteria(row: Row, out: pathlib.Path) -> list[Criterion]:
    """Everything that the row must reach."""
    goals, csd = row.goals, row.csd
    found = []
    if "sensitivity" in goals:
        found.append(
            at_least("sensitivity", goals["sensitivity"], csd["sensitivity"]["value"], 4,
                     fine(csd["sensitivity"])))
    found.append(at_most("K", goals["k"], csd["k"]["value"], 4, fine(csd["k"])))
    if "median" in goals:
        found.append(at_most("median", goals["median"], csd["error"]["median"], 3, unit=" px"))
    if "frames_until" in goals:
        found.append(soon(row))
    if "lasting" in goals:
        found.append(lasting(row))
    if "back" in goals:
        found.append(back(row, out))
    return found


def verdict(found: Rows[Criterion]) -> str:
    missed, unknown = (", ".join(c.name for c in found if c.reached is result)
                       for result in (False, None))
    if missed:
        return f"not reached: {missed}"
    return f"no occasion: {unknown}" if unknown else "**reached**"


def standing(rival: Value, csd: Value, p: Value) -> str:
    """How csd stands beside a rival in one measure, in words."""
    if rival is None or csd is None or p is None:
        return "unknown"
    if rival >= ONE and csd >= ONE:
        return "equal"
    if p >= GOALS["p"]:
        return "not told apart"
    return "above" if csd > rival else "below"


def beside(row: Row, plan: Plan) -> list[tuple[str, Share, dict[str, Standing]]]:
    """Each rival with its share of the plan, and how csd stands beside it in each measure."""
    found = []
    for share in plan.shares:
        scores = row.scores[share.name]
        for rival in share.trackers:
            if rival == "csd":
                continue
            standings = {}
            for measure, _ in MEASURES:
                a, b = scores.value(rival, measure), scores.value("csd", measure)
                p = scores.comparisons[rival][measure]["p"]
                standings[measure] = Standing(a, b, p, standing(a, b, p))
            found.append((rival, share, standings))
    return found


def all_of(standings: Mapping[str, Standing]) -> str:
    """How csd stands in all three measures, in words."""
    results = {result for *_, result in standings.values()}
    if results <= {"above", "equal"}:
        return "**above**" if "above" in results else "equal"
    return ", ".join(f"{label}: {result}" for m, label in MEASURES
                     if (result := standings[m][-1]) not in ("above", "equal"))


def calibration(plan: Plan, out: pathlib.Path, kinds: Iterable[Sequence]) -> dict[str, typing.Any]:
    """csd's expected calibration error over these sequences, and the bins that it is made of."""
    found: dict[str, typing.Any] = Scores(plan, out, kinds, ["csd"],
                                          resamples=0).trackers["csd"]["calibration"]
    return found
