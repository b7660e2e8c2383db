"""Recall of pedestrians in a box of any class, whether or not they are separated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lab.perception.evaluation.metrics.matching import TruthObjects
from stucksolver_perception.free_space import EGO_HALF_LENGTH_M, within
from stucksolver_perception.lidar.refinement.unexplained_returns import AHEAD_M, LATERAL_M
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections

PEDESTRIAN = LABELS.index("pedestrian")
NEAR_M = 20.0
"""Distance within which pedestrians count (m)."""
MARGIN_M = 0.4
"""Distance to a box within which a pedestrian is in it (m): about half a person's width."""
LEAST_SCORE = 0.4
"""Least score of a box that counts."""


@dataclass(frozen=True)
class PedestrianRecall:
    """Numbers of pedestrians within `NEAR_M`, of those close ahead (see `lidar/residual.py`), and of those in a box."""

    people: int = 0
    """Pedestrians within `NEAR_M`."""
    covered: int = 0
    """Those of them in a box."""
    ahead: int = 0
    """Pedestrians close ahead."""
    ahead_covered: int = 0
    """Those of them in a box."""

    def __add__(self, other: PedestrianRecall) -> PedestrianRecall:
        return PedestrianRecall(
            self.people + other.people,
            self.covered + other.covered,
            self.ahead + other.ahead,
            self.ahead_covered + other.ahead_covered,
        )


def coverage(found: Detections, reals: TruthObjects) -> PedestrianRecall:
    """Count the pedestrians of one frame that have enough returns, and those in the box of a detection."""
    x, y = reals.center[(reals.label == PEDESTRIAN) & reals.counted, :2].T
    near = np.hypot(x, y) < NEAR_M
    x, y = x[near], y[near]
    sure = found.score >= LEAST_SCORE
    bodies = np.column_stack([found.center[:, :2], found.yaw, found.size[:, :2] / 2.0])[sure]
    covered = within(bodies, x, y, MARGIN_M, MARGIN_M)
    ahead = (x > EGO_HALF_LENGTH_M) & (x < AHEAD_M) & (np.abs(y) < LATERAL_M)
    return PedestrianRecall(len(x), int(covered.sum()), int(ahead.sum()), int((covered & ahead).sum()))
