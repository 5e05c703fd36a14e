# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of the paper's experiments, with its tables and figures.

Its words are here. Its figures come from the runs, the paper's from paper.json.
"""

import json
import pathlib
import statistics
import typing
from collections.abc import Iterable, Mapping

from pipelines.experiments import claims, figures, page, running, sequences, truth
from pipelines.experiments.page import table
from pipelines.experiments.scores import Findings, Scores
from pipelines.experiments.sequences import Plan, Sequence

PAPER = json.loads((pathlib.Path(__file__).resolve().parent / "paper.json").read_text())
QUICK = """
**Too short to mean anything**: nothing is hidden yet, no smoke has come, and no tracker had time to
drift. It shows that everything works.
"""
TITLES = {
    "table1": "Table 1: deformation",
    "table2": "Table 2: occlusion",
    "table3": "Table 3: scale, rotation and smoke",
}
FIGURES = {
    "table1": ("fig8", "Fig. 8"), "table2": ("fig9", "Fig. 9"), "table3": ("fig10", "Fig. 10"),
}
COLUMNS = {"lk": "LK", "ms1": "MS1", "ms2": "MS2", "sift": "SIFT", "csd-2012": "CSD"}

Measure = Mapping[str, typing.Any]  # csd-score's: "value", "low" and "high"


def number(value: float | None, digits: int = 3) -> str:
    if value is None:
        return "–"
    if not round(value, digits):
        value = 0  # not −0
    return page.minus(f"{value:.{digits}f}")


def interval(measure: Measure) -> str:
    return f"{number(measure['value'])} ({number(measure['low'])}–{number(measure['high'])})"


def mean(values: Iterable[float | None], digits: int = 3) -> str:
    return number(figures.mean(values), digits)


def paper_table(name: str, scores: Scores) -> str:
    """In the paper's layout: its figures, and ours below them."""
    rows = []
    for measure, label in (("sensitivity", "sensitivity"), ("k", "K")):
        printed = [number(PAPER[name][measure][t]) for t in sequences.PAPER_ORDER]
        simulated = [interval(scores.trackers[t][measure]) for t in sequences.PAPER_ORDER]
        rows.append([f"{label}, the paper in vivo", *printed])
        rows.append([f"{label}, simulated", *simulated])
    return table(["", *(COLUMNS[t] for t in sequences.PAPER_ORDER)], rows)


def significance(scores: Scores, tracker: str, measure: str) -> str:
    if tracker not in scores.comparisons:
        return ""
    p = scores.comparisons[tracker][measure]["p"]
    return "" if p is None else f" ({page.p_value(p)})"


def all_trackers(scores: Scores) -> str:
    """Every tracker by every measure. p is of sensitivity and K against the first tracker."""
    rows = []
    for name, t in scores.trackers.items():
        recovery, error = t["recovery"], t["error"]
        returned = f"{recovery['recovered']} of {recovery['returns']}"
        rows.append([
            name,
            *(interval(t[m]) + significance(scores, name, m) for m in ("sensitivity", "k")),
            number(t["k_visible"]),
            *(number(t[m]["value"]) for m in ("delta_avg", "aj", "oa", "survival")),
            number(error["median"], 2),
            number(error["percentile_95"], 1),
            number(error["drift"], 2),
            returned if recovery["returns"] else "–",
        ])
    return table([
        "tracker", "sensitivity", "K", "K, of visible", "δavg", "AJ", "OA", "survival",
        "median, px", "95 %, px", "drift, px", "returned"
    ], rows)


def tissue_of(sequence: Sequence, seed: int) -> str:
    picture = sequence.texture(seed)
    return pathlib.Path(picture).stem if picture else f"simulated {sequence.style}"


def by_sequence(scores: Scores, kinds: Iterable[Sequence]) -> str:
    """A row for each scene, that is, for each texture of a sequence."""
    rows = []
    for sequence in kinds:
        by_tracker = {
            t: list(zip(*(scores.of_clips(sequence, t, m) for m in ("sensitivity", "k"))))
            for t in scores.trackers
        }
        for i, seed in enumerate(sequence.seeds):
            rows.append([f"{sequence.title} (Fig. {sequence.figure})", tissue_of(sequence, seed),
                         *(" / ".join(map(number, by_tracker[t][i])) for t in scores.trackers)])
    return table(["sensitivity / K", "tissue", *scores.trackers], rows)


