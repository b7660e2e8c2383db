"""What must be passed, how long that takes, and who is in the way during that time."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan.passing_geometry import ROOM_TO_RETURN_M
from stucksolver.reasoners.rules.observe import beside_lane_center, is_static_like
from stucksolver.reasoners.rules.recent_attempts import failed_for
from stucksolver.scene import (
    MOTOR_VEHICLES,
    VULNERABLE,
    LaneRelation,
    PlanFailure,
    RejectCode,
    Scene,
    SceneLane,
    SceneObject,
)
from stucksolver.scene.wording import whereabouts

GROUP_GAP_M = 16.0
"""Objects nearer to each other than this are passed together: a longer gap has room to return and stop (m)."""
WIDE_GROUP_GAP_M = 18.0
"""The same after a plan that found no room to return (m)."""
MERGE_ROOM_M, TIGHT_MERGE_ROOM_M = 12.0, 4.0
"""Distance ahead of what was passed at the return (m); the second if the return met a queue or the lane's end."""
BESIDE_M, EDGE_M = 0.5, 0.1
"""Smallest gap beside stationary objects, and to the far edge of the road (m)."""
ACCELERATION_MPS2 = 1.2
FLOWING_MPS = 2.0
"""Faster traffic in the adjacent lane passes by; the guard waits for the moment after it (m/s)."""
AT_EDGE_M = 0.5
"""What sensors place in the adjacent lane, but no further in it than this, may as well stand on the line: the guard
says whether there is room beside it (m).
"""
PASSED_M = 2.0
"""Oncoming traffic whose rear is less than this ahead of the ego's front bumper will have passed in time (m)."""


@dataclass(frozen=True)
class PassTarget:
    """What is to be passed: its foremost object, where it ends, and its speed."""

    objects: tuple[SceneObject, ...]

    @property
    def far(self) -> SceneObject:
        """The object whose far end is furthest along the route."""
        return max(self.objects, key=end_of)

    @property
    def end_m(self) -> float:
        """Distance from the ego's front bumper to the far end (m)."""
        return end_of(self.far)

    @property
    def speed_mps(self) -> float:
        """Speed of the fastest of them along the route (m/s), never below zero."""
        return max(0.0, max(o.speed_along_mps for o in self.objects))


def end_of(o: SceneObject) -> float:
    """Return the distance from the ego's front bumper to the far end of an object (m)."""
    return (o.gap_m or 0.0) + o.length_m


def group_of(scene: Scene, lead: SceneObject) -> PassTarget:
    """Return the lead and everything in the path that is too close beyond it to return in between.

    Moving traffic beyond a stationary obstruction will be gone by then. A vehicle that is only waiting there is not
    part of the obstruction: the ego returns before it if it fits at all.
    """
    gap_m = WIDE_GROUP_GAP_M if failed_for(scene, PlanFailure.NO_ROOM_TO_COME_BACK) else GROUP_GAP_M
    ahead = sorted((o for o in scene.objects if o.in_path and o.gap_m is not None), key=lambda o: o.gap_m or 0.0)
    members = [lead]
    for o in ahead:
        beyond = (o.gap_m or 0.0) > (lead.gap_m or 0.0) and o.speed_along_mps > -0.5
        beyond = beyond and (o.speed_along_mps < FLOWING_MPS or lead.speed_along_mps > 0.5)
        joins_m = ROOM_TO_RETURN_M if _only_waits(lead, o) else gap_m
        if beyond and (o.gap_m or 0.0) - max(end_of(m) for m in members) < joins_m:
            members.append(o)
    return PassTarget(tuple(members))


def _only_waits(lead: SceneObject, o: SceneObject) -> bool:
    """True if a vehicle beyond an obstruction is only waiting: in its lane, without hazard or emergency lights.

    An obstruction is recognized by its lights, by being off the lane's center, or by not being a motor vehicle.
    """
    obstructs = lead.kind not in MOTOR_VEHICLES or _warns(lead) or beside_lane_center(lead)
    return obstructs and o.kind in MOTOR_VEHICLES and not (_warns(o) or beside_lane_center(o))


def _warns(o: SceneObject) -> bool:
    return bool(o.hazard_lights or o.emergency_lights)


