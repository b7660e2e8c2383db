"""The data that the solver returns."""

from stucksolver.decision.codes import QUESTIONS, CauseCode, Intent, WaitLimits, WaitReason
from stucksolver.decision.decision import (
    Analysis,
    AnalysisStep,
    Decision,
    Observation,
    ObservedControl,
    Participant,
    RecoveryPlan,
)
from stucksolver.decision.directive import CONTINUE, Continue, Directive, Execute, PathPoint, Replan, SafeStop
from stucksolver.decision.lease import Lease
from stucksolver.decision.release import asks_for, releases
from stucksolver.decision.said import as_said, decided_as_said
from stucksolver.scene.reading import GuidanceIntent

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
