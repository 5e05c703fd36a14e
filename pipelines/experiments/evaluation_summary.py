# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tables and the plot of docs/evaluation.md, and the table of docs/own-video.md."""

import pathlib
import re
import statistics
from collections.abc import Iterable

from pipelines.experiments import figures, page
from pipelines.experiments.reach import GOALS
from pipelines.experiments.results import Results, Row, both, figure, first
from pipelines.experiments.tissue import KINDS
from pipelines.lib.failure import Failure

# Short names of scenes, for the plots.
SHORT = {
    goals["title"]: name for table in (GOALS["rows"], KINDS) for name, goals in table.items()
}
PAPER_NAMES = {"LK": "lk", "MS1": "ms1", "MS2": "ms2", "SIFT": "sift", "CSD": "csd-2012"}
CLASSES = ("Table 1: deformation", "Table 2: occlusion", "Table 3: scale, rotation and smoke")
# Styles of points; those of figures.STYLES are for lines.
POINTS = {
    "csd": "pt 7 ps 0.9 lc rgb '#762a83'",
    "csrt": "pt 9 ps 0.8 lc rgb '#b2182b'",
    "medianflow": "pt 11 ps 0.8 lc rgb '#e08214'",
    "lk": "pt 5 ps 0.7 lc rgb '#2166ac'",
    "csd-2012": "pt 13 ps 0.9 lc rgb '#1b7837'",
    "sift": "pt 2 ps 0.7 lc rgb '#000000'",
}
REACH = "to reach: sensitivity / K"  # columns of tissue.md
FOUND = "sensitivity / K"


def goals_in_short(text: str) -> str:
    """The goals for sensitivity and K, of all goals of a scenario."""
    found = [re.search(rf"{name} (\S+ [\d.]+)", text) for name in ("sensitivity", "K")]
    return " / ".join(goal[1] if goal else "–" for goal in found)


def missed(row: Row) -> list[str]:
    """Which goals a scene on real tissue misses, by its printed figures."""
    sensitivity, k = map(float, row[FOUND].split(" / "))
    goals = {
        "sensitivity": (sensitivity, figure(r"^≥ ([\d.]+)", row[REACH])),
        "K": (k, figure(r"^\S+ \S+ / ≤ ([\d.]+)", row[REACH])),
        "worst": (float(first(row["worst tissue"])), figure(r"worst ≥ ([\d.]+)", row[REACH])),
        "within 2 px": (float(row["within 2 px"]), figure(r"within 2 px ≥ ([\d.]+)", row[REACH])),
    }
    return [
        name for name, (found, goal) in goals.items()
        if (found > goal if name == "K" else found < goal)
    ]


def share_reached(rows: list[Row]) -> str:
    return f"{sum('**reached**' in row[''] for row in rows)} of {len(rows)}"


def extremes(rows: list[Row], column: str, part: int) -> tuple[tuple[str, str], tuple[str, str]]:
    """The lowest and the highest of a column's two figures, each with its scene."""
    found = sorted(((row[column].split(",")[0].split(" / ")[part], row["scene"]) for row in rows),
                   key=lambda pair: float(pair[0]))
    return found[0], found[-1]


def categories(titles: Iterable[str]) -> str:
    """gnuplot's settings for names below the axis in place of numbers."""
    names = [SHORT.get(title, title) for title in titles]
    ticks = ", ".join(f"{figures.quoted(name)} {i}" for i, name in enumerate(names))
    return f"set xrange [-0.5:{len(names) - 0.5}]; set xtics ({ticks}) rotate by -40 noenhanced"


