"""Small moves that make room: over a bag, aside within the lane, back for room, aside or back to see more."""

from __future__ import annotations

import math

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import (
    AnyBehavior,
    BackUp,
    BorrowOncomingLane,
    ChangeLane,
    DriveOver,
    KeepLane,
    NoseOut,
    Nudge,
)
from stucksolver.reasoners.rules.pass_options import RECOVERY_SPEED_MPS, SLOW_MPS, Way, is_drivable_over, lane_of
from stucksolver.reasoners.rules.pass_target import PassTarget
from stucksolver.reasoners.rules.recent_attempts import came_too_near, failed_for, has_been_tried, often_failed_for
from stucksolver.scene import VULNERABLE, LaneRelation, PlanFailure, RejectCode, Scene, SceneLane, SceneObject

SWING_M, ROOM_M = 4.5, 7.0
"""If the obstacle is nearer than the first distance, the ego backs up to the second before it swings out."""
MORE_M, ENOUGH_M = 4.0, 12.0
"""If that was still too near, it backs up by the first distance more, up to the second."""
REAR_MARGIN_M, LOOK_REAR_MARGIN_M = 2.5, 8.0
"""Distance kept behind when backing up for room, and to see more (m). The guard checks for traffic."""
SIGHT_ENDS_M = 1.1
"""The sight of sensors ends up to this far before a vehicle."""
BESIDE_M = 0.55
LOOK_M = 6.0
LOOK_ROOM_M = 9.0
BACK_M = 8.0
RUN_UP_M = 5.0
FAR_M = 18.0
MOST_MOVES = 4
ASIDE_M = 0.8
LEAST_ASIDE_M = 0.2
LOST_M = 0.25
"""What localization may be off, the guard takes from the room beside the ego in its lane (m)."""
CLEAR_OF_M = 0.2
SWING_OUT_M = 10.0
STREAM_TRIES = 2
"""Traffic is a stream once it has left no gap this often. Turning out takes some 10 s, in which a gap may come."""
NOSE_ROOM_M = 6.0
"""Before it turns its nose out, the ego backs up to this distance if it can: 5 m are too few before a usual car."""


def drive_over_plan(scene: Scene, lead: SceneObject) -> Way | None:
    """Return a plan to drive over what is soft, low, seen long enough and away from everyone; None otherwise."""
    if not is_drivable_over(scene, lead):
        return None
    return RecoveryPlan(behaviors=(DriveOver(object_id=lead.id),)), (None, f"drive over {lead.kind.value} {lead.id}")


def nudge_plan(scene: Scene, target: PassTarget) -> Way | None:
    """Return a plan past an obstacle within the ego's lane; None if it leaves too little of the lane free."""
    lane = lane_of(scene, LaneRelation.EGO)
    distance = target.end_m + scene.ego.length_m + 1.0
    if lane is None or not scene.offers("nudge") or target.speed_mps > 0.1 or not 3.0 <= distance <= 40.0:
        return None
    if any(o.kind in VULNERABLE for o in target.objects):
        return None
    half = scene.ego.width_m / 2
    most = lane.width_m / 2 - half - 0.1
    left = max(o.left_edge_m for o in target.objects) + BESIDE_M + half
    right = min(o.right_edge_m for o in target.objects) - BESIDE_M - half
    here = scene.ego.lateral_offset_m
    for side, aside in (("left", left - here), ("right", here - right)):
        fits = left <= most if side == "left" else right >= -most
        if fits and 0.2 <= aside <= 1.5:
            nudge = Nudge(
                side="left" if side == "left" else "right",
                offset_m=round(aside, 2),
                distance_m=round(distance, 1),
                speed_mps=SLOW_MPS,
            )
            return RecoveryPlan(behaviors=(nudge,)), (None, f"there is room on the {side} within the lane")
    return None


