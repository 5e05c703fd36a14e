# SPDX-License-Identifier: LGPL-2.1-or-later
"""The scores once more, in numpy on whole arrays, for csd_score_test.py to compare csd-score with.

All take arrays of features × frames: `truth` and `tracks` (…×2, pixels), `labelled`, `visible` and `claimed` (bool).
"""

import numpy as np


def distances(truth, tracks, scale):
    return np.sqrt((((tracks - truth) * scale) ** 2).sum(-1))


def after_first_visible(visible):
    """The frames after the one in which a feature is first visible (TAP-Vid's query mode "first")."""
    seen = np.cumsum(visible, axis=1) > 0
    return np.concatenate([np.zeros_like(seen[:, :1]), seen[:, :-1]], axis=1)


def jaccard(distance, visible, claimed, evaluated, thresholds):
    """Shares within, Jaccard indices, and how often claimed equals visible."""
    within, indices = [], []
    for threshold in thresholds:
        near = distance < threshold
        true_positives = np.sum(near & visible & claimed & evaluated)
        false_positives = np.sum(claimed & ~(near & visible) & evaluated)
        false_negatives = np.sum(visible & ~(near & claimed) & evaluated)
        # A claim that is too far off is both: TP + FP + FN counts it twice, as TAP-Vid and STIR do.
        indices.append(true_positives / (true_positives + false_positives + false_negatives))
        within.append(np.mean(near[visible & evaluated]))
    return np.array(within), np.array(indices), np.mean((visible == claimed)[evaluated])


def tap_vid(truth, tracks, labelled, visible, claimed, size):
    distance = distances(truth, tracks, 256 / np.array(size))
    return jaccard(distance, visible, claimed,
                   after_first_visible(visible) & labelled, (1, 2, 4, 8, 16))


def stir_2026(truth, tracks, labelled, visible, claimed):
    evaluated = labelled.copy()
    evaluated[:, 0] = False
    return jaccard(distances(truth, tracks, 1.0), visible, claimed, evaluated, (2, 4, 8, 16, 32))


def paper(truth, tracks, labelled, visible, claimed, tau):
    """Sensitivity and 1 − precision of each frame, nan where there is none."""
    claimed = claimed & labelled
    correct = visible & claimed & (distances(truth, tracks, 1.0) <= tau)
    with np.errstate(invalid="ignore"):
        return correct.sum(0) / visible.sum(0), (claimed & ~correct).sum(0) / claimed.sum(0)


def survival(truth, tracks, labelled, visible, size):
    failed = visible & (distances(truth, tracks, 255 / (np.array(size) - 1)) > 50)
    alive = np.cumprod(~failed, axis=1).astype(bool)
    return np.mean(alive[labelled])
