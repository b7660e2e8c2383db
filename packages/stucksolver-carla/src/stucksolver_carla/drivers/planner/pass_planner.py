"""Plans passes of a blocker: candidates are rolled out against predictions of all objects, and the best one wins.

The scheme is that of PDM (Dauner et al., "Parting with Misconceptions about Learning-based Vehicle Motion Planning",
CoRL 2023): proposals of lateral offset and speed, simulated and scored. In this module the frame is the route's, so a
prediction is a straight line in it, and the candidates follow from the blocker.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.route_bodies import Flags, RouteObjects
from stucksolver_carla.drivers.behavior.route_line import offset_path, rejoining_length, smooth_step, speed_limited_path
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner.adjacent_lane_widths import AdjacentLaneWidths, LaneWidths

STEP_S = 0.2
"""Step of the rollout (s). Ours."""
HORIZON_S = 24.0
"""Horizon of the rollout (s). Ours."""
ACCELERATION_MPS2 = 1.8
"""Acceleration of the rollout (m/s²). Ours."""
PASSING_MPS = 11.0
"""Maximum speed of a pass (m/s). Ours."""
VULNERABLE_CLEARANCE_M = 0.9
"""Clearance to pedestrians and two-wheelers (m). Ours."""
CLEARANCE_M = 0.5
"""Clearance to all other objects (m). Ours."""
DOOR_CLEARANCE_M = 1.1
"""Clearance to parked vehicles on a wide road (m): an opening door and about 0.1 m. Ours."""
GAP_BEFORE_M = 1.5
"""Distance between the bumpers when the ego leaves the lane (m). Ours."""
GAP_AFTER_M = 4.0
"""Distance between the bumpers when the ego re-enters the lane (m). Ours."""
GROUP_GAP_M = 11.0
"""Gap below which two successive objects are passed together (m). Ours."""
LONGEST_RETURN_M = 14.0
"""Maximum length of the return to the line (m). Ours."""
EDGE_M = 0.1
"""Clearance to the edge of the outermost lane (m). Ours."""
SIDE_MARGIN_M = 0.3
"""Clearance at the ego's sides in predictions (m). Ours."""
ONCOMING_M = 6.0
"""Required gap to oncoming traffic: the constant part (m). Ours."""
ONCOMING_S = 0.8
"""Required gap to oncoming traffic: the part that grows with its speed (s). Ours."""
FOLLOWING_M = 2.0
"""Required gap to traffic in the ego's direction: the constant part (m). Ours."""
FOLLOWING_S = 0.5
"""Required gap to traffic in the ego's direction: the part that grows with its speed (s). Ours."""
LENGTH_SHARES = (1.0, 0.8, 0.65)
"""Shares of the gentle length over which the ego leaves its lane, the gentlest first. Ours."""
_ONCOMING_MPS = -1.0
"""Speed along the route below which an object is oncoming (m/s). Ours."""
_STOPPED_MPS = 0.3
"""Speed below which an object counts as stopped (m/s). Ours."""
_STOPPED_GAP_M = 0.5
"""Required gap to stopped objects (m). Ours."""
TWO_WHEELER_M = 0.55
"""Maximum half width of a two-wheeler (m). Ours."""
_ONCOMING_COST_S = 4.0
"""Cost of a pass in the oncoming lane (s). Ours."""
_PER_METER_COST_S = 0.3
"""Cost per meter of offset (s). Ours."""
_DOORS_COST_S = 1.0
"""Cost of a pass within reach of doors (s). Ours."""


@dataclass(frozen=True)
class PassCandidate:
    """A path next to the route's line and back: offset (right positive) and arc lengths of the ego's center (m)."""

    offset_m: float
    begins_m: float
    """Arc length at which the ego leaves the line (m)."""
    beside_m: float
    """Arc length at which the offset is reached (m)."""
    returns_m: float
    """Arc length at which the return starts (m)."""
    back_m: float
    """Arc length at which the ego is on the line again (m)."""
    speed_mps: float
    """Speed cap on the path (m/s)."""
    oncoming: bool
    """True if the path uses an oncoming lane."""
    around: frozenset[int]
    """Ids of the objects that are passed."""
    ends_m: float
    """Arc length of their far end (m)."""
    by_doors: bool = False
    """True if an opening door would reach into the path."""

    def offset_at(self, s: Array, start_offset_m: float) -> Array:
        """Return the offsets at the arc lengths `s` (m), from `start_offset_m` at the start."""
        share_out = smooth_step((s - self.begins_m) / max(self.beside_m - self.begins_m, 1e-6))
        share_back = smooth_step((s - self.returns_m) / max(self.back_m - self.returns_m, 1e-6))
        return np.asarray((start_offset_m + (self.offset_m - start_offset_m) * share_out) * (1.0 - share_back))


