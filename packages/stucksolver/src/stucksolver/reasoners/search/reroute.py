"""Another road to the destination, when no plan leads on along this one."""

from __future__ import annotations

import math

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import ReplanRoute
from stucksolver.reasoners.rules.analyze import blocker
from stucksolver.reasoners.rules.detour import detour_starts, is_closed
from stucksolver.reasoners.rules.pass_target import is_staying
from stucksolver.reasoners.rules.recent_attempts import has_been_tried
from stucksolver.reasoners.rules.turn_back import turning_round
from stucksolver.scene import VEHICLES, Scene

CLOSED_S, BLOCKED_S, TURN_S = 8.0, 20.0, 60.0
"""Time stopped before the ego takes another road: if only static objects are in the path, if a vehicle is that stays,
and before it turns around for one (s). Ours.
"""


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
    patience_s = BLOCKED_S if lead is not None and lead.kind in VEHICLES else CLOSED_S
    if start is not None and stays and scene.ego.stopped_for_s >= patience_s and scene.offers("replan"):
        return RecoveryPlan(behaviors=(ReplanRoute(route_start=start.id),)), None, f"{why}: take another road"
    if lead is None or not stays or scene.ego.stopped_for_s < (CLOSED_S if is_closed(scene, lead) else TURN_S):
        return None
    turn = turning_round(scene, lead, why)
    return None if turn is None or turn[0] is None else (turn[0], None, turn[1][1])
