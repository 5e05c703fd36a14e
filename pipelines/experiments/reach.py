# SPDX-License-Identifier: LGPL-2.1-or-later
"""The pages on csd: what it reaches of beyond.json, and how it stands beside each rival. Their numbers come from the runs."""

import concurrent.futures
import dataclasses
import json
import pathlib
import sys

import figures
import page
import running
import sequences
import truth
from evaluation import PAPER, effort, number, settings
from page import table
from scores import Scores

GOALS = json.loads((pathlib.Path(__file__).resolve().parent / "beyond.json").read_text())
# frames that a point has to come back; share of the points that something hides, to be a black, a
# cut, a wipe
WITHIN, TOGETHER = 10, 0.2
ONE = 0.9995  # what prints as 1.000
QUICK = """
**Too short to mean anything**: it shows that all runs.
"""


@dataclasses.dataclass(frozen=True)
class Criterion:
    name: str
    goal: str  # in words
    found: str
    reached: bool  # None: nothing happened that could show it


@dataclasses.dataclass
class Row:
    """A scenario: its sequences, what it must reach, csd-score's word on each share of the plan."""

    title: str
    goals: dict
    kinds: list
    scores: dict  # by share

    @property
    def csd(self):
        return self.scores["tracked"].trackers["csd"]


def rows_of(plan):
    """(title, goals, sequences) of all scenarios, and of the textures that are real."""
    simulated = [(goals["title"], goals, plan.of_table(name))
                 for name, goals in GOALS["rows"].items()]
    return simulated, [(s.title, GOALS["pictures"][s.name], [s]) for s in plan.of_table("pictures")]


def score(plan, out, kinds):
    return {
        share.name: Scores(plan, out, kinds, ["csd", *(t for t in share.trackers if t != "csd")],
                           share.name) for share in plan.shares
    }


def at_most(name, goal, value, digits, found="", unit=""):
    return Criterion(name, f"{name} ≤ {goal:g}{unit}", found or number(value, digits),
                     value is not None and value <= goal)


def at_least(name, goal, value, digits, found=""):
    return Criterion(name, f"{name} ≥ {goal:g}", found or number(value, digits),
                     value is not None and value >= goal)


def shown(criterion, times):
    """Of what can be seen only where points come back."""
    return criterion if times else dataclasses.replace(criterion, reached=None)


def fine(measure):
    """A figure near 0 or 1 with its interval."""
    return f"{number(measure['value'], 4)} ({number(measure['low'], 4)}–{number(measure['high'], 4)})"


def lasting(row):
    """The last fifth beside the first: the interval of a feature's change of sensitivity has an increase in it, and no loss beyond the
    goal's, so that a wide one alone shows nothing."""
    (sequence,), scores, loss = row.kinds, row.scores["tracked"], row.goals["lasting"]
    change = scores.change(sequence, "csd")
    first, last = ([
        scores.part(sequence, "csd", f"{m}_by_frame", *part) for m in ("sensitivity", "k")
    ] for part in ((0, 0.2), (0.8, 1)))
    said = "–" if change is None else "{:+.4f} ({:+.4f} to {:+.4f}) a feature".format(
        *change).replace("-", "−")
    error = row.csd["error"]
    return Criterion(
        "last fifth",
        f"last fifth as good as the first, no loss of sensitivity beyond {loss:g} within the interval",
        f"first fifth {number(first[0], 4)} / {number(first[1], 4)}, {number(error['first_fifth'], 2)} px; last {number(last[0], 4)} / "
        f"{number(last[1], 4)}, {number(error['last_fifth'], 2)} px; sensitivity {said}",
        change is not None and change[2] >= 0 and change[1] >= -loss)


