"""Duties that no plan may pass over: when the ego must wait, whatever the guard would accept."""

from __future__ import annotations

from stucksolver.plan import Analysis, GuidanceIntent, WaitLimits, WaitReason
from stucksolver.reasoners.duties.analysis import LIGHT_AHEAD_M, NEAR_M, red_light_within
from stucksolver.reasoners.duties.observation import crosses, drives, goes_first
from stucksolver.reasoners.duties.proposal import Proposal
from stucksolver.reasoners.duties.recent_attempts import has_been_tried
from stucksolver.reasoners.duties.right_of_way import SCENES, STANDS_S, may_hold
from stucksolver.reasoners.duties.standoffs import FIRST_TURN_S
from stucksolver.scene import VEHICLES, Claim, ControlKind, LightState, ObjectKind, Scene, SceneObject
from stucksolver.scene.own_path import IN_LANE_M, is_beside_path, nearest_ahead

AT_LINE_M = 5.5
"""An ego that waits at a light is stopped at most this far before its line (m). Ours."""
LOOKED_S = 3.0
"""An ego has waited at a light after this time (s). Ours."""
HESITATES_S = 20.0
"""A person who stands beside the ego's path is given this long to cross (s). Ours: people hesitate for a quarter of a
minute before a stopped vehicle.
"""
HESITATES_M = 15.0
"""Distance ahead of the ego within which that holds (m). Ours."""
ASIDE_M = 1.5
"""Distance beside its path within which that holds (m). Ours."""


def duty_to_wait(scene: Scene, analysis: Analysis, limits: WaitLimits) -> Proposal | None:
    """Return why the ego must wait, or None. Lights, people and queues are duties that `analyse` has checked before."""
    lead = nearest_ahead(scene, NEAR_M)
    if lead is not None and lead.kind is ObjectKind.CROSSING_GATE:
        return Proposal(None, f"the gate {lead.id} must not be driven around", WaitReason.LIGHT)
    asked = analysis.guidance_intent
    follows = lead is not None and lead.kind in VEHICLES and lead.speed_along_mps > 0.5
    if lead is not None and follows and asked not in (None, GuidanceIntent.OVERTAKE):
        return Proposal(None, f"{lead.kind.value} {lead.id} is moving: follow it", WaitReason.QUEUE)
    if lead is not None and crosses(lead) and not lead.hazard_lights:
        return _duty_to_crossing(scene, drives(lead), f"{lead.kind.value} {lead.id}")
    if lead is not None and lead.kind in SCENES and asked is None and scene.ego.stopped_for_s <= limits.yield_s:
        return Proposal(None, f"{lead.kind.value} {lead.id} holds up the traffic", WaitReason.YIELD)
    person = None if asked is not None else _hesitating(scene)
    if person is not None and scene.ego.stopped_for_s < HESITATES_S:
        return Proposal(None, f"{person.kind.value} {person.id} beside the path may cross", WaitReason.PEOPLE)
    if lead is None and analysis.immobilized:
        return _duty_on_free_road(scene)
    return None


def _hesitating(scene: Scene) -> SceneObject | None:
    """Return a person on foot who stands just ahead beside the ego's path, or None."""
    near = [o for o in scene.objects if o.kind is ObjectKind.PEDESTRIAN and 0.0 < (o.gap_m or 0.0) < HESITATES_M]
    return next((o for o in near if is_beside_path(scene, o, ASIDE_M)), None)


def _duty_to_crossing(scene: Scene, moves: bool, who: str) -> Proposal | None:
    if moves:
        return Proposal(None, f"{who} is crossing the path and goes first", WaitReason.YIELD)
    if scene.ego.stopped_for_s < FIRST_TURN_S and Claim.WAVED_THROUGH not in scene.claims:
        return Proposal(None, f"{who} comes from a crossing road and may go first", WaitReason.YIELD)
    return None


def _duty_on_free_road(scene: Scene) -> Proposal | None:
    """Return the duty of an ego that is stopped on a free road: the stack is given time to set off by itself."""
    light = red_light_within(scene, LIGHT_AHEAD_M)
    if light is not None:
        # After the limit of this wait, an operator may approve crossing the line.
        return None if _may_ask_to_cross(scene) else Proposal(None, light, WaitReason.LIGHT)
    on_route = abs(scene.ego.lateral_offset_m) < IN_LANE_M
    if on_route and goes_first(scene) is None and scene.guidance is None and scene.ego.stopped_for_s < STANDS_S:
        return Proposal(None, f"nothing is in the path, and the vehicle has stood for {scene.ego.stopped_for_s:.0f} s")
    holds = may_hold(scene)
    return None if holds is None else Proposal(None, holds, WaitReason.YIELD)


def _may_ask_to_cross(scene: Scene) -> bool:
    """True if an operator may be asked to approve crossing the line of a red light.

    Only then is the light no reason to wait any more: it has been red for too long, or a passenger says that it is
    broken. A vehicle that moves, such as one that drives in circles, has not waited at this light.
    """
    if not scene.ego.is_slow or scene.ego.stopped_for_s < LOOKED_S or has_been_tried(scene, "keep_lane"):
        return False
    return any(
        c.kind is ControlKind.TRAFFIC_LIGHT
        and c.state is LightState.RED
        and c.applies is not False
        and -1.0 < c.distance_m < AT_LINE_M
        for c in scene.controls
    )
