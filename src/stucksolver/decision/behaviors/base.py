"""What every behaviour is made of: parameters with bounds, a precondition, a path, a time allowance."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from stucksolver.decision.manoeuvre import Manoeuvre
from stucksolver.scene.attempts import PlanFailure
from stucksolver.scene.model import Model
from stucksolver.scene.road import LaneDirection, ZoneKind
from stucksolver.scene.view import FrenetScene


class Check(str, Enum):
    """The guard's checks; every behaviour names those it must pass."""

    COLLISION = "collision"
    DRIVABLE_AREA = "drivable_area"
    SPEED = "speed"
    STOP_LINE = "stop_line"
    MARKING = "marking"
    ONCOMING = "oncoming"
    LANE_ENTRY = "lane_entry"
    OFF_ROUTE = "off_route"
    AUTHORITY = "authority"
    CREEP_SPEED = "creep_speed"
    WITHIN_LANE = "within_lane"
    STOPPING_PLACE = "stopping_place"
    BACKING_PLACE = "backing_place"
    TURNING = "turning"
    ROADSIDE = "roadside"
    PASSABLE = "passable"
    PATIENCE = "patience"
    SEEN_FREE = "seen_free"


class Abort(str, Enum):
    """The safe way out of a behaviour."""

    STOP = "stop"
    RETURN_TO_LANE = "return_to_lane"
    FINISH = "finish"
    GIVE_WAY = "give_way"
    """No end of it: brake for somebody whom going on would meet, then finish. Where no stop may be made to stay."""


class Release(str, Enum):
    """Who must say yes before something is done."""

    AUTONOMOUS = "autonomous"
    PASSENGER = "passenger"
    OPERATOR = "operator"


MOVING_CHECKS = (
    Check.COLLISION,
    Check.DRIVABLE_AREA,
    Check.SPEED,
    Check.STOP_LINE,
    Check.OFF_ROUTE,
    Check.AUTHORITY,
)
CREEP_MPS = 2.2
"""Just under the 8 km/h of all that must be slow."""


@dataclass(frozen=True)
class Start:
    """Where a behaviour begins: arc length, lateral offset and speed of the ego."""

    s_m: float
    d_m: float
    speed_mps: float


class Behavior(Model, ABC):
    """One entry of the closed list. Instances hold the parameters of one call."""

    checks: ClassVar[tuple[Check, ...]] = ()
    abort_after_commit: ClassVar[Abort] = Abort.FINISH
    stands_still: ClassVar[bool] = False
    reverse: ClassVar[bool] = False
    """Backs up: `view` and `start` are then those of `FrenetScene.backwards`."""
    prepares: ClassVar[bool] = False
    """Is it done for the sake of what follows, so that the vehicle need not have got on after it?"""
    release: ClassVar[Release] = Release.AUTONOMOUS
    """Who may release it where the policy does not say otherwise."""
    summary: ClassVar[str]
    """One sentence: what it does. Shown to models and in the documents."""

    name: str

    def precondition(self, view: FrenetScene) -> str | None:
        """Why it cannot be done here now, or None."""
        return None

    @abstractmethod
    def manoeuvre(self, view: FrenetScene, start: Start) -> Manoeuvre | None:
        """Its path from `start`; None for one that stands still, or that follows no road. Raises `CannotPlan`."""

    def done(self, view: FrenetScene) -> bool:
        """Is its purpose reached before its path or its time is at an end?"""
        return False

    def time_allowance_s(self, expected_s: float) -> float:
        """After how long it is given up, for an expected duration."""
        return 2.0 * expected_s + 5.0


class Standing(Behavior):
    """A behaviour without a path: the vehicle stands, or comes to rest where it is."""

    stands_still: ClassVar[bool] = True

    def precondition(self, view: FrenetScene) -> str | None:
        return no_place_to_stand(view)

    def manoeuvre(self, view: FrenetScene, start: Start) -> Manoeuvre | None:
        return None


def no_place_to_stand(view: FrenetScene) -> str | None:
    """Why the ego must not stay where it is: a stop is not safe there."""
    lane = view.ego_lane
    if lane is not None and lane.strip.direction is LaneDirection.OPPOSITE:
        return "the ego is in an oncoming lane, where a stop is not safe"
    if view.zone_at(view.ego_s, ZoneKind.LEVEL_CROSSING) is not None:
        return "the ego is on a level crossing, where a stop is not safe"
    return None


class CannotPlan(Exception):
    """No path exists for a behaviour here; `failure` says why, and the message says it to people."""

    def __init__(self, failure: PlanFailure, text: str) -> None:
        super().__init__(text)
        self.failure = failure
