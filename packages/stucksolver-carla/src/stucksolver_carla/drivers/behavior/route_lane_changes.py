"""Lane changes of the route: begun in a gap, postponed without one, early if the lane is busy.

Arc lengths along the route's line in meters; `e` is an offset from the lane that is left, right positive.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from stucksolver_carla.drivers.behavior.junction_yield import FASTER_MPS
from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift
from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.behavior.route_line import LEAST_STEP_M, change_length, rejoining_length, smooth_step
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.driver_interface import RoutePoint

if TYPE_CHECKING:
    import carla

EARLY_M = 80.0
"""A change into a busy lane may begin this much earlier than the route says."""
TIGHT_M = 12.0
"""The shortest way from lane to lane."""
NEAR_M = 60.0
"""Vehicles farther away in the lane beside say nothing about its pace."""
SLIPS_BACK_MPS = 2.0
"""While looking for a gap the ego drives this much slower than the lane beside."""
STEP_S = 0.2
HORIZON_S = 6.0
KEEP_M = 1.5
"""Distance kept before and behind the others in the lane, besides `KEEP_S` (m)."""
KEEP_S = 0.15
"""The same in seconds of their drive."""
BESIDE_M = 0.3
FASTER_MPS2 = 2.5
SLOWER_MPS2 = 1.5
DRIFTS_MPS = 0.5
"""By sensors, the speeds of others are off by up to this (m/s): their places drift by as much for `DRIFTS_S`."""
DRIFTS_S = 2.0
_IN_LANE_M = 1.3
_LEADER_M = 15.0
_HELD_S = 1.5
_LOOKS_S = 1.5
_PUT_OFF_M = 25.0
_MOVES_MPS = 0.5
_SAME_M = 1.0


class RouteSituation(Protocol):
    """The ego in the route's frame, and who is around."""

    @property
    def s_m(self) -> float:
        """Its arc length on the route's line (m)."""

    @property
    def d_m(self) -> float:
        """Its offset from that line (m, right positive)."""

    @property
    def speed_mps(self) -> float:
        """Its speed (m/s)."""

    @property
    def cruise_mps(self) -> float:
        """Its speed if nothing held it back (m/s)."""

    @property
    def bodies(self) -> RouteObjects:
        """The bodies around."""

    @property
    def model(self) -> VehicleModel:
        """Its body."""


@dataclass(frozen=True)
class LaneChange:
    """One change of lane that a route asks for."""

    begins_m: float
    length_m: float
    lateral_m: float
    """From lane to lane, right positive."""
    first_m: float
    """From here on the new lane runs beside the old one."""
    last_m: float
    """Up to here it does."""

    def line_at(self, s: Array) -> Array:
        """Offsets of the route's line from the old lane."""
        return np.asarray(self.lateral_m * smooth_step((s - self.begins_m) / self.length_m))


def lane_changes(route: Sequence[RoutePoint], line: Path) -> list[LaneChange]:
    """The changes of a route, in driving order."""
    found = []
    for k in range(1, len(route)):
        right = route[k].command == "change_right"
        if not right and route[k].command != "change_left":
            continue
        before, after = route[k - 1].waypoint.transform, route[k].waypoint.transform
        heading = np.radians(after.rotation.yaw)
        dx, dy = after.location.x - before.location.x, after.location.y - before.location.y
        lateral = float(dy * np.cos(heading) - dx * np.sin(heading))
        if abs(lateral) <= LEAST_STEP_M:
            continue
        first, last = k - 1, k
        while first > 0 and _beside(route[first - 1].waypoint, right):
            first -= 1
        while last + 1 < len(route) and _beside(route[last + 1].waypoint, not right):
            last += 1
        begins = _place(line, route, k - 1)
        found.append(
            LaneChange(
                begins, change_length(route, k), lateral, begins - (k - 1 - first), begins + max(last - k + 1.0, 1.0)
            )
        )
    return found


