"""Finds the objects to pass, the lateral offset beside them, and the distance to drive there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.plan.behaviors.behavior import BehaviorStart, NoPathError
from stucksolver.plan.frenet_path import FrenetPath, straight
from stucksolver.plan.speed_profile import slow_launch
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array, Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.road import LaneDirection, LaneKind

CLEARANCE_M, NARROW_CLEARANCE_M = 1.2, 0.5
"""Planned clearance to stationary objects, and the smallest one on a narrow road (m): the first suffices for a door
that is ajar. Ours.
"""
VULNERABLE_CLEARANCE_M, NARROW_VULNERABLE_CLEARANCE_M = 1.7, 1.35
"""The same for pedestrians and cyclists (m). Ours."""
IN_WAY_M = 0.3
"""An object nearer than this beside the body of an ego in the middle of its lane is in the way (m). Ours."""
QUICK_MPS = 5.6
"""Speed above which the clearances grow (m/s): just over 20 km/h."""
QUICK_CLEARANCE_M, QUICK_VULNERABLE_CLEARANCE_M = 1.28, 3.05
"""Clearances above `QUICK_MPS` to stationary objects and to moving cyclists (m). The guard requires 1.25 m beside a
door at 8 m/s, and `SpeedPolicy.people_aside_m` is 3 m.
"""
QUICK_SHIFT_M = 25.0
"""Distance ahead from which cyclists get the larger clearance (m): after a shorter shift, the body would reach over
the far edge of the lane.
"""
DOOR_M = 0.95
"""Least clearance to a vehicle for more than walking pace (m); for vulnerable road users it is the planned one."""
ROOM_TO_RETURN_M = 10.0
"""Least gap beyond the passed object for a return (m); with a shorter gap the next object is passed, too. The gap
contains the ego's length, 2 m to the next object, and the space in which the tail swings in.
"""
AHEAD_OF_MOVING_M = 6.0
"""Distance of the ego's rear ahead of a moving object at the start of the return (m). Ours."""
SPEED_MARGIN_MPS = 0.5
"""Assumed error of the speed of a passed road user (m/s): it may be faster by this much. Ours."""
MOVES_MPS = 0.5
"""Speed along the road above which an object counts as moving (m/s): `PredictionPolicy.along_mps`."""
FAR_CLEARANCE_M = 1.15
"""Planned clearance from a stationary object on the far side of the pass (m): `TrackingPolicy.error_m` plus
`HarmPolicy.touch_m`, which the guard requires where the path leads toward it, and 0.15 m for the front corner.
"""
EDGE_M = 0.1
"""Distance that the ego's body keeps from the far edge of the oncoming lane (m). Ours."""
MOST_ABREAST_M = 400.0
"""Greatest distance to drive beside moving objects (m). Ours."""


@dataclass(frozen=True)
class PassPlan:
    """Objects to pass, with the geometry of the pass.

    Attributes:
        ids: Ids of the objects.
        offset_m: Lateral offset of the ego's center beside them (m, left positive).
        far_s: Arc length of the far end of the foremost object (m).
        speed_mps: Speed of the fastest object along the road, at least 0 (m/s).
    """

    ids: tuple[str, ...]
    offset_m: float
    far_s: float
    speed_mps: float
    slowly: bool = False
    """True if the road is so narrow that only walking pace is allowed."""
    gentle_m: float = 0.0
    """Least length of the shift out of the lane, if there is space for it (m)."""
    least_offset_m: float = np.inf
    """Least offset beside the objects (m), if there are others on the far side that the path must not lead toward."""


def borrowed_lane(view: FrenetScene, s: float) -> Lane | None:
    """Return the oncoming driving lane to the left of the route's own lane at arc length `s` (m), or None."""
    lane = view.frame.beside(s, 0.0, +1)
    if lane is None or lane.strip.kind is not LaneKind.DRIVING:
        return None
    return lane if lane.strip.direction is LaneDirection.OPPOSITE else None


