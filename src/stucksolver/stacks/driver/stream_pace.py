"""By sensors, a stream that is faster than the known limit is joined and driven in at its own pace.

CARLA reports the limit of the last sign passed, and 30 km/h before the first one. If a whole stream drives much faster,
a car that keeps to that limit is hit from behind by traffic that does not brake.
"""

from __future__ import annotations

import numpy as np

from stucksolver.stacks.driver.concerns import HALTS_MPS2, STANDS_MPS, Concerns, Pace
from stucksolver.stacks.driver.give_way import FASTER_MPS, FASTEST_MPS
from stucksolver.stacks.driver.path import Path
from stucksolver.stacks.driver.route_bodies import RouteBodies

HURRIED = Pace(2.0, 1.4)
"""How to drive into a gap of such a stream: up to 4 m/s² ahead, and some 4 m/s² sideways."""
FOLLOWS_S, FOLLOWS_M = 2.0, 4.0
"""A vehicle nearer behind than this follows the ego."""
COMES_S = 4.0
"""A vehicle that will be there within this time counts as well, besides `FOLLOWS_M`."""
IN_LANE_M = 1.3
KEEPS_S = 4.0
"""The pace of a stream is kept for so long after it has been joined: those behind come round the corner (s)."""


class FlowConcerns(Concerns):
    """The driver's concerns, with a stream's pace instead of a lower limit."""

    flow_mps = 0.0
    """Pace of the stream that the ego joins or drives in (m/s); 0 without one."""
    _joins = False
    """True if that is faster than the limit, as of the last look at the cruising speed."""

    def cruise(self, path: Path, speed: float, limit_kmh: float, command: str, pace: Pace) -> float:
        """Keep to the path's bounds and to the limit, or to the stream's pace if that is faster."""
        self._joins = self.flow_mps > super().top_speed(limit_kmh)
        command, pace = ("", max(pace, HURRIED)) if self._joins else (command, pace)
        return super().cruise(path, speed, limit_kmh, command, pace)

    def top_speed(self, limit_kmh: float) -> float:
        """See `Concerns`; the stream's pace if that is faster."""
        return max(super().top_speed(limit_kmh), self.flow_mps)

    def wait(self, distance: float, speed: float) -> float:
        """See `Concerns`; with less room than wanted, no creeping.

        A start that is given up would otherwise end a metre further on, with the nose in the way of those who come.
        """
        usual = super().wait(distance, speed)
        return min(usual, -HALTS_MPS2) if distance < self._options.stop_line_gap_m and speed > STANDS_MPS else usual

    def own_top_speed(self, limit_kmh: float) -> float:
        """Return the speed (m/s) without any stream."""
        return super().top_speed(limit_kmh)


class PacedConcerns(FlowConcerns):
    """The concerns of the driver by sensors, which finds the pace by `heed`."""

    _joined_mps, _since_s = 0.0, 0.0

    def heed(self, joined_mps: float, behind_mps: float, limit_kmh: float, dt_s: float) -> None:
        """Take the pace of a stream (m/s) that the ego joins, or of who is behind, if it is clearly above the limit.

        `dt_s` is the time since the last call (s).
        """
        slow = self.own_top_speed(limit_kmh) + FASTER_MPS
        if joined_mps > slow:
            self._joined_mps, self._since_s = joined_mps, 0.0
        self._since_s += dt_s
        joined = self._joined_mps if self._since_s < KEEPS_S else 0.0
        pace = max(joined, behind_mps)
        self.flow_mps = min(pace, FASTEST_MPS) if pace > slow else 0.0


def pace_behind_mps(bodies: RouteBodies, s_m: float, d_m: float, speed_mps: float, half_length_m: float) -> float:
    """Return the speed of traffic behind an ego in its lane, now or soon (m/s); 0 without any.

    An ego that kept to its own pace until the traffic is close, and fell back to it afterwards, would be hit.
    """
    gap = s_m - half_length_m - bodies.s - bodies.along
    near = np.maximum(FOLLOWS_S * bodies.vs, COMES_S * np.maximum(bodies.vs - speed_mps, 0.0)) + FOLLOWS_M
    follows = (np.abs(bodies.d - d_m) < IN_LANE_M) & (gap > -1.0) & (gap < near) & ~bodies.is_walker
    return max(float(bodies.vs[follows].max()), 0.0) if follows.any() else 0.0
