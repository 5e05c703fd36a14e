# SPDX-License-Identifier: LGPL-2.1-or-later
"""What README and pages of docs/ repeat of docs/results/, and where."""

import pathlib
from collections.abc import Callable, Mapping

from pipelines.experiments import builds, page, readme_summary
from pipelines.experiments.evaluation_summary import Evaluation
from pipelines.experiments.performance_summary import Performance

Blocks = Mapping[str, str]  # text between marks, by the name of the marks
Plots = Mapping[str, Callable[[pathlib.Path], None]]  # what draws each file


def pages(folder: pathlib.Path = page.RESULTS) -> list[tuple[str, Blocks, Plots]]:
    """The blocks and plots of each page."""
    evaluation, performance = Evaluation(folder), Performance(folder)
    return [
        ("README.md", {"trackers": readme_summary.trackers(evaluation, performance)}, {}),
        ("docs/evaluation.md", {
            "scenes": evaluation.scenes_table(), "trackers": evaluation.trackers_table(),
            "reached": evaluation.reached()
        }, {"docs/evaluation/scenes.svg": evaluation.draw}),
        ("docs/performance.md", {
            "cost": performance.cost_table(), "clips": performance.clips_table(),
            "rest": performance.rest()
        }, {"docs/performance/growth.svg": performance.draw}),
        ("docs/machines.md", {
            "machine": performance.machine(), "video": evaluation.worst_in_words()
        }, {}),
        ("docs/own-video.md", {"clips": evaluation.clips_table()}, {}),
    ]


def marks(block: str) -> tuple[str, str]:
    return f"<!-- {block}: written by pipelines/experiments/summary -->", f"<!-- end of {block} -->"


def filled(text: str, blocks: Blocks, path: pathlib.Path | str) -> str:
    for block, body in blocks.items():
        text = page.filled(text, *marks(block), body, path)
    return text


def write(root: pathlib.Path = builds.ROOT) -> list[pathlib.Path]:
    """Writes the summaries from docs/results/, all of them or none. Returns the paths."""
    made = pages(root / "docs" / "results")
    texts = {
        root / name: filled((root / name).read_text(), blocks, root / name)
        for name, blocks, _ in made
    }
    plots = {root / plot: draw for *_, drawn in made for plot, draw in drawn.items()}
    for plot, draw in plots.items():
        plot.parent.mkdir(exist_ok=True)
        draw(plot)
    for path, text in texts.items():
        page.replace(path, text)
    return [*texts, *plots]
