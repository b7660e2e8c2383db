"""Finds what must be passed, at what lateral offset, and for how long."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stucksolver.plan.behaviors.behavior import BehaviorStart, NoPathError
from stucksolver.plan.frenet_path import FrenetPath, straight
from stucksolver.plan.speed_profile import slow_launch
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.road import LaneDirection, LaneKind

CLEARANCE_M, NARROW_CLEARANCE_M = 1.2, 0.5
"""Planned clearance beside stationary objects (enough for a door ajar), and the smallest one on a narrow road (m)."""
VULNERABLE_CLEARANCE_M, NARROW_VULNERABLE_CLEARANCE_M = 1.7, 1.35
"""The same beside pedestrians and cyclists."""
QUICK_MPS = 5.6
"""Above this speed, just over 20 km/h, more is kept, where there is room (m/s)."""
QUICK_CLEARANCE_M, QUICK_VULNERABLE_CLEARANCE_M = 1.28, 3.05
"""Beside stationary objects (the guard asks for 1.25 m beside a door at 8 m/s), and beside cyclists who ride (m)."""
QUICK_SHIFT_M = 25.0
"""There is room for it if they are so far ahead: a shorter way out turns the body over the far edge of the lane (m)."""
DOOR_M = 0.95
"""With less than this beside a vehicle, or less than planned beside people, the ego passes at walking pace (m)."""
ROOM_TO_RETURN_M = 10.0
"""A gap shorter than this beyond the passed object is too short to return into, so the next object is passed too. It
holds the ego's length, 2 m to what is beyond, and the room that the tail needs to swing in.
"""
AHEAD_OF_MOVING_M = 6.0
"""The ego's rear must be this far ahead of a moving object when the return begins."""
SPEED_MARGIN_MPS = 0.5
"""A road user being passed may be faster than seen by this much."""


@dataclass(frozen=True)
class PassPlan:
    """What to pass and how.

    Attributes:
        ids: Ids of the objects.
        offset_m: Lateral offset of the ego's center beside them (m, left positive).
        far_s: Arc length of the far end of the foremost one (m).
        speed_mps: Speed of the fastest one along the road, at least 0 (m/s).
    """

    ids: tuple[str, ...]
    offset_m: float
    far_s: float
    speed_mps: float
    slowly: bool = False
    """True if the road is so narrow that only walking pace is allowed."""
    gentle_m: float = 0.0
    """Least length of the way out, if there is room for it (m)."""


def borrowed_lane(view: FrenetScene, s: float) -> Lane | None:
    """Return the oncoming driving lane to the left of the route's own lane at arc length `s` (m), or None."""
    lane = view.frame.beside(s, 0.0, +1)
    if lane is None or lane.strip.kind is not LaneKind.DRIVING:
        return None
    return lane if lane.strip.direction is LaneDirection.OPPOSITE else None


def find_passing(view: FrenetScene, start: BehaviorStart, object_id: str, lane: Lane, speed_mps: float) -> PassPlan:
    """Find everything that must be passed up to and including an object.

    Args:
        view: The surroundings in road coordinates.
        start: Where the pass begins.
        object_id: The object.
        lane: The oncoming lane.
        speed_mps: Speed of the pass (m/s).

    Raises:
        CannotPlan: The object is not seen or not in the way, or the lane is too narrow.
    """
    target = view.index_of(object_id)
    if target is None:
        raise NoPathError(PlanFailure.NOT_SEEN, f"object {object_id} is not seen")
    which = _group(view, start, target)
    if not which:
        raise NoPathError(PlanFailure.NOT_IN_THE_WAY, f"object {object_id} is not in the way")
    half = view.ego.width_m / 2
    _, centre, left = lane.at(float(view.s[target]))
    limit = left - half - 0.1
    if _beside(view, which, NARROW_CLEARANCE_M, NARROW_VULNERABLE_CLEARANCE_M) > limit:
        raise NoPathError(
            PlanFailure.LANE_TOO_NARROW, f"the oncoming lane is too narrow to pass {object_id} with enough clearance"
        )
    moving = max(float(view.vs[i]) for i in which)
    near = min(float(view.s[i] - view.along[i]) for i in which) - start.s_m - view.ego.length_m / 2
    wide = speed_mps > QUICK_MPS and moving > 0.5 and near > QUICK_SHIFT_M and any(view.vulnerable[i] for i in which)
    people_m = QUICK_VULNERABLE_CLEARANCE_M if wide else VULNERABLE_CLEARANCE_M
    wished = _beside(view, which, CLEARANCE_M if speed_mps <= QUICK_MPS else QUICK_CLEARANCE_M, people_m)
    # Use the whole other lane beside a moving object, but no more than needed beside a stationary one.
    offset = max(wished, centre) if moving > 0.5 else wished
    far = max(which, key=lambda i: float(view.s[i] + view.along[i]))
    return PassPlan(
        tuple(view.objects[i].id for i in which),
        min(offset, limit),
        float(view.s[far] + view.along[far]),
        max(moving, 0.0),
        moving <= 0.5 and limit < _beside(view, which, DOOR_M, VULNERABLE_CLEARANCE_M),
        QUICK_SHIFT_M if wide else 0.0,
    )


def standing_beyond(view: FrenetScene, passing: PassPlan) -> float:
    """Return the arc length of the near end of what is stationary in the ego's lane beyond the pass (m); infinite if
    nothing is.
    """
    half = view.ego.width_m / 2
    near = [
        float(view.s[i] - view.along[i])
        for i in range(len(view.objects))
        if view.objects[i].id not in passing.ids
        and abs(view.d[i]) - view.across[i] < half
        and abs(view.vs[i]) < 0.5
        and view.s[i] > passing.far_s
    ]
    return min(near, default=np.inf)


def _beside(view: FrenetScene, which: list[int], clearance_m: float, vulnerable_clearance_m: float) -> float:
    """Return the lateral offset at which the ego's center keeps the clearance from all of them (m)."""
    edges = [
        float(view.d[i] + view.across[i]) + (vulnerable_clearance_m if view.vulnerable[i] else clearance_m)
        for i in which
    ]
    return max(edges) + view.ego.width_m / 2


def _group(view: FrenetScene, start: BehaviorStart, target: int) -> list[int]:
    """Return the target, what is in the ego's lane before it, and what is too close beyond it."""
    half = view.ego.width_m / 2 + 0.3
    in_path = [
        int(i)
        for i in np.argsort(view.s)
        if abs(view.d[i]) - view.across[i] < half and view.s[i] + view.along[i] > start.s_m and view.vs[i] > -0.5
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

    It assumes a sluggish ego, and moving objects that are a little faster than seen.
    """
    half = view.ego.length_m / 2
    if passing.speed_mps <= 0.5:
        return max(passing.far_s + half + 1.0 - out.end_s, 0.5)
    path = out.then(straight(out.end_s, out.end_d, 400.0, speed_mps))
    slow = slow_launch(path, start.speed_mps, view.ego.limits)
    rear = path.s - half
    other = passing.far_s + (passing.speed_mps + SPEED_MARGIN_MPS) * slow.t
    ahead = np.flatnonzero((rear > other + AHEAD_OF_MOVING_M) & (path.s > out.end_s))
    if not len(ahead):
        raise NoPathError(PlanFailure.TOO_LONG, "it would take more than 400 m to pass")
    return max(float(path.s[ahead[0]]) - out.end_s, 0.5)
