# SPDX-License-Identifier: LGPL-2.1-or-later
"""The pages on csd's goals: docs/results/beyond.md and beyond-clips.md."""

import concurrent.futures
import pathlib
import sys
import typing
from collections.abc import Iterable, Mapping, Sequence as Rows

from pipelines.experiments import figures, page, reach, running, sequences, truth
from pipelines.experiments.evaluation import PAPER, effort, number, settings
from pipelines.experiments.page import p_value, table
from pipelines.experiments.reach import GOALS, MEASURES, WITHIN, Goals, Row, Scenario
from pipelines.experiments.sequences import Plan

QUICK = """
**Too short to mean anything**: it shows that everything works.
"""

Calibration = Mapping[str, typing.Any]  # csd-score's


def in_vivo(goals: Goals) -> str:
    if "paper" not in goals:
        return "–"
    return " / ".join(number(PAPER[goals["paper"]][m]["csd-2012"]) for m in ("sensitivity", "k"))


def goals_table(rows: Iterable[Row], out: pathlib.Path) -> str:
    lines = []
    for row in rows:
        criteria = reach.criteria(row, out)
        found = {criterion.name: criterion.found for criterion in criteria}
        more = [f"{name}: {figures}" for name, figures in found.items()
                if name not in ("sensitivity", "K", "median")]
        lines.append([
            row.title,
            in_vivo(row.goals),
            "; ".join(criterion.goal for criterion in criteria),
            reach.fine(row.csd["sensitivity"]),
            found["K"],
            number(row.csd["error"]["median"], 3),
            "; ".join(more) or "–",
            reach.verdict(criteria),
        ])
    return table([
        "scenario", "the paper's CSD in vivo", "to reach", "csd: sensitivity", "csd: K",
        "median, px", "more", ""
    ], lines)


def by_sequence(rows: Iterable[Row]) -> str:
    lines = []
    for row in rows:
        for s in row.kinds:
            scores = row.scores["tracked"]
            measured = [scores.of_sequence(s, "csd", m) for m in ("sensitivity", "k")]
            lines.append([
                row.title, s.title, f"`{settings(s)}`", str(s.frames), ", ".join(map(str, s.seeds)),
                " / ".join(number(value, 4) for value in measured)
            ])
    return table(["scenario", "sequence", "csdsimsrc", "frames", "seeds", "csd: sensitivity / K"],
                 lines)


def comparison(row: Row, plan: Plan) -> str:
    lines = [[
        rival,
        *(f"{number(s.rival)}, {number(s.csd)} ({p_value(s.p)})" for s in standings.values()),
        reach.all_of(standings),
    ] for rival, _, standings in reach.beside(row, plan)]
    header = ["rival", *(f"{label}: rival, csd" for _, label in MEASURES), "csd is"]
    return f"\n{row.title}:\n\n{table(header, lines)}"


def summary(rows: Iterable[Row], plan: Plan) -> str:
    """How many comparisons csd wins, and which it does not."""
    results = [(f"{row.title}, {rival}", reach.all_of(standings)) for row in rows
               for rival, _, standings in reach.beside(row, plan)]
    others = [f"{pair} ({result})" for pair, result in results
              if result not in ("**above**", "equal")]
    won = (f"In {len(results) - len(others)} of {len(results)} pairs of scenario and rival csd is "
           "above in each of the three, or equal where both are at 1.000")
    if not others:
        return f"{won}.\n"
    return f"{won}. In the others:\n\n" + "".join(f"* {other}\n" for other in others)


def calibration_part(found: Calibration) -> str:
    ece = reach.at_most("ECE", GOALS["ece"], found["ece"], 4)
    bins = table(["confidence", "reports", "share that is visible and within τ"],
                 [[number(b["confidence"]), str(b["reports"]), number(b["frequency"])]
                  for b in found["bins"] if b["reports"]])
    return ("Expected calibration error of `confidence`, over all of these sequences: "
            f"{ece.found}; to reach: {ece.goal}; {reach.verdict([ece])}.\n\n{bins}\n"
            "The error is a mean over the reports, most of which are sure. A confidence between .1 "
            "and .9 is\nrare and less exact: it tells the order of magnitude.\n")