def settings(sequence: Sequence) -> str:
    """csdsimsrc's settings as a user would type them, with the textures of all seeds."""
    effects = f' effects="{sequence.effects}"' if sequence.effects else ""
    looks = [
        f"texture={pathlib.Path(picture).name}" if picture else f"style={sequence.style}"
        for picture in map(sequence.texture, sequence.seeds)
    ]
    rate = f" ! video/x-raw,framerate={sequence.rate}/1" if sequence.rate != sequences.RATE else ""
    return f"scenario={sequence.scenario}{effects} {' or '.join(dict.fromkeys(looks))}{rate}"


def hidden(scenes: Iterable[truth.Truth]) -> str:
    """The share of the features that are hidden: its mean over frames and seeds, and its most in a
    frame."""
    shares = [share for scene in scenes for share in scene.hidden]
    return f"{100 * statistics.fmean(shares):.0f} %, {100 * max(shares):.0f} %"


def sources(plan: Plan, scores: Scores) -> str:
    rows = []
    for s in plan.sequences:
        where = f"Fig. {s.figure}" if s.figure else "–"
        if s.table.startswith("table"):
            where += f", Table {s.table[-1]}"
        rows.append([
            s.title, where, f"`{settings(s)}`", str(s.features), str(s.frames),
            ", ".join(map(str, s.seeds)), hidden(scores.truths(s))
        ])
    return table(
        ["sequence", "paper", "csdsimsrc", "features", "frames", "seeds", "hidden: mean, most"],
        rows)


def costs(cost: running.Cost) -> str:
    """The paper's Fig. 11 and §3.3 as a table."""
    paper, rare = PAPER["section3.3"], PAPER["section3.3"]["retraining_is_rare_after_frames"]
    total = {search: sum(row[0] for row in rows) for search, rows in cost.items()}
    tracking = [row[2] for row in cost["ranked"][rare:]] or [row[2] for row in cost["ranked"]]
    rows = [
        ["learning a feature in all, exhaustive, ms", "–", number(total["exhaustive"], 1)],
        ["learning a feature in all, ranked, ms", "–", number(total["ranked"], 1)],
        [
            "exhaustive : ranked", f"about {paper['exhaustive_over_ranked']}",
            number(total["exhaustive"] / total["ranked"], 1)
        ],
    ]
    for search, frames in cost.items():
        first, later = (mean((row[1] for row in part), 2)
                        for part in (frames[:rare], frames[rare:]))
        rows.append([
            f"leaves retrained per feature and frame, {search}: first {rare} frames, later",
            "“reduced” later", f"{first}, {later}"
        ])
    rows.append([
        "tracking a feature in a frame, ms",
        f"{paper['track_ms_mean']} ± {paper['track_ms_deviation']}",
        mean(tracking),
    ])
    return table(["", "the paper (Pentium, 3 GHz)", "here"], rows)


def draw(plan: Plan, found: Findings, folder: pathlib.Path) -> None:
    simulation = plan.sequence("simulation")
    drawn = (*sequences.PAPER_ORDER, "csd-forest")
    figures.over_time(folder / "fig7.svg", [simulation], found.simulation.of_clips, drawn)
    panels = []
    for measure, label in figures.BY_FRAME:
        panels.append(figures.Panel("simulation, its first 100 frames", "frame", label))
        for tracker in drawn:
            frames = found.simulation.of_clips(simulation, tracker, measure)
            panels[-1].add(tracker, figures.STYLES[tracker],
                           figures.binned([f[:100] for f in frames], 1))
    figures.draw(folder / "fig7-start.svg", panels, 2)
    groups = [("simulation", found.simulation)]
    for name, scores in found.tables.items():
        figures.over_time(folder / f"{FIGURES[name][0]}.svg", plan.of_table(name), scores.of_clips,
                          drawn)
        groups.append((TITLES[name], scores))
    curves = [(title, {t: scores.trackers[t]["curve"] for t in drawn}) for title, scores in groups]
    figures.over_threshold(folder / "threshold.svg", curves, drawn)
    figures.learning(folder / "fig11.svg", found.cost)


