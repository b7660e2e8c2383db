"""Kinds of things that are confused with each other and move alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.perception.labels import LABELS


@dataclass(frozen=True)
class Group:
    """How the members of one group move, and for how long they are remembered where they cannot be seen."""

    labels: tuple[str, ...]
    acceleration_mps2: float
    """Standard deviation of the acceleration while one moves."""
    turn_rps: float
    """Standard deviation of the turn rate while one moves."""
    reach_m: float
    """How far away a detection may lie from where the track is expected, beside twice that place's uncertainty.
    (Which adds no more than the same again.)"""
    remembered_moving_s: float
    remembered_standing_s: float
    range_m: float
    """How far away the LiDAR finds such things reliably: 64 channels leave few points on what is small."""


GROUPS = (
    Group(("car", "truck"), 2.5, 0.5, 3.0, 4.0, 30.0, 65.0),
    Group(("two_wheeler", "pedestrian", "animal"), 1.5, 1.5, 1.2, 3.0, 10.0, 45.0),
    Group(("cone", "barrier", "debris"), 0.3, 0.2, 0.8, 3.0, 30.0, 35.0),
)
GROUP_OF_LABEL = np.array([next(i for i, group in enumerate(GROUPS) if name in group.labels) for name in LABELS])
"""(labels,): index into `GROUPS`."""
