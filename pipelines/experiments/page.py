# SPDX-License-Identifier: LGPL-2.1-or-later
"""docs/evaluation.md: a head, and a section for each command that writes one. A command leaves the other's alone."""

import os
import pathlib
import re
import shutil

import builds

COMMANDS = ("beyond", "tissue", "choices", "paper")  # in the order of their sections
HEAD = """# Evaluation

How good the trackers are on simulated tissue ([simulator.md](simulator.md)), with exact truth in each frame. Everything below the marks is
written by the command that the mark names, and nothing by hand. Each section says which commit it was measured at; `tests/bench/since` says what changed
since then in the code that it measures. `csd-2012` is that of the section's commit: at 95ce676 the literal reading of the paper. Real video, with markers as truth and without any, is in [own-video.md](own-video.md).

## What is measured

* **τ** = 5 · max(1, H/576) px, H being the picture's height: 5 px here. What is claimed at most τ from the truth is correct.
* **hidden**: by the truth something covers the point itself (a tool, blood, thick smoke, a highlight, black). Then, and
  where it is outside the picture, every claim is false, and to claim nothing is right.
* **sensitivity**: of the features that are visible in a frame, the share claimed within τ; mean over frames, then over clips.
* **K** = 1 − precision: of the positions claimed in a frame, the share that is false; the same means.
* **δavg**, **AJ**, **OA** are TAP-Vid's, in the picture scaled to 256×256, with the thresholds 1, 2, 4, 8, 16 px. δavg: the share of
  visible samples whose position is within a threshold, claimed or not, mean over the five. AJ: those also claimed, over the visible
  and the false claims together, mean over the five. OA: the share of samples where *claimed* equals *visible*.
* **survival**: the share of samples before a visible feature is first more than 50 px off, in that scale.
* **median**, **95 %**: of the distances of the claims on visible features, in pixels. **drift**: that median in the last fifth of the
  frames less that in the first.
* **returned**: of the times that a feature was hidden or outside and is visible again, how often it is claimed within τ before it is hidden
  again. **median of the return**: the median, over all those times, of the frames until it is claimed so; never is the longest.
* **ECE**, expected calibration error: all reports in ten bins of `confidence`; |mean confidence − share that is visible and within τ|,
  weighed by the bins' counts.

[metrics.md](metrics.md) has each of them exactly, and how they are tested; STIR's measures, which it has too, are not shown here. In brackets
stand 95 % intervals: percentiles of 10000 draws, with replacement, of as many clips (a sequence with a seed is one) as there are, and of as many
features in each as it has; a feature's frames stay together. Of one clip features alone are drawn. p is two-sided, of the difference of two trackers on
the same draws. With few clips both are too sure of themselves (an exact paired test of n clips, each taken whole, can't give less than 2^(1−n)), and nothing is
corrected for the number of comparisons. All trackers see the same bytes (I420, 640×480, 25 frames a second unless said otherwise) and begin
at the same features of the first frame. The seeds are 101 and up: no tracker was tuned on them. The strengths of the tools, the blood and the turn
in black were set with a look at these seeds' pictures and hidden shares, not at scores.

In all sections but [the one on real tissue as texture](#csd-on-real-tissue-as-texture) the tissue is one sheet that moves smoothly, and tools pass over it
without touching it: nothing is torn or grasped, or slides over something else. A tracker that trusts a point's neighbours, as `csd` does, is favoured by that ([method.md](method.md#what-csd-does-badly)).
The rivals are OpenCV's; there is no learnt point tracker among them, as those want a GPU.
"""


def table(header, rows):
    lines = [f"| {' | '.join(header)} |", "|" + "---|" * len(header)]
    return "\n".join(lines + [f"| {' | '.join(row)} |" for row in rows]) + "\n"


def marks(command):
    """The lines around a command's section. `tissue` is beyond --tissue."""
    return f"<!-- written by pipelines/experiments/{command} -->", f"<!-- end of {command} -->"


def between(text, begin, end, path):
    """What stands between two lines. Raises builds.Failure unless each is there once, in this order."""
    lines = text.splitlines()
    at = [i for i, line in enumerate(lines) if line in (begin, end)]
    if [lines[i] for i in at] != [begin, end]:
        raise builds.Failure(f"{path} must have the lines '{begin}' and '{end}', once each, in this order; "
                             "or put it away, and it is written anew")
    return "\n".join(lines[at[0] + 1:at[1]]) + "\n"


def rewrite(path, begin, end, body):
    """Puts `body` between two lines of a page. Raises builds.Failure as between() does."""
    old = path.read_text()
    os.replace(aside(path, old.replace(f"{begin}\n{between(old, begin, end, path)}", f"{begin}\n\n{body}\n")), path)


def aside(path, text):
    """The file beside this one that is to replace it: so it is written whole or not at all."""
    unfinished = path.with_name(f".unfinished-{path.name}")
    unfinished.write_text(text)
    return unfinished


def sections(path):
    """{command: its section, or None where it has written none}. Raises builds.Failure of a page that this one can't have made."""
    if not path.exists():
        return dict.fromkeys(COMMANDS)
    text = path.read_text()
    found = {command: between(text, *marks(command), path) for command in COMMANDS}
    return {command: None if section == empty(command) else section for command, section in found.items()}


def empty(command):
    run = {"tissue": "beyond --tissue DIR", "choices": "choices --tissue DIR"}.get(command, command)
    return f"\nNot run yet: `pipelines/experiments/{run}`.\n\n"


def write(path, command, section, figures):
    """The page with this section and the others as they are; whole or not at all. figures: folder that becomes the section's own; None: it has none."""
    kept = {**sections(path), command: f"\n{section.strip()}\n\n"}
    text = HEAD + "".join("\n{}\n{}{}\n".format(marks(c)[0], kept[c] or empty(c), marks(c)[1]) for c in COMMANDS)
    unfinished = aside(path, linked(text, path.parent))
    shutil.rmtree(figures_of(path, command), ignore_errors=True)
    if figures:
        os.replace(figures, figures_of(path, command))
    os.replace(unfinished, path)


def linked(text, folder):
    """The text with its links to pages of docs/ as they are from this folder."""
    docs = builds.ROOT / "docs"
    return text if folder == docs else re.sub(r"\]\(([\w-]+\.md)", rf"]({os.path.relpath(docs, folder)}/\1", text)


def figures_of(path, command):
    """The folder of the figures in this section of the page."""
    return pathlib.Path(path).with_suffix("") / command


def folder_for_figures(path, command):
    """An empty folder beside the one that it is to replace. How the page links to that: this folder's figures are not there yet."""
    folder = figures_of(path, command)
    drawn = folder.with_name(f".unfinished-{command}")
    shutil.rmtree(drawn, ignore_errors=True)
    drawn.mkdir(parents=True)
    return drawn, f"{folder.parent.name}/{command}"