class PassContext(NamedTuple):
    """The ego in the route's frame, with all data for a pass."""

    s_m: float
    d_m: float
    speed_mps: float
    cruise_mps: float
    bodies: RouteObjects
    sides: AdjacentLaneWidths
    model: VehicleModel


class PassRollout(NamedTuple):
    """A simulated pass: times (s), arc lengths and offsets of the ego's center (m)."""

    t: Array
    s: Array
    d: Array


def objects_to_pass(context: PassContext, first: int, lane_m: float) -> Flags:
    """Return True for the objects that are passed together with number `first`, because the gaps between are short."""
    bodies = context.bodies
    is_in_lane = np.abs(bodies.d) - bodies.aside < lane_m
    is_member = np.zeros(len(bodies), np.bool_)
    is_member[first] = True
    end, pace = bodies.s[first] + bodies.along[first], max(float(bodies.vs[first]), 0.0)
    for k in np.argsort(bodies.s).tolist():
        is_near = bodies.s[k] - bodies.along[k] - end < GROUP_GAP_M
        is_ahead = bodies.s[k] > bodies.s[first] and abs(float(bodies.vs[k])) < pace + 1.5
        if is_in_lane[k] and is_ahead and is_near:
            is_member[k] = True
            end = max(end, float(bodies.s[k] + bodies.along[k]))
    return is_member


def pass_candidates(context: PassContext, group: Flags) -> Iterator[PassCandidate]:
    """Yield passes of a group on either side, from gentle to tight, for lanes that are wide enough."""
    bodies, model = context.bodies.part(group), context.model
    start = float((bodies.s - bodies.along).min())
    is_vulnerable = bodies.is_walker | (bodies.aside < TWO_WHEELER_M)
    clearance_m = np.where(is_vulnerable, VULNERABLE_CLEARANCE_M, CLEARANCE_M) + model.half_width
    is_parked = ~is_vulnerable & (bodies.speed < _STOPPED_MPS) & (bodies.along > bodies.aside)
    door_clearance_m = np.where(is_parked, DOOR_CLEARANCE_M + model.half_width, clearance_m)
    speed = min(context.cruise_mps, PASSING_MPS)
    for side in (-1, 1):
        edge, beyond_doors = (
            float((side * bodies.d + bodies.aside + item).max()) for item in (clearance_m, door_clearance_m)
        )
        for offset in dict.fromkeys((edge, beyond_doors, *_lane_centers(context, start, side, edge))):
            for share in LENGTH_SHARES:
                candidate = _candidate(context, bodies, side * offset, share, speed)
                if candidate is not None:
                    yield replace(candidate, by_doors=offset < beyond_doors)


def _lane_centers(context: PassContext, s_m: float, side: int, min_offset_m: float) -> Iterator[float]:
    """Yield the center offset of the adjacent lane of the ego's direction on a side, if it is at least the minimum."""
    widths = context.sides.narrowest(s_m - 1.0, s_m + 1.0)
    width = widths.left_same if side < 0 else widths.right_same
    if width > 0.0 and widths.half + width / 2.0 > min_offset_m:
        yield widths.half + width / 2.0


def _candidate(
    context: PassContext, bodies: RouteObjects, offset: float, share: float, speed: float
) -> PassCandidate | None:
    half_length = context.model.half_length
    start, end = float((bodies.s - bodies.along).min()), float((bodies.s + bodies.along).max())
    pace = max(float(bodies.vs.max()), 0.0)
    swing_m = share * rejoining_length(offset - context.d_m, context.speed_mps)
    begins_m = max(context.s_m, start - half_length - GAP_BEFORE_M - swing_m)
    t, s = _drive(context, speed)
    is_past = s - half_length > end + pace * t + GAP_AFTER_M
    if not is_past.any():
        return None
    returns_m = float(s[int(np.argmax(is_past))])
    back_m = returns_m + min(rejoining_length(offset, speed), LONGEST_RETURN_M)
    widths = context.sides.narrowest(min(begins_m, context.s_m), back_m)
    fits, oncoming = _lane_use(widths, offset, context.model.half_width)
    if not fits:
        return None
    ids = frozenset(bodies.actor_id.tolist())
    return PassCandidate(offset, begins_m, begins_m + swing_m, returns_m, back_m, speed, oncoming, ids, end)


