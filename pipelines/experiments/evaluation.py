# SPDX-License-Identifier: LGPL-2.1-or-later
"""The paper's section of the page, with the tables and figures. Its words are here; its numbers come from the runs, the paper's from paper.json."""

import json
import pathlib

import claims
import figures
import page
import running
import sequences
from page import table
from scores import Findings

PAPER = json.loads((pathlib.Path(__file__).resolve().parent / "paper.json").read_text())
QUICK = """
**Too short to mean anything**: nothing is hidden yet, no smoke has come, and no tracker had time to drift. It shows that all runs.
"""
TITLES = {"table1": "Table 1: deformation", "table2": "Table 2: occlusion", "table3": "Table 3: scale, rotation and smoke"}
FIGURES = {"table1": ("fig8", "Fig. 8"), "table2": ("fig9", "Fig. 9"), "table3": ("fig10", "Fig. 10")}
COLUMNS = {"lk": "LK", "ms1": "MS1", "ms2": "MS2", "sift": "SIFT", "csd-2012": "CSD"}


def number(value, digits=3):
    return "–" if value is None else f"{value:.{digits}f}".replace("-", "−") if round(value, digits) else f"{0:.{digits}f}"


def interval(measure):
    return f"{number(measure['value'])} ({number(measure['low'])}–{number(measure['high'])})"


def paper_table(name, scores):
    """In the paper's layout: its numbers, ours below."""
    rows = []
    for measure, label in (("sensitivity", "sensitivity"), ("k", "K")):
        rows.append([f"{label}, the paper in vivo", *(number(PAPER[name][measure][t]) for t in sequences.PAPER_ORDER)])
        rows.append([f"{label}, simulated", *(interval(scores.trackers[t][measure]) for t in sequences.PAPER_ORDER)])
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
        returned = f"{recovery['recovered']} of {recovery['returns']}" if recovery["returns"] else "–"
        rows.append([name, *(interval(t[m]) + significance(scores, name, m) for m in ("sensitivity", "k")),
                     number(t["k_visible"]), *(number(t[m]["value"]) for m in ("delta_avg", "aj", "oa", "survival")),
                     number(t["error"]["median"], 2), number(t["error"]["percentile_95"], 1), number(t["error"]["drift"], 2),
                     returned])
    return table(["tracker", "sensitivity", "K", "K, of visible", "δavg", "AJ", "OA", "survival", "median, px", "95 %, px",
                  "drift, px", "returned"], rows)


def by_sequence(scores, kinds):
    return table(["sensitivity / K", *(f"{s.title} (Fig. {s.figure})" if s.figure else s.title for s in kinds)],
                 [[name, *(f"{number(scores.of_sequence(s, name, 'sensitivity'))} / {number(scores.of_sequence(s, name, 'k'))}"
                           for s in kinds)] for name in scores.trackers])


def settings(sequence):
    """Of csdsimsrc, as one would type them."""
    effects = f' effects="{sequence.effects}"' if sequence.effects else ""
    look = f"texture=(of {sequence.clip})" if sequence.clip else f"style={sequence.style}"
    rate = f" ! video/x-raw,framerate={sequence.rate}/1" if sequence.rate != sequences.RATE else ""
    return f"scenario={sequence.scenario}{effects} {look}{rate}"


def why(found):
    """csd-2012 where what cameras do is taken away, then LK where frames are farther apart. found: {sequence: scores}."""
    return table(["", *(f"{n}, {m}" for n in sequences.CONTROLLED for m in ("sensitivity", "K"))],
                 [[s.title, *(interval(of.trackers[n][m]) for n in sequences.CONTROLLED for m in ("sensitivity", "k"))]
                  for s, of in found.items()])


def in_words(difference, a, b):
    """Of csd-score's comparison of sensitivity, a less b."""
    more = claims.sign(difference)
    return {claims.HOLDS: f"{a} is above {b}", claims.FAILS: f"{a} is below {b}",
            claims.UNDECIDED: f"{a} and {b} are not told apart"}[more] + (
                f" (difference {number(difference['difference'])}, {number(difference['low'])} to {number(difference['high'])})")


def signed(value):
    return f"{value:+.3f}".replace("-", "−")


def apart(a, b):
    """In words, of two measures with an interval each but none of their difference."""
    if a["high"] < b["low"] or b["high"] < a["low"]:
        return "the intervals do not overlap"
    return "the intervals overlap, so no effect is shown"