def diagram_part(everything: Calibration, mixed: Calibration, folder: pathlib.Path,
                 linked: str) -> str:
    """Draws the reliability of all simulated sequences, and of the one with every difficulty."""
    figures.reliability(folder / "calibration.svg", [("all sequences", everything),
                                                     ("everything mixed", mixed)])
    return f"""Of *everything mixed* alone: {number(mixed["ece"], 4)}. How often each confidence
was right, and how often it was given:

![]({linked}/calibration.svg)
"""


def palindromes_part(found: Mapping[str, typing.Any]) -> str:
    """found: running.palindromes()."""
    by_tracks = {scored["tracks"]: scored for scored in found["palindromes"]}
    lines = []
    for name, goals in GOALS["palindromes"].items():
        scored = by_tracks[f"{name}/csd.jsonl"]
        criteria = [
            reach.at_least("claimed", goals["claimed"], scored["claimed"], 3),
            reach.at_most("apart", goals["apart"], scored["apart"], 4),
        ]
        lines.append([
            name,
            str(scored["counts"]["features"]),
            str(scored["counts"]["frames"]),
            *(criterion.found for criterion in criteria),
            "; ".join(criterion.goal for criterion in criteria),
            reach.verdict(criteria),
        ])
    return table(["clip", "features", "frames", "claimed", "> 5 px apart", "to reach", ""], lines)


def comparisons(rows: Rows[Row], plan: Plan) -> str:
    return summary(rows, plan) + "".join(comparison(row, plan) for row in rows)


def clips_page(plan: Plan, rows: Rows[Row], palindromes: Mapping[str, typing.Any],
               calibration: Calibration, out: pathlib.Path) -> str:
    """Everything that needs the clips."""
    return f"""{"" if plan.published else QUICK}
First frames of real operations as the surface's texture, noise of σ 2, and the video compressed as
recorders do (`{sequences.CODEC.split(" ! ")[0]}`). The goal for *rotation, smoke* is older and
lower than that [on many tissues](results/tissue.md):

{goals_table(rows, out)}
{by_sequence(rows)}
{calibration_part(calibration)}
The same real videos and two more without truth, played forward and then backward
(`pipelines/experiments/palindrome`; [own-video.md](own-video.md#without-any-the-palindrome)): the
share of features × frames in which csd claims a position, and of two claims on the same image the
share that is farther apart than τ. All trackers begin at the same features here, edges and tools
among them. Where `csd` chooses its features itself, it claims more and fewer claims are apart
([benchmarks.md](results/benchmarks.md), `clips`).

{palindromes_part(palindromes)}
Beside the rivals:

{comparisons(rows, plan)}
"""


def black_in_words(plan: Plan, out: pathlib.Path) -> str:
    """How the view moves while the picture is black for the first time, over the seeds."""
    sequence, moves = plan.sequence("black"), []
    for seed in sequence.seeds:
        frames = truth.read(running.folder_of(out, sequence, seed) / "truth-tracked.jsonl")
        dark = [all(state != "tracked" for *_, state in frame.values()) for frame in frames]
        if True in dark:
            first = dark.index(True)
            last = dark.index(False, first) if False in dark[first:] else None
            if first and last:
                moves.append((last - first, *truth.turned(frames[first - 1], frames[last])))
    if not moves:
        return ""
    longest = max(n for n, _, _ in moves)
    angles = [abs(angle) for _, angle, _ in moves]
    scales = [scale for _, _, scale in moves]
    return (f" In the dark, {longest} frames ({longest / sequence.rate:g} s), the view turns by "
            f"{min(angles):.0f}° to {max(angles):.0f}°, and the picture grows by a factor of "
            f"{min(scales):.2f} to {max(scales):.2f}.")


