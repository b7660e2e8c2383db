"""The closed list of behaviours; each is one file."""

from stucksolver.decision.behaviors.base import Abort, Behavior, CannotPlan, Check, Release, Start
from stucksolver.decision.behaviors.borrow_oncoming_lane import BorrowOncomingLane
from stucksolver.decision.behaviors.change_lane import ChangeLane
from stucksolver.decision.behaviors.keep_lane import KeepLane
from stucksolver.decision.behaviors.registry import REGISTRY, AnyBehavior, describe, parse_behavior
from stucksolver.decision.behaviors.wait import Wait

__all__ = [
    "REGISTRY",
    "Abort",
    "AnyBehavior",
    "Behavior",
    "BorrowOncomingLane",
    "CannotPlan",
    "ChangeLane",
    "Check",
    "KeepLane",
    "Release",
    "Start",
    "Wait",
    "describe",
    "parse_behavior",
]