def what_it_gives(found):
    """What csd-2012 gains by each of the things that the paper says nothing of. found: {name of sequence: scores}."""
    every, gain = found["why-all"], found["why-all"].comparisons["csd-2012-smoothed"]["sensitivity"]
    before, lines = every.trackers["csd-2012"]["sensitivity"], []
    for name, what in (("why-sharp", "Chroma as sharp as luma"), ("why-clean", "Chroma as sharp as luma and no noise")):
        after = found[name].trackers["csd-2012"]["sensitivity"]
        lines.append(f"* {what}: {signed(after['value'] - before['value'])}, from {interval(before)} to {interval(after)}; {apart(before, after)}.")
    shown = {claims.HOLDS: "all of it above 0", claims.FAILS: "all of it below 0", claims.UNDECIDED: "with 0 in it, so no effect is shown"}
    lines.append(f"* Smoothing before the pixel tests: {signed(gain['difference'])} ({signed(gain['low'])} to {signed(gain['high'])}; paired, "
                 f"{shown[claims.sign(gain)]}), to {number(every.value('csd-2012-smoothed', 'sensitivity'))}. The paper's Table 1 has "
                 f"{number(PAPER['table1']['sensitivity']['csd-2012'])}, in vivo.")
    return "What csd-2012's sensitivity changes by:\n\n" + "\n".join(lines) + "\n"


def what_lk_owes(found):
    """Whether LK's lead, if it has one, is owed to what is taken from it. found: {name of sequence: scores}."""
    every, said = found["why-all"], []
    leads = claims.sign(every.comparisons["lk"]["sensitivity"]) == claims.HOLDS
    for name, where, cause in (("why-half", "At half the frame rate, where tissue moves twice as far from frame to frame,", "small steps"),
                               ("why-faint", "With low texture and three times the noise", "structure above the noise")):
        lk, csd = (found[name].value(t, "sensitivity") - every.value(t, "sensitivity") for t in ("lk", "csd-2012"))
        verdict = "there is no lead of lk to explain" if not leads else (
            f"lk owes {cause} some of its lead" if lk < csd - claims.MARGIN else f"lk's lead is not owed to {cause}")
        said.append(f"{where} lk's sensitivity changes by {number(lk)} and csd-2012's by {number(csd)}: {verdict}.")
    return "\n".join(said) + "\n"


def why_in_words(found):
    """What the table shows, from its numbers."""
    lines = [f"* {s.title}: " + "; ".join(in_words(of.comparisons[a]["sensitivity"], a, "csd-2012")
                                          for a in ("lk", "csd-2012-smoothed")) + "." for s, of in found.items()]
    by_name = {s.name: of for s, of in found.items()}
    return (f"{what_it_gives(by_name)}\nBetween the trackers, in sensitivity:\n\n" + "\n".join(lines) + f"\n\n{what_lk_owes(by_name)}\n"
            "Nothing was taken away like this under tools, rotation, zoom or smoke: what keeps csd-2012 from the paper's Tables 2 and 3 is not "
            "shown here.\n")


def pictures_part(plan, scores, folder):
    """What is said of real tissue as texture, where the clips were there."""
    head = "\n## Real tissue as texture\n\n"
    if not scores:
        return head + "Not run: the clips were not there (`pipelines/experiments/paper --help`).\n"
    return (head + f"""First frames of real operations as the surface's texture, and the video compressed as recorders do
(`{sequences.CODEC.split(" ! ")[0]}`), which is harder than the procedural styles. The paper has nothing like it. One seed each.

""" + all_trackers(scores) + "\nBy sequence:\n\n" + by_sequence(scores, plan.of_table("pictures")) +
            f"\nMeans over {figures.BIN} frames:\n\n![]({folder}/pictures.svg)\n")


def hidden(scenes):
    """Share of the features that are hidden: mean over the frames and seeds, and most in a frame."""
    shares = [share for scene in scenes for share in scene.hidden]
    return f"{100 * figures.mean(shares):.0f} %, {100 * max(shares):.0f} %"


def sources(plan, truths):
    return table(["sequence", "paper", "csdsimsrc", "features", "frames", "seeds", "hidden: mean, most"],
                 [[s.title, (f"Fig. {s.figure}" if s.figure else "–") + (f", Table {s.table[-1]}" if s.table.startswith("table") else ""),
                   f"`{settings(s)}`", str(s.features), str(s.frames), ", ".join(map(str, s.seeds)), hidden(truths(s))] for s in plan.sequences])


