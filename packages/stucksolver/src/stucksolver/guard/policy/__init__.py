"""Numbers of the guard, in one place, and the approvals that it requires. All of them are stored in each record."""

from stucksolver.guard.policy.approvals import NOBODY, RANKS, RULES, SCENES, Approvals
from stucksolver.guard.policy.clearances import ClearancePolicy, DoorPolicy, PassablePolicy, PeoplePolicy
from stucksolver.guard.policy.ego import (
    HandBackPolicy,
    HarmPolicy,
    SpeedPolicy,
    StoppingPolicy,
    TrackingPolicy,
    TurningPolicy,
)
from stucksolver.guard.policy.other_road_users import EntryPolicy, OncomingPolicy, PredictionPolicy, RssPolicy
from stucksolver.guard.policy.policy import GuardPolicy
from stucksolver.guard.policy.road import (
    BackingPolicy,
    ControlPolicy,
    LanePolicy,
    QueuePolicy,
    ScenePolicy,
    SightPolicy,
)

__all__ = [
    "NOBODY",
    "RANKS",
    "RULES",
    "SCENES",
    "Approvals",
    "BackingPolicy",
    "ClearancePolicy",
    "ControlPolicy",
    "DoorPolicy",
    "EntryPolicy",
    "GuardPolicy",
    "HandBackPolicy",
    "HarmPolicy",
    "LanePolicy",
    "OncomingPolicy",
    "PassablePolicy",
    "PeoplePolicy",
    "PredictionPolicy",
    "QueuePolicy",
    "RssPolicy",
    "ScenePolicy",
    "SightPolicy",
    "SpeedPolicy",
    "StoppingPolicy",
    "TrackingPolicy",
    "TurningPolicy",
]
