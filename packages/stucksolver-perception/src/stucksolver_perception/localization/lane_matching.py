"""The lane of the vehicle, given its estimated pose."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stucksolver_perception.measurements import Floats, PoseEstimate

KEPT_TO_LANE = 0.5
"""Standard deviation of vehicles' offset from the center of their lane, as a share of its half width."""
HEADING_RAD = 0.25
"""Standard deviation of their heading relative to the lane: curves, evasions, crooked stops."""
BEYOND_END_M = 3.0
"""A lane still counts this far beyond its ends."""
ELSEWHERE_SIGMAS = 3.0
"""Being in no lane is as likely as being this many standard deviations off the center of one."""


class LaneMatch(NamedTuple):
    """One lane in which the vehicle may be."""

    line: int
    """Index of the given line."""
    probability: float
    lateral_m: float
    """Offset of the vehicle from the line (m), positive to its left."""


def match(pose: PoseEstimate, lines: Sequence[Floats], half_width_m: float) -> list[LaneMatch]:
    """Return the probability of each lane: Gaussian over the lateral offset and the heading, with the pose's
    covariance.

    Args:
        pose: Local frame.
        lines: Center lines (k, 3): x, y (m), and the heading of the lane's traffic (rad).
        half_width_m: Half of a lane's width (m).

    Returns:
        Most probable first; lanes that end before the vehicle are left out. The probabilities add up to less than 1:
        the rest is the probability of being in none of them.
    """
    found = []
    for index, line in enumerate(lines):
        nearest = _nearest(line, pose.x_m, pose.y_m)
        if nearest is None:
            continue
        lateral, heading = nearest
        side = np.array([-math.sin(heading), math.cos(heading)])
        variance = float(side @ pose.covariance[:2, :2] @ side) + (KEPT_TO_LANE * half_width_m) ** 2
        turned = math.remainder(pose.yaw_rad - heading, math.tau)
        turn_variance = float(pose.covariance[2, 2]) + HEADING_RAD**2
        found.append((index, lateral, math.exp(-0.5 * (lateral**2 / variance + turned**2 / turn_variance))))
    total = sum(weight for _, _, weight in found) + math.exp(-0.5 * ELSEWHERE_SIGMAS**2)
    matches = [LaneMatch(index, weight / total, lateral) for index, lateral, weight in found]
    return sorted(matches, key=lambda item: -item.probability)


def _nearest(line: Floats, x: float, y: float) -> tuple[float, float] | None:
    """Return the lateral offset from a line and its heading at the nearest point; None if the line ends before."""
    if len(line) < 2:
        return None
    start, step = line[:-1, :2], np.diff(line[:, :2], axis=0)
    length = np.maximum(1e-9, np.hypot(step[:, 0], step[:, 1]))
    off = np.array([x, y]) - start
    along = (off * step).sum(1) / length
    share = np.clip(along / length, 0.0, 1.0)
    away = off - share[:, None] * step
    best = int(np.hypot(away[:, 0], away[:, 1]).argmin())
    beyond = max(-along[best] if best == 0 else 0.0, along[best] - length[best] if best == len(step) - 1 else 0.0)
    if beyond > BEYOND_END_M:
        return None
    change = math.remainder(float(line[best + 1, 2] - line[best, 2]), math.tau)
    heading = float(line[best, 2]) + float(share[best]) * change
    # Measured across the piece itself, not to its end: the offset is the same a meter beyond the lane's end. The sign
    # is that of the traffic's direction, which need not be the order of the points.
    across = float(step[best, 0] * off[best, 1] - step[best, 1] * off[best, 0]) / float(length[best])
    forth = math.cos(heading) * step[best, 0] + math.sin(heading) * step[best, 1] >= 0.0
    return (across if forth else -across), heading
