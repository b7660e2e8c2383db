"""The closed list of behaviors, one file each."""

from stucksolver.plan.behaviors.back_up import BackUp
from stucksolver.plan.behaviors.behavior import (
    AbortAction,
    ApprovalLevel,
    Behavior,
    BehaviorStart,
    Check,
    ExecutorKind,
    LegBehavior,
    NoPathError,
    PlanPhrase,
    StationaryBehavior,
    drives_legs,
)
from stucksolver.plan.behaviors.borrow_oncoming_lane import BorrowOncomingLane
from stucksolver.plan.behaviors.change_lane import ChangeLane
from stucksolver.plan.behaviors.creep import Creep
from stucksolver.plan.behaviors.drive_over import DriveOver
from stucksolver.plan.behaviors.follow_vehicle import FollowVehicle
from stucksolver.plan.behaviors.hazard_lights import HazardLights
from stucksolver.plan.behaviors.keep_lane import KeepLane
from stucksolver.plan.behaviors.nose_out import NoseOut
from stucksolver.plan.behaviors.nudge import Nudge
from stucksolver.plan.behaviors.pull_over import PullOver
from stucksolver.plan.behaviors.registry import (
    REGISTRY,
    AnyBehavior,
    describe,
    names_with,
    parse_behavior,
    register,
    unregister,
)
from stucksolver.plan.behaviors.rejoin_route import RejoinRoute
from stucksolver.plan.behaviors.replan_route import ReplanRoute
from stucksolver.plan.behaviors.request_assistance import RequestAssistance
from stucksolver.plan.behaviors.turn_around import TurnAround
from stucksolver.plan.behaviors.wait import Wait

__all__ = [
    "REGISTRY",
    "AbortAction",
    "AnyBehavior",
    "ApprovalLevel",
    "BackUp",
    "Behavior",
    "BehaviorStart",
    "BorrowOncomingLane",
    "ChangeLane",
    "Check",
    "Creep",
    "DriveOver",
    "ExecutorKind",
    "FollowVehicle",
    "HazardLights",
    "KeepLane",
    "LegBehavior",
    "NoPathError",
    "NoseOut",
    "Nudge",
    "PlanPhrase",
    "PullOver",
    "RejoinRoute",
    "ReplanRoute",
    "RequestAssistance",
    "StationaryBehavior",
    "TurnAround",
    "Wait",
    "describe",
    "drives_legs",
    "names_with",
    "parse_behavior",
    "register",
    "unregister",
]
