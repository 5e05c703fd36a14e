# SPDX-License-Identifier: LGPL-2.1-or-later
from typing import Any, Literal, Sequence, TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["ALGORITHMS", "STATES", "Tracker"]
__version__: str

ALGORITHMS: tuple[str, ...]
STATES: tuple[str, ...]

class _Stats(TypedDict):
    frames: int
    learning: int
    tracked: int
    occluded: int
    lost: int
    out: int
    ended: int
    detected: int
    learning_time: int
    learned: int
    retrainings: int
    false_correspondences: int
    queue: int
    waited: int
    simd: str

class Tracker:
    def __init__(
        self,
        *,
        algorithm: Literal["csd", "csd-2012", "lk", "ms1", "ms2", "sift", "csd-forest"] = "csd",
        order: Literal["rgb", "bgr"] = "rgb",
        max_features: int = 50,
        points: ArrayLike | None = None,
        replenish: bool = True,
        forget_after: int = 10000000000,
        region: Sequence[int] | None = None,
        content_area: Literal["auto", "full"] = "auto",
        patch_size: int = 0,
        search_radius: int = 0,
        training_time: int = 500000000,
        learning: Literal["async", "sync"] = "async",
        n_threads: int = 0,
        frame_budget: int = 0,
        seed: int = 1,
    ) -> None: ...
    def process(
        self, frame: NDArray[np.uint8], pts: int | None = None, duration: int | None = None, discont: bool = False
    ) -> np.ndarray[Any, np.dtype[np.void]]: ...
    def add_point(self, x: float, y: float) -> int: ...
    def remove_point(self, id: int) -> bool: ...
    def reset(self) -> None: ...
    @property
    def stats(self) -> _Stats: ...
