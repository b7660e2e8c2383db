"""The closed list of behaviours, one file each."""

from stucksolver.decision.behaviors.back_up import BackUp
from stucksolver.decision.behaviors.base import Abort, Behavior, CannotPlan, Check, Release, Start
from stucksolver.decision.behaviors.borrow_oncoming_lane import BorrowOncomingLane
from stucksolver.decision.behaviors.change_lane import ChangeLane
from stucksolver.decision.behaviors.creep import Creep
from stucksolver.decision.behaviors.drive_over import DriveOver
from stucksolver.decision.behaviors.follow_vehicle import FollowVehicle
from stucksolver.decision.behaviors.hazard_lights import HazardLights
from stucksolver.decision.behaviors.keep_lane import KeepLane
from stucksolver.decision.behaviors.nose_out import NoseOut
from stucksolver.decision.behaviors.nudge import Nudge
from stucksolver.decision.behaviors.pull_over import PullOver
from stucksolver.decision.behaviors.registry import REGISTRY, AnyBehavior, describe, parse_behavior
from stucksolver.decision.behaviors.rejoin_route import RejoinRoute
from stucksolver.decision.behaviors.replan import ReplanRoute
from stucksolver.decision.behaviors.request_assistance import RequestAssistance
from stucksolver.decision.behaviors.turn_round import TurnRound
from stucksolver.decision.behaviors.wait import Wait

__all__ = [
    "REGISTRY",
    "Abort",
    "AnyBehavior",
    "BackUp",
    "Behavior",
    "BorrowOncomingLane",
    "CannotPlan",
    "ChangeLane",
    "Check",
    "Creep",
    "DriveOver",
    "FollowVehicle",
    "HazardLights",
    "KeepLane",
    "NoseOut",
    "Nudge",
    "PullOver",
    "RejoinRoute",
    "Release",
    "ReplanRoute",
    "RequestAssistance",
    "Start",
    "TurnRound",
    "Wait",
    "describe",
    "parse_behavior",
]
