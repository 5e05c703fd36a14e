# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tables, figures and plots of docs/evaluation.md, docs/performance.md and docs/own-video.md, from what the pages of docs/results/ say."""

import json
import os
import pathlib
import re

import builds
import figures
import page

DOCS = builds.ROOT / "docs"
GOALS = json.loads((pathlib.Path(__file__).resolve().parent / "beyond.json").read_text())
KINDS = json.loads((pathlib.Path(__file__).resolve().parent / "tissue.json").read_text())
SHORT = {of["title"]: name for goals in (GOALS["rows"], KINDS) for name, of in goals.items()}
PAPER_NAMES = {"LK": "lk", "MS1": "ms1", "MS2": "ms2", "SIFT": "sift", "CSD": "csd-2012"}
CLASSES = ("Table 1: deformation", "Table 2: occlusion", "Table 3: scale, rotation and smoke")
# Of the plots; those of figures.STYLES are lines.
POINTS = {
    "csd": "pt 7 ps 0.9 lc rgb '#762a83'", "csrt": "pt 9 ps 0.8 lc rgb '#b2182b'",
    "medianflow": "pt 11 ps 0.8 lc rgb '#e08214'", "lk": "pt 5 ps 0.7 lc rgb '#2166ac'",
    "csd-2012": "pt 13 ps 0.9 lc rgb '#1b7837'", "sift": "pt 2 ps 0.7 lc rgb '#000000'"
}


class Results:
    """A page of docs/results/."""

    def __init__(self, name, folder=page.RESULTS):
        self.path = folder / f"{name}.md"
        try:
            self.text = self.path.read_text()
        except OSError as error:
            raise builds.Failure(f"{self.path}: {error.strerror}") from error

    def rows(self, header, after=""):
        """The first table whose header begins with these cells, behind this text: [{column: cell}]."""
        begin = self.text.find(after)
        at = self.text.find(f"\n| {' | '.join(header)} |", begin) if begin >= 0 else -1
        if at < 0:
            raise builds.Failure(
                f"{self.path} has no table '{' | '.join(header)}'{f' below {after.strip()!r}' if after else ''}"
            )
        head, _, *lines = re.match(r"(?:\|.*\n?)+", self.text[at + 1:])[0].splitlines()
        columns = cells(head)
        return [dict(zip(columns, cells(line))) for line in lines]

    def found(self, pattern):
        """The groups of the only place that is so."""
        places = re.findall(pattern, self.text, re.M)
        if len(places) != 1:
            raise builds.Failure(f"{self.path} has {len(places)} places like '{pattern}', not one")
        return places[0]

    def commit(self):
        return self.found(r"^\| csdtrack \| ([^ ;]+)[^|]*\|$")


def cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def first(cell):
    """A figure without its interval."""
    return cell.split(" ")[0]


def both(sensitivity, k):
    return f"{first(sensitivity)} / {first(k)}"


def aim(text):
    """Of what is to be reached, sensitivity and K."""
    found = [(re.search(rf"{name} (\S+ [\d.]+)", text) or [None, "–"])[1]
             for name in ("sensitivity", "K")]
    return " / ".join(found)


def missed(row):
    """What a scene on real tissue fails, by its printed figures."""
    goals = dict(
        zip(("sensitivity", "K", "worst", "within 2 px"),
            (float((re.search(p, row["to reach: sensitivity / K"]) or [0, "0"])[1])
             for p in (r"^≥ ([\d.]+)", r"^\S+ \S+ / ≤ ([\d.]+)", r"worst ≥ ([\d.]+)",
                       r"within 2 px ≥ ([\d.]+)"))))
    sensitivity, k = map(float, row["sensitivity / K"].split(" / "))
    values = {
        "sensitivity": sensitivity, "K": k, "worst": float(first(row["worst tissue"])),
        "within 2 px": float(row["within 2 px"])
    }
    return [
        name for name, goal in goals.items()
        if (values[name] > goal if name == "K" else values[name] < goal)
    ]


