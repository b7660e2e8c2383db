"""Plans the lane changes of the route: in an accepted gap, postponed without one, early if the lane is busy.

Arc lengths along the route's line are in meters; `e` is an offset from the old lane (m), right positive.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from stucksolver_carla.drivers.behavior.junction_yield import FLOW_EXCESS_MPS
from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.behavior.route_line import MIN_LANE_STEP_M, change_length, rejoining_length, smooth_step
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.driver_interface import RoutePoint

if TYPE_CHECKING:
    import carla

EARLY_M = 80.0
"""Maximum distance by which a change into a busy lane starts earlier than on the route (m). Ours."""
MIN_LENGTH_M = 12.0
"""Minimum length of a lane change (m). Ours."""
NEAR_M = 60.0
"""Maximum distance of vehicles that determine the adjacent lane's speed (m). Ours."""
FALL_BACK_MPS = 2.0
"""Speed below the adjacent lane's at which the ego waits for a gap (m/s). Ours."""
STEP_S = 0.2
"""Step of the rollout (s). Ours."""
HORIZON_S = 6.0
"""Horizon of the rollout (s). Ours."""
GAP_M = 1.5
"""Required gap before and behind vehicles in the lane: the constant part (m). Ours."""
GAP_S = 0.15
"""Required gap before and behind vehicles in the lane: the part that grows with their speed (s). Ours."""
SIDE_CLEARANCE_M = 0.3
"""Clearance at the ego's sides (m). Ours."""
ACCELERATION_MPS2 = 2.5
"""Acceleration of the rollout (m/s²). Ours."""
DECELERATION_MPS2 = 1.5
"""Deceleration of the rollout (m/s²). Ours."""
DRIFT_MPS = 0.5
"""Maximum error of the vehicles' speeds (m/s): their positions drift with it for `DRIFT_S`. Sensor mode only."""
DRIFT_S = 2.0
"""Time for which such a position error grows (s). Ours."""
_IN_LANE_M = 1.3
"""Maximum lateral offset of a vehicle in a lane (m). Ours."""
_LEADER_M = 15.0
"""Distance to a lead vehicle in the old lane that limits the ego (m). Ours."""
_FOLLOW_S = 1.5
"""Time for which the lead vehicle in the old lane limits the ego (s). Ours."""
_PREVIEW_S = 1.5
"""Time before the start of a change from which the ego waits for a gap (s). Ours."""
_POSTPONE_M = 25.0
"""Distance by which a change is postponed (m). Ours."""
_MOVING_MPS = 0.5
"""Speed above which a vehicle determines the lane's speed (m/s). Ours."""
_SAME_START_M = 1.0
"""Difference to the route's start of a change that needs no shift of the line (m). Ours."""


class RouteSituation(Protocol):
    """The ego in the route's frame, and the objects around it."""

    @property
    def s_m(self) -> float:
        """The ego's arc length on the route's line (m)."""

    @property
    def d_m(self) -> float:
        """The ego's offset from that line (m, right positive)."""

    @property
    def speed_mps(self) -> float:
        """The ego's speed (m/s)."""

    @property
    def cruise_mps(self) -> float:
        """The ego's speed without traffic (m/s)."""

    @property
    def bodies(self) -> RouteObjects:
        """The objects around the ego."""

    @property
    def model(self) -> VehicleModel:
        """The ego's box."""


@dataclass(frozen=True)
class LaneChange:
    """One lane change of a route."""

    begins_m: float
    length_m: float
    lateral_m: float
    """Distance from lane to lane (m), right positive."""
    first_m: float
    """Arc length from which the new lane is next to the old one (m)."""
    last_m: float
    """Arc length up to which the new lane is next to the old one (m)."""

    def line_at(self, s: Array) -> Array:
        """Return the offsets of the route's line from the old lane (m)."""
        return np.asarray(self.lateral_m * smooth_step((s - self.begins_m) / self.length_m))


def lane_changes(route: Sequence[RoutePoint], line: Path) -> list[LaneChange]:
    """Return the lane changes of a route, in driving order."""
    changes = []
    for k in range(1, len(route)):
        is_right = route[k].command == "change_right"
        if not is_right and route[k].command != "change_left":
            continue
        transform_before, transform_after = route[k - 1].waypoint.transform, route[k].waypoint.transform
        heading = np.radians(transform_after.rotation.yaw)
        dx, dy = (
            transform_after.location.x - transform_before.location.x,
            transform_after.location.y - transform_before.location.y,
        )
        lateral = float(dy * np.cos(heading) - dx * np.sin(heading))
        if abs(lateral) <= MIN_LANE_STEP_M:
            continue
        first_index, last_index = k - 1, k
        while first_index > 0 and _has_lane(route[first_index - 1].waypoint, is_right):
            first_index -= 1
        while last_index + 1 < len(route) and _has_lane(route[last_index + 1].waypoint, not is_right):
            last_index += 1
        begins_m = _arc_length_of(line, route, k - 1)
        changes.append(
            LaneChange(
                begins_m,
                change_length(route, k),
                lateral,
                begins_m - (k - 1 - first_index),
                begins_m + max(last_index - k + 1.0, 1.0),
            )
        )
    return changes