def costs(plan, cost):
    """Fig. 11 and §3.3 as a table."""
    paper, rare = PAPER["section3.3"], PAPER["section3.3"]["retraining_is_rare_after_frames"]
    total = {search: sum(row[0] for row in rows) for search, rows in cost.items()}
    tracking = [row[2] for row in cost["ranked"][rare:]] or [row[2] for row in cost["ranked"]]
    rows = [["learning a feature in all, exhaustive, ms", "–", number(total["exhaustive"], 1)],
            ["learning a feature in all, ranked, ms", "–", number(total["ranked"], 1)],
            ["exhaustive : ranked", f"about {paper['exhaustive_over_ranked']}", number(total["exhaustive"] / total["ranked"], 1)]]
    for search, frames in cost.items():
        first, later = frames[:rare], frames[rare:]
        rows.append([f"leaves retrained per feature and frame, {search}: first {rare} frames, later", "“reduced” later",
                     f"{number(figures.mean([r[1] for r in first]), 2)}, {number(figures.mean([r[1] for r in later]), 2)}"])
    rows.append(["tracking a feature in a frame, ms", f"{paper['track_ms_mean']} ± {paper['track_ms_deviation']}",
                 number(figures.mean(tracking))])
    return table(["", "the paper (Pentium, 3 GHz)", "here"], rows)


def over_time(folder, name, kinds, scores):
    """The paper's trackers as the paper draws them, and the rivals beside csd-2012."""
    figures.over_time(folder / f"{name}.svg", kinds, scores.by_frame, sequences.PAPER_ORDER)
    figures.over_time(folder / f"{name}-rivals.svg", kinds, scores.by_frame, (*sequences.RIVALS, "csd-2012"))


def draw(plan, found, folder):
    simulation = plan.sequence("simulation")
    over_time(folder, "fig7", [simulation], found.simulation)
    panels = []
    for measure, label in figures.BY_FRAME:
        panels.append(figures.Panel("simulation, its first 100 frames", "frame", label))
        for tracker in sequences.PAPER_ORDER:
            frames = found.simulation.by_frame(simulation, tracker, measure)
            panels[-1].add(tracker, figures.STYLES[tracker], figures.binned([f[:100] for f in frames], 1))
    figures.draw(folder / "fig7-start.svg", panels, 2)
    groups = [("simulation", found.simulation)]
    for name, scores in found.tables.items():
        over_time(folder, FIGURES[name][0], plan.of_table(name), scores)
        groups.append((TITLES[name], scores))
    if found.pictures:
        figures.over_time(folder / "pictures.svg", plan.of_table("pictures"), found.pictures.by_frame, sequences.PAPER_ORDER)
    figures.over_threshold(folder / "threshold.svg", [(title, {t: s.trackers[t]["curve"] for t in sequences.PAPER_ORDER})
                                                      for title, s in groups], sequences.PAPER_ORDER)
    figures.learning(folder / "fig11.svg", found.cost)


def verdict(claim, published):
    """In bold where it means something."""
    strong = published and claim.verdict in (claims.HOLDS, claims.FAILS)
    return (f"**{claim.verdict}**" if strong else claim.verdict) + (" †" if claim.reading else "")


def effort(plan, spent, clock, intervals):
    """What the runs took, and on how many scenes the intervals stand. clock: running.by_the_clock; intervals: those that stand on all
    seeds."""
    wall, processor = spent
    seeds = max(len(s.seeds) for s in plan.sequences)
    few = "" if seeds > 1 else " One seed is few clips: between scenes the figures vary more than these intervals say."
    once = "; ".join(f"“{s.title}”" for s in plan.sequences if len(s.seeds) < seeds)
    at_once = f", and {running.minutes(clock[0])} by the clock, {clock[1]} at a time" if clock else " (several run at a time)"
    return (f"The runs took {running.minutes(processor)} of processor time, {running.minutes(wall)} one after the other{at_once}. "
            f"{intervals} stand on {seeds} seed{'s' if seeds > 1 else ''} of each sequence"
            f".{f' There is one seed only of {once}.' if once else ''}{few}")


def boxes_too(plan, found, name, kinds):
    """Every tracker on what those of boxes get of these sequences."""
    features, frames = plan.share("slow").of(kinds[0])
    return (f"\nWith the trackers of boxes, which take too long for all: on {features} of the features and the first {frames} frames. The others "
            f"beside are scored on just these.\n\n{all_trackers(found.slow[name])}")


