"""Step 2: is the vehicle immobilized and by what, or is waiting right? With guidance: what does it ask for?"""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import (
    QUESTIONS,
    Analysis,
    AnalysisStep,
    CauseCode,
    GuidanceIntent,
    Intent,
    Observation,
    WaitLimits,
    WaitReason,
)
from stucksolver.reasoners.duties.observation import beside_lane_center, drives, goes_first, intent, no_gap_to_join
from stucksolver.scene import (
    MOTOR_VEHICLES,
    REQUESTS,
    VEHICLES,
    Claim,
    ControlKind,
    Interpretation,
    LightState,
    ObjectKind,
    Scene,
    SceneObject,
)
from stucksolver.scene.wording import stood_too_briefly, whereabouts

LIGHT_AHEAD_M = 20.0
PEOPLE_CLEARANCE_M = 15.0


@dataclass(frozen=True)
class Hold:
    """A reason why waiting is right, with the evidence."""

    reason: WaitReason
    evidence: str


def analyse(scene: Scene, observation: Observation, limits: WaitLimits) -> Analysis:
    """Answer S2.1 if a passenger has spoken, otherwise S2.2 to S2.5."""
    if scene.guidance is not None:
        return _with_guidance(scene, limits)
    return _without_guidance(scene, observation, limits)


def _with_guidance(scene: Scene, limits: WaitLimits) -> Analysis:
    assert scene.guidance is not None
    reading = scene.guidance.reading
    wanted = GuidanceIntent.UNCLEAR if reading is None else reading.intent
    step = _step("S2.1", wanted in REQUESTS, f'"{scene.guidance.text}" is read as: {describe_interpretation(reading)}')
    stuck = scene.ego.is_slow and not scene.ego.at_destination
    # Whatever the passenger says, the vehicle waits at lights and stop lines, and for people ahead.
    hold = _held_by_control(scene, limits) or _held_by_people(scene, limits)
    return Analysis(
        steps=(step,),
        immobilized=stuck and hold is None,
        wait=hold.reason if hold else None,
        guidance_intent=wanted,
        reason=f"the passenger asks for: {describe_interpretation(reading)}"
        + (f"; but {hold.evidence}" if hold else ""),
    )


def describe_interpretation(reading: Interpretation | None) -> str:
    """Return a reading in words."""
    if reading is None:
        return "nothing (the words were not read)"
    side = "" if reading.side is None else f" on the {reading.side.value}"
    return f"{reading.intent.value.replace('_', ' ')}{side} ({reading.confidence:.0%})"


def loops(scene: Scene) -> bool:
    """Return True if the ego moves and makes no progress."""
    progress_m = scene.ego.progress_20s_m
    return not scene.ego.is_slow and progress_m is not None and progress_m < scene.ego.expected_progress_m


def _without_guidance(scene: Scene, observation: Observation, limits: WaitLimits) -> Analysis:
    steps = [_step("S2.2", scene.ego.at_destination, _destination(scene))]
    if scene.ego.at_destination:
        return _waiting(steps, Hold(WaitReason.AT_DESTINATION, "the route is complete"))
    moving = not scene.ego.is_slow
    looping = loops(scene)
    # Adding 0.0 removes the sign of a zero.
    motion = f"{round(scene.ego.speed_mps, 1) + 0.0:.1f} m/s, stopped for {scene.ego.stopped_for_s:.1f} s"
    steps.append(_step("S2.3", moving and not looping, motion))
    if moving:
        cause = CauseCode.LOOP if looping else None
        reason = "it is moving but makes no progress" if looping else "it is moving"
        return Analysis(steps=tuple(steps), immobilized=looping, cause=cause, reason=reason)
    hold = find_hold(scene, limits)
    steps.append(_step("S2.4", hold is not None, hold.evidence if hold else "nothing holds it up in its own lane"))
    if hold is not None:
        return _waiting(steps, hold)
    cause, evidence = find_cause(scene, limits)
    steps.append(_step("S2.5", True, evidence))
    return Analysis(steps=tuple(steps), immobilized=True, cause=cause, reason=evidence)


def _step(name: str, answer: bool, evidence: str) -> AnalysisStep:
    return AnalysisStep(id=name, question=QUESTIONS[name], answer=answer, evidence=evidence)


def _destination(scene: Scene) -> str:
    left = scene.ego.distance_to_destination_m
    return "the destination is beyond the known road" if left is None else f"{left:.0f} m to go"


def _waiting(steps: list[AnalysisStep], hold: Hold) -> Analysis:
    return Analysis(steps=tuple(steps), immobilized=False, wait=hold.reason, reason=hold.evidence)


def find_hold(scene: Scene, limits: WaitLimits) -> Hold | None:
    """Return why waiting is right, or None if it is not."""
    return _held_by_control(scene, limits) or _held_by_people(scene, limits) or _held_by_vehicle(scene, limits)


