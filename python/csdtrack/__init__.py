# SPDX-License-Identifier: LGPL-2.1-or-later
"""Tracks points on living, deforming tissue in endoscopic video: csdtrack's core on numpy arrays.

    import csdtrack
    tracker = csdtrack.Tracker(algorithm="csd")
    tracks = tracker.process(frame, pts)  # frame: uint8, H×W or H×W×3; tracks: a row per feature
    tracks["x"][tracks["state"] == "tracked"]

docs/python.md has more.
"""
from . import _core
from ._core import ALGORITHMS, STATES, __version__  # noqa: F401

__all__ = ["ALGORITHMS", "STATES", "Tracker"]


# The methods are in Python for their signatures, and for Python's messages about wrong arguments.
class Tracker(_core.Tracker):
    """Tracks points on deforming tissue through the frames of one stream.

    All arguments are keywords. Those that the GStreamer element csdtrack has too, with "-" for "_",
    have the same meanings, ranges and defaults: docs/elements.md. Times are whole nanoseconds. Any
    thread may use a Tracker; only process() must not run twice at a time. Its own threads don't
    survive os.fork(): in the child each call raises RuntimeError. Make another Tracker there.
    """

    __slots__ = ()

    def __init__(self, *, algorithm="csd", order="rgb", max_features=50, points=None,
                 replenish=True, forget_after=10000000000, region=None, content_area="auto",
                 patch_size=0, search_radius=0, training_time=500000000, learning="async",
                 n_threads=0, frame_budget=0, seed=1):
        """
        algorithm      one of csdtrack.ALGORITHMS
        order          "rgb", or "bgr" as OpenCV has it: of the last axis of colour frames
        max_features   0…10000: how many features detection keeps; 0: only points that are given
        points         N×2, x and y in pixels: track exactly these, ids 0…N-1, no detection
        replenish      new features where old ones ended (csd only)
        forget_after   ns: a detected feature that is lost or out for so long ends; 0: never
        region         (x, y, width, height) in whole pixels: where detection may look;
                       None: everywhere
        content_area   "auto": the dark border and burnt-in graphics are ignored;
                       "full": all is tissue
        patch_size     0…1024 px: side of a feature's patch; 0: from the frame's height
        search_radius  0…2048 px; 0: from the frame's height (csd-2012 and csd-forest only)
        training_time  ns: how long a feature is "learning"
        learning       "async": frames don't wait for learning; "sync": they do, and results are the
                       same on each run (only csd-2012 and csd-forest learn beside the frames)
        n_threads      0…256 threads that learn and, with csd, follow points; 0: one fewer than
                       there are processors, at least 1
        frame_budget   ns: past it the least urgent features of a frame wait; 0: none (csd only)
        seed           of every random choice

        Raises TypeError and ValueError, whose messages say what to write instead.
        """
        super().__init__(algorithm, order, max_features, points, replenish, forget_after, region,
                         content_area, patch_size, search_radius, training_time, learning,
                         n_threads, frame_budget, seed)

    def process(self, frame, pts=None, duration=None, discont=False):
        """
        Tracks all features into the next frame. Returns a structured array with a row for each, by
        ascending id.

        frame     uint8, H×W (gray) or H×W×3 (colour), any strides; read in place, not changed and
                  not kept
        pts       when it was taken, ns; None: one duration after the last one
        duration  ns; None: unknown, then 40 ms (25 frames a second)
        discont   the frame does not follow the last one. A pts more than half a second off has the
                  same effect. Where pts shows a smaller gap, frames count as dropped.

        Fields: id (uint32), x, y (float64, pixels, centres at integers, 0,0 the top left one;
        always finite), state (str, one of csdtrack.STATES), confidence (float64, 0…1), fresh
        (bool). Only "learning" and "tracked" claim a position; in these states, and only in these,
        confidence >= 0.5. After a frame of another size tracking starts again, with new ids.

        Other Python threads run meanwhile. Raises TypeError and ValueError for a frame that can't
        be read, RuntimeError while another thread's process() runs or if tracking fails. Warns once
        if a frame is too small to track in.
        """
        return super().process(frame, pts, duration, discont)

    def add_point(self, x, y):
        """
        Also tracks the point at x, y, in pixels of the next frame, and returns its id. Any thread
        may call this; it never waits for a frame.

        Raises TypeError if x or y is no number, ValueError if one is not finite, RuntimeError if
        10000 features are tracked already.
        """
        return super().add_point(x, y)

    def remove_point(self, id):
        """
        Ends a feature, given or detected, with the next frame. Returns False if none has this id.
        Any thread may call this.
        """
        return super().remove_point(id)

    def reset(self):
        """
        Forgets the stream: with the next frame all features end, and points or detection begin
        again, with new ids. Any thread may call this.
        """
        super().reset()

    @property
    def stats(self):
        """dict: frames; features of the last frame by state; detected, learning_time (ns), learned,
        retrainings, false_correspondences, queue, waited, simd: as in the element's stats."""
        return super().stats

    def __repr__(self):
        stats = self.stats
        states = "".join(f", {stats[state]} {state}" for state in STATES if stats[state])
        return f"<csdtrack.Tracker {self._algorithm}: {stats['frames']} frames{states}>"
