"""Parses a model's answer: tolerant of text around the JSON, strict about the JSON itself."""

from __future__ import annotations

from functools import partial
from typing import Any

from pydantic import Field, ValidationError

from stucksolver.plan import (
    QUESTIONS,
    Analysis,
    AnalysisStep,
    CauseCode,
    Decision,
    GuidanceIntent,
    Intent,
    Observation,
    ObservedControl,
    Participant,
    RecoveryPlan,
    WaitReason,
)
from stucksolver.plan.behaviors import Behavior
from stucksolver.plan.behaviors.registry import AnyBehavior
from stucksolver.plan.mirror import mirrored_decision, mirrored_plan
from stucksolver.reasoners.reasoner import PARSERS, ReasonerError
from stucksolver.scene import ControlKind, LaneRelation, LightState, ObjectKind, Scene, SceneObject, TrafficControl
from stucksolver.scene.base_model import FrozenModel
from stucksolver_language.llm.chain_consistency import wrong_chain
from stucksolver_language.llm.json_extraction import NoJsonError, extract_json
from stucksolver_language.llm.offered_behaviors import available
from stucksolver_language.llm.tool_schema import MOST_BEHAVIORS, MOST_CONTROLS, MOST_PARTICIPANTS, steps_of

FORMAT = "llm-decide-2"
"""Version of recorded answers. It increases when an answer that was valid before can no longer be parsed."""
FORMAT_1 = "llm-decide-1"
"""The version before the parser compared the answers to the chain's questions with its conclusion."""
MOST_ERRORS = 3
"""Maximum number of errors in the message for the model. Ours."""


class AnswerError(ReasonerError):
    """The answer is not a decision about this scene. The message can be quoted to the model."""


class _Step(FrozenModel):
    answer: bool | None
    evidence: str


class _Control(FrozenModel):
    kind: ControlKind
    state: LightState | None
    applies: bool | None


class _Participant(FrozenModel):
    object_id: str
    kind: ObjectKind
    lane: LaneRelation
    intent: Intent


class _Observation(FrozenModel):
    controls: tuple[_Control, ...] = Field(max_length=MOST_CONTROLS)
    participants: tuple[_Participant, ...] = Field(max_length=MOST_PARTICIPANTS)
    summary: str


class _Analysis(FrozenModel):
    steps: dict[str, _Step]
    immobilized: bool
    cause: CauseCode | None
    wait: WaitReason | None
    guidance_intent: GuidanceIntent | None
    reason: str


class _Decision(FrozenModel):
    rationale: str
    behaviors: tuple[AnyBehavior, ...] | None = Field(min_length=1, max_length=MOST_BEHAVIORS)
    replan_route: bool
    route_start: str | None


class _Answer(FrozenModel):
    observation: _Observation
    analysis: _Analysis
    decision: _Decision


class _PlanQuestion(FrozenModel):
    behaviors: tuple[AnyBehavior, ...] = Field(min_length=1, max_length=MOST_BEHAVIORS)


def parse_answer(text: str, scene: Scene, *, chain: bool = True) -> Decision:
    """Parse the decision in an answer.

    Args:
        text: The model's answer.
        scene: The scene to which the answer belongs.
        chain: Compare the answers to the questions S2.1 to S2.5 with the conclusion.

    Raises:
        AnswerError: The answer is not a decision about this scene. The message lists the first errors, for the model.
    """
    answer = _read(_Answer, text)
    wrong = [*_wrong_steps(answer.analysis, scene), *_wrong_ids(answer, scene), *_contradictions(answer, scene)]
    if chain and not wrong:
        wrong = wrong_chain(
            {name: step.answer for name, step in answer.analysis.steps.items()},
            immobilized=answer.analysis.immobilized,
            wait=answer.analysis.wait,
            intent=answer.analysis.guidance_intent,
            moves=any(not b.stands_still for b in answer.decision.behaviors or ()),
        )
    if wrong:
        raise AnswerError("; ".join(wrong[:MOST_ERRORS]))
    decision = _decision(answer, scene)
    # The model got the scene as it is in the image.
    return mirrored_decision(decision) if scene.mirrored else decision


def parse_plan(text: str, scene: Scene) -> RecoveryPlan:
    """Parse the plan in a query to the guard.

    Raises:
        AnswerError: The text contains no plan for this scene.
    """
    behaviors = _read(_PlanQuestion, text).behaviors
    wrong = _wrong_behaviors(behaviors, scene)
    if wrong:
        raise AnswerError("; ".join(wrong[:MOST_ERRORS]))
    plan = RecoveryPlan(behaviors=behaviors)
    return mirrored_plan(plan) if scene.mirrored else plan


PARSERS[FORMAT] = parse_answer
PARSERS[FORMAT_1] = partial(parse_answer, chain=False)


