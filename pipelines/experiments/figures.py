# SPDX-License-Identifier: LGPL-2.1-or-later
"""Figures, drawn by gnuplot as SVG. Curves differ in dashes as well as in colour: grey will do."""

import math
import subprocess

import builds

# Dash pattern and colour; thick is the paper's own tracker.
STYLES = {
    "csd-2012": "dt 1 lw 2.5 lc rgb '#1b7837'", "sift": "dt 2 lw 1.5 lc rgb '#b2182b'",
    "lk": "dt 1 lw 1.2 lc rgb '#2166ac'", "ms1": "dt 3 lw 1.5 lc rgb '#000000'",
    "ms2": "dt 4 lw 1.5 lc rgb '#4393c3'", "csd-forest": "dt 2 lw 2 lc rgb '#762a83'"
}
PERFECT = "dt 3 lw 1.5 lc rgb '#000000'"  # of a reliability diagram
BY_FRAME = (("sensitivity_by_frame", "sensitivity"), ("k_by_frame", "K = 1 − precision"))
BIN = 10  # frames that a point of a curve averages


def mean(values):
    known = [v for v in values if v is not None]
    return sum(known) / len(known) if known else None


def binned(curves, width=BIN):
    """Means over `width` frames and over the curves (one for each seed), as (middle frame, value). None: nothing to say there."""
    length = max(map(len, curves))
    return [(start + (min(width, length - start) - 1) / 2,
             mean([v
                   for c in curves
                   for v in c[start:start + width]]))
            for start in range(0, length, width)]


class Panel:
    """drawn: gnuplot's lines or points. key: where its own is; without one it has the same curves as the first panel."""

    def __init__(self, title, xlabel, ylabel, settings="set yrange [0:1.03]", drawn="lines",
                 key=None):
        self.title, self.xlabel, self.ylabel, self.settings, self.drawn, self.key = title, xlabel, ylabel, settings, drawn, key
        self.curves = []  # (name, style, [(x, y)])

    def add(self, name, style, points):
        self.curves.append((name, style, points))


def quoted(text):
    """A string of gnuplot's, in which nothing is obeyed."""
    return "'" + "".join(c if c.isprintable() else "?" for c in text).replace("'", "''") + "'"


def draw(path, panels, columns, height=230):
    """Panels row by row, one key for all but those with their own."""
    rows = math.ceil(len(panels) / columns)
    script = [
        f'set terminal svg size {420 * columns},{height * rows + 40} font "sans,11" background "#ffffff" enhanced',
        f"set output {quoted(path.name)}",
        "set encoding utf8",
        "set datafile missing '?'",
        "set grid lt 1 lc rgb '#dddddd'",
        # the title's room is the key's
        f'set multiplot layout {rows},{columns} title " \\n "'
    ]
    for i, panel in enumerate(panels):
        script += [
            f"set title {quoted(panel.title)} noenhanced", f'set xlabel "{panel.xlabel}"',
            f'set ylabel "{panel.ylabel}"', "set autoscale", "unset logscale", panel.settings,
            f"set key default {panel.key}"
            if panel.key else "set key at screen 0.5, screen 1 center top horizontal samplen 2"
            if i == 0 else "unset key"
        ]
        for j, (_, _, points) in enumerate(panel.curves):
            rows_of = "\n".join(
                f"{x:g} {'?' if y is None else format(y, '.4f')}" for x, y in points)
            script.append(f"$c{i}_{j} << EOD\n{rows_of}\nEOD")
        script.append("plot " + ", ".join(
            f'$c{i}_{j} using 1:2 with {panel.drawn} {style} title {quoted(name)} noenhanced'
            for j, (name, style, _) in enumerate(panel.curves)))
    script.append("unset multiplot")
    done = subprocess.run(["gnuplot"], input="\n".join(script) + "\n", capture_output=True,
                          text=True, cwd=path.parent)
    if done.returncode or not path.exists():
        raise builds.Failure(f"gnuplot could not draw {path.name}: {done.stderr.strip()[-500:]}")


def over_time(path, sequences, frames_of, trackers):
    """A row for each sequence: sensitivity and K over the frames. frames_of(sequence, tracker, measure) gives a list a seed."""
    panels = []
    for sequence in sequences:
        for measure, label in BY_FRAME:
            panel = Panel(sequence.title, "frame", label)
            for tracker in trackers:
                panel.add(tracker, STYLES[tracker], binned(frames_of(sequence, tracker, measure)))
            panels.append(panel)
    draw(path, panels, 2)


def over_threshold(path, groups, trackers):
    """A row for each group (title, {tracker: csd-score's curve}): sensitivity and K over τ."""
    panels = []
    for title, curves in groups:
        for measure, label in (("sensitivity", "sensitivity"), ("k", "K = 1 − precision")):
            panel = Panel(title, "τ, pixels", label, "set yrange [0:1.03]; set logscale x 2")
            for tracker in trackers:
                panel.add(tracker, STYLES[tracker],
                          [(point["pixels"], point[measure]) for point in curves[tracker]])
            panels.append(panel)
    draw(path, panels, 2)


def learning(path, cost):
    """Fig. 11: ms of learning per feature and frame, leaves retrained; exhaustive and ranked."""
    panels = []
    for column, label, settings in ((0, "learning a feature, ms", "set logscale y"),
                                    (1, "leaves retrained", "set yrange [0:*]")):
        panel = Panel("exhaustive and ranked search", "frame", label, settings)
        for search, style in (("exhaustive", "dt 2 lw 1.5 lc rgb '#b2182b'"),
                              ("ranked", "dt 1 lw 2 lc rgb '#1b7837'")):
            # On a logarithmic axis a frame without learning has no place.
            points = [(frame, row[column] if column or row[column] > 0 else None)
                      for frame, row in enumerate(cost[search])]
            panel.add(search, style, points)
        panels.append(panel)
    draw(path, panels, 2)


def reliability(path, groups):
    """The reliability diagram of each group (name, csd-score's calibration): how often a confidence is right, and is given."""
    panels = [
        Panel("reliability", "confidence", "share that is visible and within τ"),
        Panel("reports", "confidence", "share of all reports",
              "set logscale y; set yrange [1e-4:1]")
    ]
    panels[0].add("perfect", PERFECT, [(0, 0), (1, 1)])
    for (name, calibration), style in zip(groups, (STYLES["csd-2012"], STYLES["sift"])):
        bins = [b for b in calibration["bins"] if b["reports"]]
        reports = sum(b["reports"] for b in bins)
        panels[0].add(name, style, [(b["confidence"], b["frequency"]) for b in bins])
        panels[1].add(name, style, [(b["confidence"], b["reports"] / reports) for b in bins])
    draw(path, panels, 2)
