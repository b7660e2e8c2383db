"""Ways past an obstacle: a lane in the ego's direction on the left or right, or the oncoming lane."""

from __future__ import annotations

import math
from typing import Literal

from stucksolver.plan import RecoveryPlan, WaitReason
from stucksolver.plan.behaviors import AnyBehavior, BorrowOncomingLane, ChangeLane, DriveOver, KeepLane
from stucksolver.reasoners.rules.analyze import red_light_within
from stucksolver.reasoners.rules.pass_speed import pass_speed, seen_enough
from stucksolver.reasoners.rules.pass_target import (
    PassTarget,
    describe_blocked_lane,
    end_of,
    in_lane_beside,
    is_staying,
    oncoming_blocked,
    pass_distance_m,
    too_narrow,
)
from stucksolver.reasoners.rules.recent_attempts import came_too_near, failed_for, has_been_tried, recent
from stucksolver.scene import (
    PASSABLE_KINDS,
    VULNERABLE,
    CandidateWaypoint,
    Claim,
    DirectedSide,
    GuidanceIntent,
    Interpretation,
    LaneRelation,
    LineKind,
    RejectCode,
    Scene,
    SceneLane,
    SceneObject,
)

RECOVERY_SPEED_MPS = 5.5
"""Just under the 20 km/h of a recovery: a faster pass is shorter and needs less sight of the oncoming lane (m/s)."""
GUIDED_SPEED_MPS = 11.0
SLOW_MPS = 2.2
CLOSE_MPS = 3.0
"""Of a pass in an adjacent lane, if objects look larger than they are: the slower it is, the nearer it may come."""
OVER_HEIGHT_M = 0.15
OVER_SEEN_S = 1.0
OVER_CONFIDENCE, CONFIRMED_CONFIDENCE = 0.8, 0.5
"""Smallest confidence of its class; the second if a passenger says that it is only a bag. Both as in the guard."""
LIVING_M = 2.5
BEFORE_OVER_M, BEYOND_OVER_M = 6.0, 2.0
"""The ego is in its lane this far before an object that it drives over, and its rear is this far past it after (m)."""

PASSING = frozenset({RejectCode.COLLISION, RejectCode.GAP, RejectCode.LANE_ENTRY})
"""Refusals that are over once somebody has driven by."""
UP_TO_M, LEAST_WAY_M = 4.0, 2.0
"""The ego stops this far before a thing to see it better, and does not move for less (m)."""
BESIDE_US_M = 3.0
"""What stands in the route's lane up to this distance ahead is passed before the return (m)."""
STANDS_MPS, OVER_WITHIN_M = 0.2, 20.0
"""The ego stands if it is no faster (m/s). What is further ahead in the lane beside is left for later (m)."""

Why = tuple[WaitReason | None, str]
Way = tuple[RecoveryPlan | None, Why]
"""A plan with its reason, or None with the reason for waiting."""


def requested_interpretation(scene: Scene) -> Interpretation | None:
    """Return the reading of what the passenger said, or None."""
    return None if scene.guidance is None else scene.guidance.reading


def speed_for(scene: Scene, target: PassTarget) -> float:
    """Return the speed of a pass (m/s): walking pace after a refusal for clearance, more if asked to overtake.

    The guard allows more only within known limits, and with room beside people and doors.
    """
    # At walking pace nothing that moves is passed.
    if target.speed_mps < 0.5 and failed_for(scene, RejectCode.CLEARANCE, RejectCode.DOOR):
        return SLOW_MPS
    reading = requested_interpretation(scene)
    if reading is None or reading.intent is not GuidanceIntent.OVERTAKE:
        return RECOVERY_SPEED_MPS
    # A faster pass is over sooner, so less of the oncoming lane must be seen to be free.
    if target.speed_mps < 0.5 and not failed_for(scene, RejectCode.ONCOMING_SIGHT, RejectCode.ONCOMING_GAP):
        return RECOVERY_SPEED_MPS
    if failed_for(scene, RejectCode.OVERSPEED) or scene.speed_limit_mps is None:
        return RECOVERY_SPEED_MPS
    # Rounded down: the guard allows not a hair more than the limit.
    limit = math.floor(10.0 * scene.speed_limit_mps) / 10.0
    return min(max(limit, RECOVERY_SPEED_MPS), GUIDED_SPEED_MPS)