def prepend_nose_out(scene: Scene, lead: SceneObject, plan: RecoveryPlan) -> RecoveryPlan:
    """Return the same plan, with the nose turned out first, if traffic left no gap for it from inside the lane.

    The plan then waits at the border and begins in a gap that would be too short for a start from inside the lane.
    The front camera does not see past a car that stands close ahead, not even over its roof. From the
    border it sees more.
    """
    wanted = often_failed_for(scene, STREAM_TRIES, RejectCode.LANE_ENTRY, RejectCode.ONCOMING_GAP)
    wanted |= bool(lead.position_sd_m) and often_failed_for(scene, STREAM_TRIES, RejectCode.ONCOMING_SIGHT)
    if (
        not wanted
        or has_been_tried(scene, "nose_out")
        or lead.speed_along_mps > 0.2
        or scene.ego.speed_mps > 0.2
        or not scene.offers("nose_out")
    ):
        return plan
    first, *rest = plan.behaviors
    backs: list[AnyBehavior] = []
    if isinstance(first, BackUp) and rest:
        backs, (first, *rest) = [first], rest
    if not isinstance(first, ChangeLane | BorrowOncomingLane):
        return plan
    gap = lead.gap_m or 0.0
    way = _back_m(scene, lead, max(ROOM_M - gap, 1.0)) if not backs and gap < NOSE_ROOM_M else None
    if way is not None:
        backs = [BackUp(distance_m=way)]
    nose = NoseOut(side=first.side if isinstance(first, ChangeLane) else "left")
    return plan.model_copy(update={"behaviors": (*backs, nose, first, *rest)})


def prepend_back_up(scene: Scene, lead: SceneObject, plan: RecoveryPlan) -> RecoveryPlan:
    """Return the same plan, preceded by backing up if the ego stands too near to swing out."""
    gap = lead.gap_m or 0.0
    failed = failed_for(scene, PlanFailure.NO_SPACE_TO_PULL_AROUND) or came_too_near(scene, (lead,))
    near = gap < SWING_M or (failed and gap < ENOUGH_M)
    room = max(ROOM_M, min(gap + MORE_M, ENOUGH_M)) if failed else ROOM_M
    way = _back_m(scene, lead, min(max(room - gap, 1.0), 8.0))
    if not near or scene.ego.speed_mps > 0.2 or lead.speed_along_mps > 0.2 or way is None:
        return plan
    return plan.model_copy(update={"behaviors": (BackUp(distance_m=way), *plan.behaviors)})


def _back_m(scene: Scene, lead: SceneObject, wanted_m: float) -> float | None:
    """Return the distance to back up (m), as wanted or as there is room; None if that is too little to help.

    The guard asks for sight, and if it has refused for that, sensors see less far than to who stands behind.
    """
    unseen = bool(lead.position_sd_m) and failed_for(scene, RejectCode.PATH_NOT_VISIBLE)
    margin_m = REAR_MARGIN_M + (SIGHT_ENDS_M if unseen else 0.0)
    ways = (math.floor(10.0 * wanted_m * share) / 10.0 for share in (1.0, 0.75, 0.5, 0.35))
    return next((way for way in ways if way >= 1.0 and may_back_up(scene, way, margin_m)), None)