def find_passing(view: FrenetScene, start: BehaviorStart, object_id: str, lane: Lane, speed_mps: float) -> PassPlan:
    """Find all objects that must be passed, up to and including a given one.

    Args:
        view: Surroundings in road coordinates.
        start: Start of the pass.
        object_id: Id of the given object.
        lane: Oncoming lane.
        speed_mps: Speed of the pass (m/s).

    Raises:
        NoPathError: The object is not detected or not in the ego's path, or the lane is too narrow.
    """
    target, which = _passed(view, start, object_id)
    _, center, left = lane.at(float(view.s[target]))
    limit = left - view.ego.width_m / 2 - EDGE_M
    least = _beside(view, which, NARROW_CLEARANCE_M, NARROW_VULNERABLE_CLEARANCE_M)
    if least > limit:
        raise NoPathError(
            PlanFailure.LANE_TOO_NARROW,
            f"oncoming lane too narrow to pass {object_id}: offset at most {limit:.2f} m, required {least:.2f} m",
            object_id=object_id,
            short_m=least - limit,
        )
    moving = float(view.vs[which].max())
    near = float((view.s[which] - view.along[which]).min()) - start.s_m - view.ego.length_m / 2
    fast = speed_mps > QUICK_MPS and moving > MOVES_MPS and near > QUICK_SHIFT_M
    wide = fast and bool(view.vulnerable[which].any())
    people_m = QUICK_VULNERABLE_CLEARANCE_M if wide else VULNERABLE_CLEARANCE_M
    desired = _beside(view, which, CLEARANCE_M if speed_mps <= QUICK_MPS else QUICK_CLEARANCE_M, people_m)
    # Beside a moving object the ego uses the whole oncoming lane, beside a stationary one no more than needed.
    offset = max(desired, center) if moving > MOVES_MPS else desired
    others = _on_the_left(view, start, which)
    least, limit = _between(view, others, least, limit)
    far_s = float((view.s[which] + view.along[which]).max())
    return PassPlan(
        tuple(view.objects[int(i)].id for i in which),
        min(max(offset, least), limit),
        far_s,
        max(moving, 0.0),
        moving <= MOVES_MPS and limit < _beside(view, which, DOOR_M, VULNERABLE_CLEARANCE_M),
        QUICK_SHIFT_M if wide else 0.0,
        least if len(others) else np.inf,
    )


def _between(view: FrenetScene, others: Array, least: float, limit: float) -> tuple[float, float]:
    """Return the least and greatest offset of the ego's center between stationary objects on both sides (m).

    The greatest one keeps `FAR_CLEARANCE_M` on the far side, or lies in the middle if there is less room.

    Args:
        view: Surroundings in road coordinates.
        others: Indices of the objects to the left of the passed ones.
        least: Least offset beside the passed objects (m).
        limit: Greatest offset within the lane (m).

    Raises:
        NoPathError: An object leaves too little room on both of its sides.
    """
    if not len(others):
        return least, limit
    half, vulnerable = view.ego.width_m / 2, view.vulnerable[others]
    narrow_m = np.where(vulnerable, NARROW_VULNERABLE_CLEARANCE_M, NARROW_CLEARANCE_M)
    roomy_m = np.where(vulnerable, VULNERABLE_CLEARANCE_M, FAR_CLEARANCE_M)
    right, left = view.d[others] - view.across[others] - half, view.d[others] + view.across[others] + half
    near = (right - narrow_m < least) & (left + narrow_m <= limit)
    least = max(least, float((left + narrow_m)[near].max(initial=-np.inf)))
    edge, others = right[~near], others[~near]
    right = edge - roomy_m[~near]
    lack = least - right
    if len(lack) and float(lack.max()) > 0.0:
        obj, short_m = view.objects[int(others[int(lack.argmax())])], float(lack.max())
        raise NoPathError(
            PlanFailure.LANE_TOO_NARROW,
            f"{obj.kind.value} {obj.id} beside the passed object: {short_m:.2f} m short",
            object_id=obj.id,
            short_m=short_m,
        )
    roomy = min(limit, float(right.min(initial=np.inf)))
    middle = (least - NARROW_CLEARANCE_M + float(edge.min(initial=np.inf))) / 2
    return least, min(limit, max(roomy, middle))