def _has_lane(waypoint: carla.Waypoint, is_right: bool) -> bool:
    """Return True if there is a lane of the same direction on that side."""
    if waypoint.is_junction:
        return False
    lane = waypoint.get_right_lane() if is_right else waypoint.get_left_lane()
    return lane is not None and str(lane.lane_type).endswith("Driving") and lane.lane_id * waypoint.lane_id > 0


def _arc_length_of(line: Path, route: Sequence[RoutePoint], index: int) -> float:
    location, guess = route[index].waypoint.transform.location, index / max(len(route) - 1, 1) * line.length
    distance_m = np.hypot(line.x - location.x, line.y - location.y) + 0.05 * np.abs(line.s - guess)
    return float(line.s[int(np.argmin(distance_m))])


def _separated(changes: Sequence[LaneChange]) -> list[LaneChange]:
    """Return the changes, each limited to the part of the route whose line is in its old or new lane.

    `LaneChange.line_at` contains one change only. Without the limit, a change that starts early would check the wrong
    lane, before the line has changed into its old lane.
    """
    separated = []
    for k, change in enumerate(changes):
        first_m, last_m = change.first_m, change.last_m
        if k > 0:
            first_m = max(first_m, changes[k - 1].begins_m + changes[k - 1].length_m)
        if k + 1 < len(changes):
            last_m = min(last_m, changes[k + 1].begins_m)
        separated.append(replace(change, first_m=min(first_m, change.begins_m), last_m=last_m))
    return separated


class LaneChangePlanner:
    """Decides, for one route, when each lane change starts."""

    def __init__(self, changes: Sequence[LaneChange], doubt_m: float = 0.0) -> None:
        """Create the planner.

        `doubt_m` is the maximum error of the objects' positions (m); 0 for ground truth. In sensor mode, the speeds of
        other vehicles are not exact, so the ego adopts another lane's speed only if it is clearly faster.
        """
        self._doubt_m = doubt_m
        self._due = _separated(changes) if doubt_m > 0.0 else list(changes)
        self._starts: dict[LaneChange, tuple[float, float]] = {}
        """Start and length of each change that does not start as on the route (m)."""
        self._has_started = False
        self.wait_m: float | None = None
        """Distance from the front bumper to the last place to wait for a gap (m); None if the ego need not wait."""
        self.pace_mps = 0.0
        """Speed of the lane that the ego enters (m/s); 0 without one."""
        self.max_mps = math.inf
        """Speed cap while the ego waits for a gap (m/s). At the lane's own speed, a gap would never come."""
        self.checked_ids: frozenset[int] = frozenset()
        """Ids of the vehicles in the new lane for which the current change was checked."""

    def shifts(self) -> list[LateralShift]:
        """Return the shifts of the ego's line from the route's line."""
        shifts = []
        for change, (start, length) in self._starts.items():
            route_range = (change.begins_m, change.begins_m + change.length_m)
            if start < change.begins_m:
                shifts.append(LateralShift(change.lateral_m, start, start + length, *route_range))
            else:
                shifts.append(LateralShift(-change.lateral_m, *route_range, start, start + length))
        return shifts

    def update(self, situation: RouteSituation) -> None:
        """Update the decisions for one tick."""
        self.wait_m, self.pace_mps, self.max_mps, self.checked_ids = None, 0.0, math.inf, frozenset()
        while self._due and situation.s_m > self._end_m(self._due[0]):
            self._due.pop(0)
            self._has_started = False
        if not self._due:
            return
        change = self._due[0]
        lane = _TargetLane(situation, change, self._doubt_m)
        if situation.s_m < max(change.first_m, change.begins_m - EARLY_M) or lane.is_empty:
            return
        if self._has_started:
            self.pace_mps, self.checked_ids = lane.pace_mps, lane.ids
            return
        start, length = self._starts.get(change, (change.begins_m, change.length_m))
        last_start = change.last_m - MIN_LENGTH_M - situation.model.half_length
        remaining_m = max(last_start - situation.s_m, 0.0)
        gentle_m = min(rejoining_length(change.lateral_m, situation.speed_mps), max(remaining_m, MIN_LENGTH_M))
        if lane.is_clear(gentle_m):
            self._has_started = True
            if abs(situation.s_m - start) >= _SAME_START_M:
                self._starts[change] = (situation.s_m, gentle_m)
            return
        if situation.s_m > start - _PREVIEW_S * situation.speed_mps or start != change.begins_m:
            self.wait_m = remaining_m
            self.max_mps = max(lane.pace_mps - FALL_BACK_MPS, FALL_BACK_MPS)
        if start < last_start and situation.s_m > start - _PREVIEW_S * situation.speed_mps - 2.0:
            self._starts[change] = (min(max(start, situation.s_m) + _POSTPONE_M, last_start), max(length, MIN_LENGTH_M))

    def _end_m(self, change: LaneChange) -> float:
        start, length = self._starts.get(change, (change.begins_m, change.length_m))
        return start + length