def _beside(waypoint: carla.Waypoint, right: bool) -> bool:
    """True if there is a lane of the same direction on that side."""
    if waypoint.is_junction:
        return False
    lane = waypoint.get_right_lane() if right else waypoint.get_left_lane()
    return lane is not None and str(lane.lane_type).endswith("Driving") and lane.lane_id * waypoint.lane_id > 0


def _place(line: Path, route: Sequence[RoutePoint], index: int) -> float:
    place, guess = route[index].waypoint.transform.location, index / max(len(route) - 1, 1) * line.length
    away = np.hypot(line.x - place.x, line.y - place.y) + 0.05 * np.abs(line.s - guess)
    return float(line.s[int(np.argmin(away))])


def _one_after_another(changes: Sequence[LaneChange]) -> list[LaneChange]:
    """Return them, each only where the route's line is in the lane that it leaves or enters: `LaneChange.line_at` knows
    of one change only. Otherwise one that begins early would look at the wrong lane, before the line has changed to
    the lane that it leaves.
    """
    found = []
    for k, change in enumerate(changes):
        first, last = change.first_m, change.last_m
        if k > 0:
            first = max(first, changes[k - 1].begins_m + changes[k - 1].length_m)
        if k + 1 < len(changes):
            last = min(last, changes[k + 1].begins_m)
        found.append(replace(change, first_m=min(first, change.begins_m), last_m=last))
    return found


class LaneChangePlanner:
    """Decides, for one route, when each change begins."""

    def __init__(self, changes: Sequence[LaneChange], doubt_m: float = 0.0) -> None:
        """`doubt_m`: how far bodies may be from where sensors see them (m). By sensors, the speeds of others are not
        exact, and the ego takes the pace of another lane only if that is clearly faster.
        """
        self._doubt_m = doubt_m
        self._due = _one_after_another(changes) if doubt_m > 0.0 else list(changes)
        self._starts: dict[LaneChange, tuple[float, float]] = {}
        """Start and length of a change that does not begin as the route says."""
        self._going = False
        self.wait_m: float | None = None
        """Distance from the front bumper to where the ego waits for a gap at the latest (m)."""
        self.pace_mps = 0.0
        """Pace of the lane that is being entered (m/s); 0 if none is."""
        self.most_mps = math.inf
        """Speed cap while it looks for a gap: abreast of others at their pace there would never be one."""
        self.judged: frozenset[int] = frozenset()
        """Ids of those in that lane against whom the current change was proven."""

    def shifts(self) -> list[LateralShift]:
        """Distance of the ego's line from the route's."""
        found = []
        for change, (start, length) in self._starts.items():
            own = (change.begins_m, change.begins_m + change.length_m)
            if start < change.begins_m:
                found.append(LateralShift(change.lateral_m, start, start + length, *own))
            else:
                found.append(LateralShift(-change.lateral_m, *own, start, start + length))
        return found

    def look(self, here: RouteSituation) -> None:
        """Take a tick into account."""
        self.wait_m, self.pace_mps, self.most_mps, self.judged = None, 0.0, math.inf, frozenset()
        while self._due and here.s_m > self._ends(self._due[0]):
            self._due.pop(0)
            self._going = False
        if not self._due:
            return
        change = self._due[0]
        lane = _Lane(here, change, self._doubt_m)
        if here.s_m < max(change.first_m, change.begins_m - EARLY_M) or lane.is_empty:
            return
        if self._going:
            self.pace_mps, self.judged = lane.pace_mps, lane.ids
            return
        start, length = self._starts.get(change, (change.begins_m, change.length_m))
        last = change.last_m - TIGHT_M - here.model.half_length
        left = max(last - here.s_m, 0.0)
        gentle = min(rejoining_length(change.lateral_m, here.speed_mps), max(left, TIGHT_M))
        if lane.is_clear(gentle):
            self._going = True
            if abs(here.s_m - start) >= _SAME_M:
                self._starts[change] = (here.s_m, gentle)
            return
        if here.s_m > start - _LOOKS_S * here.speed_mps or start != change.begins_m:
            self.wait_m = left
            self.most_mps = max(lane.pace_mps - SLIPS_BACK_MPS, SLIPS_BACK_MPS)
        if start < last and here.s_m > start - _LOOKS_S * here.speed_mps - 2.0:
            self._starts[change] = (min(max(start, here.s_m) + _PUT_OFF_M, last), max(length, TIGHT_M))

    def _ends(self, change: LaneChange) -> float:
        start, length = self._starts.get(change, (change.begins_m, change.length_m))
        return start + length


