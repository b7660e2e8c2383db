"""Reasoner that knows no situations: duties say when to wait, everything else is searched through the guard."""

from __future__ import annotations

from stucksolver.plan import (
    Analysis,
    CauseCode,
    Decision,
    GuidanceIntent,
    WaitLimits,
    WaitReason,
)
from stucksolver.plan.assessment import PlanAssessor
from stucksolver.reasoners.duties import decide_wait
from stucksolver.reasoners.duties.analysis import NEAR_M
from stucksolver.reasoners.duties.assistance import call_for_help
from stucksolver.reasoners.duties.duty_to_wait import duty_to_wait
from stucksolver.reasoners.duties.observation import is_staying
from stucksolver.reasoners.duties.proposal import Proposal
from stucksolver.reasoners.duties.pushed_object import assume_stopped
from stucksolver.reasoners.duties.requests import REQUESTS_FOR_EGO, plan_for_request
from stucksolver.reasoners.duties.standoffs import assert_to_crossing, assert_to_merging, back_off
from stucksolver.reasoners.reasoner import ReasonerAnswer, ReasonerRequest, ReasonerTrace
from stucksolver.reasoners.search.binding_constraint import binding_constraint, in_words
from stucksolver.reasoners.search.plan_search import Candidate, SearchResult, overtaken_by_request, search_for
from stucksolver.reasoners.search.reroute import new_route, reroute
from stucksolver.reasoners.search.search_memory import SearchMemory
from stucksolver.reasoners.search.way_out import may_leave, must_leave, way_out
from stucksolver.scene import MOTOR_VEHICLES, REQUESTS, RejectCode, Scene, SceneObject
from stucksolver.scene.own_path import nearest_ahead

UNKNOWN_SURROUNDINGS = "the surroundings are unknown: no plan can be checked"


class SearchReasoner:
    """Observes and analyses, waits where that is a duty, and searches a plan through the guard otherwise."""

    name = "search"

    def __init__(self, limits: WaitLimits | None = None) -> None:
        self._limits = limits or WaitLimits()
        self._memory = SearchMemory()

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the decision that follows from the scene and the guard's assessments. Deterministic.

        A search without a plan is repeated after ten seconds, or when something that is stationary or seen changes.

        In unknown surroundings no plan can be checked, and none is proposed.
        """
        decision = assume_stopped(request.scene, lambda scene: self._decide(scene, request.assess))
        trace = ReasonerTrace(answers=(decision.model_dump_json(),))
        return ReasonerAnswer(decision, self.name, trace)

    def _decide(self, scene: Scene, assess: PlanAssessor | None) -> Decision:
        waiting = decide_wait(scene, self._limits)
        out = way_out(scene, assess) if assess is not None and must_leave(scene) else None
        if out is not None:
            analysis = waiting.analysis.model_copy(update={"immobilized": True, "wait": None})
            return waiting.model_copy(update={"analysis": analysis, "plan": out, "rationale": "leave the rails"})
        if not _is_to_act(waiting.analysis):
            return waiting
        found, analysis = self._searched(scene, assess, waiting.analysis)
        plan = found.plan
        if plan is None and analysis.immobilized:
            plan = call_for_help(scene, found.wait, found.why, self._limits)
        if plan is None:
            analysis = analysis.model_copy(update={"wait": found.wait, "reason": found.why})
        why = f"wait: {found.why}" if plan is None else found.why
        return waiting.model_copy(update={"analysis": analysis, "plan": plan, "rationale": why})

    def _searched(self, scene: Scene, assess: PlanAssessor | None, analysis: Analysis) -> tuple[Proposal, Analysis]:
        """Return the plan or the reason to wait, and the analysis with the cause that was found."""
        asked = analysis.guidance_intent
        if asked in REQUESTS_FOR_EGO:
            return plan_for_request(scene, asked), analysis
        duty = duty_to_wait(scene, analysis, self._limits)
        if duty is not None:
            return duty, analysis
        if analysis.cause is CauseCode.LOOP:
            circles = new_route(scene, "the vehicle is driving in circles")
            return circles or Proposal(None, "a new route has led nowhere"), analysis
        lead = nearest_ahead(scene, NEAR_M)
        shown = None if lead is None else assert_to_crossing(scene, lead) or assert_to_merging(scene, lead)
        if shown is not None:
            return shown, analysis
        if assess is None:
            return Proposal(None, UNKNOWN_SURROUNDINGS, WaitReason.NO_SAFE_WAY), analysis
        if asked is GuidanceIntent.OVERTAKE and overtaken_by_request(scene) is None:
            return Proposal(None, "there is nothing ahead to overtake"), analysis
        search = search_for(scene, assess)
        result = self._memory.recall(scene, search.run, search.passes)
        analysis = _explained(analysis, scene, result)
        if result.best is not None and not self._holds(scene, result.best):
            return Proposal(result.best.plan, _says(result.best)), analysis
        if scene.guidance is not None and result.nearly is not None:
            # The guard refuses what the passenger asks for, and its reason is told back.
            return Proposal(result.nearly.plan, analysis.reason), analysis
        other = (None if lead is None else back_off(scene, lead)) or reroute(scene, analysis.reason)
        out = way_out(scene, assess) if other is None and may_leave(scene) else None
        if out is not None:
            return Proposal(out, f"{analysis.reason}: leave the place where no vehicle should stop"), analysis
        return other or Proposal(None, analysis.reason, self._reason_to_wait(scene, result, lead)), analysis

    def _holds(self, scene: Scene, best: Candidate) -> bool:
        """True if the best plan would pass a scene on own authority, such as a school bus: it is waited for first."""
        authority = any(item.code is RejectCode.AUTHORITY for item in best.assessment.shortfalls)
        return authority and scene.guidance is None and scene.ego.stopped_for_s <= self._limits.yield_s

    def _reason_to_wait(self, scene: Scene, result: SearchResult, lead: SceneObject | None) -> WaitReason:
        """Return why there is no plan: what holds the ego may move on by itself, or there is no safe way at all."""
        if result.best is not None:
            return WaitReason.YIELD
        constraint = None if result.nearly is None else result.nearly.assessment.shortfalls[0]
        if constraint is not None and constraint.code is RejectCode.RED_LIGHT:
            return WaitReason.LIGHT
        found = next((o for o in scene.objects if constraint is not None and o.id == constraint.object_id), None)
        leaves = found is not None and found.kind in MOTOR_VEHICLES and found != lead and not is_staying(found)
        return WaitReason.YIELD if leaves else WaitReason.NO_SAFE_WAY


def _is_to_act(analysis: Analysis) -> bool:
    """True if something should be done: the ego is immobilized, or a passenger asks for something."""
    if analysis.wait is not None:
        return False
    return analysis.immobilized if analysis.guidance_intent is None else analysis.guidance_intent in REQUESTS


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