class _TargetLane:
    """The lane that the ego will enter, and the vehicles in it."""

    def __init__(self, situation: RouteSituation, change: LaneChange, doubt_m: float) -> None:
        self._situation, self._change, self._doubt_m = situation, change, doubt_m
        bodies = situation.bodies
        self._e = bodies.d + change.line_at(bodies.s)
        is_near = np.abs(bodies.s - situation.s_m) < NEAR_M
        is_inside = is_near & (np.abs(self._e - change.lateral_m) < _IN_LANE_M + bodies.aside - 0.9)
        self._vehicles, self._vehicles_e = bodies.part(is_inside), self._e[is_inside]

    @property
    def ids(self) -> frozenset[int]:
        """Ids of the vehicles in the lane."""
        return frozenset(self._vehicles.actor_id.tolist())

    @property
    def is_empty(self) -> bool:
        return len(self._vehicles) == 0

    @property
    def pace_mps(self) -> float:
        """Median speed of the moving vehicles in the lane (m/s); 0 without any."""
        is_moving = self._vehicles.vs > _MOVING_MPS
        return float(np.median(self._vehicles.vs[is_moving])) if is_moving.any() else 0.0

    def is_clear(self, length_m: float) -> bool:
        """Return True if a lane change over the next `length_m` keeps the required gap to all vehicles."""
        cruise = self._situation.cruise_mps
        if self._doubt_m > 0.0:
            return self._keeps_gaps(length_m, self.pace_mps if self.pace_mps > cruise + FLOW_EXCESS_MPS else cruise)
        top = max(cruise, self.pace_mps)
        return any(self._keeps_gaps(length_m, pace) for pace in (top, self.pace_mps or top))

    def _keeps_gaps(self, length_m: float, pace: float) -> bool:
        situation, vehicles, model = self._situation, self._vehicles, self._situation.model
        t = np.asarray(STEP_S * np.arange(round(HORIZON_S / STEP_S) + 1), dtype=np.float64)
        s = situation.s_m + self._rollout(t, pace)
        ego_e = situation.d_m + float(self._change.line_at(np.array([situation.s_m]))[0])
        e = ego_e + (self._change.lateral_m - ego_e) * smooth_step((s - situation.s_m) / length_m)
        is_alongside = np.abs(e[:, None] - self._vehicles_e) < model.half_width + vehicles.aside + SIDE_CLEARANCE_M
        gap_m = model.half_length + vehicles.along + GAP_M + GAP_S * np.abs(vehicles.vs)
        travel_m = vehicles.vs * t[:, None]
        if self._doubt_m > 0.0:
            gap_m = gap_m + self._doubt_m + DRIFT_MPS * np.minimum(t, DRIFT_S)[:, None]
        is_near = np.abs(vehicles.s + travel_m - s[:, None]) < gap_m
        return not bool((is_alongside & is_near).any())

    def _rollout(self, t: Array, pace: float) -> Array:
        """Return the travel (m): toward the lane's speed, limited by a lead vehicle in the old lane at first."""
        situation, bodies = self._situation, self._situation.bodies
        v = situation.speed_mps + np.clip(pace - situation.speed_mps, -DECELERATION_MPS2 * t, ACCELERATION_MPS2 * t)
        is_leading = (
            (np.abs(self._e) < _IN_LANE_M) & (bodies.s > situation.s_m) & (bodies.s < situation.s_m + _LEADER_M)
        )
        if is_leading.any():
            slowest = max(float(bodies.vs[is_leading].min()), 0.0)
            time_s = np.maximum(t - _FOLLOW_S, 0.0)
            start_mps = min(situation.speed_mps, slowest) if slowest < situation.speed_mps else slowest
            v = np.minimum(v, start_mps + ACCELERATION_MPS2 * time_s)
        return np.asarray(np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1]) / 2.0 * STEP_S)]))
