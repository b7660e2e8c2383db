"""Ways past what blocks the lane: proposals, each rolled out against a prediction of everybody; the best one wins.

The scheme is that of PDM (Dauner et al., "Parting with Misconceptions about Learning-based Vehicle Motion Planning",
CoRL 2023): proposals of lateral offset and speed, simulated and scored. Here the frame is the route's, so that a
prediction is a straight line in it, and proposals follow from what is in the way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stucksolver_carla.drivers.behavior.path import Array, Path
from stucksolver_carla.drivers.behavior.route_bodies import Flags, RouteObjects
from stucksolver_carla.drivers.behavior.route_line import beside, rejoining_length, slowed, smooth_step
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner.adjacent_lane_widths import AdjacentLaneWidths, LaneWidths

STEP_S = 0.2
HORIZON_S = 24.0
ACCELERATION_MPS2 = 1.8
PASSING_MPS = 11.0
BESIDE_VULNERABLE_M = 0.9
"""Clearance kept beside people and two-wheelers (m)."""
BESIDE_M = 0.5
"""Clearance kept beside everything else (m)."""
BESIDE_DOORS_M = 1.1
"""Clearance kept beside stationary vehicles if there is room: an opening door and 10 cm or so (m)."""
ROOM_BEFORE_M = 1.5
"""Distance between the bumpers when the lane is left (m)."""
ROOM_AFTER_M = 4.0
"""Distance between the bumpers when the lane is re-entered (m)."""
GROUP_GAP_M = 11.0
"""A body nearer than this behind another one is passed with it."""
LONGEST_RETURN_M = 14.0
EDGE_M = 0.1
ALONE_M = 0.3
"""Clearance beside the body in predictions (m)."""
ONCOMING_M = 6.0
"""Distance kept from oncoming traffic, besides `ONCOMING_S` (m)."""
ONCOMING_S = 0.8
"""The same in seconds of their drive."""
FOLLOWING_M = 2.0
"""Distance kept from traffic in the ego's direction, besides `FOLLOWING_S` (m)."""
FOLLOWING_S = 0.5
"""The same in seconds of their drive."""
TIGHTER = (1.0, 0.8, 0.65)
_COMES_MPS = -1.0
_STANDS_MPS = 0.3
_BEFORE_WHAT_STANDS_M = 0.5
TWO_WHEELER_M = 0.55
"""A narrower body than twice this is a bicycle or a motorcycle."""
_ONCOMING_COST_S = 4.0
_PER_METRE_COST_S = 0.3
_DOORS_COST_S = 1.0


@dataclass(frozen=True)
class PassCandidate:
    """A way beside the route's line and back: offset (right positive) and arc lengths of the ego's center (m)."""

    offset_m: float
    begins_m: float
    beside_m: float
    """Where the offset is reached."""
    returns_m: float
    """Where the way back begins."""
    back_m: float
    """Where it is on the line again."""
    speed_mps: float
    """Speed cap beside it (m/s)."""
    oncoming: bool
    """True if it uses a lane of the other direction."""
    around: frozenset[int]
    """Ids of what is passed."""
    ends_m: float
    """Where that ends."""
    by_doors: bool = False
    """True if an opening door would reach into its way."""

    def offset_at(self, s: Array, start_offset_m: float) -> Array:
        """Return the offsets at arc lengths `s`, from `start_offset_m` at its beginning."""
        out = smooth_step((s - self.begins_m) / max(self.beside_m - self.begins_m, 1e-6))
        home = smooth_step((s - self.returns_m) / max(self.back_m - self.returns_m, 1e-6))
        return np.asarray((start_offset_m + (self.offset_m - start_offset_m) * out) * (1.0 - home))


class PassContext(NamedTuple):
    """The ego in the route's frame, and everything that a pass depends on."""

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


def group_of(here: PassContext, first: int, lane_m: float) -> Flags:
    """Return what is passed together with body number `first`: followers in the lane too close to return between."""
    bodies = here.bodies
    inside = np.abs(bodies.d) - bodies.aside < lane_m
    members = np.zeros(len(bodies), np.bool_)
    members[first] = True
    end, pace = bodies.s[first] + bodies.along[first], max(float(bodies.vs[first]), 0.0)
    for k in np.argsort(bodies.s).tolist():
        near = bodies.s[k] - bodies.along[k] - end < GROUP_GAP_M
        ahead = bodies.s[k] > bodies.s[first] and abs(float(bodies.vs[k])) < pace + 1.5
        if inside[k] and ahead and near:
            members[k] = True
            end = max(end, float(bodies.s[k] + bodies.along[k]))
    return members


def proposals(here: PassContext, group: Flags) -> Iterator[PassCandidate]:
    """Yield ways past a group, on either side, from gentle to tight, if the lanes are wide enough."""
    bodies, model = here.bodies.part(group), here.model
    start = float((bodies.s - bodies.along).min())
    vulnerable = bodies.is_walker | (bodies.aside < TWO_WHEELER_M)
    keep = np.where(vulnerable, BESIDE_VULNERABLE_M, BESIDE_M) + model.half_width
    parked = ~vulnerable & (bodies.speed < _STANDS_MPS) & (bodies.along > bodies.aside)
    wide = np.where(parked, BESIDE_DOORS_M + model.half_width, keep)
    speed = min(here.cruise_mps, PASSING_MPS)
    for side in (-1, 1):
        edge, beyond = (float((side * bodies.d + bodies.aside + item).max()) for item in (keep, wide))
        for offset in dict.fromkeys((edge, beyond, *_lane_middles(here, start, side, edge))):
            for share in TIGHTER:
                found = _pass(here, bodies, side * offset, share, speed)
                if found is not None:
                    yield replace(found, by_doors=offset < beyond)