class Evaluation:
    def __init__(self, folder=page.RESULTS):
        self.beyond, self.clips_of_beyond, self.tissue, self.paper, self.clips = (Results(
            name, folder) for name in ("beyond", "beyond-clips", "tissue", "paper", "clips"))
        self.scenarios = self.beyond.rows(["scenario", "the paper's CSD in vivo"])
        self.scenes = self.tissue.rows(["scene", "tissues"])
        self.beside = [
            self.beyond.rows(["rival"], f"\n{row['scenario']}:\n") for row in self.scenarios
        ]

    def scenes_table(self):
        rows = [[
            "simulated", row["scenario"],
            aim(row["to reach"]),
            both(row["csd: sensitivity"], row["csd: K"]), "", row[""].removeprefix("not reached: ")
        ] for row in self.scenarios]
        for row in self.scenes:
            rows.append([
                "real", row["scene"], row["to reach: sensitivity / K"].split(";")[0],
                row["sensitivity / K"], row["worst tissue"].split(",")[0],
                row[""] if "**" in row[""] else ", ".join(missed(row))
            ])
        return page.table([
            "tissue", "scene", "to reach: sensitivity / K", "`csd`: sensitivity / K",
            "worst tissue", "missed"
        ], rows)

    def rivals(self):
        """{tracker: [(δavg, AJ) of each scenario]}, csd's where it is measured on all."""
        found = {}
        for rows in self.beside:
            for row in rows:
                of = [[
                    float(value)
                    for value in re.match(r"([\d.]+), ([\d.]+)", row[f"{m}: rival, csd"]).groups()
                ]
                      for m in ("δavg", "AJ")]
                found.setdefault(row["rival"], []).append(tuple(pair[0] for pair in of))
                if row["rival"] == "lk":
                    found.setdefault("csd", []).append(tuple(pair[1] for pair in of))
        return found

    def of_the_paper(self):
        """{tracker: [(the paper's, ours) of each class]}, each sensitivity / K."""
        found = {}
        for title in CLASSES:
            printed = {row[""]: row for row in self.paper.rows(["", "LK"], f"\n## {title}\n")}
            in_vivo = {
                tracker:
                both(*(printed[f"{m}, the paper in vivo"][name] for m in ("sensitivity", "K")))
                for name, tracker in PAPER_NAMES.items()
            }
            for row in self.paper.rows(["tracker", "sensitivity", "K"], f"\n## {title}\n"):
                found.setdefault(row["tracker"], []).append(
                    (in_vivo.get(row["tracker"], "–"), both(row["sensitivity"], row["K"])))
        return found

    def trackers_table(self):
        rivals, paper = self.rivals(), self.of_the_paper()
        names = [
            *sorted(rivals, key=lambda name: -mean(aj for _, aj in rivals[name])),
            *(name for name in paper if name not in rivals)
        ]
        rows = []
        for name in names:
            ours = " / ".join(
                f"{mean(values):.3f}" for values in zip(*rivals[name])) if name in rivals else "–"
            rows.append([
                f"`{name}`", ours,
                *(cell for pair in paper.get(name, [("–", "–")] * 3) for cell in pair)
            ])
        return page.table([
            "tracker", "δavg / AJ",
            *(f"{title}{of}" for title in ("deformation", "occlusion", "scale, rotation, smoke")
              for of in (": the paper", ", here"))
        ], rows)

    def reached(self):
        """In words: how much of what was to be reached is."""
        def share(rows):
            return f"{sum('**reached**' in row[''] for row in rows)} of {len(rows)}"
        pairs = self.beyond.found(r"^In (\d+ of \d+) pairs of scenario and rival csd is above")
        below = sum("below" in row["csd is"] for rows in self.beside for row in rows)
        ece = self.beyond.found(
            r"^Expected calibration error .*: ([\d.]+); to reach: ECE ≤ ([\d.]+); ")
        of_clips, palindromes = (self.clips_of_beyond.rows(header)
                                 for header in (["scenario", "the paper's CSD in vivo"],
                                                ["clip", "features"]))
        claims = [row["here"].strip("*† ") for row in self.paper.rows(["", "the paper finds"])]
        return "".join(f"* {line}\n" for line in (
            f"Reached on simulated tissue: {share(self.scenarios)} scenarios; on pictures of real tissue: {share(self.scenes)} scenes; on clips as textures: {share(of_clips)} scenes; "
            f"of clips forward and backward: {share(palindromes)}.",
            f"In {pairs} pairs of scenario and rival `csd` is above in δavg, AJ and OA (p < {GOALS['p']:g}), or equal; in {below or 'no'} pair{'s' * (below > 1)} is it below in any of them.",
            f"The expected calibration error of `confidence` is {ece[0]}; {ece[1]} was to be reached.",
            f"Of {len(claims)} statements that the paper makes of its trackers, {sum(c.startswith('holds') for c in claims)} hold here, {sum(c.startswith('does not') for c in claims)} do not, "
            f"{sum(not c.startswith(('holds', 'does not')) for c in claims)} are not decided.",
            f"Measured at: {', '.join(f'{of.path.name} {of.commit()}' for of in (self.beyond, self.clips_of_beyond, self.tissue, self.paper))}."
        ))

    def clips_table(self):
        """Of own-video.md."""
        by_clip = {}
        for row in self.clips.rows(["tracks", "tracker"], "\n## Palindromes\n"):
            clip = row["tracks"].split("/")[0]
            by_clip.setdefault(clip,
                               {})[row["tracker"]] = f"{row['claimed']} / {row['> 5 px apart']}"
        truth = {
            row["tracker"]: both(row["sensitivity"], row["1 − precision"])
            for row in self.clips.rows(["tracker", "sensitivity"])
        }
        trackers = list(truth)
        rows = [["beads, by their truth: sensitivity / K", *truth.values()]]
        rows += [[f"{clip}: claimed / apart", *(of[t]
                                                for t in trackers)]
                 for clip, of in by_clip.items()]
        return page.table(["", *(f"`{t}`" for t in trackers)], rows)

    def draw(self, path):
        left = figures.Panel(
            "simulated tissue", "", "AJ",
            f"set yrange [0:1.03]; {categories(row['scenario'] for row in self.scenarios)}",
            "points")
        rivals = self.rivals()
        for name, style in POINTS.items():
            if name in rivals:
                left.add(name, style, [(i, aj) for i, (_, aj) in enumerate(rivals[name])])
        right = figures.Panel(
            "pictures of real tissue: csd", "", "sensitivity",
            f"set yrange [0:1.03]; {categories(row['scene'] for row in self.scenes)}", "points",
            "inside left bottom samplen 1")
        for name, style, of in (
            ("to reach", "pt 1 ps 1 lc rgb '#000000'",
             lambda row: float(re.match(r"≥ ([\d.]+)", row["to reach: sensitivity / K"])[1])),
            ("mean", POINTS["csd"], lambda row: float(first(row["sensitivity / K"]))),
            ("worst tissue", "pt 6 ps 0.9 lc rgb '#762a83'",
             lambda row: float(first(row["worst tissue"])))):
            right.add(name, style, [(i, of(row)) for i, row in enumerate(self.scenes)])
        figures.draw(path, [left, right], 2, 320)