def verdict(claim: claims.Claim, published: bool) -> str:
    """In bold where it means something."""
    strong = published and claim.verdict in (claims.HOLDS, claims.FAILS)
    return (f"**{claim.verdict}**" if strong else claim.verdict) + (" †" if claim.reading else "")


def effort(plan: Plan, spent: tuple[float, float], clock: tuple[float, int] | None, intervals: str,
           kinds: Iterable[Sequence]) -> str:
    """How long the runs took, and how many scenes the intervals stand on.

    clock: running.by_the_clock(); intervals: the name of those of `kinds`.
    """
    wall, processor = spent
    seeds = max(len(s.seeds) for s in kinds)
    once = "; ".join(f"“{s.title}”" for s in plan.sequences if len(s.seeds) == 1 < seeds)
    at_once = " (several run at a time)"
    if clock:
        at_once = f", and {running.minutes(clock[0])} by the clock, {clock[1]} at a time"
    text = (f"The runs took {running.minutes(processor)} of processor time, "
            f"{running.minutes(wall)} one after the other{at_once}. "
            f"{intervals} stand on {seeds} seed{'s' if seeds > 1 else ''} of each sequence.")
    if once:
        text += f" There is one seed only of {once}."
    if seeds == 1:
        text += (" One seed is few clips: between scenes the figures vary more than these "
                 "intervals say.")
    return text


def fifths(scores: Scores, kinds: Iterable[Sequence]) -> str:
    """The claim of Fig. 7 that nothing drifts: sensitivity and K in each fifth of the frames, a row
    for each scene and tracker."""
    rows = []
    for sequence in kinds:
        for i, seed in enumerate(sequence.seeds):
            for t in scores.trackers:
                curves = [
                    scores.of_clips(sequence, t, f"{m}_by_frame")[i] for m in ("sensitivity", "k")
                ]
                parts = [
                    " / ".join(
                        mean(curve[round(n * len(curve) / 5):round((n + 1) * len(curve) / 5)])
                        for curve in curves) for n in range(5)
                ]
                rows.append([tissue_of(sequence, seed), t, *parts])
    names = ("first", "second", "third", "fourth", "last")
    return table(["tissue", "sensitivity / K", *(f"{name} fifth" for name in names)], rows)


def second_opinion(plan: Plan, scores: Mapping[str, Scores]) -> str:
    """What csd-forest could give csd, a row for each scene of the tables."""
    rows = []
    for kind, of_kind in scores.items():
        for sequence in plan.of_table(kind):
            for seed in sequence.seeds:
                folder = running.folder_of(of_kind.out, sequence, seed)
                tracks = [
                    truth.read(folder / f"{name}.jsonl")
                    for name in ("truth-tracked", "csd", "csd-forest")
                ]
                sensitivity, k, either, again, agreed, agreed_k = truth.together(*tracks)
                rows.append([
                    sequence.title,
                    tissue_of(sequence, seed),
                    f"{number(sensitivity)} / {number(k)}",
                    f"+{number(either - sensitivity, 4)}",
                    f"+{number(again, 4)}",
                    f"{number(agreed)} / {number(agreed_k)}",
                ])
    return table([
        "", "tissue", "csd", "told where csd-forest is right", "of that where csd is silent",
        "silent where csd-forest is"
    ], rows)


def tissue_in_words(plan: Plan) -> str:
    """What tissue the scenes show."""
    if not any(s.texture(seed) for s in plan.sequences for seed in s.seeds):
        return ("The surfaces are the simulator's own: the pictures of real tissue were not there "
                "(`pipelines/experiments/paper --help`).")
    return ("Every second scene of Tables 1 to 3, and each of the simulation, has a picture of "
            "real tissue as its surface, and its video is compressed as recorders do "
            f"(`{sequences.CODEC.split(' ! ')[0]}`). csd-2012's choices were made on three "
            "pictures with seed 1, of which heart.png is one; the others are new to it.")


def claims_part(plan: Plan, found: Findings) -> str:
    rows = [[claim.where, claim.says, verdict(claim, plan.published), claim.evidence]
            for claim in claims.check(plan, found, PAPER)]
    return f"""
## What the paper found, and what is found here

{table(["", "the paper finds", "here", ""], rows)}
Verdicts without † follow from the 95 % interval of the difference, paired over clips and features:
*not decided* where it contains 0. The two on blood use the features of all seeds together, each
paired with itself in the scene without blood and water (2000 draws).

† marks this project's reading of the paper's words: {claims.READING}.
Some evidence has an interval, by bootstrap over features: that of the change of a feature's
sensitivity from one window of frames to another. There the verdict asks whether all of the interval
is beyond the threshold. Other evidence only describes these very sequences: figures of two
sequences or two trackers count as different if {claims.MARGIN} or more apart, and otherwise are
*not decided*. *No occasion*: nothing happened that could show it.
"""