def _on_the_left(view: FrenetScene, start: BehaviorStart, which: Array) -> Array:
    """(found,): indices of stationary objects that reach further left than the passed ones, beside the ego's path."""
    edge = float((view.d[which] + view.across[which]).max())
    until_s = float((view.s[which] + view.along[which]).max()) + view.ego.length_m
    beside = (view.s + view.along > start.s_m) & (view.s - view.along < until_s)
    found = ~view.moving & beside & (view.d + view.across > edge)
    found[which] = False
    return np.flatnonzero(found)


def standing_beyond(view: FrenetScene, passing: PassPlan) -> float:
    """Return the arc length of the near end of the first stationary object in the ego's lane beyond the pass (m).

    Infinite if there is none.
    """
    half = view.ego.width_m / 2
    near = [
        float(view.s[i] - view.along[i])
        for i in range(len(view.objects))
        if view.objects[i].id not in passing.ids
        and abs(view.d[i]) - view.across[i] < half
        and abs(view.vs[i]) < MOVES_MPS
        and view.s[i] > passing.far_s
    ]
    return min(near, default=np.inf)


def _beside(view: FrenetScene, which: Array, clearance_m: float, vulnerable_clearance_m: float) -> float:
    """Return the lateral offset at which the ego's center keeps the clearance from all of the objects (m)."""
    clearance = np.where(view.vulnerable[which], vulnerable_clearance_m, clearance_m)
    return float((view.d[which] + view.across[which] + clearance).max()) + view.ego.width_m / 2


def _passed(view: FrenetScene, start: BehaviorStart, object_id: str) -> tuple[int, Array]:
    """Return the index of a given object, and those of the objects to pass with it (found,). See `find_passing`."""
    target = view.index_of(object_id)
    if target is None:
        raise NoPathError(PlanFailure.NOT_SEEN, f"object {object_id} is not detected")
    which = _group(view, start, target)
    if not which:
        raise NoPathError(PlanFailure.NOT_IN_THE_WAY, f"object {object_id} is not in the ego's path")
    return target, np.array(which)


def _group(view: FrenetScene, start: BehaviorStart, target: int) -> list[int]:
    """Return the target, the objects in the ego's way before it, and the objects that are too close beyond it.

    A person on the right is in the way also at the edge of the lane, if the ego in its middle comes too near.
    """
    at_edge = view.vulnerable & (view.d < 0.0)
    half = view.ego.width_m / 2 + np.where(at_edge, NARROW_VULNERABLE_CLEARANCE_M, IN_WAY_M)
    in_path = [
        int(i)
        for i in np.argsort(view.s)
        if abs(view.d[i]) - view.across[i] < half[i] and view.s[i] + view.along[i] > start.s_m and view.vs[i] > -0.5
    ]
    group: list[int] = []
    for i in in_path:
        near = float(view.s[i] - view.along[i])
        if (
            view.s[i] <= view.s[target]
            or not group
            or near - max(float(view.s[j] + view.along[j]) for j in group) < ROOM_TO_RETURN_M
        ):
            group.append(i)
    return group if target in group else []


def length_abreast(
    view: FrenetScene, start: BehaviorStart, out: FrenetPath, passing: PassPlan, speed_mps: float
) -> float:
    """Return the distance to drive beside the passed objects before the return may begin (m).

    It assumes a sluggish ego, and moving objects that are a little faster than perceived.
    """
    half = view.ego.length_m / 2
    if passing.speed_mps <= MOVES_MPS:
        return max(passing.far_s + half + 1.0 - out.end_s, 0.5)
    path = out.then(straight(out.end_s, out.end_d, MOST_ABREAST_M, speed_mps))
    slow = slow_launch(path, start.speed_mps, view.ego.limits)
    rear = path.s - half
    other = passing.far_s + (passing.speed_mps + SPEED_MARGIN_MPS) * slow.t
    ahead = np.flatnonzero((rear > other + AHEAD_OF_MOVING_M) & (path.s > out.end_s))
    if not len(ahead):
        raise NoPathError(PlanFailure.TOO_LONG, f"pass of {', '.join(passing.ids)}: longer than {MOST_ABREAST_M:g} m")
    return max(float(path.s[ahead[0]]) - out.end_s, 0.5)