def back(row, out):
    """How many points are found again after black, cut or wipe, within WITHIN frames; the worst of these counts."""
    by_sequence = {}
    for sequence in row.kinds:
        by_sequence[sequence.title] = found = []
        for seed in sequence.seeds:
            folder = running.folder_of(out, sequence, seed)
            found += truth.returns(truth.read(folder / "truth-tracked.jsonl"),
                                   truth.read(folder / "csd.jsonl"), WITHIN, TOGETHER)
    shares = [sum(found) / len(found) for found in by_sequence.values() if found]
    said = "; ".join(
        f"{title} {sum(found)} of {len(found)}" for title, found in by_sequence.items())
    return shown(
        at_least(f"back within {WITHIN} frames", row.goals["back"], min(shares, default=None), 3,
                 said),
        len(shares) == len(by_sequence))


def criteria(row, out):
    """Of everything that the row must reach."""
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
        recovery = csd["recovery"]
        found.append(
            shown(
                at_most(
                    "median of the return", goals["frames_until"], recovery["median_frames"], 1,
                    f"{number(recovery['median_frames'], 1)} frames ({recovery['recovered']} of {recovery['returns']} returned)",
                    " frames"), recovery["returns"]))
    if "lasting" in goals:
        found.append(lasting(row))
    if "back" in goals:
        found.append(back(row, out))
    return found


def verdict(found):
    missed, unknown = ([c.name for c in found if c.reached is of] for of in (False, None))
    if missed:
        return f"not reached: {', '.join(missed)}"
    return f"no occasion: {', '.join(unknown)}" if unknown else "**reached**"


def in_vivo(goals):
    if "paper" not in goals:
        return "–"
    return " / ".join(number(PAPER[goals["paper"]][m]["csd-2012"]) for m in ("sensitivity", "k"))


def goals_table(rows, out):
    lines = []
    for row in rows:
        found = criteria(row, out)
        of = {c.name: c.found for c in found}
        lines.append([
            row.title,
            in_vivo(row.goals), "; ".join(c.goal for c in found),
            fine(row.csd["sensitivity"]), of["K"],
            number(row.csd["error"]["median"], 3),
            "; ".join(f"{name}: {said}" for name, said in of.items()
                      if name not in ("sensitivity", "K", "median")) or "–",
            verdict(found)
        ])
    return table([
        "scenario", "the paper's CSD in vivo", "to reach", "csd: sensitivity", "csd: K",
        "median, px", "more", ""
    ], lines)


def by_sequence(rows):
    return table(["scenario", "sequence", "csdsimsrc", "frames", "seeds", "csd: sensitivity / K"],
                 [[
                     row.title, s.title, f"`{settings(s)}`",
                     str(s.frames), ", ".join(map(str, s.seeds)), " / ".join(
                         number(row.scores["tracked"].of_sequence(s, "csd", m), 4)
                         for m in ("sensitivity", "k"))
                 ]
                  for row in rows
                  for s in row.kinds])


MEASURES = (("delta_avg", "δavg"), ("aj", "AJ"), ("oa", "OA"))


def standing(rival, csd, p):
    """Of csd beside a rival, in one measure."""
    if rival is None or csd is None or p is None:
        return "unknown"
    if rival >= ONE and csd >= ONE:
        return "equal"
    if p >= GOALS["p"]:
        return "not told apart"
    return "above" if csd > rival else "below"


def beside(row, plan):
    """[(rival, share, {measure: (its figure, csd's, p, standing)})]"""
    found = []
    for share in plan.shares:
        scores = row.scores[share.name]
        for rival in share.trackers:
            if rival == "csd":
                continue
            of = {}
            for measure, _ in MEASURES:
                a, b, p = scores.value(rival, measure), scores.value(
                    "csd", measure), scores.comparisons[rival][measure]["p"]
                of[measure] = a, b, p, standing(a, b, p)
            found.append((rival, share, of))
    return found


def all_of(of):
    """In words, for the three measures."""
    standings = {s for *_, s in of.values()}
    if standings <= {"above", "equal"}:
        return "**above**" if "above" in standings else "equal"
    return ", ".join(f"{label}: {of[m][3]}" for m, label in MEASURES
                     if of[m][3] not in ("above", "equal"))


def p_of(p):
    return "–" if p is None else "p < .001" if p < 0.001 else f"p {p:.3f}"


