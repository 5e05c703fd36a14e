# SPDX-License-Identifier: LGPL-2.1-or-later
"""Figures, drawn by gnuplot as SVG.

Curves differ in dashes as well as in colour, so they can be told apart in grey.
"""

import math
import pathlib
import statistics
import subprocess
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence

from pipelines.experiments import sequences
from pipelines.lib.failure import Failure

# Dash pattern and colour; thick is the paper's own tracker.
STYLES = {
    "csd-2012": "dt 1 lw 2.5 lc rgb '#1b7837'",
    "sift": "dt 2 lw 1.5 lc rgb '#b2182b'",
    "lk": "dt 1 lw 1.2 lc rgb '#2166ac'",
    "ms1": "dt 3 lw 1.5 lc rgb '#000000'",
    "ms2": "dt 4 lw 1.5 lc rgb '#4393c3'",
    "csd-forest": "dt 2 lw 2 lc rgb '#762a83'",
}
PERFECT = "dt 3 lw 1.5 lc rgb '#000000'"  # in a reliability diagram
BY_FRAME = (("sensitivity_by_frame", "sensitivity"), ("k_by_frame", "K = 1 − precision"))
BIN = 10  # frames that one point of a curve averages

Value = float | None  # None: unknown
Points = Sequence[tuple[float, Value]]  # x, y
Cost = Mapping[str, Sequence[tuple[float, float, float]]]  # running.read_learning_cost()


def mean(values: Iterable[Value]) -> Value:
    known = [value for value in values if value is not None]
    # As precise in all versions of Python, as sum() is not: a figure's last digit can depend on it.
    return statistics.fmean(known) if known else None


def binned(curves: Sequence[Sequence[Value]], width: int = BIN) -> list[tuple[float, Value]]:
    """Means over `width` frames and over the curves, one of each seed: (middle frame, mean)."""
    length = max(map(len, curves))
    points = []
    for start in range(0, length, width):
        middle = start + (min(width, length - start) - 1) / 2
        points.append((middle, mean([v for curve in curves for v in curve[start:start + width]])))
    return points


class Panel:
    """One plot of a figure.

    drawn: "lines" or "points"; key: gnuplot's place for the panel's own key. A panel without one
    has the same curves as the first.
    """

    def __init__(self, title: str, xlabel: str, ylabel: str, settings: str = "set yrange [0:1.03]",
                 drawn: str = "lines", key: str | None = None) -> None:
        self.title, self.xlabel, self.ylabel = title, xlabel, ylabel
        self.settings, self.drawn, self.key = settings, drawn, key
        self.curves: list[tuple[str, str, Points]] = []  # name, style, points

    def add(self, name: str, style: str, points: Points) -> None:
        self.curves.append((name, style, points))


def quoted(text: str) -> str:
    """A gnuplot string in which no character has a meaning of its own."""
    printable = "".join(c if c.isprintable() else "?" for c in text)
    return "'" + printable.replace("'", "''") + "'"


def draw(path: pathlib.Path, panels: Sequence[Panel], columns: int, height: int = 230) -> None:
    """Draws the panels row by row, with one key for all but those with their own."""
    rows = math.ceil(len(panels) / columns)
    script = [
        f'set terminal svg size {420 * columns},{height * rows + 40} '
        'font "sans,11" background "#ffffff" enhanced',
        f"set output {quoted(path.name)}",
        "set encoding utf8",
        "set datafile missing '?'",
        "set grid lt 1 lc rgb '#dddddd'",
        # The empty title leaves room for the key.
        f'set multiplot layout {rows},{columns} title " \\n "',
    ]
    for i, panel in enumerate(panels):
        if panel.key:
            key = f"set key default {panel.key}"
        elif i == 0:
            key = "set key at screen 0.5, screen 1 center top horizontal samplen 2"
        else:
            key = "unset key"
        script += [
            f"set title {quoted(panel.title)} noenhanced",
            f'set xlabel "{panel.xlabel}"',
            f'set ylabel "{panel.ylabel}"',
            "set autoscale",
            "unset logscale",
            panel.settings,
            key,
        ]
        for j, (_, _, points) in enumerate(panel.curves):
            lines = [f"{x:g} {'?' if y is None else format(y, '.4f')}" for x, y in points]
            script.append("\n".join([f"$c{i}_{j} << EOD", *lines, "EOD"]))
        script.append("plot " + ", ".join(
            f"$c{i}_{j} using 1:2 with {panel.drawn} {style} title {quoted(name)} noenhanced"
            for j, (name, style, _) in enumerate(panel.curves)))
    script.append("unset multiplot")
    done = subprocess.run(["gnuplot"], input="\n".join(script) + "\n", capture_output=True,
                          text=True, cwd=path.parent)
    if done.returncode or not path.exists():
        raise Failure(f"gnuplot could not draw {path.name}: {done.stderr.strip()[-500:]}")


