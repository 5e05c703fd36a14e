# SPDX-License-Identifier: LGPL-2.1-or-later
"""README's table of trackers."""

from pipelines.experiments import page
from pipelines.experiments.evaluation_summary import Evaluation
from pipelines.experiments.performance_summary import Performance

TRACKERS = {
    "csd": "`csd`, the default",
    "csd-2012": "`csd-2012`, the paper's",
    "lk": "`lk`, Lucas–Kanade",
    "csrt": "`csrt`, OpenCV's",
}


def trackers(evaluation: Evaluation, performance: Performance) -> str:
    """The table, how csd stands beside its rivals, and what it reaches."""
    clips = {"csrt": "–"} | evaluation.means_of_clips()
    simulated, milliseconds = evaluation.means_beside(), performance.milliseconds()
    rows = [[words, clips[name], simulated[name], milliseconds[name]]
            for name, words in TRACKERS.items()]
    table = page.table(["tracker", "real clips: claimed / apart", "simulated tissue: δavg / AJ",
                        "ms a frame"], rows)
    return "\n".join((table, page.wrapped(evaluation.beside_in_words()),
                      page.wrapped(f"{performance.clips_in_words()} {evaluation.real_in_words()}"),
                      page.wrapped(evaluation.goals_in_words())))
