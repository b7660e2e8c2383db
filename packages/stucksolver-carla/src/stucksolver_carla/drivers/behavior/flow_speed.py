"""By sensors, a stream that is faster than the known limit is joined and driven in at its own pace.

CARLA reports the limit of the last sign passed, and 30 km/h before the first one. If a whole stream drives much faster,
a car that keeps to that limit is hit from behind by traffic that does not brake.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver_carla.drivers.behavior.acceleration_limits import (
    HALTS_MPS2,
    STANDS_MPS,
    AccelerationLimits,
    PaceFactors,
)
from stucksolver_carla.drivers.behavior.junction_yield import FASTER_MPS, FASTEST_MPS
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.profiles import toward_gap
from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.behavior.swept_path import Hazard

HURRIED = PaceFactors(2.0, 1.4)
"""How to drive into a gap of such a stream: up to 4 m/s² ahead, and some 4 m/s² sideways."""
LEAST_GAP_M = 2.5
"""Bumper gap to the leader in a stream, while traffic comes up from behind."""
SLOWER_MPS = 0.4
"""The ego lets the gap grow by driving this much slower than its leader."""
SAME_PACE_MPS = 1.5
"""A leader slower than the stream by more than this is not one of it (m/s)."""
FOLLOWS_S, FOLLOWS_M = 2.0, 4.0
"""A vehicle nearer behind than this follows the ego."""
COMES_S = 4.0
"""A vehicle that will be there within this time counts as well, besides `FOLLOWS_M`."""
IN_LANE_M = 1.3
LOST_S = 1.0
"""Who follows may be lost for so long (s)."""
CLOSES_S = 4.0
"""A leader that seems slower than the stream counts as one of it if it would be reached no sooner than this (s)."""
FOLLOWED_GAP_M = 6.0
"""An ego that is followed in a stream does not fall back as long as the gap ahead is longer than this (m)."""
KEEPS_S = 4.0
"""The pace of a stream is kept for so long after it has been joined: those behind come round the corner (s)."""


class FlowAccelerationLimits(AccelerationLimits):
    """The driver's concerns, with a stream's pace instead of a lower limit, and close behind its leader there."""

    flow_mps = 0.0
    """Pace of the stream that the ego joins or drives in (m/s); 0 without one."""
    _joins = False
    """True if that is faster than the limit, as of the last look at the cruising speed."""

    def cruise(self, path: Path, speed: float, limit_kmh: float, command: str, pace: PaceFactors) -> float:
        """Keep to the path's bounds and to the limit, or to the stream's pace if that is faster."""
        self._joins = self.flow_mps > super().top_speed(limit_kmh)
        command, pace = ("", max(pace, HURRIED)) if self._joins else (command, pace)
        return super().cruise(path, speed, limit_kmh, command, pace)

    def top_speed(self, limit_kmh: float) -> float:
        """See `AccelerationLimits`; the stream's pace if that is faster."""
        return max(super().top_speed(limit_kmh), self.flow_mps)

    def wait(self, distance: float, speed: float) -> float:
        """See `AccelerationLimits`; with less room than wanted, no creeping.

        A start that is given up would otherwise end a meter further on, with the nose in the way of those who come.
        """
        usual = super().wait(distance, speed)
        return min(usual, -HALTS_MPS2) if distance < self._options.stop_line_gap_m and speed > STANDS_MPS else usual

    def own_top_speed(self, limit_kmh: float) -> float:
        """Return the speed (m/s) without any stream."""
        return super().top_speed(limit_kmh)

    def hazard(self, hazard: Hazard, speed: float) -> float:
        """See `AccelerationLimits`; in a stream the gap to a leader that drives away is not opened by falling back."""
        usual = super().hazard(hazard, speed)
        return max(usual, self._close_behind(hazard.gap, hazard.speed, speed))

    def behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """See `AccelerationLimits` and `hazard`."""
        return max(super().behind(gap, lead_speed, speed), self._close_behind(gap, lead_speed, speed))

    def _close_behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """Up to nearly the speed of a leader that drives away in a fast stream; the gap then grows by itself."""
        leaves = lead_speed > speed + SLOWER_MPS and lead_speed + SAME_PACE_MPS > self.flow_mps
        if not (self._joins and leaves) or gap < LEAST_GAP_M:
            return -math.inf
        return toward_gap(speed, gap - LEAST_GAP_M, lead_speed - SLOWER_MPS, self._profile.deceleration, 0.0)


class PacedAccelerationLimits(FlowAccelerationLimits):
    """The concerns of the driver by sensors, which finds the pace by `heed`."""

    _joined_mps, _since_s = 0.0, 0.0
    _behind_mps, _behind_s = 0.0, 0.0
    _followed = False
    """True if a stream faster than the limit follows it."""

    def _close_behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """See `FlowAccelerationLimits`; a leader's speed is off by some m/s now and then, which the others' pace
        corrects.
        """
        believed = max(lead_speed, min(self.flow_mps, lead_speed + gap / CLOSES_S))
        found = super()._close_behind(gap, believed, speed)
        if not (self._followed and self._joins) or gap < FOLLOWED_GAP_M or believed + SAME_PACE_MPS < self.flow_mps:
            return found
        room = gap - FOLLOWED_GAP_M
        return max(found, toward_gap(speed, room, believed, self._profile.deceleration, 0.0))

    def set_flow_speed(self, joined_mps: float, behind_mps: float, limit_kmh: float, dt_s: float) -> None:
        """Take the pace of a stream (m/s) that the ego joins, or of who is behind, if it is clearly above the limit.

        `dt_s` is the time since the last call (s).
        """
        slow = self.own_top_speed(limit_kmh) + FASTER_MPS
        if joined_mps > slow:
            self._joined_mps, self._since_s = joined_mps, 0.0
        self._since_s += dt_s
        joined = self._joined_mps if self._since_s < KEEPS_S else 0.0
        self._behind_s += dt_s
        if behind_mps > slow:
            self._behind_mps, self._behind_s = behind_mps, 0.0
        behind = max(behind_mps, self._behind_mps if self._behind_s < LOST_S else 0.0)
        self._followed = behind > slow
        pace = max(joined, behind)
        self.flow_mps = min(pace, FASTEST_MPS) if pace > slow else 0.0


def rear_flow_speed_mps(bodies: RouteObjects, s_m: float, d_m: float, speed_mps: float, half_length_m: float) -> float:
    """Return the speed of traffic behind an ego in its lane, now or soon (m/s); 0 without any.

    An ego that kept to its own pace until the traffic is close, and fell back to it afterward, would be hit.
    """
    gap = s_m - half_length_m - bodies.s - bodies.along
    near = np.maximum(FOLLOWS_S * bodies.vs, COMES_S * np.maximum(bodies.vs - speed_mps, 0.0)) + FOLLOWS_M
    follows = (np.abs(bodies.d - d_m) < IN_LANE_M) & (gap > -1.0) & (gap < near) & ~bodies.is_walker
    return max(float(bodies.vs[follows].max()), 0.0) if follows.any() else 0.0
