"""Which people are noticed at all: in a box of any class, whether or not they are told apart."""

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
MARGIN_M = 0.4
"""A person this near to a box is in it: about half a person's width."""
LEAST_SCORE = 0.4


@dataclass(frozen=True)
class PedestrianRecall:
    """How many people are within `NEAR_M`, how many of them close ahead (see `lidar/residual.py`), and in a box."""

    people: int = 0
    covered: int = 0
    ahead: int = 0
    ahead_covered: int = 0

    def __add__(self, other: PedestrianRecall) -> PedestrianRecall:
        return PedestrianRecall(
            self.people + other.people,
            self.covered + other.covered,
            self.ahead + other.ahead,
            self.ahead_covered + other.ahead_covered,
        )


def coverage(found: Detections, reals: TruthObjects) -> PedestrianRecall:
    """Count the people of one look that have enough returns, and those in the box of a detection."""
    x, y = reals.center[(reals.label == PEDESTRIAN) & reals.counted, :2].T
    near = np.hypot(x, y) < NEAR_M
    x, y = x[near], y[near]
    sure = found.score >= LEAST_SCORE
    bodies = np.column_stack([found.center[:, :2], found.yaw, found.size[:, :2] / 2.0])[sure]
    covered = within(bodies, x, y, MARGIN_M, MARGIN_M)
    ahead = (x > EGO_HALF_LENGTH_M) & (x < AHEAD_M) & (np.abs(y) < LATERAL_M)
    return PedestrianRecall(len(x), int(covered.sum()), int(ahead.sum()), int((covered & ahead).sum()))
