# SPDX-License-Identifier: LGPL-2.1-or-later
"""The page of the paper's experiments, with its tables and figures. Its words are here; its numbers come from the runs, the paper's from paper.json."""

import json
import pathlib

import claims
import figures
import page
import running
import sequences
import truth
from page import table
from scores import Findings

PAPER = json.loads((pathlib.Path(__file__).resolve().parent / "paper.json").read_text())
QUICK = """
**Too short to mean anything**: nothing is hidden yet, no smoke has come, and no tracker had time to drift. It shows that all runs.
"""
TITLES = {
    "table1": "Table 1: deformation", "table2": "Table 2: occlusion",
    "table3": "Table 3: scale, rotation and smoke"
}
FIGURES = {
    "table1": ("fig8", "Fig. 8"), "table2": ("fig9", "Fig. 9"), "table3": ("fig10", "Fig. 10")
}
COLUMNS = {"lk": "LK", "ms1": "MS1", "ms2": "MS2", "sift": "SIFT", "csd-2012": "CSD"}


def number(value, digits=3):
    return "–" if value is None else f"{value:.{digits}f}".replace("-", "−") if round(
        value, digits) else f"{0:.{digits}f}"


def interval(measure):
    return f"{number(measure['value'])} ({number(measure['low'])}–{number(measure['high'])})"


def paper_table(name, scores):
    """In the paper's layout: its numbers, ours below."""
    rows = []
    for measure, label in (("sensitivity", "sensitivity"), ("k", "K")):
        rows.append([
            f"{label}, the paper in vivo",
            *(number(PAPER[name][measure][t]) for t in sequences.PAPER_ORDER)
        ])
        rows.append([
            f"{label}, simulated",
            *(interval(scores.trackers[t][measure]) for t in sequences.PAPER_ORDER)
        ])
    return table(["", *(COLUMNS[t] for t in sequences.PAPER_ORDER)], rows)


def significance(scores, tracker, measure):
    if tracker not in scores.comparisons:
        return ""
    p = scores.comparisons[tracker][measure]["p"]
    return "" if p is None else f" (p {'< .001' if p < 0.001 else f'{p:.3f}'})"


def all_trackers(scores):
    """Every tracker by every measure; p of sensitivity and K against the first."""
    rows = []
    for name, t in scores.trackers.items():
        recovery = t["recovery"]
        returned = f"{recovery['recovered']} of {recovery['returns']}" if recovery[
            "returns"] else "–"
        rows.append([
            name, *(interval(t[m]) + significance(scores, name, m) for m in ("sensitivity", "k")),
            number(t["k_visible"]),
            *(number(t[m]["value"]) for m in ("delta_avg", "aj", "oa", "survival")),
            number(t["error"]["median"], 2),
            number(t["error"]["percentile_95"], 1),
            number(t["error"]["drift"], 2), returned
        ])
    return table([
        "tracker", "sensitivity", "K", "K, of visible", "δavg", "AJ", "OA", "survival",
        "median, px", "95 %, px", "drift, px", "returned"
    ], rows)


def tissue_of(sequence, seed):
    picture = sequence.texture(seed)
    return pathlib.Path(picture).stem if picture else f"simulated {sequence.style}"


def by_sequence(scores, kinds):
    """A row for each scene, by its texture."""
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


def settings(sequence):
    """Of csdsimsrc, as one would type them; by seed, where these differ."""
    effects = f' effects="{sequence.effects}"' if sequence.effects else ""
    looks = [
        f"texture={pathlib.Path(picture).name}" if picture else f"style={sequence.style}"
        for picture in map(sequence.texture, sequence.seeds)
    ]
    rate = f" ! video/x-raw,framerate={sequence.rate}/1" if sequence.rate != sequences.RATE else ""
    return f"scenario={sequence.scenario}{effects} {' or '.join(dict.fromkeys(looks))}{rate}"


def hidden(scenes):
    """Share of the features that are hidden: mean over the frames and seeds, and most in a frame."""
    shares = [share for scene in scenes for share in scene.hidden]
    return f"{100 * figures.mean(shares):.0f} %, {100 * max(shares):.0f} %"


def sources(plan, truths):
    return table(
        ["sequence", "paper", "csdsimsrc", "features", "frames", "seeds", "hidden: mean, most"], [[
            s.title, (f"Fig. {s.figure}" if s.figure else "–") +
            (f", Table {s.table[-1]}" if s.table.startswith("table") else ""), f"`{settings(s)}`",
            str(s.features),
            str(s.frames), ", ".join(map(str, s.seeds)),
            hidden(truths(s))
        ] for s in plan.sequences])


