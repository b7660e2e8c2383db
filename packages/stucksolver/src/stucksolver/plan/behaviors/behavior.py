"""The base of every behaviour: parameters with bounds, a precondition, a path and a time allowance."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.road import LaneDirection, ZoneKind


class Check(str, Enum):
    """The guard's checks. Every behaviour lists those that it must pass."""

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


class AbortAction(str, Enum):
    """The safe way to end a behaviour early."""

    STOP = "stop"
    RETURN_TO_LANE = "return_to_lane"
    FINISH = "finish"
    YIELD = "give_way"
    """Do not end it: brake for whoever would be hit, then finish. For places where the vehicle must not stay."""
    STOP_SOON = "stop_soon"
    """Perception has failed: go no faster than now, and stop where the path first leads to a place to stop."""


class ApprovalLevel(str, Enum):
    """Who must approve something before it is done."""

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
"""Just under 8 km/h, the limit for everything that must be done slowly (m/s)."""


@dataclass(frozen=True)
class BehaviorStart:
    """The ego where a behaviour begins: arc length (m), lateral offset (m), speed (m/s) and heading (rad)."""

    s_m: float
    d_m: float
    speed_mps: float
    yaw_rad: float = 0.0


class Behavior(FrozenModel, ABC):
    """One behaviour of the closed list. An instance holds the parameters of one call."""

    checks: ClassVar[tuple[Check, ...]] = ()
    abort_after_commit: ClassVar[AbortAction] = AbortAction.FINISH
    stands_still: ClassVar[bool] = False
    reverse: ClassVar[bool] = False
    """The behaviour backs up. `view` and `start` are then in the frame of `FrenetScene.backwards`."""
    prepares: ClassVar[bool] = False
    """The behaviour only prepares the next one, so the vehicle need not have moved on after it."""
    release: ClassVar[ApprovalLevel] = ApprovalLevel.AUTONOMOUS
    """Who must approve it, unless the policy says otherwise."""
    summary: ClassVar[str]
    """One sentence that says what it does, shown to models and in the documentation."""

    name: str

    def precondition(self, view: FrenetScene) -> str | None:
        """Return why it cannot be done here now, or None."""
        return None

    @abstractmethod
    def manoeuvre(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath | None:
        """Return the path from `start`, in the road coordinates of `view`.

        Returns:
            The path; None for a behaviour that stands still or follows no road.

        Raises:
            CannotPlan: There is no path here.
        """

    def done(self, view: FrenetScene) -> bool:
        """True if its purpose has been achieved before the end of its path or its time allowance."""
        return False

    def time_allowance_s(self, expected_s: float) -> float:
        """Return the time after which it is given up (s), given its expected duration (s)."""
        return 2.0 * expected_s + 5.0


class StationaryBehavior(Behavior):
    """A behaviour without a path: the vehicle stops where it is and stays."""

    stands_still: ClassVar[bool] = True

    def precondition(self, view: FrenetScene) -> str | None:
        return no_place_to_stand(view)

    def manoeuvre(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath | None:
        """Return None: it stands still."""
        return None


def no_place_to_stand(view: FrenetScene) -> str | None:
    """Return why the ego must not stay where it is, or None if a stop here is safe."""
    lane = view.ego_lane
    if lane is not None and lane.strip.direction is LaneDirection.OPPOSITE:
        return "the ego is in an oncoming lane, where a stop is not safe"
    if view.zone_at(view.ego_s, ZoneKind.LEVEL_CROSSING) is not None:
        return "the ego is on a level crossing, where a stop is not safe"
    return None


class NoPathError(Exception):
    """There is no path for a behaviour here. `failure` is the code; the message is for people."""

    def __init__(self, failure: PlanFailure, text: str) -> None:
        super().__init__(text)
        self.failure = failure
