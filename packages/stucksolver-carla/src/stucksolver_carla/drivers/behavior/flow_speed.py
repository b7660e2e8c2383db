"""Adapts the driver's speed to a traffic flow that is faster than the reported speed limit.

CARLA reports the limit of the last sign passed, and 30 km/h before the first one. If a whole flow drives much faster, a
car at that limit is hit from behind by traffic that does not brake.
"""

from __future__ import annotations

import math

import numpy as np

from stucksolver_carla.drivers.behavior.acceleration_limits import (
    AT_REST_MPS,
    HALT_MPS2,
    AccelerationLimits,
    PaceFactors,
)
from stucksolver_carla.drivers.behavior.junction_yield import FASTEST_MPS, FLOW_EXCESS_MPS
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.profiles import toward_gap
from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.behavior.swept_path import Hazard

FLOW_MERGE = PaceFactors(2.0, 1.4)
"""Pace of a merge into a faster flow: accelerations up to 4 m/s² ahead, and about 4 m/s² sideways. Ours."""
MIN_GAP_M = 2.5
"""Minimum bumper gap to the lead vehicle in a flow with rear traffic (m). Ours."""
SLOWER_MPS = 0.4
"""Speed below that of the lead vehicle at which the gap grows (m/s). Ours."""
SAME_PACE_MPS = 1.5
"""Maximum speed below the flow's for a lead vehicle that belongs to the flow (m/s). Ours."""
FOLLOWS_S, FOLLOWS_M = 2.0, 4.0
"""Maximum gap to a follower: a part that grows with its speed (s) and a constant part (m). Ours."""
ARRIVES_S = 4.0
"""Time within which a faster vehicle from behind counts as a follower (s), in addition to `FOLLOWS_M`. Ours."""
IN_LANE_M = 1.3
"""Maximum lateral offset of a vehicle in the ego's lane (m). Ours."""
TRACK_LOSS_S = 1.0
"""Time for which a follower counts after its track is lost (s). Ours."""
CLOSING_S = 4.0
"""Minimum time to reach a lead vehicle that seems slower than the flow but belongs to it (s). Ours."""
FOLLOWED_GAP_M = 6.0
"""Gap ahead above which an ego with a follower does not fall back (m). Ours."""
FLOW_MEMORY_S = 4.0
"""Time for which the flow's speed is used after the merge (s), until the followers come around the corner. Ours."""


class FlowAccelerationLimits(AccelerationLimits):
    """The accelerations with the speed of a faster flow instead of the speed limit, and with short gaps in the flow."""

    flow_mps = 0.0
    """Speed of the flow that the ego joins or drives in (m/s); 0 without one."""
    _joins_flow = False
    """True if that was above the speed limit at the last call of `cruise`."""

    def cruise(self, path: Path, speed: float, limit_kmh: float, command: str, pace: PaceFactors) -> float:
        """Return the acceleration for the path's bounds and the speed limit, or the flow's speed if that is higher."""
        self._joins_flow = self.flow_mps > super().top_speed(limit_kmh)
        command, pace = ("", max(pace, FLOW_MERGE)) if self._joins_flow else (command, pace)
        return super().cruise(path, speed, limit_kmh, command, pace)

    def top_speed(self, limit_kmh: float) -> float:
        """Return the profile's speed at the speed limit, or the flow's speed if that is higher (m/s)."""
        return max(super().top_speed(limit_kmh), self.flow_mps)

    def wait(self, distance: float, speed: float) -> float:
        """Return the acceleration for a stop before a conflict path, without creeping at the end.

        Otherwise an aborted start would end a meter farther ahead, with the front in the path of the traffic.
        """
        acceleration = super().wait(distance, speed)
        return (
            min(acceleration, -HALT_MPS2)
            if distance < self._options.stop_line_gap_m and speed > AT_REST_MPS
            else acceleration
        )

    def own_top_speed(self, limit_kmh: float) -> float:
        """Return the profile's speed at the speed limit, without a flow (m/s)."""
        return super().top_speed(limit_kmh)

    def hazard(self, hazard: Hazard, speed: float) -> float:
        """Return the acceleration behind a hazard. In a flow, the ego does not fall back behind a faster one."""
        acceleration = super().hazard(hazard, speed)
        return max(acceleration, self._close_behind(hazard.gap, hazard.speed, speed))

    def behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """Return the acceleration behind a joining lead vehicle, as in `hazard`."""
        return max(super().behind(gap, lead_speed, speed), self._close_behind(gap, lead_speed, speed))

    def _close_behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """Return the acceleration close behind a faster lead vehicle in a fast flow; -inf in other cases.

        The speed stays a little below the lead vehicle's, so the gap grows.
        """
        is_leaving = lead_speed > speed + SLOWER_MPS and lead_speed + SAME_PACE_MPS > self.flow_mps
        if not (self._joins_flow and is_leaving) or gap < MIN_GAP_M:
            return -math.inf
        return toward_gap(speed, gap - MIN_GAP_M, lead_speed - SLOWER_MPS, self._profile.deceleration, 0.0)


