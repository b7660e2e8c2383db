"""Matches the vehicle's estimated pose to lanes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from stucksolver_perception.measurements import Floats, PoseEstimate

LATERAL_SHARE = 0.5
"""Standard deviation of a vehicle's offset from the center of its lane, as a share of the lane's half width. Ours."""
HEADING_RAD = 0.25
"""Standard deviation of a vehicle's heading relative to its lane (rad): curves, evasions, stops at an angle. Ours."""
BEYOND_END_M = 3.0
"""Distance beyond its ends up to which a lane counts (m). Ours."""
OFF_LANE_SDS = 3.0
"""Offset from a lane's center, in standard deviations, that is as probable as a position in no lane. Ours."""


class LaneMatch(NamedTuple):
    """A lane in which the vehicle may be."""

    line: int
    """Index of the center line."""
    probability: float
    """Probability that the vehicle is in this lane."""
    lateral_m: float
    """Offset of the vehicle from the line (m), positive to its left."""


def match(pose: PoseEstimate, lines: Sequence[Floats], half_width_m: float) -> list[LaneMatch]:
    """Return the probability of each lane, from lateral offset, heading and the pose's covariance (Gaussian).

    Args:
        pose: Pose in the local frame.
        lines: Center lines (k, 3): x, y (m), and the heading of the lane's traffic (rad).
        half_width_m: Half width of the lanes (m).

    Returns:
        The lanes, the most probable one first, without those that end before the vehicle. The sum of the probabilities
        is less than 1; the rest is the probability of being in no lane.
    """
    candidates = []
    for index, line in enumerate(lines):
        nearest = _nearest(line, pose.x_m, pose.y_m)
        if nearest is None:
            continue
        lateral, heading = nearest
        side = np.array([-math.sin(heading), math.cos(heading)])
        variance = float(side @ pose.covariance[:2, :2] @ side) + (LATERAL_SHARE * half_width_m) ** 2
        heading_error = math.remainder(pose.yaw_rad - heading, math.tau)
        heading_variance = float(pose.covariance[2, 2]) + HEADING_RAD**2
        candidates.append(
            (index, lateral, math.exp(-0.5 * (lateral**2 / variance + heading_error**2 / heading_variance)))
        )
    total = sum(weight for _, _, weight in candidates) + math.exp(-0.5 * OFF_LANE_SDS**2)
    matches = [LaneMatch(index, weight / total, lateral) for index, lateral, weight in candidates]
    return sorted(matches, key=lambda item: -item.probability)


def _nearest(line: Floats, x: float, y: float) -> tuple[float, float] | None:
    """Return the lateral offset from a line (m) and the line's heading at the nearest point (rad); None beyond its
    ends.
    """
    if len(line) < 2:
        return None
    start, step = line[:-1, :2], np.diff(line[:, :2], axis=0)
    length = np.maximum(1e-9, np.hypot(step[:, 0], step[:, 1]))
    offset = np.array([x, y]) - start
    along = (offset * step).sum(1) / length
    share = np.clip(along / length, 0.0, 1.0)
    distance = offset - share[:, None] * step
    nearest = int(np.hypot(distance[:, 0], distance[:, 1]).argmin())
    beyond = max(
        -along[nearest] if nearest == 0 else 0.0, along[nearest] - length[nearest] if nearest == len(step) - 1 else 0.0
    )
    if beyond > BEYOND_END_M:
        return None
    change = math.remainder(float(line[nearest + 1, 2] - line[nearest, 2]), math.tau)
    heading = float(line[nearest, 2]) + float(share[nearest]) * change
    # The offset is measured across the segment, not to its end, so that it is the same a meter beyond the lane's end.
    # Its sign follows the direction of traffic, which may be opposite to the order of the points.
    across = float(step[nearest, 0] * offset[nearest, 1] - step[nearest, 1] * offset[nearest, 0]) / float(
        length[nearest]
    )
    same_direction = math.cos(heading) * step[nearest, 0] + math.sin(heading) * step[nearest, 1] >= 0.0
    return (across if same_direction else -across), heading