# ---- from text to a typed answer


def _read(kind: type[Any], text: str) -> Any:
    try:
        return kind.model_validate_json(extract_json(text), strict=True)
    except NoJsonError as error:
        raise AnswerError(str(error)) from error
    except ValidationError as error:
        raise AnswerError("; ".join(_worded(e) for e in error.errors()[:MOST_ERRORS])) from error


def _worded(error: Any) -> str:
    where = ".".join(str(part) for part in error["loc"])
    return f"{where}: {error['msg']}" if where else str(error["msg"])


# ---- comparison with the scene


def _wrong_steps(analysis: _Analysis, scene: Scene) -> list[str]:
    asked = steps_of(scene)
    return [] if set(analysis.steps) == set(asked) else [f"analysis.steps must be exactly {', '.join(asked)}"]


def _wrong_ids(answer: _Answer, scene: Scene) -> list[str]:
    objects = {o.id for o in scene.objects}
    starts = {w.id for w in scene.waypoints}
    wrong = [f"unknown object {p.object_id!r}" for p in answer.observation.participants if p.object_id not in objects]
    if answer.decision.route_start is not None and answer.decision.route_start not in starts:
        wrong.append(f"unknown waypoint {answer.decision.route_start!r}")
    return wrong + _wrong_behaviors(answer.decision.behaviors or (), scene)


def _wrong_behaviors(behaviors: tuple[Behavior, ...], scene: Scene) -> list[str]:
    objects, starts = {o.id for o in scene.objects}, {w.id for w in scene.waypoints}
    offered = {b.name for b in available(scene)}
    wrong = [f"behavior {b.name} is not available here" for b in behaviors if b.name not in offered]
    for behavior in behaviors:
        for key, value in behavior.model_dump().items():
            if key == "route_start" and value is not None and value not in starts:
                wrong.append(f"{behavior.name}: unknown waypoint {value!r}")
            elif key.endswith("_id") and value is not None and value not in objects:
                wrong.append(f"{behavior.name}: unknown object {value!r}")
    return wrong


def _contradictions(answer: _Answer, scene: Scene) -> list[str]:
    """Return the contradictions in the chain."""
    plan, analysis = answer.decision.behaviors is not None, answer.analysis
    wrong = []
    if plan and not analysis.immobilized and scene.guidance is None:
        wrong.append("behaviors are given although the vehicle is not immobilized and nobody spoke")
    if scene.guidance is not None and analysis.guidance_intent is None:
        wrong.append("the passenger spoke: analysis.guidance_intent must say what is asked")
    if answer.decision.route_start is not None and not answer.decision.replan_route:
        wrong.append("route_start is given although replan_route is false")
    return wrong


# ---- conversion to a decision


def _decision(answer: _Answer, scene: Scene) -> Decision:
    chosen = answer.decision
    plan = None
    if chosen.behaviors is not None:
        plan = RecoveryPlan(
            behaviors=chosen.behaviors, replan_route=chosen.replan_route, route_start=chosen.route_start
        )
    return Decision(
        observation=_observation(answer.observation, scene),
        analysis=_analysis(answer.analysis, scene),
        plan=plan,
        rationale=chosen.rationale,
    )


def _observation(observed: _Observation, scene: Scene) -> Observation:
    """Return the observation with measured distances. The model does not estimate numbers that are measured."""
    by_id = {o.id: o for o in scene.objects}
    return Observation(
        controls=tuple(
            ObservedControl(kind=c.kind, state=c.state, applies=c.applies, distance_m=_distance(c, scene.controls))
            for c in observed.controls
        ),
        participants=tuple(_participant(p, by_id[p.object_id]) for p in observed.participants),
        summary=observed.summary,
    )


def _participant(observed: _Participant, measured: SceneObject) -> Participant:
    return Participant(
        object_id=observed.object_id,
        kind=observed.kind,
        lane=observed.lane,
        distance_m=measured.gap_m,
        intent=observed.intent,
    )


def _distance(observed: _Control, measured: tuple[TrafficControl, ...]) -> float | None:
    return next((c.distance_m for c in measured if c.kind is observed.kind), None)


def _analysis(analyzed: _Analysis, scene: Scene) -> Analysis:
    steps = tuple(
        AnalysisStep(
            id=name,
            question=QUESTIONS[name],
            answer=analyzed.steps[name].answer,
            evidence=analyzed.steps[name].evidence,
        )
        for name in steps_of(scene)
    )
    return Analysis(
        steps=steps,
        immobilized=analyzed.immobilized,
        cause=analyzed.cause,
        wait=analyzed.wait,
        guidance_intent=analyzed.guidance_intent,
        reason=analyzed.reason,
    )