def over_time(path: pathlib.Path, kinds: Iterable[sequences.Sequence],
              frames_of: Callable[[sequences.Sequence, str, str], Sequence[Sequence[Value]]],
              trackers: Iterable[str]) -> None:
    """A row for each sequence: sensitivity and K over the frames.

    frames_of(sequence, tracker, measure) gives a list for each seed.
    """
    panels = []
    for sequence in kinds:
        for measure, label in BY_FRAME:
            panel = Panel(sequence.title, "frame", label)
            for tracker in trackers:
                panel.add(tracker, STYLES[tracker], binned(frames_of(sequence, tracker, measure)))
            panels.append(panel)
    draw(path, panels, 2)


def over_threshold(path: pathlib.Path, groups: Iterable[tuple[str, Mapping[str, typing.Any]]],
                   trackers: Iterable[str]) -> None:
    """A row for each group (title, csd-score's curve by tracker): sensitivity and K over τ."""
    panels = []
    for title, curves in groups:
        for measure, label in (("sensitivity", "sensitivity"), ("k", "K = 1 − precision")):
            panel = Panel(title, "τ, pixels", label, "set yrange [0:1.03]; set logscale x 2")
            for tracker in trackers:
                panel.add(tracker, STYLES[tracker],
                          [(point["pixels"], point[measure]) for point in curves[tracker]])
            panels.append(panel)
    draw(path, panels, 2)


def learning(path: pathlib.Path, cost: Cost) -> None:
    """The paper's Fig. 11: learning time per feature and frame, and leaves retrained, with
    exhaustive and with ranked search."""
    panels = []
    for column, label, settings in ((0, "learning a feature, ms", "set logscale y"),
                                    (1, "leaves retrained", "set yrange [0:*]")):
        panel = Panel("exhaustive and ranked search", "frame", label, settings)
        for search, style in (("exhaustive", "dt 2 lw 1.5 lc rgb '#b2182b'"),
                              ("ranked", "dt 1 lw 2 lc rgb '#1b7837'")):
            # A logarithmic axis has no place for a frame without learning.
            points = [(frame, row[column] if column or row[column] > 0 else None)
                      for frame, row in enumerate(cost[search])]
            panel.add(search, style, points)
        panels.append(panel)
    draw(path, panels, 2)


def reliability(path: pathlib.Path, groups: Iterable[tuple[str, Mapping[str, typing.Any]]]) -> None:
    """The reliability diagram of each group (name, csd-score's calibration): how often each
    confidence is right, and how often it is given."""
    panels = [
        Panel("reliability", "confidence", "share that is visible and within τ"),
        Panel("reports", "confidence", "share of all reports",
              "set logscale y; set yrange [1e-4:1]"),
    ]
    panels[0].add("perfect", PERFECT, [(0, 0), (1, 1)])
    for (name, calibration), style in zip(groups, (STYLES["csd-2012"], STYLES["sift"])):
        bins = [b for b in calibration["bins"] if b["reports"]]
        reports = sum(b["reports"] for b in bins)
        panels[0].add(name, style, [(b["confidence"], b["frequency"]) for b in bins])
        panels[1].add(name, style, [(b["confidence"], b["reports"] / reports) for b in bins])
    draw(path, panels, 2)