def is_drivable_over(scene: Scene, o: SceneObject) -> bool:
    """True if it is soft, low, seen long enough and away from everyone, and driving over it has not just failed."""
    needed = CONFIRMED_CONFIDENCE if Claim.SOFT_OBJECT in scene.claims else OVER_CONFIDENCE
    sure = o.kind in PASSABLE_KINDS and (o.kind_confidence or 0.0) >= needed
    low = o.height_m <= OVER_HEIGHT_M and (o.seen_for_s or 0.0) >= OVER_SEEN_S
    living = any(
        other.kind in VULNERABLE and math.hypot(other.x_m - o.x_m, other.y_m - o.y_m) < LIVING_M
        for other in scene.objects
    )
    return sure and low and not living and scene.offers("drive_over") and not _over_has_failed(scene, o)


def _over_has_failed(scene: Scene, o: SceneObject) -> bool:
    """True if driving over has just failed; if sensors see the thing, not for somebody who has driven by since."""
    if not o.position_sd_m:
        return has_been_tried(scene, "drive_over")
    tried = (a for a in recent(scene) if "drive_over" in a.behaviors)
    return any(a.failures or not set(a.codes) <= PASSING for a in tried)


def find_pass(scene: Scene, target: PassTarget, speed: float) -> Way:
    """Return the first way past that is open, or why there is none. `speed`: of the pass (m/s)."""
    light = red_light_within(scene, pass_distance_m(scene, target, speed)[0])
    if light is not None:
        return None, (WaitReason.LIGHT, light)
    beside = _lane_beside_the_route(scene)
    if beside is not None and scene.offers("keep_lane", "change_lane"):
        return _go_on_beside(scene, beside, target, speed)
    reading = requested_interpretation(scene)
    side = reading.side if reading is not None and reading.intent is GuidanceIntent.OVERTAKE else None
    where_asked = "" if side is None else f" on the {side.value}, as the passenger asks"
    why: Why = (WaitReason.NO_SAFE_WAY, f"there is no lane to pass in{where_asked}")
    if scene.offers("change_lane"):
        for where in (LaneRelation.LEFT, LaneRelation.RIGHT):
            if side is not None and where.value != side.value:
                continue
            lane = lane_of(scene, where)
            if lane is None or lane.line is LineKind.KERB:
                continue
            ahead = in_lane_beside(scene, lane, target, speed)
            if all(is_drivable_over(scene, o) for o in ahead):
                return _by_lane_change(scene, lane, target, speed, ahead)
            if why[0] is not WaitReason.YIELD:
                why = _why_not_beside(ahead)
    oncoming = lane_of(scene, LaneRelation.ONCOMING)
    is_next = lane_of(scene, LaneRelation.LEFT) is None and side is not DirectedSide.RIGHT
    if oncoming is not None and is_next and scene.offers("borrow_oncoming_lane") and why[0] is WaitReason.NO_SAFE_WAY:
        narrow = too_narrow(scene, oncoming, target)
        if narrow is not None:
            return None, (WaitReason.NO_SAFE_WAY, narrow)
        if speed < RECOVERY_SPEED_MPS and not seen_enough(scene, oncoming, target, speed):
            speed = RECOVERY_SPEED_MPS
        busy = oncoming_blocked(scene, oncoming, target, speed)
        if busy is None:
            return _by_oncoming_lane(target, pass_speed(scene, oncoming, target, speed))
        why = (WaitReason.YIELD, busy)
    return None, why


def lane_of(scene: Scene, where: LaneRelation) -> SceneLane | None:
    """Return the nearest lane with a relation to the route, or None. Lanes are listed from the route outwards."""
    return next((lane for lane in scene.lanes if lane.relation is where), None)