def _lane_middles(here: PassContext, s_m: float, side: int, least_m: float) -> Iterator[float]:
    """Yield the center of a lane of our direction on that side, if it is far enough away."""
    room = here.sides.room(s_m - 1.0, s_m + 1.0)
    width = room.left_same if side < 0 else room.right_same
    if width > 0.0 and room.half + width / 2.0 > least_m:
        yield room.half + width / 2.0


def _pass(here: PassContext, bodies: RouteObjects, offset: float, share: float, speed: float) -> PassCandidate | None:
    half = here.model.half_length
    start, end = float((bodies.s - bodies.along).min()), float((bodies.s + bodies.along).max())
    pace = max(float(bodies.vs.max()), 0.0)
    swing = share * rejoining_length(offset - here.d_m, here.speed_mps)
    begins = max(here.s_m, start - half - ROOM_BEFORE_M - swing)
    t, s = _driven(here, speed)
    clear = s - half > end + pace * t + ROOM_AFTER_M
    if not clear.any():
        return None
    returns = float(s[int(np.argmax(clear))])
    back = returns + min(rejoining_length(offset, speed), LONGEST_RETURN_M)
    room = here.sides.room(min(begins, here.s_m), back)
    reaches, oncoming = _lanes(room, offset, here.model.half_width)
    if not reaches:
        return None
    ids = frozenset(bodies.actor_id.tolist())
    return PassCandidate(offset, begins, begins + swing, returns, back, speed, oncoming, ids, end)


def _lanes(room: LaneWidths, offset: float, half_width: float) -> tuple[bool, bool]:
    """Return whether the lanes are wide enough for the body at that offset, and whether it uses an oncoming one."""
    edge = abs(offset) + half_width + EDGE_M
    if offset >= 0.0:
        return edge <= room.half + room.right_same, False
    return edge <= room.half + room.left_same + room.left_oncoming, edge > room.half + room.left_same


def _driven(here: PassContext, speed: float) -> tuple[Array, Array]:
    t = STEP_S * np.arange(round(HORIZON_S / STEP_S))
    v = np.minimum(here.speed_mps + ACCELERATION_MPS2 * t, max(speed, here.speed_mps))
    s: Array = here.s_m + np.concatenate([[0.0], np.cumsum(v[:-1]) * STEP_S])
    return t.astype(np.float64), s


def rollout(here: PassContext, way: PassCandidate) -> PassRollout:
    """Return the pass from the ego's position until it is back on its line."""
    t, s = _driven(here, way.speed_mps)
    count = int(np.searchsorted(s, way.back_m)) + 1
    return PassRollout(t[:count], s[:count], way.offset_at(s[:count], here.d_m))


def is_clear(here: PassContext, way: PassCandidate, share: float = 1.0) -> bool:
    """True if nobody would come too near, if everybody continues along the route's frame as now.

    `share` scales the distances kept: smaller for an ego that has set off, so that it does not hesitate.
    """
    drive, bodies, model = rollout(here, way), here.bodies, here.model
    ours = bodies.among(way.around)
    behind_us = (bodies.s + bodies.along < here.s_m) & (np.abs(bodies.d - here.d_m) < 1.0)
    # Behind a body in the lane beyond the group the ego stops or follows, as usual.
    leads = (np.abs(bodies.d) - bodies.aside < model.half_width) & (bodies.s - bodies.along > way.ends_m)
    leads &= bodies.vs > _COMES_MPS
    others = bodies.part(~ours & ~behind_us & ~leads)
    if len(others) == 0:
        return True
    t = drive.t[:, None]
    s, d = others.s + others.vs * t, others.d + np.where(others.is_walker, others.vd, 0.0) * t
    comes = others.vs < _COMES_MPS
    keep = np.where(comes, ONCOMING_M - ONCOMING_S * others.vs, FOLLOWING_M + FOLLOWING_S * np.maximum(others.vs, 0.0))
    keep = np.where(np.abs(others.vs) < _STANDS_MPS, _BEFORE_WHAT_STANDS_M, keep)
    along = np.abs(s - drive.s[:, None]) < model.half_length + others.along + share * keep
    aside = np.abs(d - drive.d[:, None]) < model.half_width + others.aside + share * ALONE_M
    return not bool((along & aside).any())


def cost_s(here: PassContext, way: PassCandidate) -> float:
    """Return the cost of a pass in seconds: its time, exposure to oncoming traffic and doors, and how far it
    swings out.
    """
    drive = rollout(here, way)
    exposed_s = _ONCOMING_COST_S * way.oncoming + _DOORS_COST_S * way.by_doors
    return float(drive.t[-1]) + exposed_s + _PER_METRE_COST_S * abs(way.offset_m)


def pass_path(line: Path, here: PassContext, way: PassCandidate, lateral_accel: float, deceleration: float) -> Path:
    """Return the rest of the route's `line` with the pass in it."""
    rest = line.s >= min(here.s_m, line.length - 1.0)
    s, bounds = line.s[rest], line.speed[rest]
    out = (s > way.begins_m) & (s < way.back_m)
    path = beside(line, rest, way.offset_at(s, here.d_m), np.where(out, np.minimum(bounds, way.speed_mps), bounds))
    return slowed(path, lateral_accel, deceleration)
