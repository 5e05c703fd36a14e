# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the paper says of its five trackers: each sentence as a test of the figures found here."""

import dataclasses
import typing
from collections.abc import Collection, Iterable, Mapping, Sequence as Rows

from pipelines.experiments import figures, page, truth
from pipelines.experiments.scores import Changes, Findings, Scores, Windows
from pipelines.experiments.sequences import Plan, Sequence

BASELINES = ("lk", "ms1", "ms2", "sift")
MEAN_SHIFTS = ("ms1", "ms2")
ALL = ("csd-2012", *BASELINES)

HOLDS, FAILS, UNDECIDED, NO_OCCASION = "holds", "does not hold", "not decided", "no occasion"

# The paper gives words; these numbers are this project's reading of them.
WELL, POOR = 0.7, 0.5  # sensitivity at least, at most
BEGINS_WELL = 0.8  # sensitivity in the first fifth
LOW_K, HIGH_K = 0.2, 0.3
ZERO, ALMOST_ZERO = 0.05, 0.1
LOSS = 0.1  # "degrades", "declines", "reduction": sensitivity
# Two figures without an interval of their difference are told apart from here on.
MARGIN = 0.05
CYCLE = 0.02  # "oscillates": between the quarters of least and most deformation
READING = (
    f"“well”: sensitivity ≥ {WELL}, at the beginning (the first fifth) ≥ {BEGINS_WELL}; “poor”, "
    f"“low”: ≤ {POOR}; low K: ≤ {LOW_K}, high: ≥ {HIGH_K}; “zero”: < {ZERO}, “almost zero”: < "
    f"{ALMOST_ZERO}; “degrades”, “reduction”: by ≥ {LOSS}; “oscillates”: ≥ {CYCLE} between the "
    "quarters of the frames of least and of most deformation")

Value = float | None
Measure = Mapping[str, float]  # "low" and "high", the ends of an interval
Levels = dict[str, float]  # a figure of each tracker


@dataclasses.dataclass(frozen=True)
class Claim:
    where: str  # in the paper
    says: str
    verdict: str
    evidence: str  # in words, with numbers
    reading: bool = True  # judged by a threshold of this project, not by an interval


def known(value: Value, otherwise: float) -> float:
    return otherwise if value is None else value


def words(values: Mapping[str, Value], digits: int = 3) -> str:
    return ", ".join(f"{name} {'–' if value is None else format(value, f'.{digits}f')}"
                     for name, value in values.items())


def of_all(verdicts: Collection[str]) -> str:
    """The verdict on several conditions, all of which must hold."""
    return next((v for v in (FAILS, UNDECIDED, NO_OCCASION) if v in verdicts), HOLDS)


def over(measure: Measure, least: float) -> str:
    """Whether a figure with its 95 % interval is above a threshold."""
    if measure["low"] > least:
        return HOLDS
    return FAILS if measure["high"] < least else UNDECIDED


def sign(difference: Measure) -> str:
    """Whether a paired difference is above 0, by its 95 % interval."""
    return over(difference, 0)


def margin(difference: Value) -> str:
    """Whether a difference without an interval is above 0."""
    if difference is None or abs(difference) < MARGIN:
        return UNDECIDED
    return HOLDS if difference > 0 else FAILS


def test(*conditions: bool) -> str:
    return HOLDS if all(conditions) else FAILS


def opposite(verdict: str) -> str:
    return {HOLDS: FAILS, FAILS: HOLDS}.get(verdict, verdict)


def negative(difference: Measure) -> Measure:
    return {"low": -difference["high"], "high": -difference["low"]}


