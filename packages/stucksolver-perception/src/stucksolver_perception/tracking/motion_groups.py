"""Defines groups of labels that the detector confuses with each other and that move alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver_perception.lidar_labels import LABELS


@dataclass(frozen=True)
class MotionGroup:
    """Motion of the objects of one group, and time for which hidden ones are tracked. All values are ours."""

    labels: tuple[str, ...]
    """Names of the labels."""
    acceleration_mps2: float
    """Standard deviation of a moving object's acceleration along its axis (m/s²)."""
    across_mps2: float
    """Standard deviation of this acceleration across the axis (m/s²)."""
    turn_rps: float
    """Standard deviation of a moving object's turn rate (rad/s)."""
    reach_m: float
    """Maximum distance of a detection from the track's predicted position (m). Twice the standard deviation of that
    position is added, up to the same distance."""
    memory_moving_s: float
    """Maximum time without a detection of a moving object (s)."""
    memory_stationary_s: float
    """Maximum time without a detection of a stationary object (s)."""
    range_m: float
    """Range within which the LiDAR detects such objects reliably (m): 64 channels give few points on small ones."""
    is_static: bool = False
    """True for objects that are stationary from the start, and move only if they are pushed or blown away."""


GROUPS = (
    MotionGroup(("car", "truck"), 1.5, 0.8, 0.3, 3.0, 4.0, 30.0, 65.0),
    MotionGroup(("two_wheeler", "pedestrian", "animal"), 1.5, 1.5, 1.5, 1.2, 3.0, 10.0, 45.0),
    MotionGroup(("cone", "barrier", "debris"), 0.3, 0.3, 0.2, 0.8, 3.0, 30.0, 35.0, is_static=True),
)
GROUP_OF_LABEL = np.array([next(i for i, group in enumerate(GROUPS) if name in group.labels) for name in LABELS])
"""(labels,): index into `GROUPS`."""
WHEELED = np.array([name in ("car", "truck", "two_wheeler") for name in LABELS])
"""(labels,): True for vehicles, which move only along their axis."""