def comparison(row, plan):
    return f"\n{row.title}:\n\n" + table(
        ["rival", *(f"{label}: rival, csd" for _, label in MEASURES), "csd is"], [[
            rival, *(f"{number(a)}, {number(b)} ({p_of(p)})" for a, b, p, _ in of.values()),
            all_of(of)
        ] for rival, _, of in beside(row, plan)])


def summary(rows, plan):
    """Of all comparisons, and which of them csd does not win."""
    pairs = [(row, rival, of) for row in rows for rival, _, of in beside(row, plan)]
    others = [
        f"{row.title}, {rival} ({said})" for row, rival, of in pairs
        if (said := all_of(of)) not in ("**above**", "equal")
    ]
    won = f"In {len(pairs) - len(others)} of {len(pairs)} pairs of scenario and rival csd is above in each of the three, or equal where both are at 1.000"
    return f"{won}.\n" if not others else f"{won}. In the others:\n\n" + "\n".join(
        f"* {other}" for other in others) + "\n"


def calibration(plan, out, kinds):
    """csd's expected calibration error over these sequences, and the bins it comes from."""
    return Scores(plan, out, kinds, ["csd"], resamples=0).trackers["csd"]["calibration"]


def calibration_part(found):
    said = at_most("ECE", GOALS["ece"], found["ece"], 4)
    return (
        f"Expected calibration error of `confidence`, over all of these sequences: {said.found}; to reach: {said.goal}; {verdict([said])}.\n\n"
        + table(
            ["confidence", "reports", "share that is visible and within τ"],
            [[number(b["confidence"]),
              str(b["reports"]), number(b["frequency"])] for b in found["bins"] if b["reports"]]) +
        "\nThe figure is a mean over the reports, and most of them are sure. One between .1 and .9 is rare, and less exact: take it as an order.\n"
    )


def diagram_part(everything, mixed, folder, linked):
    """The simulated sequences, and the one with everything in it by itself."""
    figures.reliability(folder / "calibration.svg", [("all sequences", everything),
                                                     ("everything mixed", mixed)])
    return (
        f"Of *everything mixed* alone: {number(mixed['ece'], 4)}. How often each confidence was right, and how often it was given:\n\n"
        f"![]({linked}/calibration.svg)\n")


def palindromes_part(found):
    lines = []
    for name, goals in GOALS["palindromes"].items():
        of = next(p for p in found["palindromes"] if p["tracks"] == f"{name}/csd.jsonl")
        held = [
            at_least("claimed", goals["claimed"], of["claimed"], 3),
            at_most("apart", goals["apart"], of["apart"], 4)
        ]
        lines.append([
            name,
            str(of["counts"]["features"]),
            str(of["counts"]["frames"]), *(c.found for c in held), "; ".join(c.goal for c in held),
            verdict(held)
        ])
    return table(["clip", "features", "frames", "claimed", "> 5 px apart", "to reach", ""], lines)


def clips_page(plan, rows, palindromes, found, out):
    """What needs the clips."""
    return f"""{"" if plan.published else QUICK}
First frames of real operations as the surface's texture, noise of σ 2, and the video compressed as
recorders do (`{sequences.CODEC.split(" ! ")[0]}`). The aim of *rotation, smoke* is an older and lower one than [on many tissues](results/tissue.md):

{goals_table(rows, out)}
{by_sequence(rows)}
{calibration_part(found)}
The same real videos and two more without truth, played forward and then backward (`pipelines/experiments/palindrome`;
[own-video.md](own-video.md#without-any-the-palindrome)): the share of features × frames in which csd claims a position, and, of two claims on the same image,
the share that is farther apart than τ. All trackers begin at the same features here, edges and tools among them; where `csd` begins by itself, more is claimed and less
is apart ([benchmarks.md](results/benchmarks.md), `clips`).

{palindromes_part(palindromes)}
Beside the rivals:

{summary(rows, plan)}{"".join(comparison(row, plan) for row in rows)}
"""


