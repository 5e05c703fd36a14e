# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tables and the plot of docs/performance.md, from docs/results/benchmarks.md."""

import pathlib
import re
from collections.abc import Sequence

from pipelines.experiments import figures, page
from pipelines.experiments.results import Results
from pipelines.lib.failure import Failure

# What Highway's targets are commonly called.
SIMD = {"AVX3": "AVX-512", "AVX2": "AVX2", "SSE4": "SSE 4", "SCALAR": "none"}
SIMULATED = ("cavity-mucosa", "grasp-charred")  # among the clips
SIZES = ("640x480", "1920x1080")  # of the plots by the number of features
P50, P95 = ("p50", "dt 1 lw 2 lc rgb '#762a83'"), ("p95", "dt 2 lw 1.5 lc rgb '#762a83'")
# Rivals: what they are called here, and in the benchmark peer_frame.
PEERS = (("PyrLK forward and backward", "lk_fb/100"), ("MedianFlow", "median_flow/10"),
         ("KCF", "kcf/10"), ("CSRT", "csrt/10"))


def times(size: str) -> str:
    """With a multiplication sign."""
    return size.replace("x", "×")


def megapixels(size: str) -> float:
    width, height = map(int, size.split("x"))
    return width * height / 1e6


def panel(title: str, xlabel: str, rows: Sequence[tuple[float, Sequence[str]]],
          settings: str = "") -> figures.Panel:
    """p50 and p95 of the cost of a frame; rows: x, and the two as text."""
    drawn = figures.Panel(title, xlabel, "ms a frame",
                          f"set yrange [0:*]; set xrange [*:*]; {settings}")
    for column, (name, style) in enumerate((P50, P95)):
        drawn.add(name, style, [(x, float(values[column])) for x, values in rows])
    return drawn