def categories(titles):
    """Names below the axis in place of numbers."""
    names = [SHORT.get(title, title) for title in titles]
    ticks = ", ".join(f"{figures.quoted(name)} {i}" for i, name in enumerate(names))
    return f"set xrange [-0.5:{len(names) - 0.5}]; set xtics ({ticks}) rotate by -40 noenhanced"


class Performance:
    def __init__(self, folder=page.RESULTS):
        self.bench = Results("benchmarks", folder)

    def lines(self, title):
        """Of a table below a line that begins so: the numbers and words of each row."""
        at = self.bench.text.find(f"\n{title}")
        if at < 0:
            raise builds.Failure(f"{self.bench.path} has nothing that begins with '{title}'")
        rows = []
        for line in self.bench.text[at + 1:].splitlines()[2:]:
            if not line.strip() or line.startswith("```"):
                break
            rows.append(line.replace(" / ", " ").split())
        return rows

    def growth(self, size):
        """{features: [p50, p95, MB]}"""
        return {
            int(features): values
            for at, features, *values in self.lines("csd by the number of features")
            if at == size
        }

    def cost_table(self):
        found = {}
        for size, kind, features, *values in self.lines("ms a frame on the streaming thread"):
            if kind == "I420":
                found[size, int(features)] = [
                    " / ".join(values[i:i + 2]) for i in range(0, len(values), 2)
                ]
        rows = []
        for size in dict.fromkeys(size for size, _ in found):
            many = self.growth(size).get(1000)
            csd = [found[size, n][0] for n in (50, 100)]
            rows.append([
                size.replace("x", "×"), *csd, f"{many[0]} / {many[1]}" if many else "–",
                *(found[size, 100][i] for i in (1, 2, 3))
            ])
        return page.table([
            "picture", "`csd`: 50 features", "100", "1000", "`csd-2012`: 100", "`lk`: 100",
            "OpenCV's PyrLK: 100"
        ], rows)

    def clips_table(self):
        rows = []
        for clip, size, _, features, _, _, p50, p95, most, start, lk, lk95, csrt, csrt95, *_ in self.lines(
                "== clips"):
            rows.append([
                clip,
                size.replace("x", "×"), features, f"{p50} / {p95}", most, start, f"{lk} / {lk95}",
                f"{csrt} / {csrt95}"
            ])
        return page.table([
            "clip", "picture", "features", "`csd`", "most", "first frame", "PyrLK",
            "CSRT, 10 features"
        ], rows)

    def microseconds(self, name):
        """A point in a frame, of `peers`."""
        value, unit = self.bench.found(rf"^{name} .* ([\d.]+)(us|ms|s)$")
        return float(value) * {"us": 1, "ms": 1e3, "s": 1e6}[unit]

    def rest(self):
        machine = self.bench.found(r"^\| processor \| (.*) \|$")
        few, many = (self.microseconds(f"csd_frame/{n}") for n in (100, 1000))
        peers = [
            f"{name} {self.microseconds(f'peer_frame/{of}'):.0f}"
            for name, of in (("PyrLK forward and backward", "lk_fb/100"),
                             ("MedianFlow", "median_flow/10"), ("KCF", "kcf/10"), ("CSRT",
                                                                                   "csrt/10"))
        ]
        recording = []
        for block in re.findall(r"^record: (.*?) ! .*\n((?:  .*\n)+)", self.bench.text, re.M):
            kept = {
                name: (fps, share) for name, fps, share in re.findall(
                    r"^  (.+?) +([\d.]+) fps +([\d.]+) % kept$", block[1], re.M)
            }
            csd, lk, without = (kept[name]
                                for name in ("csdtrack algorithm=csd", "csdtrack algorithm=lk",
                                             "without csdtrack"))
            what = block[0].split()[1].replace("I420", "the texture")
            recording.append(
                f"{what} at {csd[0]} frames a second instead of {without[0]} ({csd[1]} %; `lk` {lk[1]} %)"
            )
        dropped, frames = self.bench.found(
            r"^  csdtrack algorithm=csd +(\d+) of (\d+) frames dropped at the source$")
        stop = self.bench.found(
            r"^  algorithm=csd max-features=1000 +([\d.]+) / +[\d.]+ / +([\d.]+),")
        memory = self.growth("640x480")
        minutes = self.lines("csd over time")
        each = 1000 * (float(memory[1000][2]) - float(memory[100][2])) / 900
        return "".join(f"* {line}\n" for line in (
            f"**Machine**: {machine}; csdtrack {self.bench.commit()}.",
            f"**A feature in a frame** takes {few:.0f} µs with 100 features and {many:.1f} µs with 1000. Others take, in µs: {', '.join(peers)}.",
            f"**Recording** 1280×720 with x264enc on the same processors, as fast as both go, 50 features: {'; '.join(recording)}.",
            f"**Live** at 30 frames a second: {dropped} of {frames} frames dropped.",
            "**Latency**: no frame is held back. Each leaves as soon as it is tracked, after the times above.",
            f"**Stopping** a pipeline with 1000 features takes {stop[0]} ms in the median, {stop[1]} at most.",
            f"**Memory**: {memory[100][2]} MB with 100 features, {memory[1000][2]} with 1000 (640×480): {each:.0f} kB a feature.",
            f"**Over time**: {minutes[0][1]} ms a frame in minute {minutes[0][0]}, {minutes[-1][1]} in minute {minutes[-1][0]} (100 features)."
        ))

    def draw(self, path):
        p50, p95 = ("p50", "dt 1 lw 2 lc rgb '#762a83'"), ("p95", "dt 2 lw 1.5 lc rgb '#762a83'")
        panels = []

        def panel(title, xlabel, rows, settings=""):
            panels.append(
                figures.Panel(title, xlabel, "ms a frame",
                              f"set yrange [0:*]; set xrange [*:*]; {settings}"))
            for column, (name, style) in enumerate((p50, p95)):
                panels[-1].add(name, style, [(x, float(values[column])) for x, values in rows])
        for size in ("640x480", "1920x1080"):
            panel(size.replace("x", "×"), "features", list(self.growth(size).items()),
                  "set logscale x")
        sizes = [(megapixels(size), values)
                 for size, *values in self.lines("csd by the size of the picture")]
        panel("100 features", "megapixels", sizes)
        panel("640×480, 100 features", "minutes",
              [(int(minute), values) for minute, *values in self.lines("csd over time")])
        figures.draw(path, panels, 2)