def costs(plan, cost):
    """Fig. 11 and §3.3 as a table."""
    paper, rare = PAPER["section3.3"], PAPER["section3.3"]["retraining_is_rare_after_frames"]
    total = {search: sum(row[0] for row in rows) for search, rows in cost.items()}
    tracking = [row[2] for row in cost["ranked"][rare:]] or [row[2] for row in cost["ranked"]]
    rows = [["learning a feature in all, exhaustive, ms", "–",
             number(total["exhaustive"], 1)],
            ["learning a feature in all, ranked, ms", "–",
             number(total["ranked"], 1)],
            [
                "exhaustive : ranked", f"about {paper['exhaustive_over_ranked']}",
                number(total["exhaustive"] / total["ranked"], 1)
            ]]
    for search, frames in cost.items():
        first, later = frames[:rare], frames[rare:]
        rows.append([
            f"leaves retrained per feature and frame, {search}: first {rare} frames, later",
            "“reduced” later",
            f"{number(figures.mean([r[1] for r in first]), 2)}, {number(figures.mean([r[1] for r in later]), 2)}"
        ])
    rows.append([
        "tracking a feature in a frame, ms",
        f"{paper['track_ms_mean']} ± {paper['track_ms_deviation']}",
        number(figures.mean(tracking))
    ])
    return table(["", "the paper (Pentium, 3 GHz)", "here"], rows)


def draw(plan, found, folder):
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
    figures.over_threshold(folder / "threshold.svg",
                           [(title, {t: s.trackers[t]["curve"]
                                     for t in drawn})
                            for title, s in groups], drawn)
    figures.learning(folder / "fig11.svg", found.cost)


def verdict(claim, published):
    """In bold where it means something."""
    strong = published and claim.verdict in (claims.HOLDS, claims.FAILS)
    return (f"**{claim.verdict}**" if strong else claim.verdict) + (" †" if claim.reading else "")


def effort(plan, spent, clock, intervals, kinds):
    """What the runs took, and on how many scenes the intervals stand. clock: running.by_the_clock; intervals: what those of `kinds` are
    called."""
    wall, processor = spent
    seeds = max(len(s.seeds) for s in kinds)
    few = "" if seeds > 1 else " One seed is few clips: between scenes the figures vary more than these intervals say."
    once = "; ".join(f"“{s.title}”" for s in plan.sequences if len(s.seeds) == 1 < seeds)
    at_once = f", and {running.minutes(clock[0])} by the clock, {clock[1]} at a time" if clock else " (several run at a time)"
    return (
        f"The runs took {running.minutes(processor)} of processor time, {running.minutes(wall)} one after the other{at_once}. "
        f"{intervals} stand on {seeds} seed{'s' if seeds > 1 else ''} of each sequence"
        f".{f' There is one seed only of {once}.' if once else ''}{few}")


def fifths(scores, kinds):
    """Fig. 7's claim of no drift: sensitivity and K of each fifth of the frames, a row for each scene and tracker."""
    rows = []
    for sequence in kinds:
        for i, seed in enumerate(sequence.seeds):
            for t in scores.trackers:
                curves = [
                    scores.of_clips(sequence, t, f"{m}_by_frame")[i] for m in ("sensitivity", "k")
                ]
                parts = [[
                    curve[round(n * len(curve) / 5):round((n + 1) * len(curve) / 5)]
                    for curve in curves
                ]
                         for n in range(5)]
                rows.append([
                    tissue_of(sequence, seed), t,
                    *(" / ".join(number(figures.mean(part)) for part in both) for both in parts)
                ])
    return table([
        "tissue", "sensitivity / K",
        *(f"{name} fifth" for name in ("first", "second", "third", "fourth", "last"))
    ], rows)


def second_opinion(plan, scores):
    """What csd-forest could give csd, a row for each scene of the tables."""
    rows = []
    for kind, of_kind in scores.items():
        for sequence in plan.of_table(kind):
            for seed in sequence.seeds:
                folder = running.folder_of(of_kind.out, sequence, seed)
                of = [
                    truth.read(folder / f"{name}.jsonl")
                    for name in ("truth-tracked", "csd", "csd-forest")
                ]
                sensitivity, k, either, again, agreed, agreed_k = truth.together(*of)
                rows.append([
                    sequence.title,
                    tissue_of(sequence, seed), f"{number(sensitivity)} / {number(k)}",
                    f"+{number(either - sensitivity, 4)}", f"+{number(again, 4)}",
                    f"{number(agreed)} / {number(agreed_k)}"
                ])
    return table([
        "", "tissue", "csd", "told where csd-forest is right", "of that where csd is silent",
        "silent where csd-forest is"
    ], rows)


