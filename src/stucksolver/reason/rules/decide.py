"""Step 3: which behaviours get the vehicle going, and whether the route must be planned anew."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.decision import Analysis, CauseCode, Decision, GuidanceIntent, Observation, RecoveryPlan, WaitReason
from stucksolver.decision.behaviors import BorrowOncomingLane, ChangeLane
from stucksolver.reason.rules.analyse import blocker, red_light_within
from stucksolver.scene import CandidateWaypoint, LaneRelation, LineKind, Scene, SceneLane, SceneObject

RECOVERY_SPEED_MPS = 5.0
GUIDED_SPEED_MPS = 11.0
LEAST_SPEED_MPS = 2.0
GROUP_GAP_M = 14.0
"""Objects nearer to each other than this are passed together."""
MERGE_ROOM_M = 12.0
ACCELERATION_MPS2 = 1.2
LEAD_RANGE_M = 45.0
SAME_MOMENT_S = 0.5
PASSED_M = 2.0
"""Oncoming traffic whose rear is less than this ahead of our front bumper will be past before we are beside it."""


Way = tuple[RecoveryPlan | None, tuple[WaitReason, str]]
"""A plan with its reason, or None with the reason for waiting."""


@dataclass(frozen=True)
class Target:
    """What is to be passed: its foremost object, where it ends, and how fast it goes."""

    objects: tuple[SceneObject, ...]

    @property
    def far(self) -> SceneObject:
        return max(self.objects, key=end_of)

    @property
    def end_m(self) -> float:
        """From the ego's front bumper to the far end."""
        return end_of(self.far)

    @property
    def speed_mps(self) -> float:
        return max(0.0, max(o.speed_along_mps for o in self.objects))


def end_of(o: SceneObject) -> float:
    """From the ego's front bumper to the far side of an object."""
    return (o.gap_m or 0.0) + o.length_m


def decide(scene: Scene, observation: Observation, analysis: Analysis) -> Decision:
    """The answer, with its reason."""
    lead = _lead(scene, analysis)
    if lead is None:
        return Decision(observation=observation, analysis=analysis, plan=None, rationale=_why_nothing(analysis))
    target = group_of(scene, lead)
    speed = _speed(scene, target)
    plan, why = _way_past(scene, target, speed)
    if plan is None:
        waiting = analysis.model_copy(update={"wait": why[0], "reason": f"{analysis.reason}; {why[1]}"})
        return Decision(observation=observation, analysis=waiting, plan=None, rationale=f"wait: {why[1]}")
    refused = _just_refused(scene, plan)
    if refused is not None:
        waiting = analysis.model_copy(update={"wait": WaitReason.NO_SAFE_WAY})
        return Decision(observation=observation, analysis=waiting, plan=None, rationale=f"wait: {refused}")
    return Decision(observation=observation, analysis=analysis, plan=plan, rationale=why[1])


def _just_refused(scene: Scene, plan: RecoveryPlan) -> str | None:
    """Why the same plan was refused a moment ago; a rule has no better idea in the same instant."""
    names = tuple(b.name for b in plan.behaviors)
    for attempt in scene.attempts:
        if attempt.behaviors == names and scene.time_s - attempt.time_s < SAME_MOMENT_S:
            return attempt.outcome
    return None


def _why_nothing(analysis: Analysis) -> str:
    if analysis.wait is not None:
        return f"waiting is right: {analysis.reason}"
    return f"nothing to do: {analysis.reason}"


def _lead(scene: Scene, analysis: Analysis) -> SceneObject | None:
    """What should be passed, None where nothing should be done."""
    if analysis.guidance_intent is not None:
        if analysis.wait is not None or analysis.guidance_intent in (GuidanceIntent.WAIT, GuidanceIntent.UNCLEAR):
            return None
        ahead = [o for o in scene.objects if o.in_path and o.gap_m is not None and -0.5 < o.gap_m < LEAD_RANGE_M]
        return min(ahead, key=lambda o: o.gap_m or 0.0, default=None)
    if not analysis.immobilized or analysis.cause in (CauseCode.UNKNOWN, CauseCode.LOOP):
        return None
    return blocker(scene)


def group_of(scene: Scene, lead: SceneObject) -> Target:
    """The lead and all in the path that follow it too closely to come back in between."""
    ahead = sorted((o for o in scene.objects if o.in_path and o.gap_m is not None), key=lambda o: o.gap_m or 0.0)
    members = [lead]
    for o in ahead:
        beyond = (o.gap_m or 0.0) > (lead.gap_m or 0.0) and o.speed_along_mps > -0.5
        if beyond and (o.gap_m or 0.0) - max(end_of(m) for m in members) < GROUP_GAP_M:
            members.append(o)
    return Target(tuple(members))


def _speed(scene: Scene, target: Target) -> float:
    if scene.guidance is None or target.speed_mps < 0.5:
        return RECOVERY_SPEED_MPS
    return round(min(max(scene.speed_limit_mps or 8.0, LEAST_SPEED_MPS), GUIDED_SPEED_MPS), 1)