def megapixels(size):
    width, height = map(int, size.split("x"))
    return width * height / 1e6


def pages(folder=page.RESULTS):
    """[(page of docs/, {block: its text}, {plot: what draws it})]"""
    evaluation, performance = Evaluation(folder), Performance(folder)
    return [("evaluation.md", {
        "scenes": evaluation.scenes_table(), "trackers": evaluation.trackers_table(),
        "reached": evaluation.reached()
    }, {"evaluation/scenes.svg": evaluation.draw}),
            ("performance.md", {
                "cost": performance.cost_table(), "clips": performance.clips_table(),
                "rest": performance.rest()
            }, {"performance/growth.svg": performance.draw}),
            ("own-video.md", {"clips": evaluation.clips_table()}, {})]


def marks(block):
    return f"<!-- {block}: written by pipelines/experiments/summary -->", f"<!-- end of {block} -->"


def filled(text, blocks, path):
    for block, body in blocks.items():
        text = page.filled(text, *marks(block), body, path)
    return text


def write(docs=DOCS):
    """The summaries in docs/ from its results, all of them or none. Returns the paths."""
    made = pages(docs / "results")
    texts = {
        docs / name: filled((docs / name).read_text(), blocks, docs / name)
        for name, blocks, _ in made
    }
    plots = {docs / plot: draw for *_, drawn in made for plot, draw in drawn.items()}
    for plot, draw in plots.items():
        plot.parent.mkdir(exist_ok=True)
        draw(plot)
    for path, text in texts.items():
        os.replace(page.aside(path, text), path)
    return [*texts, *plots]
