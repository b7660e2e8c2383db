"""What the solver answers."""

from stucksolver.decision.codes import QUESTIONS, CauseCode, GuidanceIntent, Intent, WaitLimits, WaitReason
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
]
