# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks points on living, deforming tissue in endoscopic video: csdtrack's core on numpy arrays.

    import csdtrack
    tracker = csdtrack.Tracker(algorithm="csd")
    tracks = tracker.process(frame, pts)      # uint8, H×W or H×W×3; a structured array, a row per feature
    tracks["x"][tracks["state"] == "tracked"]

docs/python.md has more.
"""
from ._core import ALGORITHMS, STATES, Tracker

__all__ = ["ALGORITHMS", "STATES", "Tracker"]
