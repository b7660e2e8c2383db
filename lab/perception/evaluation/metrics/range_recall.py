"""Recall by distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lab.perception.evaluation.metrics.matching import Flags
from stucksolver_perception.measurements import Floats


@dataclass(frozen=True)
class RangeBin:
    """Objects from `nearest_m` up to `farthest_m`."""

    nearest_m: float
    farthest_m: float
    objects: int
    found: int

    @property
    def recall(self) -> float | None:
        """Share of the objects that were found; None without objects."""
        return self.found / self.objects if self.objects else None


def recall_by_range(range_m: Floats, found: Flags, step_m: float, farthest_m: float) -> tuple[RangeBin, ...]:
    """Return the recall by distance.

    Args:
        range_m: Shape (n,): distance of each object (m).
        found: Shape (n,): True for objects that were found.
        step_m: Width of a bin (m).
        farthest_m: End of the last bin (m).
    """
    edges = np.arange(0.0, farthest_m + 1e-9, step_m)
    bins = []
    for nearest, farthest in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        inside = (range_m >= nearest) & (range_m < farthest)
        bins.append(RangeBin(nearest, farthest, int(inside.sum()), int((inside & found).sum())))
    return tuple(bins)
