"""What a passenger asks for that does not concern an object ahead."""

from __future__ import annotations

from stucksolver.plan import GuidanceIntent, WaitReason
from stucksolver.plan.behaviors import BackUp, PullOver, RejoinRoute, ReplanRoute, Wait
from stucksolver.reasoners.duties.analysis import LIGHT_AHEAD_M, blocker, red_light_within
from stucksolver.reasoners.duties.other_roads import detour_starts, to_other_road, turning_round
from stucksolver.reasoners.duties.proposal import Proposal, propose
from stucksolver.reasoners.duties.recent_attempts import has_been_tried
from stucksolver.reasoners.duties.right_of_way import siren_behind
from stucksolver.scene import Scene

REQUESTS_FOR_EGO = (
    GuidanceIntent.PULL_OVER,
    GuidanceIntent.LET_ME_OUT,
    GuidanceIntent.BACK_UP,
    GuidanceIntent.REROUTE,
    GuidanceIntent.TURN_AROUND,
)
"""Requests that do not concern an object ahead."""
GET_OUT_S = 30.0
"""How long the vehicle stays stopped while someone gets out (s). Ours; "drive on" ends it sooner."""
BACK = RejoinRoute(speed_mps=5.5)
"""The return from the roadside, at the quickest speed for crossing a solid line: the quicker, the smaller the gap."""
LET_BY_S = 20.0
"""The vehicle stands at most this long to let an emergency vehicle by. Ours: 80 m behind, at 15 km/h in a queue."""
BACK_M = 3.0
"""Distance to back up if a passenger names none (m). Ours."""


def plan_for_request(scene: Scene, wanted: GuidanceIntent | None) -> Proposal:
    """Return the plan for one of `REQUESTS_FOR_EGO`, or the reason why there is none."""
    if wanted is GuidanceIntent.BACK_UP:
        return propose(scene, "the passenger asks to back up", BackUp(distance_m=BACK_M))
    if wanted in (GuidanceIntent.REROUTE, GuidanceIntent.TURN_AROUND):
        return _other_route(scene, wanted)
    light = red_light_within(scene, LIGHT_AHEAD_M)
    if light is not None:
        return Proposal(None, light, WaitReason.LIGHT)
    if wanted is GuidanceIntent.LET_ME_OUT and scene.offers("pull_over", "wait"):
        why = "the passenger wants to get out: pull over and stay stopped"
        return propose(scene, why, PullOver(), Wait(duration_s=GET_OUT_S))
    siren = siren_behind(scene)
    if siren is not None and scene.offers("pull_over", "wait", "rejoin_route"):
        why = f"pull over, let {siren.kind.value} {siren.id} by, and return when it has passed"
        return propose(scene, why, PullOver(), Wait(duration_s=LET_BY_S, until="passed"), BACK)
    return propose(scene, "the passenger asks to pull over", PullOver())


def _other_route(scene: Scene, wanted: GuidanceIntent) -> Proposal:
    lead, starts = blocker(scene), detour_starts(scene)
    # If the passenger wants another street and there is none to turn into ahead, it is behind.
    if wanted is GuidanceIntent.TURN_AROUND or (lead is not None and not starts):
        turn = turning_round(scene, lead, "the passenger asks for it")
        if turn is not None:
            return turn
    if has_been_tried(scene, "replan"):
        return Proposal(None, "a new route has led nowhere")
    if lead is not None and not starts and _no_way_back(scene):
        return Proposal(None, "no other road leads to the destination")
    why = "the passenger asks for another route"
    return to_other_road(scene, why) or propose(scene, why, ReplanRoute())


def _no_way_back(scene: Scene) -> bool:
    """True if every route back is known to pass this place again."""
    return any(w.x_m < 0.0 and w.reaches_destination is False for w in scene.waypoints)
