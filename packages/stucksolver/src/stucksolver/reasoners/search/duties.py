"""Duties that no plan may pass over: when the ego must wait, whatever the guard would accept."""

from __future__ import annotations

from stucksolver.plan import Analysis, GuidanceIntent, WaitLimits, WaitReason
from stucksolver.reasoners.rules.analyze import NEAR_M, red_light_within
from stucksolver.reasoners.rules.deadlocks import FIRST_TURN_S
from stucksolver.reasoners.rules.no_blocker import LIGHT_AHEAD_M, across_stuck_light
from stucksolver.reasoners.rules.observe import crosses, drives, goes_first
from stucksolver.reasoners.rules.resume_driving import SCENES, STANDS_S, may_hold
from stucksolver.reasoners.search.behavior_grid import IN_LANE_M, nearest_ahead
from stucksolver.scene import VEHICLES, Claim, ObjectKind, Scene


def duty_to_wait(scene: Scene, analysis: Analysis, limits: WaitLimits) -> tuple[WaitReason | None, str] | None:
    """Return why the ego must wait, or None. Lights, people and queues are duties that `analyse` has checked before."""
    lead = nearest_ahead(scene, NEAR_M)
    if lead is not None and lead.kind is ObjectKind.CROSSING_GATE:
        return WaitReason.LIGHT, f"the gate {lead.id} must not be driven around"
    asked = analysis.guidance_intent
    follows = lead is not None and lead.kind in VEHICLES and lead.speed_along_mps > 0.5
    if lead is not None and follows and asked not in (None, GuidanceIntent.OVERTAKE):
        return WaitReason.QUEUE, f"{lead.kind.value} {lead.id} is moving: follow it"
    if lead is not None and crosses(lead) and not lead.hazard_lights:
        return _duty_to_crossing(scene, drives(lead), f"{lead.kind.value} {lead.id}")
    if lead is not None and lead.kind in SCENES and asked is None and scene.ego.stopped_for_s <= limits.yield_s:
        return WaitReason.YIELD, f"{lead.kind.value} {lead.id} holds up the traffic"
    if lead is None and analysis.immobilized:
        return _duty_on_free_road(scene)
    return None


def _duty_to_crossing(scene: Scene, moves: bool, who: str) -> tuple[WaitReason, str] | None:
    if moves:
        return WaitReason.YIELD, f"{who} is crossing the path and goes first"
    if scene.ego.stopped_for_s < FIRST_TURN_S and Claim.WAVED_THROUGH not in scene.claims:
        return WaitReason.YIELD, f"{who} comes from a crossing road and may go first"
    return None


def _duty_on_free_road(scene: Scene) -> tuple[WaitReason | None, str] | None:
    """Return the duty of an ego that is stopped on a free road: the stack is given time to set off by itself."""
    light = red_light_within(scene, LIGHT_AHEAD_M)
    if light is not None:
        # After the limit of this wait, an operator may approve crossing the line.
        return None if across_stuck_light(scene) is not None else (WaitReason.LIGHT, light)
    on_route = abs(scene.ego.lateral_offset_m) < IN_LANE_M
    if on_route and goes_first(scene) is None and scene.guidance is None and scene.ego.stopped_for_s < STANDS_S:
        return None, f"nothing is in the path, and the vehicle has been stopped for {scene.ego.stopped_for_s:.0f} s"
    holds = may_hold(scene)
    return None if holds is None else (WaitReason.YIELD, holds)
