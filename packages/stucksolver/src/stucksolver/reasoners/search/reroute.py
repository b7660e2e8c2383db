"""Another road to the destination, when no plan leads on along this one."""

from __future__ import annotations

import math

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import ReplanRoute
from stucksolver.reasoners.rules.analyze import blocker
from stucksolver.reasoners.rules.detour import detour_starts
from stucksolver.reasoners.rules.pass_target import is_staying
from stucksolver.reasoners.rules.recent_attempts import has_been_tried
from stucksolver.reasoners.rules.turn_back import turning_round
from stucksolver.scene import Scene

BLOCKED_S, TURN_S = 20.0, 60.0
"""The ego has been stopped this long before it takes another road, and before it turns around for one (s). Ours."""


def new_route(scene: Scene, why: str) -> tuple[RecoveryPlan, None, str] | None:
    """Return a plan to plan the route anew from here; None if that has just been tried."""
    if has_been_tried(scene, "replan") or not scene.offers("replan"):
        return None
    return RecoveryPlan(behaviors=(ReplanRoute(),)), None, f"{why}: plan the route anew"


def reroute(scene: Scene, why: str) -> tuple[RecoveryPlan, None, str] | None:
    """Return a plan to take another road, with its reason; None if there is none, or if it is too soon."""
    if scene.guidance is not None or has_been_tried(scene, "replan"):
        return None
    lead = blocker(scene)
    stays = lead is None or is_staying(lead)
    start = min(detour_starts(scene), key=lambda w: w.route_length_m or math.inf, default=None)
    if start is not None and stays and scene.ego.stopped_for_s >= BLOCKED_S and scene.offers("replan"):
        return RecoveryPlan(behaviors=(ReplanRoute(route_start=start.id),)), None, f"{why}: take another road"
    if lead is None or not stays or scene.ego.stopped_for_s < TURN_S:
        return None
    turn = turning_round(scene, lead, why)
    return None if turn is None or turn[0] is None else (turn[0], None, turn[1][1])
