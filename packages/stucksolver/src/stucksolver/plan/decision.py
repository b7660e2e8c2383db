"""Answer of a reasoner: observation, analysis and decision.

The reasoning chain follows Bao and Li 2025 (arXiv:2510.26023).
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from stucksolver.plan.behaviors.registry import AnyBehavior
from stucksolver.plan.codes import CauseCode, Intent, WaitReason
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.interpretation import GuidanceIntent
from stucksolver.scene.objects import ObjectKind
from stucksolver.scene.scene import LaneRelation
from stucksolver.scene.surroundings import ControlKind, LightState


class ObservedControl(FrozenModel):
    """Traffic control as the reasoner observes it."""

    kind: ControlKind
    state: LightState | None
    applies: bool | None
    distance_m: float | None
    """Distance along the route (m); None if only the image shows the control."""


class Participant(FrozenModel):
    """Relevant road user or obstacle, with its lane and its intent."""

    object_id: str
    kind: ObjectKind
    lane: LaneRelation
    distance_m: float | None
    intent: Intent


class ReportedSign(FrozenModel):
    """Sign with its content as the reasoner reads it. It is evidence for people, never an input of the guard."""

    content: str = Field(max_length=120)
    object_id: str | None = None
    """Id of the object that carries it; None if no tracked object does."""


class ReportedWorkZone(FrozenModel):
    """Work zone on the route, with its measured extent from the ego's front bumper (m); None if it is not measured."""

    start_m: float | None = None
    end_m: float | None = None


class PictureObject(FrozenModel):
    """Object that only the image shows, with its direction from the ego's heading and its rough distance."""

    kind: ObjectKind
    bearing_deg: float = Field(ge=-180.0, le=180.0)
    """Bearing (deg), left positive."""
    distance_m: float = Field(ge=0.0, le=1000.0)


class Observation(FrozenModel):
    """Step 1: observation of the scene. `signs` and the fields after it are empty in old records."""

    controls: tuple[ObservedControl, ...]
    participants: tuple[Participant, ...]
    summary: str
    signs: tuple[ReportedSign, ...] = ()
    work_zone: ReportedWorkZone | None = None
    picture_only: tuple[PictureObject, ...] = ()


class AnalysisStep(FrozenModel):
    """One question of the reasoning chain."""

    id: str
    question: str
    answer: bool | None
    """None if the scene does not contain the answer."""
    evidence: str


class Analysis(FrozenModel):
    """Step 2: the questions of the reasoning chain, and the conclusions."""

    steps: tuple[AnalysisStep, ...]
    immobilized: bool
    cause: CauseCode | None = None
    wait: WaitReason | None = None
    """Reason for a legitimate wait, if the ego should wait."""
    guidance_intent: GuidanceIntent | None = None
    reason: str


class RecoveryPlan(FrozenModel):
    """Step 3: behaviors to perform in order, and whether to replan the route."""

    behaviors: tuple[AnyBehavior, ...] = Field(min_length=1, max_length=6)
    replan_route: bool = False
    route_start: str | None = None
    """Id of a candidate waypoint of the scene; None to replan from the present position."""


class Decision(FrozenModel):
    """Decision of a reasoner. `plan` is None if no action is needed, or no safe action is possible."""

    version: Literal[1] = 1
    observation: Observation
    analysis: Analysis
    plan: RecoveryPlan | None
    rationale: str
