"""Reasoner that knows no situations: duties say when to wait, everything else is searched through the guard."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver.plan import (
    Analysis,
    CauseCode,
    Decision,
    GuidanceIntent,
    RecoveryPlan,
    WaitLimits,
    WaitReason,
    plan_matches_intent,
)
from stucksolver.plan.assessment import PlanAssessor
from stucksolver.reasoners.reasoner import ReasonerAnswer, ReasonerRequest, ReasonerTrace
from stucksolver.reasoners.rules.analyze import NEAR_M, analyse
from stucksolver.reasoners.rules.deadlocks import assert_to_crossing, assert_to_merging, back_off
from stucksolver.reasoners.rules.decide import FOR_US, LEAD_RANGE_M, call_for_help, decide
from stucksolver.reasoners.rules.no_blocker import plan_for_request
from stucksolver.reasoners.rules.observe import observe
from stucksolver.reasoners.rules.pass_target import is_staying
from stucksolver.reasoners.rules.pushed_object import assume_stopped
from stucksolver.reasoners.search.behavior_grid import nearest_ahead
from stucksolver.reasoners.search.binding_constraint import binding_constraint, in_words
from stucksolver.reasoners.search.duties import duty_to_wait
from stucksolver.reasoners.search.plan_search import Candidate, PlanSearch, SearchResult
from stucksolver.reasoners.search.reroute import new_route, reroute
from stucksolver.scene import MOTOR_VEHICLES, RejectCode, Scene, SceneObject


class SearchReasoner:
    """Observes and analyses as the rules do, and searches the plan through the guard.

    Without surroundings to check plans in, it answers as the rules do.
    """

    name = "search"

    def __init__(self, limits: WaitLimits | None = None) -> None:
        self._limits = limits or WaitLimits()

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the decision that follows from the scene and the guard's assessments. Deterministic."""
        decision = assume_stopped(request.scene, lambda scene: self._decide(scene, request.assess))
        trace = ReasonerTrace(answers=(decision.model_dump_json(),))
        return ReasonerAnswer(decision, self.name, trace)

    def _decide(self, scene: Scene, assess: PlanAssessor | None) -> Decision:
        observation = observe(scene, self._limits)
        analysis = analyse(scene, observation, self._limits)
        if assess is None or not _is_to_act(analysis):
            return decide(scene, observation, analysis, self._limits)
        plan, wait, why, analysis = self._searched(scene, assess, analysis)
        if plan is None and analysis.immobilized:
            plan = call_for_help(scene, wait, why, self._limits)
        if plan is not None:
            return Decision(observation=observation, analysis=analysis, plan=plan, rationale=why)
        waiting = analysis.model_copy(update={"wait": wait, "reason": why})
        return Decision(observation=observation, analysis=waiting, plan=None, rationale=f"wait: {why}")

    def _searched(
        self, scene: Scene, assess: PlanAssessor, analysis: Analysis
    ) -> tuple[RecoveryPlan | None, WaitReason | None, str, Analysis]:
        """Return the plan or the reason to wait, in words, and the analysis with the cause that was found."""
        asked = analysis.guidance_intent
        if asked in FOR_US:
            plan, (wait, why) = plan_for_request(scene, asked)
            return plan, wait, why, analysis
        duty = duty_to_wait(scene, analysis, self._limits)
        if duty is not None:
            return None, duty[0], duty[1], analysis
        if analysis.cause is CauseCode.LOOP:
            found = new_route(scene, "the vehicle is driving in circles")
            return (None, None, "a new route has led nowhere", analysis) if found is None else (*found, analysis)
        lead = nearest_ahead(scene, NEAR_M)
        shown = None if lead is None else assert_to_crossing(scene, lead) or assert_to_merging(scene, lead)
        if shown is not None:
            return shown[0], shown[1][0], shown[1][1], analysis
        overtaken = nearest_ahead(scene, LEAD_RANGE_M) if asked is GuidanceIntent.OVERTAKE else None
        passes = None if overtaken is None else overtaken.id
        result = PlanSearch(scene, assess, _filter(scene, asked), passes).run()
        if result.best is not None and not self._holds(scene, result.best):
            return result.best.plan, None, _says(result.best), _explained(analysis, scene, result)
        analysis = _explained(analysis, scene, result)
        if scene.guidance is not None and result.nearly is not None:
            # The guard refuses what the passenger asks for, and its reason is told back.
            return result.nearly.plan, None, analysis.reason, analysis
        room = None if lead is None else back_off(scene, lead)
        if room is not None:
            return room[0], room[1][0], room[1][1], analysis
        found = reroute(scene, analysis.reason)
        if found is not None:
            return (*found, analysis)
        return None, self._reason_to_wait(scene, result, lead), analysis.reason, analysis

    def _holds(self, scene: Scene, best: Candidate) -> bool:
        """True if the best plan would pass a scene on own authority, such as a school bus: it is waited for first."""
        authority = any(item.code is RejectCode.AUTHORITY for item in best.assessment.shortfalls)
        return authority and scene.guidance is None and scene.ego.stopped_for_s <= self._limits.yield_s

    def _reason_to_wait(self, scene: Scene, result: SearchResult, lead: SceneObject | None) -> WaitReason:
        """Return why there is no plan: what holds the ego may move on by itself, or there is no safe way at all."""
        if result.best is not None:
            return WaitReason.YIELD
        constraint = None if result.nearly is None else result.nearly.assessment.shortfalls[0]
        found = next((o for o in scene.objects if constraint is not None and o.id == constraint.object_id), None)
        leaves = found is not None and found.kind in MOTOR_VEHICLES and found != lead and not is_staying(found)
        return WaitReason.YIELD if leaves else WaitReason.NO_SAFE_WAY


def _is_to_act(analysis: Analysis) -> bool:
    """True if something should be done: the ego is immobilized, or a passenger asks for something."""
    if analysis.wait is not None:
        return False
    return analysis.immobilized if analysis.guidance_intent is None else True


def _filter(scene: Scene, asked: GuidanceIntent | None) -> Callable[[RecoveryPlan], bool]:
    """Return which plans may be proposed: all, or those that the passenger asks for."""
    reading = None if scene.guidance is None else scene.guidance.reading
    if asked is None or reading is None:
        return lambda plan: True
    return lambda plan: plan_matches_intent(reading, plan)


def _says(best: Candidate) -> str:
    """Return in words what a plan does."""
    moves = ", then ".join(in_words(behavior) for behavior in best.plan.behaviors)
    if best.assessment.needs_approval:
        lacking = next(item for item in best.assessment.shortfalls if item.approval)
        return f"{moves}, if a person approves it: {lacking.detail}"[:300]
    if best.assessment.shortfalls:
        return f"{moves}, as soon as this is over: {best.assessment.shortfalls[0].detail}"[:300]
    return moves


def _explained(analysis: Analysis, scene: Scene, result: SearchResult) -> Analysis:
    """Return the analysis with the constraint that holds the ego, instead of an object that is merely there."""
    found = binding_constraint(scene, result)
    if found is None:
        return analysis
    return analysis.model_copy(update={"cause": found[0] or analysis.cause, "reason": found[1]})