class _Lane:
    """The lane that will be entered, and the vehicles in it."""

    def __init__(self, here: RouteSituation, change: LaneChange, doubt_m: float) -> None:
        self._here, self._change, self._doubt_m = here, change, doubt_m
        bodies = here.bodies
        self._e = bodies.d + change.line_at(bodies.s)
        near = np.abs(bodies.s - here.s_m) < NEAR_M
        inside = near & (np.abs(self._e - change.lateral_m) < _IN_LANE_M + bodies.aside - 0.9)
        self._others, self._others_e = bodies.part(inside), self._e[inside]

    @property
    def ids(self) -> frozenset[int]:
        """Ids of the vehicles in it."""
        return frozenset(self._others.actor_id.tolist())

    @property
    def is_empty(self) -> bool:
        return len(self._others) == 0

    @property
    def pace_mps(self) -> float:
        """The pace at which they drive (m/s)."""
        moves = self._others.vs > _MOVES_MPS
        return float(np.median(self._others.vs[moves])) if moves.any() else 0.0

    def is_clear(self, length_m: float) -> bool:
        """True if the ego, changing over within `length_m` from now on, comes too near to nobody."""
        cruise = self._here.cruise_mps
        if self._doubt_m > 0.0:
            return self._meets_nobody(length_m, self.pace_mps if self.pace_mps > cruise + FASTER_MPS else cruise)
        top = max(cruise, self.pace_mps)
        return any(self._meets_nobody(length_m, pace) for pace in (top, self.pace_mps or top))

    def _meets_nobody(self, length_m: float, pace: float) -> bool:
        here, others, model = self._here, self._others, self._here.model
        t = np.asarray(STEP_S * np.arange(round(HORIZON_S / STEP_S) + 1), dtype=np.float64)
        s = here.s_m + self._driven(t, pace)
        own_e = here.d_m + float(self._change.line_at(np.array([here.s_m]))[0])
        e = own_e + (self._change.lateral_m - own_e) * smooth_step((s - here.s_m) / length_m)
        abreast = np.abs(e[:, None] - self._others_e) < model.half_width + others.aside + BESIDE_M
        keep = model.half_length + others.along + KEEP_M + KEEP_S * np.abs(others.vs)
        gone = others.vs * t[:, None]
        if self._doubt_m > 0.0:
            keep = keep + self._doubt_m + DRIFTS_MPS * np.minimum(t, DRIFTS_S)[:, None]
        near = np.abs(others.s + gone - s[:, None]) < keep
        return not bool((abreast & near).any())

    def _driven(self, t: Array, pace: float) -> Array:
        """Return the meters driven: toward the pace, at first held back by a leader in the old lane."""
        here, bodies = self._here, self._here.bodies
        v = here.speed_mps + np.clip(pace - here.speed_mps, -SLOWER_MPS2 * t, FASTER_MPS2 * t)
        leads = (np.abs(self._e) < _IN_LANE_M) & (bodies.s > here.s_m) & (bodies.s < here.s_m + _LEADER_M)
        if leads.any():
            slowest = max(float(bodies.vs[leads].min()), 0.0)
            late = np.maximum(t - _HELD_S, 0.0)
            held = min(here.speed_mps, slowest) if slowest < here.speed_mps else slowest
            v = np.minimum(v, held + FASTER_MPS2 * late)
        return np.asarray(np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1]) / 2.0 * STEP_S)]))
