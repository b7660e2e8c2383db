"""Ways past what is in the way: a lane of our direction on the left, on the right, the oncoming lane."""

from __future__ import annotations

from stucksolver.decision import RecoveryPlan, WaitReason
from stucksolver.decision.behaviors import BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.reason.rules.analyse import red_light_within
from stucksolver.reason.rules.passing import Target, blocked, oncoming_blocked, way_to_pass_m
from stucksolver.scene import CandidateWaypoint, LaneRelation, LineKind, Scene, SceneLane

RECOVERY_SPEED_MPS = 5.0
GUIDED_SPEED_MPS = 11.0
LEAST_SPEED_MPS = 2.0
SLOW_MPS = 2.2
REMEMBERED_S = 30.0


Why = tuple[WaitReason | None, str]
Way = tuple[RecoveryPlan | None, Why]
"""A plan with its reason, or None with the reason for waiting."""


def has_failed(scene: Scene, *words: str) -> bool:
    """Was a plan of the last half minute refused or given up for one of these reasons, or of one of these names?"""
    recent = [a for a in scene.attempts if scene.time_s - a.time_s < REMEMBERED_S]
    return any(word in a.outcome or word in a.behaviors for a in recent for word in words)


def speed_for(scene: Scene, target: Target) -> float:
    """Walking pace where more was refused for want of clearance; more than usual for what moves, when asked."""
    if has_failed(scene, "vulnerable_clearance", "door_may_open"):
        return SLOW_MPS
    if scene.guidance is None or target.speed_mps < 0.5:
        return RECOVERY_SPEED_MPS
    return round(min(max(scene.speed_limit_mps or 8.0, LEAST_SPEED_MPS), GUIDED_SPEED_MPS), 1)


def way_past(scene: Scene, target: Target, speed: float) -> Way:
    """The first way past that is open."""
    available = {b.name for b in scene.behaviors}
    light = red_light_within(scene, way_to_pass_m(scene, target, speed)[0])
    if light is not None:
        return None, (WaitReason.LIGHT, light)
    beside = _lane_beside_the_route(scene)
    if beside is not None and {"keep_lane", "change_lane"} <= available:
        return _go_on_beside(scene, beside, target, speed)
    why: Why = (WaitReason.NO_SAFE_WAY, "there is no lane to go round in")
    if "change_lane" in available:
        for where in (LaneRelation.LEFT, LaneRelation.RIGHT):
            lane = lane_of(scene, where)
            if lane is None or lane.line is LineKind.KERB:
                continue
            busy = blocked(scene, lane, target, speed)
            if busy is None:
                return _by_lane_change(scene, lane, target, speed)
            why = (WaitReason.YIELD, busy)
    oncoming = lane_of(scene, LaneRelation.ONCOMING)
    if oncoming is not None and "borrow_oncoming_lane" in available and why[0] is WaitReason.NO_SAFE_WAY:
        busy = oncoming_blocked(scene, oncoming, target, speed)
        if busy is None:
            return _by_oncoming_lane(target, speed)
        why = (WaitReason.YIELD, busy)
    return None, why


def lane_of(scene: Scene, where: LaneRelation) -> SceneLane | None:
    """The nearest lane in a relation (lists keep the stack's order: from the route outwards)."""
    return next((lane for lane in scene.lanes if lane.relation is where), None)


def _by_lane_change(scene: Scene, lane: SceneLane, target: Target, speed: float) -> Way:
    way, _ = way_to_pass_m(scene, target, speed)
    side = "left" if lane.relation is LaneRelation.LEFT else "right"
    distance = round(min(max(way, 20.0), 150.0), 1)
    out = ChangeLane(side="left" if side == "left" else "right", distance_m=distance, speed_mps=speed)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    start = _waypoint_in(scene, lane, distance)
    if start is not None and _return_was_refused(scene):
        plan = RecoveryPlan(behaviors=(out,), replan_route=True, route_start=start.id)
        return plan, (None, f"pass {who} in the {side} lane and plan the route anew from there")
    back = ChangeLane(side="right" if side == "left" else "left", distance_m=25.0, speed_mps=speed)
    return RecoveryPlan(behaviors=(out, back)), (None, f"pass {who} in the {side} lane, then return")


def _lane_beside_the_route(scene: Scene) -> SceneLane | None:
    """The lane of our direction beside the route's in which the ego is, None where it is in another."""
    return next(
        (
            lane
            for lane in scene.lanes
            if lane.id == scene.ego.lane_id and lane.relation in (LaneRelation.LEFT, LaneRelation.RIGHT)
        ),
        None,
    )


def _go_on_beside(scene: Scene, lane: SceneLane, target: Target, speed: float) -> Way:
    """Half-way past already: on in the lane beside until there is room to come back."""
    busy = blocked(scene, lane, target, speed)
    if busy is not None:
        return None, (WaitReason.YIELD, busy)
    way, _ = way_to_pass_m(scene, target, speed)
    on = KeepLane(distance_m=round(min(max(way, 5.0), 150.0), 1), speed_mps=speed)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    if _return_was_refused(scene):
        return RecoveryPlan(behaviors=(on,)), (None, f"go on past {who} in the lane beside")
    back = ChangeLane(side="right" if lane.relation is LaneRelation.LEFT else "left", distance_m=25.0, speed_mps=speed)
    return RecoveryPlan(behaviors=(on, back)), (None, f"go on past {who} in the lane beside, then return")


def _return_was_refused(scene: Scene) -> bool:
    """Did an earlier plan of this episode with a change back fail?"""
    return any(len(a.behaviors) > 1 and a.behaviors[-1] == "change_lane" for a in scene.attempts)


def _waypoint_in(scene: Scene, lane: SceneLane, distance_m: float) -> CandidateWaypoint | None:
    """The first candidate for a new route that lies in a lane beyond a distance."""
    fitting = [
        w
        for w in scene.waypoints
        if w.lane_id == lane.id and w.distance_m >= distance_m and w.reaches_destination is not False
    ]
    return min(fitting, key=lambda w: w.distance_m, default=None)


def _by_oncoming_lane(target: Target, speed: float) -> Way:
    behavior = BorrowOncomingLane(past_object_id=target.far.id, speed_mps=speed)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    return RecoveryPlan(behaviors=(behavior,)), (None, f"pass {who} through the oncoming lane")
