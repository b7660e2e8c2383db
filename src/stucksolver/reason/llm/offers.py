"""Which of the behaviours that the stack offers make sense in a scene: the others would only lengthen the prompt."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver.decision.behaviors import REGISTRY
from stucksolver.scene import (
    MOTOR_VEHICLES,
    PASSABLE_KINDS,
    AvailableBehavior,
    LaneDirection,
    LaneKind,
    LaneRelation,
    Scene,
)

OFF_LANE_M = 0.5


def available(scene: Scene) -> tuple[AvailableBehavior, ...]:
    """The offers that have something to act on here. The guard judges each plan all the same."""
    known = [b for b in scene.behaviors if b.name in REGISTRY]
    return tuple(b for b in known if b.name not in NEEDS or NEEDS[b.name](scene))


def _neighbour(scene: Scene) -> bool:
    beside = (LaneRelation.LEFT, LaneRelation.RIGHT)
    return any(x.relation in beside and x.direction is LaneDirection.SAME for x in scene.lanes)


def _oncoming(scene: Scene) -> bool:
    lanes = any(x.direction is LaneDirection.OPPOSITE and x.kind is LaneKind.DRIVING for x in scene.lanes)
    return lanes and bool(scene.objects)


def _leader(scene: Scene) -> bool:
    return any(o.in_path and o.kind in MOTOR_VEHICLES and o.speed_along_mps > 0.5 for o in scene.objects)


def _passable(scene: Scene) -> bool:
    return any(o.kind in PASSABLE_KINDS for o in scene.objects)


def _off_lane(scene: Scene) -> bool:
    return abs(scene.ego.lateral_offset_m) > OFF_LANE_M


def _starts(scene: Scene) -> bool:
    return bool(scene.waypoints)


NEEDS: dict[str, Callable[[Scene], bool]] = {
    "change_lane": _neighbour,
    "borrow_oncoming_lane": _oncoming,
    "follow_vehicle": _leader,
    "drive_over": _passable,
    "rejoin_route": _off_lane,
    "replan": _starts,
}
