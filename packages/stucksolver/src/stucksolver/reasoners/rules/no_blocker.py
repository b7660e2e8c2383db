"""What to do if nothing is ahead: a loop, a dark light, or a passenger's request."""

from __future__ import annotations

import math

from stucksolver.plan import Analysis, CauseCode, GuidanceIntent, RecoveryPlan, WaitReason
from stucksolver.plan.behaviors import BackUp, KeepLane, PullOver, RejoinRoute, ReplanRoute, Wait
from stucksolver.plan.behaviors.behavior import Behavior
from stucksolver.reasoners.rules.analyze import blocker, red_light_within
from stucksolver.reasoners.rules.detour import detour_starts
from stucksolver.reasoners.rules.gap_acceptance import enter_flow
from stucksolver.reasoners.rules.pass_options import Way, pass_from_adjacent_lane
from stucksolver.reasoners.rules.recent_attempts import has_been_tried
from stucksolver.reasoners.rules.resume_driving import resume, siren_behind
from stucksolver.reasoners.rules.turn_back import turning_round
from stucksolver.scene import ControlKind, LightState, Scene

AT_THE_LINE_M = 5.5
LOOKED_S = 3.0
CROSS_M = 20.0
CREEP_MPS = 2.2
LIGHT_AHEAD_M = 20.0
GET_OUT_S = 30.0
"""How long the vehicle stays stopped while someone gets out (s). Ours; "drive on" ends it sooner."""
BACK = RejoinRoute(speed_mps=5.5)
"""The return from the roadside, at the quickest speed for crossing a solid line: the quicker, the smaller the gap."""
LET_BY_S = 20.0
"""The vehicle stands at most this long to let an emergency vehicle by. Ours: 80 m behind, at 15 km/h in a queue."""


def decide_without_blocker(scene: Scene, analysis: Analysis) -> Way:
    """Leave a loop by a new route, creep past a dark light after a stop, or drive on along a free lane."""
    light = red_light_within(scene, LIGHT_AHEAD_M)
    if light is not None:
        return across_stuck_light(scene) or (None, (WaitReason.LIGHT, light))
    if analysis.cause is CauseCode.LOOP:
        if has_been_tried(scene, "replan"):
            return None, (None, "a new route has led nowhere")
        return _one(scene, ReplanRoute(), "the vehicle is driving in circles: replan the route")
    if analysis.guidance_intent is None and _stands_at_light(scene, LightState.OFF):
        onward = KeepLane(distance_m=CROSS_M, speed_mps=CREEP_MPS)
        return _one(scene, onward, "the light is out: stop first, then creep across when nobody is coming")
    way = enter_flow(scene) or pass_from_adjacent_lane(scene) or resume(scene)
    return way or (None, (None, "nothing in the path"))


def across_stuck_light(scene: Scene) -> Way | None:
    """Creep past a light that stays red. The guard refuses this without an operator's approval, so one is asked.

    It is called when waiting is no longer right: the light has been red for too long, or a passenger says that it is
    broken. None away from its line, for a yellow light, if this has just failed, and for a vehicle that moves, such as
    one that drives in circles: it has not waited at this light.
    """
    if not _stands_at_light(scene, LightState.RED) or has_been_tried(scene, "keep_lane"):
        return None
    return _one(
        scene,
        KeepLane(distance_m=CROSS_M, speed_mps=CREEP_MPS),
        "the light stays red: creep past it if an operator approves",
    )


def plan_for_request(scene: Scene, wanted: GuidanceIntent | None) -> Way:
    """Do what a passenger asks for if it does not concern an object ahead."""
    light = red_light_within(scene, LIGHT_AHEAD_M)
    if wanted is GuidanceIntent.BACK_UP:
        return _one(scene, BackUp(distance_m=3.0), "the passenger asks to back up")
    lead = blocker(scene)
    # If the passenger wants another street and there is none to turn into ahead, it is behind.
    back = wanted is GuidanceIntent.REROUTE and lead is not None and not detour_starts(scene)
    turn = (
        turning_round(scene, lead, "the passenger asks for it")
        if back or wanted is GuidanceIntent.TURN_AROUND
        else None
    )
    if turn is not None:
        return turn
    if wanted in (GuidanceIntent.REROUTE, GuidanceIntent.TURN_AROUND):
        if has_been_tried(scene, "replan"):
            return None, (None, "a new route has led nowhere")
        if lead is not None and _no_way_back(scene) and not detour_starts(scene):
            return None, (None, "no other road leads to the destination")
        start = min(detour_starts(scene), key=lambda w: w.route_length_m or math.inf, default=None)
        return _one(
            scene, ReplanRoute(route_start=None if start is None else start.id), "the passenger asks for another route"
        )
    if light is not None:
        return None, (WaitReason.LIGHT, light)
    if wanted is GuidanceIntent.LET_ME_OUT and scene.offers("pull_over", "wait"):
        stop = RecoveryPlan(behaviors=(PullOver(), Wait(duration_s=GET_OUT_S)))
        return stop, (None, "the passenger wants to get out: pull over and stay stopped")
    siren = siren_behind(scene)
    if siren is not None and scene.offers("pull_over", "wait", "rejoin_route"):
        let_by = RecoveryPlan(behaviors=(PullOver(), Wait(duration_s=LET_BY_S, until="passed"), BACK))
        return let_by, (None, f"pull over, let {siren.kind.value} {siren.id} by, and return when it has passed")
    return _one(scene, PullOver(), "the passenger asks to pull over")


def _no_way_back(scene: Scene) -> bool:
    """True if every route back is known to pass this place again."""
    return any(w.x_m < 0.0 and w.reaches_destination is False for w in scene.waypoints)


def _stands_at_light(scene: Scene, state: LightState) -> bool:
    """True if the vehicle has stood long enough at the line of a light in this state."""
    stands = scene.ego.is_slow and scene.ego.stopped_for_s >= LOOKED_S
    return stands and any(
        c.kind is ControlKind.TRAFFIC_LIGHT
        and c.state is state
        and c.applies is not False
        and -1.0 < c.distance_m < AT_THE_LINE_M
        for c in scene.controls
    )


def _one(scene: Scene, behavior: Behavior, why: str) -> Way:
    if not scene.offers(behavior.name):
        return None, (None, f"the stack does not offer {behavior.name}")
    return RecoveryPlan(behaviors=(behavior,)), (None, why)