def _why_not_beside(ahead: tuple[SceneObject, ...]) -> Why:
    """Return why the adjacent lane is blocked. Waiting helps only if everything there will move on by itself."""
    lasting = next((o for o in ahead if is_staying(o) and o.kind not in PASSABLE_KINDS), None)
    lasting = lasting or next((o for o in ahead if is_staying(o)), None)
    return (
        (WaitReason.YIELD, describe_blocked_lane(ahead[0]))
        if lasting is None
        else (WaitReason.NO_SAFE_WAY, describe_blocked_lane(lasting))
    )


def _by_lane_change(
    scene: Scene, lane: SceneLane, target: PassTarget, speed: float, over: tuple[SceneObject, ...] = ()
) -> Way:
    """Return a plan to change lanes, pass the target, drive over what may be driven over there, and return."""
    if came_too_near(scene, target.objects):
        speed = min(speed, CLOSE_MPS)
    way, _ = pass_distance_m(scene, target, speed)
    side: Literal["left", "right"] = "left" if lane.relation is LaneRelation.LEFT else "right"
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    what = "".join(f", over {o.kind.value} {o.id}" for o in over)
    behaviors = _out_and_over(scene, side, way, speed, over)
    start = _waypoint_in(scene, lane, min(max(way, 20.0), 150.0))
    if start is not None and _return_was_refused(scene):
        plan = RecoveryPlan(behaviors=behaviors, replan_route=True, route_start=start.id)
        return plan, (None, f"pass {who} in the {side} lane{what}, and replan the route from there")
    return RecoveryPlan(behaviors=(*behaviors, _back_from(lane, speed))), (
        None,
        f"pass {who} in the {side} lane{what}, then return",
    )


def _out_and_over(
    scene: Scene, side: Literal["left", "right"], way_m: float, speed: float, over: tuple[SceneObject, ...]
) -> tuple[AnyBehavior, ...]:
    """Return the behaviors into the adjacent lane and along it; at walking pace if they drive over something."""
    if not over:
        return (ChangeLane(side=side, distance_m=round(min(max(way_m, 20.0), 150.0), 1), speed_mps=speed),)
    before = round(min(max((over[0].gap_m or 0.0) - BEFORE_OVER_M, 15.0), 150.0), 1)
    out = ChangeLane(side=side, distance_m=before, speed_mps=min(speed, SLOW_MPS))
    onward = way_m - max(end_of(o) for o in over) - scene.ego.length_m - BEYOND_OVER_M
    on = (KeepLane(distance_m=round(min(max(onward, 5.0), 150.0), 1), speed_mps=speed),) if onward > 0.0 else ()
    return (out, *(DriveOver(object_id=o.id) for o in over), *on)


def _lane_beside_the_route(scene: Scene) -> SceneLane | None:
    """Return the lane that the ego is in if it is adjacent to the route's in the same direction, else None."""
    return next(
        (
            lane
            for lane in scene.lanes
            if lane.id == scene.ego.lane_id and lane.relation in (LaneRelation.LEFT, LaneRelation.RIGHT)
        ),
        None,
    )


def _go_on_beside(scene: Scene, lane: SceneLane, target: PassTarget, speed: float) -> Way:
    """Return a plan for an ego that is half-way past: go on in the adjacent lane until there is room to return."""
    ahead = in_lane_beside(scene, lane, target, speed)
    if ahead:
        return pass_from_adjacent_lane(scene) or (None, _why_not_beside(ahead))
    if came_too_near(scene, target.objects):
        speed = min(speed, CLOSE_MPS)
    way, _ = pass_distance_m(scene, target, speed)
    on = KeepLane(distance_m=round(min(max(way, 5.0), 150.0), 1), speed_mps=speed)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    if _return_was_refused(scene):
        return RecoveryPlan(behaviors=(on,)), (None, f"go on past {who} in the adjacent lane")
    return RecoveryPlan(behaviors=(on, _back_from(lane, speed))), (
        None,
        f"go on past {who} in the adjacent lane, then return",
    )