def black_in_words(plan, out):
    """What the view does while the picture is black for the first time, over the seeds."""
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
    frames, angles, scales = zip(*((n, abs(angle), scale) for n, angle, scale in moves))
    return (
        f" In the dark, {max(frames)} frames ({max(frames) / sequence.rate:g} s), the view turns by {min(angles):.0f}° to {max(angles):.0f}°, and the "
        f"picture grows by a factor of {min(scales):.2f} to {max(scales):.2f}.")


def shares_in_words(plan):
    longest = max(plan.sequences, key=lambda s: s.frames)
    lines = []
    for share in plan.shares:
        features, frames = share.of(longest)
        rivals = ", ".join(f"`{t}`" for t in share.trackers if t != "csd")
        lines.append(
            f"* {rivals}: {f'{features} of the features' if share.features else 'all features'}, "
            f"{f'the first {frames} frames' if share.frames else 'all frames'}, {'the first seed' if share.first_seed else 'all seeds'}"
        )
    return "\n".join(lines)


def simulated_page(plan, rows, found, out, drawn, linked):
    """What needs no clips. found: csd's calibration over all rows."""
    mixed = rows[list(GOALS["rows"]).index("mixed")].csd["calibration"]
    return f"""{"" if plan.published else QUICK}
{effort(plan, running.spent(plan, out), running.by_the_clock(plan, out), "The intervals", plan.sequences)}

{goals_table(rows, out)}
*Reached* is by the figure itself, not by its interval. The paper's Table 3 is of zoom, rotation and smoke together; its figures are
of other videos, in vivo, and stand here for orientation. *Median of the return*: frames from when a feature is visible again until csd claims it
within τ, whatever hid it, be it a highlight in a single frame. *Back within {WITHIN} frames*: of the times that a visible feature was hidden
together with at least a fifth of all and is visible again, in how many csd claims it within τ in one of the first {WITHIN} frames; in each of
the three sequences the share must be that high.{black_in_words(plan, out)}
*Last fifth*: sensitivity / K and the median error of the first and the last fifth of the frames; as good means that the interval of a feature's change
of sensitivity reaches 0 at least, and that none of it is below −{GOALS["rows"]["mixed"]["lasting"]:g}: a wide one shows nothing.

By sequence:

{by_sequence(rows)}
{calibration_part(found)}
{diagram_part(found, mixed, drawn, linked)}
## Beside the rivals

δavg, AJ and OA of each rival and of csd on the features and frames that this rival was run on; p of the paired difference; *above*: in each of the three with
p < {GOALS["p"]:g}. [baselines.md](baselines.md) says how each is set. What costs much, or is far below by the paper's experiments, gets a part:

{shares_in_words(plan)}

{summary(rows, plan)}{"".join(comparison(row, plan) for row in rows)}
"""


def write(plan, out, path, command, jobs):
    """Scores all runs, draws the figure, and writes the page; where the clips were there, theirs, too."""
    versions = running.versions(plan, out)
    simulated, pictures = rows_of(plan)
    palindromes = running.palindromes(plan, out) if pictures else None
    print("scores", file=sys.stderr)
    # csd-score is a process; here they only wait for it
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        scored = list(pool.map(lambda row: score(plan, out, row[2]), simulated + pictures))
        everything, of_pictures = (pool.submit(calibration, plan, out,
                                               [s
                                                for *_, kinds in of
                                                for s in kinds]) if of else None
                                   for of in (simulated, pictures))
    rows = [Row(*of, scores) for of, scores in zip(simulated + pictures, scored)]
    rows, real = rows[:len(simulated)], rows[len(simulated):]
    drawn, linked = page.folder_for_figures(path)
    about = f"`csd` ([method.md](method.md)), on {plan.sequences[0].features} features of each scene, held to figures that were set before it was measured."
    page.write(path, "csd: what it reaches", about, command, versions,
               simulated_page(plan, rows, everything.result(), out, drawn, linked), drawn)
    if real:
        page.write(path.with_name("beyond-clips.md"),
                   "csd: what it reaches with clips of real tissue", about, command, versions,
                   clips_page(plan, real, palindromes, of_pictures.result(), out))
