"""Step 3: which behaviors get the vehicle moving, and whether the route must be replanned."""

from __future__ import annotations

from stucksolver.plan import (
    Analysis,
    CauseCode,
    Decision,
    GuidanceIntent,
    Observation,
    RecoveryPlan,
    WaitLimits,
    WaitReason,
)
from stucksolver.plan.behaviors import RequestAssistance
from stucksolver.reasoners.rules.analyze import blocker
from stucksolver.reasoners.rules.deadlocks import assert_to_crossing, assert_to_merging, back_off
from stucksolver.reasoners.rules.detour import detour
from stucksolver.reasoners.rules.no_blocker import decide_without_blocker, plan_for_request
from stucksolver.reasoners.rules.pass_options import Way, find_pass, speed_for
from stucksolver.reasoners.rules.pass_target import group_of
from stucksolver.reasoners.rules.recent_attempts import failed_for, has_been_tried
from stucksolver.reasoners.rules.small_maneuvers import (
    drive_over_plan,
    nudge_plan,
    prepend_back_up,
    prepend_moves_for_sight,
    prepend_nose_out,
)
from stucksolver.reasoners.rules.turn_back import out_of_blocked_road, out_of_closed_road
from stucksolver.scene import REQUESTS, VEHICLES, ObjectKind, RejectCode, Scene, SceneObject

LEAD_RANGE_M = 45.0
SAME_MOMENT_S = 0.5
NO_WAY_S = 120.0
"""After this long without a safe plan, a person is asked for help (s)."""
FOR_US = (
    GuidanceIntent.PULL_OVER,
    GuidanceIntent.LET_ME_OUT,
    GuidanceIntent.BACK_UP,
    GuidanceIntent.REROUTE,
    GuidanceIntent.TURN_AROUND,
)
"""Requests that do not concern an object ahead."""


def decide(scene: Scene, observation: Observation, analysis: Analysis, limits: WaitLimits) -> Decision:
    """Return the answer with its reason."""
    nothing = _why_nothing(analysis)
    if nothing is not None:
        return Decision(observation=observation, analysis=analysis, plan=None, rationale=nothing)
    plan, (wait, why) = _way_on(scene, analysis)
    refused = None if plan is None else _just_refused(scene, plan)
    if refused is not None:
        plan, wait, why = None, WaitReason.NO_SAFE_WAY, refused
    if plan is None and analysis.immobilized:
        plan, why = call_for_help(scene, wait, why, limits), why
    if plan is not None:
        return Decision(observation=observation, analysis=analysis, plan=plan, rationale=why)
    waiting = analysis.model_copy(update={"wait": wait, "reason": f"{analysis.reason}; {why}"})
    return Decision(observation=observation, analysis=waiting, plan=None, rationale=f"wait: {why}")


def _why_nothing(analysis: Analysis) -> str | None:
    """Return why nothing should be done, or None if something should."""
    if analysis.wait is not None:
        return f"waiting is right: {analysis.reason}"
    wanted = analysis.guidance_intent
    idle = (wanted is not None and wanted not in REQUESTS) or (wanted is None and not analysis.immobilized)
    return f"nothing to do: {analysis.reason}" if idle else None


def _way_on(scene: Scene, analysis: Analysis) -> Way:
    if analysis.guidance_intent in FOR_US:
        return plan_for_request(scene, analysis.guidance_intent)
    lead = _lead(scene, analysis)
    if lead is None:
        return decide_without_blocker(scene, analysis)
    if lead.kind is ObjectKind.CROSSING_GATE:
        return None, (WaitReason.LIGHT, f"the gate {lead.id} must not be driven around")
    over = drive_over_plan(scene, lead)
    if over is not None:
        return over
    followed = _is_followed(lead, analysis)
    if followed is not None:
        return None, (WaitReason.QUEUE, followed)
    standoff = assert_to_crossing(scene, lead) or assert_to_merging(scene, lead)
    if standoff is not None:
        return standoff
    other = detour(scene, lead) or out_of_closed_road(scene, lead)
    if other is not None:
        return other
    target = group_of(scene, lead)
    aside = nudge_plan(scene, target)
    if aside is not None and not has_been_tried(scene, "nudge"):
        return aside
    plan, why = find_pass(scene, target, speed_for(scene, target))
    if plan is None:
        back = back_off(scene, lead) if why[0] is WaitReason.NO_SAFE_WAY else None
        return back or out_of_blocked_road(scene, lead) or (plan, why)
    if failed_for(scene, RejectCode.ONCOMING_SIGHT) and _just_refused(scene, plan) is not None:
        look = prepend_moves_for_sight(scene, target, plan)
        if look is not None:
            return look
    return prepend_nose_out(scene, lead, prepend_back_up(scene, lead, plan)), why


def _is_followed(lead: SceneObject, analysis: Analysis) -> str | None:
    """Return why to follow a moving vehicle, or None: it is passed only if the passenger asks to overtake."""
    asked = analysis.guidance_intent
    if asked in (None, GuidanceIntent.OVERTAKE) or lead.kind not in VEHICLES or lead.speed_along_mps <= 0.5:
        return None
    return f"{lead.kind.value} {lead.id} is moving: follow it"


def _lead(scene: Scene, analysis: Analysis) -> SceneObject | None:
    """Return the object that should be passed, or None."""
    if analysis.guidance_intent is not None:
        return next(iter(scene.in_path_ahead(LEAD_RANGE_M)), None)
    return None if analysis.cause in (CauseCode.UNKNOWN, CauseCode.LOOP) else blocker(scene)


def _just_refused(scene: Scene, plan: RecoveryPlan) -> str | None:
    """Return why the same plan was refused a moment ago, or None: so soon, the rules have no better idea.

    After a refusal for lack of clearance, a plan at walking pace counts as a new plan. So does a faster one after a
    refusal for oncoming traffic or lack of sight, if the passenger asks to overtake.
    """
    names = tuple(b.name for b in plan.behaviors)
    same = [a for a in scene.attempts if a.behaviors == names and scene.time_s - a.time_s < SAME_MOMENT_S]
    slowed = failed_for(scene, RejectCode.CLEARANCE, RejectCode.DOOR)
    reading = None if scene.guidance is None else scene.guidance.reading
    asked = reading is not None and reading.intent is GuidanceIntent.OVERTAKE
    quickened = asked and failed_for(scene, RejectCode.ONCOMING_SIGHT, RejectCode.ONCOMING_GAP)
    return same[-1].outcome if same and not (len(same) == 1 and (slowed or quickened)) else None


def call_for_help(scene: Scene, wait: WaitReason | None, why: str, limits: WaitLimits) -> RecoveryPlan | None:
    """Return a call for help if nothing legal is left: a light stays red, or there has been no safe plan for long."""
    if not scene.offers("request_assistance"):
        return None
    after = {WaitReason.LIGHT: limits.light_s, WaitReason.NO_SAFE_WAY: NO_WAY_S}
    if wait is None or scene.ego.stopped_for_s <= after.get(wait, float("inf")):
        return None
    reason = f"stopped for {scene.ego.stopped_for_s:.0f} s: {why}"[:200]
    return RecoveryPlan(behaviors=(RequestAssistance(reason=reason),))
