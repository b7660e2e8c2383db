"""Groups of kinds that are confused with each other and move alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver_perception.lidar_labels import LABELS


@dataclass(frozen=True)
class MotionGroup:
    """How the members of one group move, and how long they are remembered while they cannot be seen."""

    labels: tuple[str, ...]
    acceleration_mps2: float
    """Standard deviation of the acceleration along the body's axis while moving (m/s²)."""
    across_mps2: float
    """The same across that axis."""
    turn_rps: float
    """Standard deviation of the turn rate while moving (rad/s)."""
    reach_m: float
    """How far a detection may be from the track's predicted position (m), besides twice the uncertainty of that
    position, which adds at most the same again.
    """
    remembered_moving_s: float
    remembered_standing_s: float
    range_m: float
    """Range within which the LiDAR finds such objects reliably (m): 64 channels give few points on small ones."""
    lifeless: bool = False
    """True for things: they stand from the start, and move only if something pushes or blows them."""


GROUPS = (
    MotionGroup(("car", "truck"), 1.5, 0.8, 0.3, 3.0, 4.0, 30.0, 65.0),
    MotionGroup(("two_wheeler", "pedestrian", "animal"), 1.5, 1.5, 1.5, 1.2, 3.0, 10.0, 45.0),
    MotionGroup(("cone", "barrier", "debris"), 0.3, 0.3, 0.2, 0.8, 3.0, 30.0, 35.0, lifeless=True),
)
GROUP_OF_LABEL = np.array([next(i for i, group in enumerate(GROUPS) if name in group.labels) for name in LABELS])
"""(labels,): index into `GROUPS`."""
WHEELED = np.array([name in ("car", "truck", "two_wheeler") for name in LABELS])
"""(labels,): True for what moves along its own axis only."""
