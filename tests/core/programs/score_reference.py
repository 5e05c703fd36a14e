# SPDX-License-Identifier: LGPL-2.1-or-later
"""A second implementation of the scores, in numpy on whole arrays.

csd_score_test.py compares csd-score with it. All functions take arrays of features × frames:
`truth` and `tracks` (…×2, pixels), `labelled`, `visible` and `claimed` (bool).
"""

import typing
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[typing.Any]
# Shares within each threshold, Jaccard indices, and how often `claimed` equals `visible`.
Scores = tuple[Array, Array, float]


def distances(truth: Array, tracks: Array, scale: Array | float) -> Array:
    return typing.cast(Array, np.sqrt((((tracks - truth) * scale) ** 2).sum(-1)))


def after_first_visible(visible: Array) -> Array:
    """The frames after the one in which a feature is first visible (TAP-Vid's query mode
    "first")."""
    seen = np.cumsum(visible, axis=1) > 0
    return np.concatenate([np.zeros_like(seen[:, :1]), seen[:, :-1]], axis=1)


def jaccard(distance: Array, visible: Array, claimed: Array, evaluated: Array,
            thresholds: Sequence[float]) -> Scores:
    within, indices = [], []
    for threshold in thresholds:
        near = distance < threshold
        true_positives = np.sum(near & visible & claimed & evaluated)
        false_positives = np.sum(claimed & ~(near & visible) & evaluated)
        false_negatives = np.sum(visible & ~(near & claimed) & evaluated)
        # A claim that is too far off is both: TP + FP + FN counts it twice, as TAP-Vid and STIR do.
        indices.append(true_positives / (true_positives + false_positives + false_negatives))
        within.append(np.mean(near[visible & evaluated]))
    return np.array(within), np.array(indices), float(np.mean((visible == claimed)[evaluated]))


def tap_vid(truth: Array, tracks: Array, labelled: Array, visible: Array, claimed: Array,
            size: tuple[int, int]) -> Scores:
    distance = distances(truth, tracks, 256 / np.array(size))
    return jaccard(distance, visible, claimed,
                   after_first_visible(visible) & labelled, (1, 2, 4, 8, 16))


def stir_2026(truth: Array, tracks: Array, labelled: Array, visible: Array,
              claimed: Array) -> Scores:
    evaluated = labelled.copy()
    evaluated[:, 0] = False
    return jaccard(distances(truth, tracks, 1.0), visible, claimed, evaluated, (2, 4, 8, 16, 32))


def paper(truth: Array, tracks: Array, labelled: Array, visible: Array, claimed: Array,
          tau: float) -> tuple[Array, Array]:
    """Sensitivity and 1 − precision of each frame, nan where there is none."""
    claimed = claimed & labelled
    correct = visible & claimed & (distances(truth, tracks, 1.0) <= tau)
    with np.errstate(invalid="ignore"):
        return correct.sum(0) / visible.sum(0), (claimed & ~correct).sum(0) / claimed.sum(0)


def survival(truth: Array, tracks: Array, labelled: Array, visible: Array,
             size: tuple[int, int]) -> float:
    failed = visible & (distances(truth, tracks, 255 / (np.array(size) - 1)) > 50)
    alive = np.cumprod(~failed, axis=1).astype(bool)
    return float(np.mean(alive[labelled]))