class Performance:
    def __init__(self, folder: pathlib.Path = page.RESULTS) -> None:
        self.bench = Results("benchmarks", folder)

    def lines(self, title: str) -> list[list[str]]:
        """The numbers and words of each row of a table, whose title begins so."""
        at = self.bench.text.find(f"\n{title}")
        if at < 0:
            raise Failure(f"{self.bench.path} has nothing that begins with '{title}'")
        rows = []
        for line in self.bench.text[at + 1:].splitlines()[2:]:
            if not line.strip() or line.startswith("```"):
                break
            rows.append(line.replace(" / ", " ").split())
        return rows

    def growth(self, size: str) -> dict[int, list[str]]:
        """p50, p95 and MB by the number of features."""
        return {
            int(features): values
            for at, features, *values in self.lines("csd by the number of features") if at == size
        }

    def cost(self) -> dict[tuple[str, int], list[str]]:
        """p50 / p95 of csd, csd-2012, lk and PyrLK, by size and number of features."""
        found = {}
        for size, kind, features, *values in self.lines("ms a frame on the streaming thread"):
            if kind == "I420":
                pairs = [" / ".join(values[i:i + 2]) for i in range(0, len(values), 2)]
                found[size, int(features)] = pairs
        return found

    def milliseconds(self) -> dict[str, str]:
        """A frame's median cost at 640×480, by tracker: 100 points, but 10 of CSRT."""
        medians = (cell.split(" / ")[0] for cell in self.cost()["640x480", 100])
        csrt = self.microseconds("peer_frame/csrt/10") * 10 / 1000
        return dict(zip(("csd", "csd-2012", "lk"), medians)) | {
            "csrt": f"{csrt:.0f} (10 points)"
        }

    def cost_table(self) -> str:
        found = self.cost()
        rows = []
        for size in dict.fromkeys(size for size, _ in found):
            many = self.growth(size).get(1000)
            few = [found[size, features][0] for features in (50, 100)]
            rows.append([
                times(size), *few, f"{many[0]} / {many[1]}" if many else "–",
                *(found[size, 100][tracker] for tracker in (1, 2, 3))
            ])
        return page.table([
            "picture", "`csd`: 50 features", "100", "1000", "`csd-2012`: 100", "`lk`: 100",
            "OpenCV's PyrLK: 100"
        ], rows)

    def clips_table(self) -> str:
        rows = []
        for line in self.lines("== clips"):
            clip, size, _, features, _, _, p50, p95, most, start, lk, lk95, csrt, csrt95, *_ = line
            rows.append([
                clip, times(size), features, f"{p50} / {p95}", most, start, f"{lk} / {lk95}",
                f"{csrt} / {csrt95}"
            ])
        return page.table([
            "clip", "picture", "features", "`csd`", "most", "first frame", "PyrLK",
            "CSRT, 10 features"
        ], rows)

    def microseconds(self, name: str) -> float:
        """The time of a point in a frame, from the table of `peers`."""
        value, unit = self.bench.groups(rf"^{name} .* ([\d.]+)(us|ms|s)$")
        return float(value) * {"us": 1, "ms": 1e3, "s": 1e6}[unit]

    def recording(self) -> str:
        """Frames a second beside an encoder, in words."""
        recordings = []
        table = r"^record: (.*?) ! .*\n((?:  .*\n)+)"
        for source, rows in re.findall(table, self.bench.text, re.M):
            kept = {
                name: (fps, share) for name, fps, share in re.findall(
                    r"^  (.+?) +([\d.]+) fps +([\d.]+) % kept$", rows, re.M)
            }
            csd, lk = (kept[f"csdtrack algorithm={name}"] for name in ("csd", "lk"))
            picture = source.split()[1].replace("I420", "the texture")
            recordings.append(f"{picture} at {csd[0]} frames a second instead of "
                              f"{kept['without csdtrack'][0]} ({csd[1]} %; `lk` {lk[1]} %)")
        return "; ".join(recordings)

    def rest(self) -> str:
        """Everything that is in no table of the page."""
        machine, = self.bench.groups(r"^\| processor \| (.*) \|$")
        few, many = (self.microseconds(f"csd_frame/{n}") for n in (100, 1000))
        peers = [f"{name} {self.microseconds(f'peer_frame/{bench}'):.0f}" for name, bench in PEERS]
        dropped, frames = self.bench.groups(
            r"^  csdtrack algorithm=csd +(\d+) of (\d+) frames dropped at the source$")
        median, most = self.bench.groups(
            r"^  algorithm=csd max-features=1000 +([\d.]+) / +[\d.]+ / +([\d.]+),")
        memory = self.growth("640x480")
        minutes = self.lines("csd over time")
        kilobytes = 1000 * (float(memory[1000][2]) - float(memory[100][2])) / 900
        return page.bullets((
            f"**Machine**: {machine}; csdtrack {self.bench.commit()}.",
            f"**A feature in a frame** takes {few:.0f} µs with 100 features and {many:.1f} µs with "
            f"1000. Others take, in µs: {', '.join(peers)}.",
            "**Recording** 1280×720 with x264enc on the same processors, as fast as both go, "
            f"50 features: {self.recording()}.",
            f"**Live** at 30 frames a second: {dropped} of {frames} frames dropped.",
            "**Latency**: no frame is held back. Each leaves as soon as it is tracked, after the "
            "times above.",
            f"**Stopping** a pipeline with 1000 features takes {median} ms in the median, {most} "
            "at most.",
            f"**Memory**: {memory[100][2]} MB with 100 features, {memory[1000][2]} with 1000 "
            f"(640×480): {kilobytes:.0f} kB a feature.",
            f"**Over time**: {minutes[0][1]} ms a frame in minute {minutes[0][0]}, "
            f"{minutes[-1][1]} in minute {minutes[-1][0]} (100 features)."
        ))

    def machine(self) -> str:
        """What machines.md says of `csd`."""
        fastest, *_, slowest = clips = self.real_clips()
        first = [float(cells[9]) for cells in clips]
        steps = [f"{float(time):.1f} with {SIMD[name]}" for name, time in re.findall(
            r"^fine_pass/(\w+) .* ([\d.]+)us$", self.bench.text, re.M) if name in SIMD]
        return page.bullets((
            f"**A frame** of a real clip with some 50 points takes, in one thread, {fastest[6]} ms "
            f"in the median ({fastest[0]}, {times(fastest[1])}) to {slowest[6]} ms ({slowest[0]}, "
            f"{times(slowest[1])}); the 95th percentile is {slowest[7]} ms there. The first frame, "
            f"which detects the points, takes {min(first):.0f} to {max(first):.0f} ms "
            "([clips](performance.md#real-clips)).",
            "**On a texture**, points and pixels cost little: "
            f"1000 points {self.growth('1920x1080')[1000][0]} ms "
            f"at 1920×1080; 100 points {self.cost()['3840x2160', 100][0].split(' / ')[0]} ms at "
            "3840×2160 ([texture](performance.md#a-swaying-texture)).",
            f"**Vector instructions**: the fine alignment of a point takes, in µs, "
            f"{', '.join(steps)} ([benchmarks.md](results/benchmarks.md), `align`)."
        ))

    def real_clips(self) -> list[list[str]]:
        """The cells of each, in the order of their medians."""
        return sorted((cells for cells in self.lines("== clips") if cells[0] not in SIMULATED),
                      key=lambda cells: float(cells[6]))

    def clips_in_words(self) -> str:
        fastest, *_, slowest = (f"{float(cells[6]):.0f}" for cells in self.real_clips())
        return f"On real clips `csd` takes {fastest} to {slowest} ms with some 50 points."

    def draw(self, path: pathlib.Path) -> None:
        panels = [
            panel(times(size), "features", list(self.growth(size).items()), "set logscale x")
            for size in SIZES
        ]
        by_size = self.lines("csd by the size of the picture")
        panels.append(panel("100 features", "megapixels",
                            [(megapixels(size), values) for size, *values in by_size]))
        over_time = self.lines("csd over time")
        panels.append(panel("640×480, 100 features", "minutes",
                            [(int(minute), values) for minute, *values in over_time]))
        figures.draw(path, panels, 2)