def of_scores(where: str, scores: Scores, mean_shifts: bool) -> list[Claim]:
    """The claims about each of its tables and about the simulation.

    By the paired differences from csd-2012.
    """
    s = {t: scores.value(t, "sensitivity") for t in ALL}
    k = {t: scores.value(t, "k") for t in ALL}
    less = {t: scores.comparisons[t] for t in BASELINES}  # its figure less csd-2012's
    claims = [
        Claim(where, "CSD has the highest sensitivity",
              of_all([sign(negative(less[t]["sensitivity"])) for t in BASELINES]), words(s), False),
        Claim(
            where, "SIFT has the lowest K, CSD the next",
            of_all([
                sign(negative(less["sift"]["k"])),
                *(sign(less[t]["k"]) for t in BASELINES if t != "sift")
            ]), words(k), False)
    ]
    if mean_shifts:
        best = max(known(s[t], 0) for t in MEAN_SHIFTS)
        claims.append(
            Claim(where, "both mean shifts have lower sensitivity than the others",
                  test(best < min(known(s[t], 0) for t in ("lk", "sift", "csd-2012"))), words(s)))
    return claims


def cycle(scores: Scores, sequence: Sequence, tracker: str) -> float:
    """How much higher sensitivity is in the quarter of the frames with least deformation than in
    the quarter with most."""
    gaps = []
    for found, scene in zip(scores.of_clips(sequence, tracker, "sensitivity_by_frame"),
                            scores.truths(sequence)):
        order = sorted(range(len(found)), key=lambda n: scene.deformation[n])
        quarter = max(1, len(order) // 4)
        calm, deformed = (figures.mean(found[n] for n in part)
                          for part in (order[:quarter], order[-quarter:]))
        gaps.append(drop(calm, deformed))
    return known(figures.mean(gaps), 0)


def fifths(scores: Scores, sequence: Sequence, tracker: str,
           measure: str = "sensitivity_by_frame") -> list[float]:
    """A measure in the first and in the last fifth of the frames."""
    return [
        known(scores.part(sequence, tracker, measure, *part), 0) for part in ((0, 0.2), (0.8, 1))
    ]


def signed(change: truth.Interval | None) -> str:
    """A change of sensitivity with its interval."""
    if change is None:
        return "no change known"
    return page.minus("{:+.3f} ({:+.3f} to {:+.3f})".format(*change))


def loses(change: truth.Interval | None) -> str:
    """Whether sensitivity falls by LOSS or more, by the interval of its change."""
    return NO_OCCASION if change is None else over({"low": -change[2], "high": -change[1]}, LOSS)


def declines(where: str, says: str, scores: Scores, kinds: Iterable[Sequence]) -> Claim:
    """Whether LK declines from the first fifth of the frames to the last."""
    kinds = tuple(kinds)
    parts = [fifths(scores, s, "lk") for s in kinds]
    changes = [scores.change(s, "lk") for s in kinds]
    return Claim(
        where, says, of_all([loses(c) for c in changes]),
        "; ".join(f"first fifth {a:.3f}, last {b:.3f}: {signed(c)} a feature"
                  for (a, b), c in zip(parts, changes)))


def begins_and_degrades(where: str, scores: Scores, kinds: Rows[Sequence],
                        of: str = "") -> list[Claim]:
    begins = [fifths(scores, s, "lk")[0] for s in kinds]
    return [Claim(where, f"LK begins well{of}", test(*(a >= BEGINS_WELL for a in begins)),
                  "first fifth " + ", ".join(f"{a:.3f}" for a in begins)),
            declines(where, f"LK degrades over time{of}", scores, kinds)]


def of_simulation(plan: Plan, found: Findings) -> list[Claim]:
    sequence, scores = plan.sequence("simulation"), found.simulation
    cycles = {t: cycle(scores, sequence, t) for t in ALL}
    s = {t: known(scores.value(t, "sensitivity"), 0) for t in ALL}
    k = {t: known(scores.value(t, "k"), 1) for t in ALL}
    begins = scores.part(sequence, "lk", "k_by_frame", 0, 0.2)
    most = max(ALL, key=lambda t: cycles[t])
    return [
        Claim("§3.1", "the sensitivity of all trackers oscillates with the deformation",
              test(*(c >= CYCLE for c in cycles.values())), words(cycles)),
        Claim("§3.1", "SIFT's oscillates most",
              test(most == "sift", cycles["sift"] >= CYCLE), words(cycles)),
        *begins_and_degrades("§3.1", scores, [sequence]),
        Claim("§3.1", "LK has low K at the beginning", test(known(begins, 1) <= LOW_K),
              f"first fifth {known(begins, 1):.3f}"),
        Claim(
            "§3.1", "both mean shifts have low sensitivity and high K",
            test(*(s[t] <= POOR and k[t] >= HIGH_K for t in MEAN_SHIFTS)),
            f"{words({t: s[t] for t in MEAN_SHIFTS})}; K {words({t: k[t] for t in MEAN_SHIFTS})}"),
    ]


def level(scores: Scores, sequence: Sequence, trackers: Iterable[str],
          measure: str = "sensitivity") -> Levels:
    worst = 0 if measure == "sensitivity" else 1
    return {t: known(scores.of_sequence(sequence, t, measure), worst) for t in trackers}


def well(where: str, scores: Scores, sequence: Sequence, trackers: Iterable[str],
         says: str) -> Claim:
    found = level(scores, sequence, trackers)
    return Claim(where, says, test(*(v >= WELL for v in found.values())), words(found))


def poor(where: str, scores: Scores, sequence: Sequence, trackers: Iterable[str],
         says: str) -> Claim:
    found = level(scores, sequence, trackers)
    return Claim(where, says, test(*(v <= POOR for v in found.values())), words(found))


def of_deformation(plan: Plan, scores: Scores) -> list[Claim]:
    strong, mild, liver = map(plan.sequence, ("strong-heart", "mild-heart", "liver"))
    worse = {t: level(scores, mild, [t])[t] - level(scores, strong, [t])[t] for t in MEAN_SHIFTS}
    sift = cycle(scores, liver, "sift")
    return [
        *begins_and_degrades("§3.2.1", scores, [strong, mild], " on both hearts"),
        Claim("§3.2.1", "mean shift is worse on the strong heart than on the mild one",
              of_all([margin(d) for d in worse.values()]), "mild less strong: " + words(worse)),
        poor("§3.2.1", scores, strong, ["sift"], "SIFT is poor on the strong heart"),
        poor("§3.2.1", scores, liver, ["lk"], "LK is poor on the breathing liver"),
        Claim("§3.2.1", "SIFT's sensitivity is cyclical on the liver", test(sift >= CYCLE),
              f"sift {sift:.3f}"),
        poor("§3.2.1", scores, liver, MEAN_SHIFTS, "mean shift is poor on the liver"),
        well("§3.2.1", scores, liver, ["csd-2012"], "CSD does well on the liver"),
    ]


def before_and_after_tools(scene: truth.Truth) -> Windows:
    """The frames before the first feature is hidden, and those from there on.

    None if nothing is hidden, or something from the beginning.
    """
    first = next((n for n, share in enumerate(scene.hidden) if share), 0)
    return (range(first), range(first, len(scene.hidden))) if first else None


def of_occlusion(plan: Plan, scores: Scores) -> list[Claim]:
    few, irrigation = plan.sequence("few-occluded"), plan.sequence("irrigation")
    change = {t: scores.change(few, t, before_and_after_tools) for t in ALL}
    changes = "change: " + ", ".join(f"{t} {signed(c)}" for t, c in change.items())
    recovery = {t: scores.trackers[t]["recovery"] for t in ALL}
    returns = any(r["returns"] for r in recovery.values())
    rate = {t: r["recovered"] / r["returns"] if r["returns"] else 0 for t, r in recovery.items()}
    last = {t: fifths(scores, irrigation, t)[1] for t in ("lk", *MEAN_SHIFTS)}
    k = {t: scores.trackers[t]["k"] for t in ("sift", "csd-2012")}
    return [
        Claim("§3.2.2", "LK and mean shift lose when the first tool comes",
              of_all([loses(change[t]) for t in ("lk", *MEAN_SHIFTS)]), changes),
        Claim("§3.2.2", "SIFT and CSD stay robust then",
              of_all([opposite(loses(change[t])) for t in ("sift", "csd-2012")]), changes),
        Claim("§3.2.2", "CSD has higher sensitivity than SIFT",
              sign(negative(scores.comparisons["sift"]["sensitivity"])),
              words({t: scores.value(t, "sensitivity") for t in ("csd-2012", "sift")}), False),
        Claim("§3.2.2", "SIFT and CSD have low K",
              of_all([over(negative(m), -LOW_K) for m in k.values()]),
              words({t: m["value"] for t, m in k.items()})),
        Claim(
            "§3.2.2",
            "SIFT and CSD find features again after occlusion more often than LK and mean shift",
            test(min(rate["sift"], rate["csd-2012"]) > max(rate["lk"], rate["ms1"], rate["ms2"]))
            if returns else NO_OCCASION,
            ", ".join(f"{t} {r['recovered']} of {r['returns']}" for t, r in recovery.items())),
        Claim("§3.2.2", "LK and mean shift are almost zero after irrigation",
              test(*(v < ALMOST_ZERO for v in last.values())), "last fifth: " + words(last)),
    ]


def of_blood(changes: Changes) -> list[Claim]:
    """changes: truth.aftermath of csd-2012, of all seeds."""
    claims = []
    for column, says, factor in ((0, "CSD loses sensitivity where blood was washed away", -1),
                                 (1, "and its K rises there", 1)):
        values = [value for change in changes if (value := change[column]) is not None]
        found = truth.bootstrap(values)
        if found is None:
            claims.append(
                Claim("§3.2.2", says, NO_OCCASION,
                      f"{len(values)} features were covered and seen again", False))
            continue
        mean, low, high = found
        interval = {"low": low, "high": high}
        evidence = (f"{mean:+.3f} ({low:+.3f} to {high:+.3f}) from the same scene without blood "
                    f"and water, of the {len(values)} features that these covered, once they are "
                    "free again")
        claims.append(
            Claim("§3.2.2", says, sign(interval if factor > 0 else negative(interval)),
                  page.minus(evidence), False))
    return claims


def at_scale(scores: Scores, sequence: Sequence, tracker: str, measure: str, low: float,
             high: float) -> Value:
    """A measure in the frames whose scale is in this range."""
    return figures.mean(
        value for found, scene in zip(scores.of_clips(sequence, tracker, measure),
                                      scores.truths(sequence))
        for value, scale in zip(found, scene.scale) if low <= scale < high)


def drop(a: Value, b: Value) -> Value:
    return None if a is None or b is None else a - b


def least(scores: Scores, sequence: Sequence, tracker: str) -> float:
    """The least sensitivity of any figures.BIN frames."""
    curves = scores.of_clips(sequence, tracker, "sensitivity_by_frame")
    return min(known(value, 1) for _, value in figures.binned(curves))


def of_zoom(scores: Scores, zoom: Sequence) -> list[Claim]:
    k = level(scores, zoom, MEAN_SHIFTS, "k")
    same, large, small = (at_scale(scores, zoom, "sift", "sensitivity_by_frame", *scales)
                          for scales in ((0.9, 1.1), (1.5, 9), (0, 0.8)))
    right, wrong = (at_scale(scores, zoom, "sift", "k_by_frame", *scales)
                    for scales in ((0.9, 1.1), (0, 0.8)))
    best = level(scores, zoom, ALL)
    losses = [drop(same, large), drop(same, small)]
    rise = drop(wrong, right)
    return [
        declines("§3.2.3", "LK declines towards the end of the zoom", scores, [zoom]),
        Claim("§3.2.3", "mean shift has high K in the zoom",
              test(*(v >= HIGH_K for v in k.values())), words(k)),
        Claim("§3.2.3", "SIFT's sensitivity decreases as scale changes",
              NO_OCCASION if None in losses else of_all([margin(v) for v in losses]),
              words({"at 0.9–1.1×": same, "above 1.5×": large, "below 0.8×": small})),
        Claim("§3.2.3", "SIFT matches wrongly more often when the scale is reduced (0.66×)",
              NO_OCCASION if rise is None else margin(rise),
              "K " + words({"at 0.9–1.1×": right, "below 0.8×": wrong})),
        Claim("§3.2.3", "CSD has the highest sensitivity in the zoom",
              of_all([margin(best["csd-2012"] - best[t]) for t in BASELINES]), words(best)),
    ]


def of_rotation(scores: Scores, rotation: Sequence) -> list[Claim]:
    turned = level(scores, rotation, ("csd-2012", "sift"))
    return [
        well("§3.2.3", scores, rotation, ["lk"], "LK does well in rotation"),
        poor("§3.2.3", scores, rotation, MEAN_SHIFTS, "mean shift is poor in rotation"),
        Claim("§3.2.3", "CSD has higher sensitivity than SIFT in rotation",
              margin(turned["csd-2012"] - turned["sift"]), words(turned)),
        well("§3.2.3", scores, rotation, ["csd-2012"], "CSD does well in rotation"),
    ]


def of_smoke(scores: Scores, smoke: Sequence) -> list[Claim]:
    before = {
        t: known(scores.part(smoke, t, "sensitivity_by_frame", 0, 0.1), 0) for t in MEAN_SHIFTS
    }
    thick = least(scores, smoke, "sift")
    csd, csd_least = fifths(scores, smoke, "csd-2012")[0], least(scores, smoke, "csd-2012")
    return [
        Claim("§3.2.4", "SIFT's sensitivity drops to zero in smoke", test(thick < ZERO),
              f"least mean over {figures.BIN} frames {thick:.3f}"),
        Claim("§3.2.4", "mean shift does well before the smoke",
              test(*(v >= WELL for v in before.values())), "first tenth: " + words(before)),
        declines("§3.2.4", "LK drifts in smoke", scores, [smoke]),
        well("§3.2.4", scores, smoke, ["csd-2012"], "CSD does well in smoke"),
        Claim("§3.2.4", "with a slight drop only", test(csd - csd_least < 2 * LOSS),
              f"first fifth {csd:.3f}, least {csd_least:.3f}"),
    ]


def of_cameras(plan: Plan, scores: Scores) -> list[Claim]:
    """The claims of §3.2.3 and §3.2.4."""
    zoom, rotation, smoke = map(plan.sequence, ("zoom", "rotation", "smoke"))
    return of_zoom(scores, zoom) + of_rotation(scores, rotation) + of_smoke(scores, smoke)


def of_mean_shifts(scores: Scores) -> list[Claim]:
    """scores: of these two, ms1 first."""
    d = scores.comparisons["ms2"]["sensitivity"]
    return [
        Claim("§4", "MS2 is slightly better than MS1", sign(d),
              page.minus(f"{d['difference']:+.3f} ({d['low']:+.3f} to {d['high']:+.3f})"), False)
    ]


def of_cost(found: Findings, paper: Mapping[str, typing.Any]) -> list[Claim]:
    total = {search: sum(row[0] for row in rows) for search, rows in found.cost.items()}
    ratio = total["exhaustive"] / total["ranked"]
    rare = paper["retraining_is_rare_after_frames"]
    ranked = found.cost["ranked"]
    first, later = (figures.mean(row[1] for row in rows) for rows in (ranked[:rare], ranked[rare:]))
    spent = known(figures.mean(row[2] for row in ranked[rare:] or ranked), 0)
    claims = [
        Claim("§3.3", f"ranked search is about {paper['exhaustive_over_ranked']} times faster "
              "(5 to 20 times)", test(5 <= ratio <= 20), f"{ratio:.1f} times"),
        Claim("§3.3", f"tracking a feature takes {paper['track_ms_mean']} ms (no longer)",
              test(spent <= paper["track_ms_mean"]), f"{spent:.2f} ms, on another processor")
    ]
    if first is not None and later is not None:
        claims.append(
            Claim("§3.3",
                  f"after {rare} frames trees are rarely retrained (less than a fifth as often)",
                  test(later < first / 5),
                  f"leaves a feature and frame: {first:.2f}, then {later:.2f}"))
    return claims


def check(plan: Plan, found: Findings, paper: Mapping[str, typing.Any]) -> list[Claim]:
    claims = of_scores("§3.1", found.simulation, False) + of_simulation(plan, found)
    for name, scores in found.tables.items():
        claims += of_scores(f"Table {name[-1]}", scores, True)
    return (claims + of_deformation(plan, found.tables["table1"]) +
            of_occlusion(plan, found.tables["table2"]) + of_blood(found.blood) +
            of_cameras(plan, found.tables["table3"]) + of_mean_shifts(found.mean_shifts) +
            of_cost(found, paper["section3.3"]))