class Evaluation:
    def __init__(self, folder: pathlib.Path = page.RESULTS) -> None:
        self.beyond, self.clips_of_beyond, self.tissue, self.paper, self.clips = (
            Results(name, folder)
            for name in ("beyond", "beyond-clips", "tissue", "paper", "clips"))
        self.scenarios = self.beyond.rows(["scenario", "the paper's CSD in vivo"])
        self.scenes = self.tissue.rows(["scene", "tissues"])
        self.beside = [
            self.beyond.rows(["rival"], f"\n{row['scenario']}:\n") for row in self.scenarios
        ]

    def scenes_table(self) -> str:
        rows = [[
            "simulated", row["scenario"],
            goals_in_short(row["to reach"]),
            both(row["csd: sensitivity"], row["csd: K"]), "", row[""].removeprefix("not reached: ")
        ] for row in self.scenarios]
        for row in self.scenes:
            rows.append([
                "real", row["scene"], row[REACH].split(";")[0], row[FOUND],
                row["worst tissue"].split(",")[0],
                row[""] if "**" in row[""] else ", ".join(missed(row))
            ])
        return page.table(["tissue", "scene", REACH, "`csd`: sensitivity / K", "worst tissue",
                           "missed"], rows)

    def worst_in_words(self) -> str:
        """What machines.md says of real tissue."""
        def between(column: str, part: int) -> str:
            (low, lowest_scene), (high, highest_scene) = extremes(self.scenes, column, part)
            return f"from {low} ({lowest_scene}) to {high} ({highest_scene})"

        pictures = {row["tissues"] for row in self.scenes}
        if len(pictures) != 1:
            raise Failure(f"{self.tissue.path}: the scenes differ in their number of tissues")
        worst = "of the picture that is worst in all"
        return page.bullets((
            f"**Real tissue**: {pictures.pop()} pictures of it, moved by the simulator, "
            "so that the truth is known, and compressed as by a recorder "
            "([tissue.md](results/tissue.md)).",
            f"**Found**, of the visible points: {between(FOUND, 0)}; {worst} "
            f"{between('worst tissue', 0)}.",
            "**Wrong**, of the claims, by more than 5 pixels or of a hidden point: "
            f"{between(FOUND, 1)}; {worst} {between('worst tissue', 1)}."
        ))

    def real_in_words(self) -> str:
        """The ranges on real tissue, in short."""
        found, wrong = (
            " to ".join(f"{float(value):.{digits}f}".lstrip("0")
                        for value, _ in extremes(self.scenes, FOUND, part))
            for part, digits in ((0, 2), (1, 3)))
        return ("On pictures of real tissue that the simulator moves it finds "
                f"{found} of the visible points, depending on the scene, and {wrong} of its claims "
                "are wrong.")

    def of_clips(self) -> tuple[list[Row], list[Row]]:
        """Clips as textures, and clips forward and backward, with their goals."""
        return (self.clips_of_beyond.rows(["scenario", "the paper's CSD in vivo"]),
                self.clips_of_beyond.rows(["clip", "features"]))

    def goals_in_words(self) -> str:
        textures, palindromes = self.of_clips()
        return ("The goals set before the measurement are reached in "
                f"{share_reached(self.scenarios)} scenarios of simulated tissue, and in "
                f"{share_reached([*self.scenes, *textures, *palindromes])} scenes and clips of "
                "real tissue.")

    def rivals(self) -> dict[str, list[tuple[float, float]]]:
        """δavg and AJ of each scenario, by tracker; csd's where all features were tracked."""
        found: dict[str, list[tuple[float, float]]] = {}
        for rows in self.beside:
            for row in rows:
                (delta, csd_delta), (aj, csd_aj) = (
                    map(float, row[f"{m}: rival, csd"].split(" (")[0].split(", "))
                    for m in ("δavg", "AJ"))
                found.setdefault(row["rival"], []).append((delta, aj))
                if row["rival"] == "lk":  # which runs on all features
                    found.setdefault("csd", []).append((csd_delta, csd_aj))
        return found

    def of_the_paper(self) -> dict[str, list[tuple[str, str]]]:
        """Sensitivity / K in each class by tracker: the paper's and ours."""
        found: dict[str, list[tuple[str, str]]] = {}
        for title in CLASSES:
            heading = f"\n## {title}\n"
            printed = {row[""]: row for row in self.paper.rows(["", "LK"], heading)}
            in_vivo = {
                tracker:
                both(*(printed[f"{m}, the paper in vivo"][name] for m in ("sensitivity", "K")))
                for name, tracker in PAPER_NAMES.items()
            }
            for row in self.paper.rows(["tracker", "sensitivity", "K"], heading):
                found.setdefault(row["tracker"], []).append(
                    (in_vivo.get(row["tracker"], "–"), both(row["sensitivity"], row["K"])))
        return found

    def means_beside(self) -> dict[str, str]:
        """δavg / AJ over all scenarios, by tracker, in the order of AJ."""
        rivals = self.rivals()
        by_aj = sorted(rivals, key=lambda name: -statistics.fmean(aj for _, aj in rivals[name]))
        return {
            name: " / ".join(f"{statistics.fmean(found):.3f}" for found in zip(*rivals[name]))
            for name in by_aj
        }

    def trackers_table(self) -> str:
        beside, paper = self.means_beside(), self.of_the_paper()
        rows = []
        for name in [*beside, *(name for name in paper if name not in beside)]:
            of_paper = paper.get(name, [("–", "–")] * 3)
            rows.append([f"`{name}`", beside.get(name, "–"),
                         *(cell for pair in of_paper for cell in pair)])
        classes = [
            f"{title}{of}" for title in ("deformation", "occlusion", "scale, rotation, smoke")
            for of in (": the paper", ", here")
        ]
        return page.table(["tracker", "δavg / AJ", *classes], rows)

    def beside_in_words(self) -> str:
        pairs, = self.beyond.groups(r"^In (\d+ of \d+) pairs of scenario and rival csd is above")
        below = sum("below" in row["csd is"] for rows in self.beside for row in rows)
        return (f"In {pairs} pairs of scenario and rival `csd` is above in δavg, AJ and OA "
                f"(p < {GOALS['p']:g}), or equal; in {below or 'no'} pair{'s' * (below > 1)} is it "
                "below in any of them.")

    def reached(self) -> str:
        """How many goals are reached, in words."""
        textures, palindromes = self.of_clips()
        ece, ece_goal = self.beyond.groups(
            r"^Expected calibration error .*: ([\d.]+); to reach: ECE ≤ ([\d.]+); ")
        claims = [row["here"].strip("*† ") for row in self.paper.rows(["", "the paper finds"])]
        hold = sum(claim.startswith("holds") for claim in claims)
        fail = sum(claim.startswith("does not") for claim in claims)
        commits = [
            f"{results.path.name} {results.commit()}"
            for results in (self.beyond, self.clips_of_beyond, self.tissue, self.paper)
        ]
        return page.bullets((
            f"Reached on simulated tissue: {share_reached(self.scenarios)} scenarios; "
            f"on pictures of real tissue: {share_reached(self.scenes)} scenes; "
            f"on clips as textures: {share_reached(textures)} scenes; "
            f"of clips forward and backward: {share_reached(palindromes)}.",
            self.beside_in_words(),
            f"The expected calibration error of `confidence` is {ece}; {ece_goal} was to be "
            "reached.",
            f"Of {len(claims)} statements that the paper makes of its trackers, {hold} hold here, "
            f"{fail} do not, {len(claims) - hold - fail} are not decided.",
            f"Measured at: {', '.join(commits)}."
        ))

    def by_clip(self) -> dict[str, dict[str, str]]:
        """claimed / apart by clip and tracker; the means come last."""
        found: dict[str, dict[str, str]] = {}
        for row in self.clips.rows(["tracks", "tracker"], "\n## Palindromes\n"):
            cell = f"{row['claimed']} / {row['> 5 px apart']}"
            found.setdefault(row["tracks"].split("/")[0], {})[row["tracker"]] = cell
        return found

    def means_of_clips(self) -> dict[str, str]:
        """claimed / apart over all clips, by tracker."""
        means, = (cells for clip, cells in self.by_clip().items() if clip.startswith("mean"))
        return means

    def clips_table(self) -> str:
        """The table of own-video.md."""
        by_truth = {
            row["tracker"]: both(row["sensitivity"], row["1 − precision"])
            for row in self.clips.rows(["tracker", "sensitivity"])
        }
        rows = [["beads, by their truth: sensitivity / K", *by_truth.values()]]
        rows += [[f"{clip}: claimed / apart", *(cells[tracker] for tracker in by_truth)]
                 for clip, cells in self.by_clip().items()]
        return page.table(["", *(f"`{tracker}`" for tracker in by_truth)], rows)

    def draw(self, path: pathlib.Path) -> None:
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
        for name, style, values in (
            ("to reach", "pt 1 ps 1 lc rgb '#000000'",
             [figure(r"≥ ([\d.]+)", row[REACH]) for row in self.scenes]),
            ("mean", POINTS["csd"], [float(first(row[FOUND])) for row in self.scenes]),
            ("worst tissue", "pt 6 ps 0.9 lc rgb '#762a83'",
             [float(first(row["worst tissue"])) for row in self.scenes])):
            right.add(name, style, list(enumerate(values)))
        figures.draw(path, [left, right], 2, 320)
