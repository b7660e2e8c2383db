"""Other roads to the destination: where they begin ahead, and the turn to one behind."""

from __future__ import annotations

import math

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import AnyBehavior, BackUp, ReplanRoute, TurnAround
from stucksolver.reasoners.duties.proposal import Proposal, propose
from stucksolver.reasoners.duties.recent_attempts import failed_for, has_been_tried
from stucksolver.reasoners.duties.standoffs import may_back_up
from stucksolver.scene import CandidateWaypoint, PlanFailure, Scene, SceneObject

ROOM_M = 7.0
"""How far the first leg of a turn reaches along the road (m): a circle of 6 m, and a little more."""
BACK_MPS = 1.5
"""Speed of backing up before a turn (m/s)."""
STANDS_MPS = 0.2
"""The ego is stopped if it is not faster (m/s)."""
LEAST_BACK_M, MOST_BACK_M = 1.0, 8.0
"""The shortest and the longest distance to back up (m)."""
REAR_MARGIN_M = 2.5
"""Distance kept behind (m). The guard checks for traffic."""
ABREAST_M = 1.0
"""How far behind the ego's center another road may begin for the ego to turn into it (m). Ours."""
BEHIND_M = 3.0
"""The same if the ego backs up first (m). Ours."""


def to_other_road(scene: Scene, why: str) -> Proposal | None:
    """Return a plan to take the shortest other road that begins ahead or abreast; None if there is none.

    Where it begins a little behind, the ego backs up first.
    """
    start = _shortest(detour_starts(scene))
    if start is None or not scene.offers("replan"):
        return None
    replan = ReplanRoute(route_start=start.id)
    if start.x_m >= -ABREAST_M:
        return propose(scene, why, replan)
    way_m = float(math.ceil(-start.x_m))
    if not may_back_up(scene, way_m, REAR_MARGIN_M):
        return None
    return propose(scene, why, BackUp(distance_m=way_m, speed_mps=BACK_MPS), replan)


def detour_starts(scene: Scene) -> list[CandidateWaypoint]:
    """Return the candidate waypoints on other roads, not far behind, from which the destination can be reached."""
    known = {lane.id for lane in scene.lanes}
    leads = [w for w in scene.waypoints if w.reaches_destination and w.route_length_m and w.lane_id not in known]
    return [w for w in leads if w.x_m >= -BEHIND_M]


def turning_round(scene: Scene, lead: SceneObject | None, why: str) -> Proposal | None:
    """Return a turn, after backing up if the lead is too near, and a new route from the lane in the other direction."""
    start = _shortest(_behind(scene))
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
    return Proposal(plan, f"{why}: turn around and take another road")


def _shortest(starts: list[CandidateWaypoint]) -> CandidateWaypoint | None:
    """Return the one from which the route to the destination is shortest, or None."""
    return min(starts, key=lambda w: w.route_length_m or math.inf, default=None)


def _behind(scene: Scene) -> list[CandidateWaypoint]:
    """Return the candidate waypoints behind, in lanes in the other direction, from which the destination is reached."""
    return [w for w in scene.waypoints if w.x_m < 0.0 and w.reaches_destination and w.route_length_m]