def _lane_use(widths: LaneWidths, offset: float, half_width: float) -> tuple[bool, bool]:
    """Return (fits, oncoming): True if the lanes are wide enough at the offset, and if an oncoming lane is used."""
    edge = abs(offset) + half_width + EDGE_M
    to_right = offset >= 0.0
    same = widths.half + (widths.right_same if to_right else widths.left_same)
    oncoming = widths.right_oncoming if to_right else widths.left_oncoming
    return edge <= same + oncoming, edge > same


def _drive(context: PassContext, speed: float) -> tuple[Array, Array]:
    t = STEP_S * np.arange(round(HORIZON_S / STEP_S))
    v = np.minimum(context.speed_mps + ACCELERATION_MPS2 * t, max(speed, context.speed_mps))
    s: Array = context.s_m + np.concatenate([[0.0], np.cumsum(v[:-1]) * STEP_S])
    return t.astype(np.float64), s


def rollout(context: PassContext, candidate: PassCandidate) -> PassRollout:
    """Return the rollout of a pass, from the ego's position until it is back on its line."""
    t, s = _drive(context, candidate.speed_mps)
    count = int(np.searchsorted(s, candidate.back_m)) + 1
    return PassRollout(t[:count], s[:count], candidate.offset_at(s[:count], context.d_m))


def is_clear(context: PassContext, candidate: PassCandidate, share: float = 1.0) -> bool:
    """Return True if a pass keeps the required gaps to all objects that continue along the route as now.

    `share` scales the gaps. It is smaller after the start, so that the ego does not hesitate.
    """
    drive, bodies, model = rollout(context, candidate), context.bodies, context.model
    is_passed = bodies.has_id_in(candidate.around)
    is_behind = (bodies.s + bodies.along < context.s_m) & (np.abs(bodies.d - context.d_m) < 1.0)
    # An object in the lane after the group is no conflict: the ego stops behind it or follows it.
    is_leading = (np.abs(bodies.d) - bodies.aside < model.half_width) & (bodies.s - bodies.along > candidate.ends_m)
    is_leading &= bodies.vs > _ONCOMING_MPS
    vehicles = bodies.part(~is_passed & ~is_behind & ~is_leading)
    if len(vehicles) == 0:
        return True
    t = drive.t[:, None]
    s, d = vehicles.s + vehicles.vs * t, vehicles.d + np.where(vehicles.is_walker, vehicles.vd, 0.0) * t
    is_oncoming = vehicles.vs < _ONCOMING_MPS
    clearance_m = np.where(
        is_oncoming, ONCOMING_M - ONCOMING_S * vehicles.vs, FOLLOWING_M + FOLLOWING_S * np.maximum(vehicles.vs, 0.0)
    )
    clearance_m = np.where(np.abs(vehicles.vs) < _STOPPED_MPS, _STOPPED_GAP_M, clearance_m)
    along = np.abs(s - drive.s[:, None]) < model.half_length + vehicles.along + share * clearance_m
    aside = np.abs(d - drive.d[:, None]) < model.half_width + vehicles.aside + share * SIDE_MARGIN_M
    return not bool((along & aside).any())


def cost_s(context: PassContext, candidate: PassCandidate) -> float:
    """Return the cost of a pass (s): its time, exposure to oncoming traffic and doors, and its offset."""
    drive = rollout(context, candidate)
    exposed_s = _ONCOMING_COST_S * candidate.oncoming + _DOORS_COST_S * candidate.by_doors
    return float(drive.t[-1]) + exposed_s + _PER_METER_COST_S * abs(candidate.offset_m)


def pass_path(
    line: Path, context: PassContext, candidate: PassCandidate, lateral_accel: float, deceleration: float
) -> Path:
    """Return the rest of the route's `line` with the pass."""
    rest = line.s >= min(context.s_m, line.length - 1.0)
    s, bounds = line.s[rest], line.speed[rest]
    share_out = (s > candidate.begins_m) & (s < candidate.back_m)
    path = offset_path(
        line,
        rest,
        candidate.offset_at(s, context.d_m),
        np.where(share_out, np.minimum(bounds, candidate.speed_mps), bounds),
    )
    return speed_limited_path(path, lateral_accel, deceleration)