def simulation_part(plan: Plan, found: Findings, pictures: str) -> str:
    simulation = plan.sequence("simulation")
    kinds = [simulation, plan.sequence("more")]
    return f"""
## The simulation (Fig. 7)

{simulation.features} features, {simulation.frames} frames; noise, compression and a light that
changes, in which LK drifts; no highlights. Curves are means over {figures.BIN} frames.

![]({pictures}/fig7.svg)

How the periods of heart and breath show, frame by frame:

![]({pictures}/fig7-start.svg)

{all_trackers(found.simulation)}
Over time, on this picture and two more, with the trackers that take less than a tenth of a second a
frame:

{fifths(found.persistent, kinds)}"""


def table_part(plan: Plan, name: str, scores: Scores, pictures: str) -> str:
    picture, figure = FIGURES[name]
    return f"""
## {TITLES[name]}

*Simulated motion; the paper's in-vivo figures for orientation.*

{paper_table(name, scores)}
Every tracker:

{all_trackers(scores)}
By scene:

{by_sequence(scores, plan.of_table(name))}
{figure}; means over {figures.BIN} frames and the seeds:

![]({pictures}/{picture}.svg)
"""


def second_opinion_part(plan: Plan, found: Findings) -> str:
    return f"""
## What csd-forest could give csd

*Told where csd-forest is right*: how much sensitivity csd would gain if it knew, for each feature
in each frame, whether csd-forest is right where csd is not; no rule gains more. *Of that where csd
is silent*: the part of this gain from finding what csd has lost. *Silent where csd-forest is*:
sensitivity and K of csd if it claimed only what csd-forest claims too.

{second_opinion(plan, found.tables)}"""


def cost_part(plan: Plan, found: Findings, pictures: str) -> str:
    return f"""
## What it costs (Fig. 11, §3.3)

{plan.cost_features} features of the simulation, {plan.cost_frames} frames. All work is done in one
thread, whose processor time this is, when nothing else of this command runs
(`tests/bench/learning-cost`). Means over features and frames. Tracking is all that is not learning:
the search, cutting out samples, and preparing the frame, which is done once for all features and so
divided by {plan.cost_features}.

![]({pictures}/fig11.svg)

{costs(found.cost)}"""


def text(plan: Plan, found: Findings, pictures: str, spent: tuple[float, float],
         clock: tuple[float, int] | None) -> str:
    tables = [table_part(plan, name, scores, pictures) for name, scores in found.tables.items()]
    return f"""{"" if plan.published else QUICK}
CSD is `csd-2012`, the paper's tracker; `csd-forest` is its future work, and `csd` the project's own
([method.md](method.md)); the others are in [baselines.md](baselines.md). p is of the difference
from csd-2012. {tissue_in_words(plan)}

{effort(plan, spent, clock, "The intervals of Tables 1 to 3", plan.of_tables())}
{claims_part(plan, found)}
## The sequences

{sources(plan, found.simulation)}{simulation_part(plan, found, pictures)}{"".join(tables)}\
{second_opinion_part(plan, found)}
## How near is near

Sensitivity and K by τ:

![]({pictures}/threshold.svg)
{cost_part(plan, found, pictures)}"""


def write(plan: Plan, out: pathlib.Path, path: pathlib.Path, command: str, _jobs: int) -> None:
    """Scores all runs, draws the figures, and writes the page."""
    running.learning_cost(plan, out)  # alone: it measures time
    versions = running.versions(plan, out)
    spent, clock = running.spent(plan, out), running.by_the_clock(plan, out)
    found = Findings(plan, out)
    drawn, pictures = page.folder_for_figures(path)
    draw(plan, found, drawn)
    page.write(path, "The paper's experiments again",
               "The experiments of Mountney & Yang (2012) on simulated motion.", command, versions,
               text(plan, found, pictures, spent, clock), drawn)
