"""The data that the solver returns."""

from stucksolver.plan.codes import QUESTIONS, CauseCode, Intent, WaitLimits, WaitReason
from stucksolver.plan.decision import (
    Analysis,
    AnalysisStep,
    Decision,
    Observation,
    ObservedControl,
    Participant,
    RecoveryPlan,
)
from stucksolver.plan.directive import CONTINUE, Continue, Directive, Execute, PathPoint, Replan, SafeStop
from stucksolver.plan.guidance_limits import as_said, decided_as_said
from stucksolver.plan.intent_authorization import asks_for, releases
from stucksolver.plan.lease import Lease
from stucksolver.scene.interpretation import GuidanceIntent

__all__ = [
    "CONTINUE",
    "QUESTIONS",
    "Analysis",
    "AnalysisStep",
    "CauseCode",
    "Continue",
    "Decision",
    "Directive",
    "Execute",
    "GuidanceIntent",
    "Intent",
    "Lease",
    "Observation",
    "ObservedControl",
    "Participant",
    "PathPoint",
    "RecoveryPlan",
    "Replan",
    "SafeStop",
    "WaitLimits",
    "WaitReason",
    "as_said",
    "asks_for",
    "decided_as_said",
    "releases",
]