def prepend_moves_for_sight(scene: Scene, target: PassTarget, plan: RecoveryPlan) -> Way | None:
    """Return the same plan after moves that show more of the road: back, aside to the middle of it, and further back.

    Behind a van at 5 m, some 24 m of the oncoming lane are seen from the lane's center; at 15 m, 0.75 m aside, 188 m.
    The pass must follow at once, because the stack by itself drives up to the van again.
    """
    lead, lane = target.objects[0], lane_of(scene, LaneRelation.EGO)
    gap = start = lead.gap_m or 0.0
    # A move that has not shown enough once will not show more the next time. Sensors' sight wavers: a plan that only
    # backed up to swing out may have begun on a sight that was gone the next moment, and was no look around.
    sensed = any(o.position_sd_m for o in target.objects)
    back = _back_to_see(scene, lead, plan) if sensed else None
    if back is not None:
        return back
    moves_to_look = {"nudge"} if sensed else {"back_up", "nudge"}
    looked = any(moves_to_look & set(a.behaviors) for a in scene.attempts)
    if looked or scene.ego.speed_mps > 0.2 or not scene.offers("nudge", "back_up"):
        return None
    moves: list[BackUp | Nudge] = []
    if gap < LOOK_ROOM_M and may_back_up(scene, BACK_M, LOOK_REAR_MARGIN_M):
        moves, gap = [BackUp(distance_m=BACK_M, speed_mps=2.0)], gap + BACK_M
    if gap < LOOK_M + 1.5:
        return None
    aside = ASIDE_M if lane is None or not sensed else min(ASIDE_M, _room_left_m(scene, lane) - LOST_M)
    if aside < LEAST_ASIDE_M:
        return None
    moves.append(Nudge(side="left", offset_m=round(aside, 2), distance_m=LOOK_M, speed_mps=1.5))
    gap -= LOOK_M
    hides = _hides_from_aside(scene, target)
    further, step = (FAR_M, BACK_M) if hides else (SWING_OUT_M, max(SWING_OUT_M - gap, 1.0))
    while gap < further and len(moves) < MOST_MOVES and may_back_up(scene, gap + step - start, LOOK_REAR_MARGIN_M):
        moves, gap = [*moves, BackUp(distance_m=round(step, 1), speed_mps=2.0)], gap + step
    if gap < SWING_M:
        return None
    whole = plan.model_copy(update={"behaviors": (*moves, *plan.behaviors)})
    return whole, (None, f"back up and move aside to see past {lead.id}, then pass")


def _back_to_see(scene: Scene, lead: SceneObject, plan: RecoveryPlan) -> Way | None:
    """Return the same plan after backing up, to where the camera sees past the target; None if that showed too little.

    The plan then waits there for its gap. Moves aside to see still more take half a minute, in which somebody comes.
    From there the ego first drives on in its lane: in motion it is in the oncoming lane for less time, so that no more
    of it must be seen than from nearby.
    """
    back = BackUp(distance_m=BACK_M, speed_mps=2.0)
    on = KeepLane(distance_m=RUN_UP_M, speed_mps=RECOVERY_SPEED_MPS)
    whole = plan.model_copy(update={"behaviors": (back, on, *plan.behaviors)})
    names = tuple(b.name for b in whole.behaviors)
    in_vain = any(a.behaviors == names and set(a.codes) == {RejectCode.ONCOMING_SIGHT} for a in scene.attempts)
    near = (lead.gap_m or 0.0) < LOOK_ROOM_M and scene.ego.speed_mps <= 0.2 and lead.speed_along_mps <= 0.2
    enough = (lead.gap_m or 0.0) + BACK_M - RUN_UP_M >= ROOM_M
    if in_vain or not near or not enough or not scene.offers("keep_lane"):
        return None
    if not may_back_up(scene, BACK_M, LOOK_REAR_MARGIN_M):
        return None
    return whole, (None, f"back up to see past {lead.id}, then pass")


def _hides_from_aside(scene: Scene, target: PassTarget) -> bool:
    """True if the target hides the oncoming lane even from the lane's left border: then only distance helps."""
    lane = lane_of(scene, LaneRelation.EGO)
    if lane is None:
        return True
    eye = min(scene.ego.lateral_offset_m + ASIDE_M, (lane.width_m - scene.ego.width_m) / 2)
    return any(o.left_edge_m > eye - CLEAR_OF_M for o in target.objects)


def _room_left_m(scene: Scene, lane: SceneLane) -> float:
    """Return how far the ego may go to the left within its lane (m)."""
    return (lane.width_m - scene.ego.width_m) / 2 - scene.ego.lateral_offset_m


def may_back_up(scene: Scene, way_m: float, margin_m: float) -> bool:
    """True if the ego's lane is free behind for `way_m` plus a margin (m)."""
    lane = lane_of(scene, LaneRelation.EGO)
    free = None if lane is None else lane.free_behind_m
    return scene.offers("back_up") and free is not None and free >= way_m + margin_m
