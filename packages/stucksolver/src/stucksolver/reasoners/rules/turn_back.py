"""Turns round to leave a road that is closed, or blocked for good."""

from __future__ import annotations

import math

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import AnyBehavior, BackUp, TurnAround
from stucksolver.reasoners.rules.detour import is_closed
from stucksolver.reasoners.rules.pass_options import Way
from stucksolver.reasoners.rules.pass_target import is_staying
from stucksolver.reasoners.rules.recent_attempts import failed_for, has_been_tried
from stucksolver.reasoners.rules.small_maneuvers import REAR_MARGIN_M, may_back_up
from stucksolver.scene import CandidateWaypoint, PlanFailure, Scene, SceneObject

CLOSED_S, BLOCKED_S = 8.0, 60.0
"""How long the vehicle is stopped before it turns round: at a closed road, and if no way past was found (s)."""
ROOM_M = 7.0
"""How far the first leg of a turn reaches along the road (m): a circle of 6 m, and a little more."""
BACK_MPS = 1.5
STANDS_MPS = 0.2
LEAST_BACK_M, MOST_BACK_M = 1.0, 8.0
"""The shortest and the longest distance to back up (m)."""


def out_of_closed_road(scene: Scene, lead: SceneObject) -> Way | None:
    """Return a plan to turn round where the road is closed from kerb to kerb; None if that is not possible."""
    if scene.guidance is not None or scene.ego.stopped_for_s < CLOSED_S or not is_closed(scene, lead):
        return None
    return turning_round(scene, lead, f"the road is closed from kerb to kerb by {lead.kind.value} {lead.id}")


def out_of_blocked_road(scene: Scene, lead: SceneObject) -> Way | None:
    """Return a plan to turn round if something that will not move has long left no way past."""
    if scene.guidance is not None or scene.ego.stopped_for_s < BLOCKED_S or not is_staying(lead):
        return None
    return turning_round(scene, lead, f"there is no way past {lead.kind.value} {lead.id}")


def turning_round(scene: Scene, lead: SceneObject | None, why: str) -> Way | None:
    """Return a turn, after backing up if the lead is too near, and a new route from the lane in the other direction."""
    start = min(_behind(scene), key=lambda w: w.route_length_m or math.inf, default=None)
    failed = has_been_tried(scene, "turn_round") and failed_for(scene, PlanFailure.NO_ROOM_TO_TURN)
    if start is None or failed or not scene.offers("turn_round") or scene.ego.speed_mps > STANDS_MPS:
        return None
    moves: tuple[AnyBehavior, ...] = (TurnAround(),)
    missing_m = ROOM_M - (lead.gap_m or 0.0) if lead is not None else 0.0
    # A turn that was given up half-way continues from there.
    if missing_m > 0.0 and not has_been_tried(scene, "turn_round"):
        way_m = math.ceil(min(max(missing_m, LEAST_BACK_M), MOST_BACK_M))
        if not may_back_up(scene, way_m, REAR_MARGIN_M):
            return None
        moves = (BackUp(distance_m=float(way_m), speed_mps=BACK_MPS), *moves)
    plan = RecoveryPlan(behaviors=moves, replan_route=True, route_start=start.id)
    return plan, (None, f"{why}: turn round and take another road")


def _behind(scene: Scene) -> list[CandidateWaypoint]:
    """Return the candidate waypoints behind, in lanes in the other direction, from which the destination is reached."""
    return [w for w in scene.waypoints if w.x_m < 0.0 and w.reaches_destination and w.route_length_m]