def tissue_in_words(plan):
    """What the scenes look like."""
    if not any(s.texture(seed) for s in plan.sequences for seed in s.seeds):
        return (
            "The surfaces are the simulator's own: the pictures of real tissue were not there (`pipelines/experiments/paper --help`)."
        )
    return (
        f"Every second scene of Tables 1 to 3, and each of the simulation, has a picture of real tissue as its surface, and its video is "
        f"compressed as recorders do (`{sequences.CODEC.split(' ! ')[0]}`). csd-2012's choices were made on three pictures with seed 1, of which "
        f"heart.png is one; the others are new to it.")


def text(plan, found, pictures, spent, clock):
    simulation = plan.sequence("simulation")
    parts = [
        f"""{"" if plan.published else QUICK}
CSD is `csd-2012`, the paper's tracker; `csd-forest` is its future work, and `csd` the project's own ([method.md](method.md)); the others are in
[baselines.md](baselines.md). p is of the difference from csd-2012. {tissue_in_words(plan)}

{effort(plan, spent, clock, "The intervals of Tables 1 to 3", plan.of_tables())}

## What the paper found, and what is found here

""",
        table(["", "the paper finds", "here", ""],
              [[c.where, c.says, verdict(c, plan.published), c.evidence]
               for c in claims.check(plan, found, PAPER)]), f"""
Verdicts without † are by the 95 % interval of the difference, paired over clips and features: *not decided* where it contains 0. Those of the two on blood are of
the features of all seeds together (each paired with itself in the scene without blood and water; 2000 draws).
† is this project's reading of the paper's words: {claims.READING}. Where the evidence has an interval (of the change of a feature's sensitivity from one window of frames to another, by bootstrap
over features), the verdict asks whether all of it is beyond that threshold; without one the figures are descriptive, of these very sequences. Two sequences' or two trackers' figures
that have no interval count as different from {claims.MARGIN} on, and nearer together as *not decided*. *No occasion*: nothing happened that could show it.

## The sequences

""",
        sources(plan, found.simulation.truths), f"""
## The simulation (Fig. 7)

{simulation.features} features, {simulation.frames} frames; noise, compression and a light that changes, in which LK drifts; no highlights. Curves are means over {figures.BIN} frames.

![]({pictures}/fig7.svg)

How the periods of heart and breath show, frame by frame:

![]({pictures}/fig7-start.svg)

""",
        all_trackers(found.simulation), f"""
Over time, on this picture and two more, with those trackers that take less than a tenth of a second a frame:

""",
        fifths(found.persistent, [simulation, plan.sequence("more")])
    ]
    for name, scores in found.tables.items():
        kinds, (picture, figure) = plan.of_table(name), FIGURES[name]
        parts += [
            f"\n## {TITLES[name]}\n\n*Simulated motion; the paper's in-vivo figures for orientation.*\n\n",
            paper_table(name, scores), "\nEvery tracker:\n\n",
            all_trackers(scores), "\nBy scene:\n\n",
            by_sequence(scores, kinds),
            f"\n{figure}; means over {figures.BIN} frames and the seeds:\n\n![]({pictures}/{picture}.svg)\n"
        ]
    parts += [
        f"""
## What csd-forest could give csd

*Told where csd-forest is right*: what sensitivity csd would gain if it knew, of each feature in each frame, whether csd-forest is right where it is not; no
rule gains more. *Of that where csd is silent*: by finding again what csd has lost. *Silent where csd-forest is*: sensitivity and K of csd if it claimed only what csd-forest claims too.

""",
        second_opinion(plan, found.tables), f"""
## How near is near

Sensitivity and K by τ:

![]({pictures}/threshold.svg)

## What it costs (Fig. 11, §3.3)

{plan.cost_features} features of the simulation, {plan.cost_frames} frames, all work in one thread, whose processor time this is, after all else
had been run (`tests/bench/learning-cost`). Means over features and frames. Tracking is all that isn't learning: search, cutting out
samples, and preparing the frame, which is done once for all features and so divided by {plan.cost_features}.

![]({pictures}/fig11.svg)

""",
        costs(plan, found.cost)
    ]
    return "".join(parts)


def write(plan, out, path, command, _jobs):
    """Scores all runs, draws the figures, and writes the page."""
    running.learning_cost(plan, out)  # alone: it measures time
    versions, *of_runs = [
        f(plan, out) for f in (running.versions, running.spent, running.by_the_clock)
    ]
    found = Findings(plan, out)
    drawn, pictures = page.folder_for_figures(path)
    draw(plan, found, drawn)
    page.write(path, "The paper's experiments again",
               "The experiments of Mountney & Yang (2012) on simulated motion.", command, versions,
               text(plan, found, pictures, *of_runs), drawn)