def pass_distance_m(scene: Scene, target: PassTarget, speed: float) -> tuple[float, float]:
    """Return the ego's distance (m) and time (s) until its rear is past the target with room to return."""
    relative = target.end_m + scene.ego.length_m + _merge_room_m(scene)
    own, time, way = max(scene.ego.speed_mps, 0.5), 0.0, 0.0
    while way - target.speed_mps * time < relative and time < 60.0:
        own = min(own + ACCELERATION_MPS2 * 0.25, max(speed, scene.ego.speed_mps))
        way, time = way + own * 0.25, time + 0.25
    return way, time


def _merge_room_m(scene: Scene) -> float:
    tight = failed_for(scene, PlanFailure.NO_ROOM_TO_COME_BACK, RejectCode.OFF_LANES)
    return TIGHT_MERGE_ROOM_M if tight else MERGE_ROOM_M


def in_lane_beside(scene: Scene, lane: SceneLane, target: PassTarget, speed: float) -> tuple[SceneObject, ...]:
    """Return what is stationary or crawls in the way in an adjacent lane in the ego's direction, nearest first.

    Faster traffic there is left to the guard. `speed`: of the pass (m/s).
    """
    way, time = pass_distance_m(scene, target, speed)
    found = []
    for o in scene.objects:
        if o.lane_id != lane.id or o.gap_m is None or o.gap_m < -scene.ego.length_m - 1.0:
            continue
        drives = o.speed_along_mps > FLOWING_MPS and not o.hazard_lights
        if _only_at_edge(scene, lane, o):
            continue
        if not drives and o.gap_m + max(o.speed_along_mps, 0.0) * time < way:
            found.append(o)
    return tuple(sorted(found, key=lambda o: o.gap_m or 0.0))


def _only_at_edge(scene: Scene, lane: SceneLane, o: SceneObject) -> bool:
    """True if sensors place a thing across the line between the ego's lane and an adjacent one."""
    own = next((x.width_m for x in scene.lanes if x.relation is LaneRelation.EGO), None)
    if own is None or not o.position_sd_m or o.kind in MOTOR_VEHICLES | VULNERABLE:
        return False
    reaches = o.left_edge_m if lane.relation is LaneRelation.LEFT else -o.right_edge_m
    return reaches - own / 2 < AT_EDGE_M


def describe_blocked_lane(blocking: SceneObject) -> str:
    """Return in words that an object blocks the adjacent lane."""
    return f"{blocking.kind.value} {blocking.id} blocks the adjacent lane, {whereabouts(blocking.gap_m or 0.0)}"


def is_staying(o: SceneObject) -> bool:
    """True if it will still be there however long the ego waits: a thing, or a broken-down vehicle."""
    return bool(o.hazard_lights) or o.kind not in MOTOR_VEHICLES | VULNERABLE or is_static_like(o)


def too_narrow(scene: Scene, lane: SceneLane, target: PassTarget) -> str | None:
    """Return in words that the adjacent lane leaves too little room to pass the target, or None."""
    own = next((x.width_m for x in scene.lanes if x.relation is LaneRelation.EGO), None)
    if own is None:
        return None
    widest = max(target.objects, key=lambda o: o.left_edge_m)
    free = own / 2 + lane.width_m - widest.left_edge_m
    needed = scene.ego.width_m + BESIDE_M + EDGE_M
    if free >= needed:
        return None
    return f"only {free:.1f} m of the road are free beside {widest.kind.value} {widest.id}; {needed:.1f} m are needed"


def oncoming_blocked(scene: Scene, lane: SceneLane, target: PassTarget, speed: float) -> str | None:
    """Return, in words, who would be in the way in the oncoming lane before the ego is back, or None."""
    way, time = pass_distance_m(scene, target, speed)
    for o in scene.objects:
        coming = max(-o.speed_along_mps, 0.0)
        passed = PASSED_M if coming > 0.5 else -scene.ego.length_m
        if o.lane_id != lane.id or o.gap_m is None or end_of(o) < passed:
            continue
        if o.gap_m - (coming + 1.0 if coming > 0.5 else 0.0) * (time + 2.0) < way:
            return f"{o.kind.value} {o.id} in the oncoming lane, {whereabouts(o.gap_m)} at {coming:.1f} m/s"
    return None