def _way_past(scene: Scene, target: Target, speed: float) -> Way:
    """The first way past that is open: a lane of our direction on the left, on the right, the oncoming lane."""
    available = {b.name for b in scene.behaviors}
    light = red_light_within(scene, way_to_pass_m(scene, target, speed)[0])
    if light is not None:
        return None, (WaitReason.LIGHT, light)
    why: tuple[WaitReason, str] = (WaitReason.NO_SAFE_WAY, "there is no lane to go round in")
    if "change_lane" in available:
        for where in (LaneRelation.LEFT, LaneRelation.RIGHT):
            lane = _lane(scene, where)
            if lane is None or lane.line is LineKind.KERB:
                continue
            blocked = _blocked(scene, lane, target, speed)
            if blocked is None:
                return _by_lane_change(scene, lane, target, speed)
            why = (WaitReason.YIELD, blocked)
    oncoming = _lane(scene, LaneRelation.ONCOMING)
    if oncoming is not None and "borrow_oncoming_lane" in available and why[0] is WaitReason.NO_SAFE_WAY:
        blocked = _oncoming_blocked(scene, oncoming, target, speed)
        if blocked is None:
            return _by_oncoming_lane(target, speed)
        why = (WaitReason.YIELD, blocked)
    return None, why


def _lane(scene: Scene, where: LaneRelation) -> SceneLane | None:
    """The nearest lane in a relation (lists keep the stack's order: from the route outwards)."""
    return next((lane for lane in scene.lanes if lane.relation is where), None)


def way_to_pass_m(scene: Scene, target: Target, speed: float) -> tuple[float, float]:
    """(way of the ego, time) until its rear is past the target with room to come back."""
    relative = target.end_m + scene.ego.length_m + MERGE_ROOM_M
    own, time, way = max(scene.ego.speed_mps, 0.5), 0.0, 0.0
    while way - target.speed_mps * time < relative and time < 60.0:
        own = min(own + ACCELERATION_MPS2 * 0.25, max(speed, scene.ego.speed_mps))
        way, time = way + own * 0.25, time + 0.25
    return way, time


def _blocked(scene: Scene, lane: SceneLane, target: Target, speed: float) -> str | None:
    """Who is in the way in a lane of our direction."""
    way, time = way_to_pass_m(scene, target, speed)
    for o in scene.objects:
        if o.lane_id != lane.id or o.gap_m is None:
            continue
        if o.gap_m > -scene.ego.length_m - 1.0:
            if o.gap_m + max(o.speed_along_mps, 0.0) * time < way:
                return f"{o.kind.value} {o.id} blocks the lane beside, {o.gap_m:.0f} m ahead"
        else:
            behind = -o.gap_m - scene.ego.length_m - o.length_m
            if behind < max(o.speed_along_mps - scene.ego.speed_mps, 0.0) * 3.0 + 2.0:
                return f"{o.kind.value} {o.id} comes from behind in the lane beside, {behind:.0f} m away"
    return None


def _oncoming_blocked(scene: Scene, lane: SceneLane, target: Target, speed: float) -> str | None:
    """Who comes, or stands, in the oncoming lane before we would be back."""
    way, time = way_to_pass_m(scene, target, speed)
    for o in scene.objects:
        coming = max(-o.speed_along_mps, 0.0)
        passed = PASSED_M if coming > 0.5 else -scene.ego.length_m
        if o.lane_id != lane.id or o.gap_m is None or end_of(o) < passed:
            continue
        if o.gap_m - (coming + 1.0 if coming > 0.5 else 0.0) * (time + 2.0) < way:
            return f"{o.kind.value} {o.id} in the oncoming lane, {o.gap_m:.0f} m ahead at {coming:.1f} m/s"
    return None


def _by_lane_change(scene: Scene, lane: SceneLane, target: Target, speed: float) -> Way:
    way, _ = way_to_pass_m(scene, target, speed)
    side = "left" if lane.relation is LaneRelation.LEFT else "right"
    distance = round(min(max(way, 20.0), 150.0), 1)
    out = ChangeLane(side="left" if side == "left" else "right", distance_m=distance, speed_mps=speed)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    start = _waypoint_in(scene, lane, distance)
    if start is not None and _return_was_refused(scene):
        plan = RecoveryPlan(behaviors=(out,), replan_route=True, route_start=start.id)
        return plan, (WaitReason.NO_SAFE_WAY, f"pass {who} in the {side} lane and plan the route anew from there")
    back = ChangeLane(side="right" if side == "left" else "left", distance_m=25.0, speed_mps=speed)
    return RecoveryPlan(behaviors=(out, back)), (WaitReason.NO_SAFE_WAY, f"pass {who} in the {side} lane, then return")


def _return_was_refused(scene: Scene) -> bool:
    """Did an earlier plan of this episode with a change back fail?"""
    return any(len(a.behaviors) > 1 and a.behaviors[-1] == "change_lane" for a in scene.attempts)


def _waypoint_in(scene: Scene, lane: SceneLane, distance_m: float) -> CandidateWaypoint | None:
    """The first candidate for a new route that lies in a lane beyond a distance."""
    fitting = [
        w
        for w in scene.waypoints
        if w.lane_id == lane.id and w.distance_m >= distance_m and w.reaches_destination is not False
    ]
    return min(fitting, key=lambda w: w.distance_m, default=None)


def _by_oncoming_lane(target: Target, speed: float) -> Way:
    behavior = BorrowOncomingLane(past_object_id=target.far.id, speed_mps=speed)
    who = ", ".join(f"{o.kind.value} {o.id}" for o in target.objects)
    return RecoveryPlan(behaviors=(behavior,)), (WaitReason.NO_SAFE_WAY, f"pass {who} through the oncoming lane")
