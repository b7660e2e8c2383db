"""What a reasoner answers: observation, analysis, decision, the chain of Bao and Li 2025 (arXiv:2510.26023)."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from stucksolver.decision.behaviors.registry import AnyBehavior
from stucksolver.decision.codes import CauseCode, Intent, WaitReason
from stucksolver.scene.model import Model
from stucksolver.scene.objects import ObjectKind
from stucksolver.scene.reading import GuidanceIntent
from stucksolver.scene.scene import LaneRelation
from stucksolver.scene.surroundings import ControlKind, LightState


class ObservedControl(Model):
    """A traffic control as the reasoner sees it."""

    kind: ControlKind
    state: LightState | None
    applies: bool | None
    distance_m: float | None
    """None where only the image shows it."""


class Participant(Model):
    """A road user or obstacle that matters, with its lane and what it is about to do."""

    object_id: str
    kind: ObjectKind
    lane: LaneRelation
    distance_m: float | None
    intent: Intent


class Observation(Model):
    """Step 1."""

    controls: tuple[ObservedControl, ...]
    participants: tuple[Participant, ...]
    summary: str


class AnalysisStep(Model):
    """One question of the chain."""

    id: str
    question: str
    answer: bool | None
    """None: cannot be told from the scene."""
    evidence: str


class Analysis(Model):
    """Step 2."""

    steps: tuple[AnalysisStep, ...]
    immobilized: bool
    cause: CauseCode | None = None
    wait: WaitReason | None = None
    """Why waiting is right, when it is."""
    guidance_intent: GuidanceIntent | None = None
    reason: str


class RecoveryPlan(Model):
    """Step 3: behaviours to perform one after the other, and whether to plan the route anew."""

    behaviors: tuple[AnyBehavior, ...] = Field(min_length=1, max_length=6)
    replan_route: bool = False
    route_start: str | None = None
    """Id of a candidate waypoint of the scene."""


class Decision(Model):
    """`plan` is None when the vehicle is not stuck, or nothing safe can be done: the stack then drives on."""

    version: Literal[1] = 1
    observation: Observation
    analysis: Analysis
    plan: RecoveryPlan | None
    rationale: str