def _held_by_control(scene: Scene, limits: WaitLimits) -> Hold | None:
    for control in scene.controls:
        if control.applies is False or not -1.0 < control.distance_m < LIGHT_AHEAD_M:
            continue
        stopping = control.kind is ControlKind.TRAFFIC_LIGHT and control.state in (LightState.RED, LightState.YELLOW)
        patient = scene.ego.stopped_for_s <= limits.light_s and Claim.BROKEN_LIGHT not in scene.claims
        if stopping and patient and not _blocked_before(scene, control.distance_m):
            state = control.state.value if control.state else ""
            return Hold(WaitReason.LIGHT, f"{state} light {whereabouts(control.distance_m)}")
        if control.kind is ControlKind.STOP_SIGN and scene.ego.stopped_for_s < 3.0:
            return Hold(WaitReason.STOP_SIGN, f"stop sign {whereabouts(control.distance_m)}")
    gate = blocker(scene)
    if gate is not None and gate.kind is ObjectKind.CROSSING_GATE and scene.ego.stopped_for_s <= limits.light_s:
        return Hold(WaitReason.LIGHT, f"the gate of a level crossing is closed {whereabouts(gate.gap_m or 0.0)}")
    return None


def red_light_within(scene: Scene, way_m: float) -> str | None:
    """Return, in words, a red or yellow light whose line is within `way_m` ahead (m); a plan must not cross it."""
    for control in scene.controls:
        lit = control.kind is ControlKind.TRAFFIC_LIGHT and control.state in (LightState.RED, LightState.YELLOW)
        if lit and control.state and control.applies is not False and -1.0 < control.distance_m < way_m:
            return f"{control.state.value} light {whereabouts(control.distance_m)}"
    return None


def _blocked_before(scene: Scene, distance_m: float) -> bool:
    """True if something that is not traffic, such as a parked car or cones, is between the ego and the stop line
    (m).
    """
    lead = blocker(scene)
    if lead is None or lead.gap_m is None or lead.gap_m > distance_m - 2.0:
        return False
    return lead.kind not in MOTOR_VEHICLES or bool(lead.hazard_lights) or beside_lane_center(lead)


def _held_by_people(scene: Scene, limits: WaitLimits) -> Hold | None:
    for o in scene.objects:
        if o.kind not in (ObjectKind.PEDESTRIAN, ObjectKind.ANIMAL):
            continue
        if intent(scene, o, limits) is Intent.CROSSING and -3.0 < (o.gap_m or 0.0) < PEOPLE_CLEARANCE_M:
            return Hold(WaitReason.PEOPLE, f"{o.kind.value} {o.id} is crossing {whereabouts(o.gap_m or 0.0)}")
    return None


def _held_by_vehicle(scene: Scene, limits: WaitLimits) -> Hold | None:
    lead = blocker(scene)
    patient = scene.ego.stopped_for_s <= limits.yield_s
    if not patient and lead is not None and _drives_across(lead):
        return None
    if patient and (lead is None or _drives_across(lead)):
        first = goes_first(scene)
        if first is not None:
            return Hold(WaitReason.YIELD, f"{first.kind.value} {first.id} is about to enter the path ahead")
    if lead is None or lead.kind not in VEHICLES:
        return None
    if no_gap_to_join(scene, lead) is not None:
        return None
    if lead.speed_along_mps > 0.5:
        return Hold(WaitReason.QUEUE, f"{lead.kind.value} {lead.id} ahead is moving")
    what = intent(scene, lead, limits)
    if what is Intent.QUEUEING:
        return Hold(WaitReason.QUEUE, f"{lead.kind.value} {lead.id} ahead is waiting in a queue")
    stays = lead.hazard_lights or what is Intent.PARKED or Claim.LONG_STAY in scene.claims
    needed = limits.hazard_or_parked_s if stays else limits.unknown_vehicle_s
    seen = lead.stationary_s or 0.0
    if seen < needed:
        evidence = f"{lead.kind.value} {lead.id} {stood_too_briefly(seen, needed)}"
        return Hold(WaitReason.UNKNOWN_STOPPED, evidence)
    return None


def _drives_across(lead: SceneObject) -> bool:
    """True if a vehicle in the path is moving, but not along it."""
    return drives(lead) and lead.speed_along_mps < 0.5


NEAR_M = 25.0
"""Objects further ahead do not hold the vehicle up (m)."""


def blocker(scene: Scene) -> SceneObject | None:
    """Return the nearest object in the path ahead, or None."""
    return next(iter(scene.in_path_ahead(NEAR_M)), None)


def find_cause(scene: Scene, limits: WaitLimits) -> tuple[CauseCode, str]:
    """Return what immobilizes the vehicle, with the evidence."""
    lead = blocker(scene)
    if lead is None:
        return CauseCode.UNKNOWN, f"stopped for {scene.ego.stopped_for_s:.0f} s with nothing in the path"
    if _drives_across(lead):
        return CauseCode.UNKNOWN, f"stopped for {scene.ego.stopped_for_s:.0f} s by traffic that crosses the path"
    joining = no_gap_to_join(scene, lead)
    if joining is not None:
        since = f"for {scene.ego.stopped_for_s:.0f} s"
        return CauseCode.BLOCKED_ROAD, f"{joining.kind.value} {joining.id} and others have left no gap {since}"
    seen = f"{lead.kind.value} {lead.id}, {lead.gap_m:.1f} m ahead"
    if lead.kind in VEHICLES:
        since = f"stationary for {lead.stationary_s or 0.0:.0f} s"
        if lead.hazard_lights:
            return CauseCode.DISABLED_VEHICLE, f"{seen}, {since} with hazard lights"
        return CauseCode.PARKED_VEHICLE, f"{seen}, {since} and not in a queue"
    return CauseCode.STATIC_OBSTACLE, f"{seen}, is in the lane"