def text(plan, found, command, pictures, versions, spent, clock):
    simulation, half = plan.sequence("simulation"), plan.sequence("why-half")
    parts = [f"""## The paper's experiments again

The experiments of Mountney & Yang (2012) on simulated tissue, written by

    {command}
{"" if plan.published else QUICK}
""", table(["", ""], versions.items()), f"""
CSD is `csd-2012`, the paper's tracker as printed ([method.md](method.md)); the others are in [baselines.md](baselines.md). p is of the
difference from csd-2012.

{effort(plan, spent, clock, "The intervals of Tables 1 to 3")}

## What the paper found, and what is found here

""", table(["", "the paper finds", "here", ""], [[c.where, c.says, verdict(c, plan.published), c.evidence]
                                                  for c in claims.check(plan, found, PAPER)]), f"""
Verdicts without † are by the 95 % interval of the difference, paired over clips and features: *not decided* where it contains 0. §3.1's is of
features alone, for there is one clip; so is that of the two on blood, of the features of all seeds together (each paired with itself in the scene without
blood and water; 2000 draws).
† is this project's reading of the paper's words: {claims.READING}. Where the evidence has an interval (of the change of a feature's sensitivity from one window of frames to another, by bootstrap
over features), the verdict asks whether all of it is beyond that threshold; without one the figures are descriptive, of these very sequences. Two sequences' or two trackers' figures
that have no interval count as different from {claims.MARGIN} on, and nearer together as *not decided*. *No occasion*: nothing happened that could show it.

## The sequences

""", sources(plan, found.simulation.truths), f"""
## The simulation (Fig. 7)

{simulation.features} features, {simulation.frames} frames; no highlights, no change of light. Curves are means over {figures.BIN} frames.

![]({pictures}/fig7.svg)

The rivals, and csd-2012 again:

![]({pictures}/fig7-rivals.svg)

How the periods of heart and breath show, frame by frame:

![]({pictures}/fig7-start.svg)

""", all_trackers(found.simulation), boxes_too(plan, found, "simulation", [simulation])]
    for name, scores in found.tables.items():
        kinds, (picture, figure) = plan.of_table(name), FIGURES[name]
        parts += [f"\n## {TITLES[name]}\n\n*Simulated classes; the paper's in-vivo figures for orientation.*\n\n",
                  paper_table(name, scores), "\nEvery tracker:\n\n", all_trackers(scores), boxes_too(plan, found, name, kinds),
                  "\nBy sequence, means over the seeds:\n\n",
                  by_sequence(scores, kinds), f"\n{figure}; means over {figures.BIN} frames and the seeds:\n\n![]({pictures}/{picture}.svg)\n\n"
                  f"The rivals, and csd-2012 again:\n\n![]({pictures}/{picture}-rivals.svg)\n"]
    parts += [f"""
## What keeps csd-2012 from the paper's figures

The same beating heart without highlights and change of light, {plan.of_table("why")[0].frames} frames; then what a camera does to it is taken away. The paper compares
single pixels and says nothing of noise; `csd-2012-smoothed` is the same tracker behind a Gaussian of σ = 1 pixel. In the last
two rows it is made hard for LK, which looks from frame to frame: the scene is rendered at {half.rate} frames a second, as many frames, so it lasts twice
as long; or there is little structure and much noise. At {half.rate} a second csd-2012 learns in its first half second from fewer frames than the
{(sequences.RATE + 1) // 2} otherwise: from its least number, 8 ([method.md](method.md#what-the-paper-leaves-open)).

""", why(found.why), "\n", why_in_words(found.why), pictures_part(plan, found.pictures, pictures), f"""
## How near is near

Sensitivity and K by τ:

![]({pictures}/threshold.svg)

## What it costs (Fig. 11, §3.3)

{plan.cost_features} features of the simulation, {plan.cost_frames} frames, all work in one thread, whose processor time this is, after all else
had been run (`tests/bench/learning-cost`). Means over features and frames. Tracking is all that isn't learning: search, cutting out
samples, and preparing the frame, which is done once for all features and so divided by {plan.cost_features}.

![]({pictures}/fig11.svg)

""", costs(plan, found.cost)]
    return "".join(parts)


def section(plan, out, path, command, _jobs):
    """Scores all runs and draws the figures. Returns the section's text and the folder of the figures."""
    running.learning_cost(plan, out)  # alone: it measures time
    of_runs = [f(plan, out) for f in (running.versions, running.spent, running.by_the_clock)]
    found = Findings(plan, out)
    drawn, pictures = page.folder_for_figures(path, "paper")
    draw(plan, found, drawn)
    return text(plan, found, command, pictures, *of_runs), drawn