class PacedAccelerationLimits(FlowAccelerationLimits):
    """The accelerations in sensor mode, with a flow speed that is set with `set_flow_speed`."""

    _joined_mps, _joined_age_s = 0.0, 0.0
    _rear_mps, _rear_age_s = 0.0, 0.0
    _is_followed = False
    """True if a flow faster than the speed limit follows the ego."""

    def _close_behind(self, gap: float, lead_speed: float, speed: float) -> float:
        """Return the acceleration close behind a lead vehicle in a flow.

        The measured speed of a lead vehicle is sometimes wrong by some m/s. The speed of the flow corrects it.
        """
        lead_mps = max(lead_speed, min(self.flow_mps, lead_speed + gap / CLOSING_S))
        acceleration = super()._close_behind(gap, lead_mps, speed)
        if (
            not (self._is_followed and self._joins_flow)
            or gap < FOLLOWED_GAP_M
            or lead_mps + SAME_PACE_MPS < self.flow_mps
        ):
            return acceleration
        free_gap = gap - FOLLOWED_GAP_M
        return max(acceleration, toward_gap(speed, free_gap, lead_mps, self._profile.deceleration, 0.0))

    def set_flow_speed(self, joined_mps: float, rear_mps: float, limit_kmh: float, dt_s: float) -> None:
        """Set the flow speed if the joined flow or the rear traffic is clearly faster than the speed limit.

        Args:
            joined_mps: Speed of the flow that the ego joins (m/s).
            rear_mps: Speed of the rear traffic (m/s).
            limit_kmh: Speed limit (km/h).
            dt_s: Time since the last call (s).
        """
        threshold_mps = self.own_top_speed(limit_kmh) + FLOW_EXCESS_MPS
        if joined_mps > threshold_mps:
            self._joined_mps, self._joined_age_s = joined_mps, 0.0
        self._joined_age_s += dt_s
        joined_now_mps = self._joined_mps if self._joined_age_s < FLOW_MEMORY_S else 0.0
        self._rear_age_s += dt_s
        if rear_mps > threshold_mps:
            self._rear_mps, self._rear_age_s = rear_mps, 0.0
        behind = max(rear_mps, self._rear_mps if self._rear_age_s < TRACK_LOSS_S else 0.0)
        self._is_followed = behind > threshold_mps
        pace = max(joined_now_mps, behind)
        self.flow_mps = min(pace, FASTEST_MPS) if pace > threshold_mps else 0.0


def rear_flow_speed_mps(bodies: RouteObjects, s_m: float, d_m: float, speed_mps: float, half_length_m: float) -> float:
    """Return the speed of the rear traffic in the ego's lane, now or soon (m/s); 0 without any.

    An ego that drove at its own speed until the traffic is close, and returned to that speed later, would be hit.
    """
    gap = s_m - half_length_m - bodies.s - bodies.along
    near_m = np.maximum(FOLLOWS_S * bodies.vs, ARRIVES_S * np.maximum(bodies.vs - speed_mps, 0.0)) + FOLLOWS_M
    is_follower = (np.abs(bodies.d - d_m) < IN_LANE_M) & (gap > -1.0) & (gap < near_m) & ~bodies.is_walker
    return max(float(bodies.vs[is_follower].max()), 0.0) if is_follower.any() else 0.0
