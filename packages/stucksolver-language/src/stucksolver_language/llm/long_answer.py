"""The long form of an answer: observation, analysis and decision along the chain of the paper."""

from __future__ import annotations

from pydantic import Field

from stucksolver.plan import (
    QUESTIONS,
    Analysis,
    AnalysisStep,
    CauseCode,
    GuidanceIntent,
    Intent,
    Observation,
    ObservedControl,
    Participant,
    PictureObject,
    ReportedSign,
    WaitReason,
)
from stucksolver.plan.behaviors.registry import AnyBehavior
from stucksolver.scene import ControlKind, LaneRelation, LightState, ObjectKind, Scene, SceneObject, TrafficControl
from stucksolver.scene.base_model import FrozenModel
from stucksolver_language.llm.tool_schema import (
    MOST_BEHAVIORS,
    MOST_CONTROLS,
    MOST_PARTICIPANTS,
    MOST_SIGNS,
    steps_of,
)
from stucksolver_language.llm.work_zones import work_zone_of


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
    signs: tuple[ReportedSign, ...] = Field(default=(), max_length=MOST_SIGNS)
    work_zone: bool = False
    picture_only: tuple[PictureObject, ...] = Field(default=(), max_length=MOST_SIGNS)


class LongAnalysis(FrozenModel):
    """Second step of the long form."""

    steps: dict[str, _Step]
    immobilized: bool
    cause: CauseCode | None
    wait: WaitReason | None
    guidance_intent: GuidanceIntent | None
    reason: str


class _Decision(FrozenModel):
    choice: str | None = None
    """Letter of a plan of the menu."""
    rationale: str
    behaviors: tuple[AnyBehavior, ...] | None = Field(min_length=1, max_length=MOST_BEHAVIORS)
    replan_route: bool
    route_start: str | None


class LongAnswer(FrozenModel):
    """Answer in the long form. Fields with a default are missing in answers of older versions.

    The names of the fields are those of the schema.
    """

    observation: _Observation
    analysis: LongAnalysis
    decision: _Decision


def observation_of(answer: LongAnswer, scene: Scene) -> Observation:
    """Return the observation with measured distances. The model does not estimate numbers that are measured."""
    by_id, observed = {o.id: o for o in scene.objects}, answer.observation
    return Observation(
        controls=tuple(
            ObservedControl(kind=c.kind, state=c.state, applies=c.applies, distance_m=_distance(c, scene.controls))
            for c in observed.controls
        ),
        participants=tuple(_participant(p, by_id[p.object_id]) for p in observed.participants),
        summary=observed.summary,
        signs=observed.signs,
        work_zone=work_zone_of(scene) if observed.work_zone else None,
        picture_only=observed.picture_only,
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


def analysis_of(answer: LongAnswer, scene: Scene) -> Analysis:
    """Return the second step: the answers to the questions that apply, and the conclusions."""
    analyzed = answer.analysis
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
