"""Another road to the destination, when no plan leads on along this one."""

from __future__ import annotations

from stucksolver.plan.behaviors import ReplanRoute
from stucksolver.reasoners.duties.analysis import blocker
from stucksolver.reasoners.duties.observation import is_staying
from stucksolver.reasoners.duties.other_roads import to_other_road, turning_round
from stucksolver.reasoners.duties.proposal import Proposal, propose
from stucksolver.reasoners.duties.recent_attempts import has_been_tried
from stucksolver.scene import VEHICLES, Scene

OTHER_ROAD_S = {True: 20.0, False: 8.0}
"""Time stopped before the ego takes another road ahead, behind a vehicle that stays and behind anything else (s). Ours.
"""
TURN_S = {True: 60.0, False: 20.0}
"""The same before it turns around for one (s). Ours."""


def new_route(scene: Scene, why: str) -> Proposal | None:
    """Return a plan to plan the route anew from here; None if that has just been tried, or is not offered."""
    if has_been_tried(scene, "replan") or not scene.offers("replan"):
        return None
    return propose(scene, f"{why}: plan the route anew", ReplanRoute())


def reroute(scene: Scene, why: str) -> Proposal | None:
    """Return a plan to take another road, with its reason; None if there is none, or if it is too soon."""
    if scene.guidance is not None or has_been_tried(scene, "replan"):
        return None
    lead = blocker(scene)
    if lead is not None and not is_staying(lead):
        return None
    vehicle, stopped_s = lead is not None and lead.kind in VEHICLES, scene.ego.stopped_for_s
    other = to_other_road(scene, f"{why}: take another road")
    if other is not None and stopped_s >= OTHER_ROAD_S[vehicle]:
        return other
    return None if lead is None or stopped_s < TURN_S[vehicle] else turning_round(scene, lead, why)