def shares_in_words(plan: Plan) -> str:
    longest = max(plan.sequences, key=lambda s: s.frames)
    lines = []
    for share in plan.shares:
        features, frames = share.of(longest)
        rivals = ", ".join(f"`{t}`" for t in share.trackers if t != "csd")
        limits = [
            f"{features} of the features" if share.features else "all features",
            f"the first {frames} frames" if share.frames else "all frames",
            "the first seed" if share.first_seed else "all seeds",
        ]
        lines.append(f"* {rivals}: {', '.join(limits)}")
    return "\n".join(lines)


def simulated_page(plan: Plan, rows: Rows[Row], calibration: Calibration, out: pathlib.Path,
                   drawn: pathlib.Path, linked: str) -> str:
    """Everything that needs no clips. calibration: csd's over all rows."""
    mixed = rows[list(GOALS["rows"]).index("mixed")].csd["calibration"]
    spent, clock = running.spent(plan, out), running.by_the_clock(plan, out)
    return f"""{"" if plan.published else QUICK}
{effort(plan, spent, clock, "The intervals", plan.sequences)}

{goals_table(rows, out)}
*Reached* compares the figure itself with the goal, not its interval. The paper's Table 3 is of
zoom, rotation and smoke together; its figures come from other videos, in vivo, and are here for
orientation. *Median of the return*: frames from when a feature is visible again until csd claims it
within τ, whatever hid it, even a highlight in a single frame. *Back within {WITHIN} frames*: how
often csd claims a feature within τ in one of the first {WITHIN} frames in which it is visible
again, if at least a fifth of all features was hidden with it; each of the three sequences must
reach that share.{black_in_words(plan, out)} *Last fifth*: sensitivity / K and the median error of
the first and the last fifth of the frames. The last is as good if the interval of a feature's
change of sensitivity reaches 0, and contains nothing below
−{GOALS["rows"]["mixed"]["lasting"]:g}: a wide interval alone shows nothing.

By sequence:

{by_sequence(rows)}
{calibration_part(calibration)}
{diagram_part(calibration, mixed, drawn, linked)}
## Beside the rivals

δavg, AJ and OA of each rival and of csd, on the features and frames that this rival ran on; p of
the paired difference; *above*: in each of the three with p < {GOALS["p"]:g}.
[baselines.md](baselines.md) says how each rival is set. Rivals that cost much, or are far below by
the paper's experiments, run on a part:

{shares_in_words(plan)}

{comparisons(rows, plan)}
"""


def write(plan: Plan, out: pathlib.Path, path: pathlib.Path, command: str, jobs: int) -> None:
    """Scores all runs, draws the figure, and writes the page; that of the clips too, if they were
    there."""
    versions = running.versions(plan, out)
    simulated, pictures = reach.rows_of(plan)
    scenarios = simulated + pictures
    palindromes = running.palindromes(plan, out) if pictures else {}
    print("scores", file=sys.stderr)

    def calibration(some: Iterable[Scenario]) -> Calibration:
        return reach.calibration(plan, out, [s for _, _, kinds in some for s in kinds])

    # csd-score is a process; these threads only wait for it.
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        scored = pool.map(lambda scenario: reach.score(plan, out, scenario[2]), scenarios)
        of_simulated = pool.submit(calibration, simulated)
        of_pictures = pool.submit(calibration, pictures) if pictures else None
        rows = [Row(*scenario, scores) for scenario, scores in zip(scenarios, scored)]
    drawn, linked = page.folder_for_figures(path)
    about = (f"`csd` ([method.md](method.md)), on {plan.sequences[0].features} features of each "
             "scene, beside goals that were set before it was measured.")
    body = simulated_page(plan, rows[:len(simulated)], of_simulated.result(), out, drawn, linked)
    page.write(path, "csd: what it reaches", about, command, versions, body, drawn)
    if of_pictures:
        body = clips_page(plan, rows[len(simulated):], palindromes, of_pictures.result(), out)
        page.write(path.with_name("beyond-clips.md"),
                   "csd: what it reaches with clips of real tissue", about, command, versions, body)
