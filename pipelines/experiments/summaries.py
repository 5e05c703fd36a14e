# SPDX-License-Identifier: LGPL-2.1-or-later
"""What docs/evaluation.md, performance.md and own-video.md repeat of docs/results/, and where."""

import pathlib
from collections.abc import Callable, Mapping

from pipelines.experiments import builds, page
from pipelines.experiments.evaluation_summary import Evaluation
from pipelines.experiments.performance_summary import Performance

DOCS = builds.ROOT / "docs"

Blocks = Mapping[str, str]  # text between marks, by the name of the marks
Plots = Mapping[str, Callable[[pathlib.Path], None]]  # what draws each file


def pages(folder: pathlib.Path = page.RESULTS) -> list[tuple[str, Blocks, Plots]]:
    """The blocks and plots of each page of docs/."""
    evaluation, performance = Evaluation(folder), Performance(folder)
    return [
        ("evaluation.md", {
            "scenes": evaluation.scenes_table(), "trackers": evaluation.trackers_table(),
            "reached": evaluation.reached()
        }, {"evaluation/scenes.svg": evaluation.draw}),
        ("performance.md", {
            "cost": performance.cost_table(), "clips": performance.clips_table(),
            "rest": performance.rest()
        }, {"performance/growth.svg": performance.draw}),
        ("own-video.md", {"clips": evaluation.clips_table()}, {}),
    ]


def marks(block: str) -> tuple[str, str]:
    return f"<!-- {block}: written by pipelines/experiments/summary -->", f"<!-- end of {block} -->"


def filled(text: str, blocks: Blocks, path: pathlib.Path | str) -> str:
    for block, body in blocks.items():
        text = page.filled(text, *marks(block), body, path)
    return text


def write(docs: pathlib.Path = DOCS) -> list[pathlib.Path]:
    """Writes the summaries in docs/ from its results, all of them or none. Returns the paths."""
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
        page.replace(path, text)
    return [*texts, *plots]
