"""Standoffs: show crossing traffic that the ego means to go, and make room for a vehicle that faces it."""

from __future__ import annotations

import math

from stucksolver.plan import WaitReason
from stucksolver.plan.behaviors import BackUp, KeepLane, Wait
from stucksolver.reasoners.duties.analysis import LIGHT_AHEAD_M, red_light_within
from stucksolver.reasoners.duties.observation import crosses, drives, joins, no_gap_to_join
from stucksolver.reasoners.duties.proposal import Proposal, propose
from stucksolver.reasoners.duties.recent_attempts import has_been_tried
from stucksolver.scene import MOTOR_VEHICLES, Claim, LaneRelation, Scene, SceneObject

FIRST_TURN_S = 8.0
"""Crossing traffic is given this long to go first (s)."""
SHORT_OF_M = 0.4
"""Gap left to the vehicle that the ego creeps towards (m)."""
LEAST_M = 2.0
"""The shortest distance to creep (m)."""
MOST_M = 5.0
"""The longest distance to creep (m)."""
STEP_M = 0.5
"""The distance to creep is a multiple of this (m)."""
CREEP_MPS = 1.5
NOSE_M = 3.0
"""The longest distance to nose in (m)."""
LEAST_NOSE_M = 0.6
"""The shortest distance to nose in (m)."""
NOSE_CLEAR_M = 0.32
"""Gap left beside crawling traffic (m)."""
FACES_COS = -0.7
BACK_M = 8.0
LEAST_BACK_M = 3.0
REAR_MARGIN_M = 5.5
GIVES_WAY_S = 10.0


def assert_to_crossing(scene: Scene, lead: SceneObject) -> Proposal | None:
    """Creep up to a vehicle that has stopped across the path and does not go: someone has to begin.

    None if the lead is not across the path, or if there is no room left.
    """
    if not crosses(lead) or lead.hazard_lights or not scene.offers("keep_lane"):
        return None
    light = red_light_within(scene, LIGHT_AHEAD_M)
    if light is not None:
        return Proposal(None, light, WaitReason.LIGHT)
    who = f"{lead.kind.value} {lead.id}"
    if drives(lead):
        return Proposal(None, f"{who} is crossing the path and goes first", WaitReason.YIELD)
    if scene.ego.stopped_for_s < FIRST_TURN_S and Claim.WAVED_THROUGH not in scene.claims:
        return Proposal(None, f"{who} comes from a crossing road and may go first", WaitReason.YIELD)
    way = STEP_M * math.floor(((lead.gap_m or 0.0) - SHORT_OF_M) / STEP_M)
    if way < LEAST_M or has_been_tried(scene, "keep_lane"):
        return None
    creep = KeepLane(distance_m=min(way, MOST_M), speed_mps=CREEP_MPS)
    return propose(scene, f"{who} is across the path and does not go: creep to go first", creep)


def assert_to_merging(scene: Scene, lead: SceneObject) -> Proposal | None:
    """Nose into a crawling stream of traffic that leaves no gap. None if there is no such stream, or no room."""
    joining = no_gap_to_join(scene, lead)
    if joining is None or not scene.offers("keep_lane"):
        return None
    light = red_light_within(scene, LIGHT_AHEAD_M)
    if light is not None:
        return Proposal(None, light, WaitReason.LIGHT)
    who = f"{joining.kind.value} {joining.id}"
    way = min(_free_before(scene, o) for o in scene.objects if joins(scene, o))
    if way < LEAST_NOSE_M:
        return None
    nose = KeepLane(distance_m=min(way, NOSE_M), speed_mps=CREEP_MPS)
    return propose(scene, f"{who} and others crawl by without a gap: nose in to be let in", nose)


def _free_before(scene: Scene, o: SceneObject) -> float:
    """Return how far the ego may go straight on until its front corner is as near to a vehicle's path as allowed (m).

    Rounded down to tenths of a meter.
    """
    side = math.copysign(1.0, o.y_m)
    cos, sin = math.cos(o.yaw_rad), math.sin(o.yaw_rad)
    ahead, aside = scene.ego.length_m / 2 - o.x_m, side * scene.ego.width_m / 2 - o.y_m
    clear = abs(aside * cos - ahead * sin) - o.width_m / 2
    return math.floor(10.0 * (clear - NOSE_CLEAR_M) / abs(sin)) / 10.0


def back_off(scene: Scene, lead: SceneObject) -> Proposal | None:
    """Back up from an oncoming vehicle if there is no room to pass it, and let it pass or turn off.

    None if the lead does not face the ego, or if there is no room behind.
    """
    faces = lead.kind in MOTOR_VEHICLES and math.cos(lead.yaw_rad) < FACES_COS and not lead.hazard_lights
    if not faces or scene.ego.speed_mps > 0.2 or has_been_tried(scene, "back_up"):
        return None
    way = next((m for m in (BACK_M, LEAST_BACK_M) if may_back_up(scene, m, REAR_MARGIN_M)), None)
    if way is None:
        return None
    moves = (BackUp(distance_m=way, speed_mps=2.0), Wait(duration_s=GIVES_WAY_S, until="clear"))
    return propose(scene, f"{lead.kind.value} {lead.id} faces us: back up and let it go first", *moves)


def may_back_up(scene: Scene, way_m: float, margin_m: float) -> bool:
    """True if the ego's lane is free behind for `way_m` plus a margin (m)."""
    lane = next((lane for lane in scene.lanes if lane.relation is LaneRelation.EGO), None)
    free = None if lane is None else lane.free_behind_m
    return scene.offers("back_up") and free is not None and free >= way_m + margin_m
