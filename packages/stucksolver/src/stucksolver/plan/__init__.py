"""Data types that the solver returns."""

from stucksolver.plan.codes import QUESTIONS, CauseCode, Intent, WaitLimits, WaitReason
from stucksolver.plan.decision import (
    Analysis,
    AnalysisStep,
    Decision,
    Observation,
    ObservedControl,
    Participant,
    PictureObject,
    RecoveryPlan,
    ReportedSign,
    ReportedWorkZone,
)
from stucksolver.plan.directive import CONTINUE, Directive, Execute, PathPoint
from stucksolver.plan.guidance_limits import apply_guidance_limits, apply_limits_to_decision
from stucksolver.plan.intent_authorization import intent_authorizes, plan_matches_intent
from stucksolver.plan.lease import Lease
from stucksolver.plan.simple_directives import Continue, Replan, SafeStop
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
    "PictureObject",
    "RecoveryPlan",
    "Replan",
    "ReportedSign",
    "ReportedWorkZone",
    "SafeStop",
    "WaitLimits",
    "WaitReason",
    "apply_guidance_limits",
    "apply_limits_to_decision",
    "intent_authorizes",
    "plan_matches_intent",
]