def pass_from_adjacent_lane(scene: Scene) -> Way | None:
    """Return a plan for an ego that stands in the lane beside the route's: a pass was given up.

    It drives over what is soft there, and changes back. Up to anything else that sensors see there it drives to see it
    better: from nearby, a bag is measured to be low. If nothing is there any more, it goes on past what stands in the
    route's lane, and changes back. None if it stands elsewhere, or if nothing of this helps.
    """
    lane = _lane_beside_the_route(scene)
    if lane is None or scene.ego.speed_mps > STANDS_MPS or not scene.offers("change_lane"):
        return None
    near = [o for o in scene.objects if o.lane_id == lane.id and 0.0 < (o.gap_m or 0.0) < OVER_WITHIN_M]
    ahead = sorted(near, key=lambda o: o.gap_m or 0.0)
    if ahead and all(is_drivable_over(scene, o) for o in ahead):
        over = tuple(DriveOver(object_id=o.id) for o in ahead)
        what = ", ".join(f"{o.kind.value} {o.id}" for o in ahead)
        plan = RecoveryPlan(behaviors=(*over, _back_from(lane, SLOW_MPS)))
        return plan, (None, f"drive over {what} in the adjacent lane, then return")
    if not scene.offers("keep_lane"):
        return None
    return _up_to(ahead[0]) if ahead else _on_and_back(scene, lane)


def _up_to(o: SceneObject) -> Way | None:
    """Return a plan to drive up to a thing that sensors see ahead; None if it is near already, or a road user."""
    way_m = round((o.gap_m or 0.0) - UP_TO_M, 1)
    if not o.position_sd_m or not is_staying(o) or way_m < LEAST_WAY_M:
        return None
    plan = RecoveryPlan(behaviors=(KeepLane(distance_m=way_m, speed_mps=SLOW_MPS),))
    return plan, (None, f"drive up to {o.kind.value} {o.id} to see it better")


def _on_and_back(scene: Scene, lane: SceneLane) -> Way | None:
    """Return a plan past what sensors see standing beside the ego in the route's lane, then back; or None."""
    own = lane_of(scene, LaneRelation.EGO)
    beside = [
        o
        for o in scene.objects
        if own is not None
        and o.lane_id == own.id
        and o.position_sd_m
        and abs(o.speed_along_mps) < STANDS_MPS
        and -scene.ego.length_m < end_of(o)
        and (o.gap_m or 0.0) < BESIDE_US_M
    ]
    if not beside:
        return None
    way_m = round(max(end_of(o) for o in beside) + scene.ego.length_m + BEYOND_OVER_M, 1)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in beside)
    on = KeepLane(distance_m=max(way_m, 5.0), speed_mps=SLOW_MPS)
    plan = RecoveryPlan(behaviors=(on, _back_from(lane, SLOW_MPS)))
    return plan, (None, f"the adjacent lane is free again: go on past {who}, then return")


def _back_from(lane: SceneLane, speed: float) -> ChangeLane:
    """Return the change from a lane beside the route's back into it."""
    side: Literal["left", "right"] = "right" if lane.relation is LaneRelation.LEFT else "left"
    return ChangeLane(side=side, distance_m=25.0, speed_mps=speed)


def _return_was_refused(scene: Scene) -> bool:
    """True if an earlier plan of this episode with a change back failed."""
    return any(len(a.behaviors) > 1 and a.behaviors[-1] == "change_lane" for a in scene.attempts)


def _waypoint_in(scene: Scene, lane: SceneLane, distance_m: float) -> CandidateWaypoint | None:
    """Return the first candidate waypoint in a lane beyond a distance (m), or None."""
    fitting = [
        w
        for w in scene.waypoints
        if w.lane_id == lane.id and w.distance_m >= distance_m and w.reaches_destination is not False
    ]
    return min(fitting, key=lambda w: w.distance_m, default=None)


def _by_oncoming_lane(target: PassTarget, speed: float) -> Way:
    behavior = BorrowOncomingLane(past_object_id=target.far.id, speed_mps=speed)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    at = f"at {3.6 * speed:.0f} km/h"
    return RecoveryPlan(behaviors=(behavior,)), (None, f"pass {who} through the oncoming lane {at}")
