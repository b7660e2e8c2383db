"""The bases of all behaviors. A behavior states all facts about itself, so that no other module has to know it.

Its parameters have bounds. It states how it is executed, which checks it must pass, which intents of a passenger it
carries out, on which side it passes, and how a sentence for people names it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, TypeGuard

from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.plan.simple_directives import Replan, SafeStop
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import DirectedSide, GuidanceIntent, GuidanceLimits, Interpretation
from stucksolver.scene.road import LaneDirection, ZoneKind
from stucksolver.scene.scene import Scene

if TYPE_CHECKING:
    from stucksolver.plan.multi_point_turn import Leg


class Check(str, Enum):
    """The guard's checks. Every behavior lists those that it must pass."""

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
    NO_WORSE_PLACE = "no_worse_place"
    TURNING = "turning"
    ROADSIDE = "roadside"
    PASSABLE = "passable"
    PATIENCE = "patience"
    SEEN_FREE = "seen_free"


class AbortAction(str, Enum):
    """The safe way to end a behavior early."""

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


class ExecutorKind(str, Enum):
    """How a behavior is executed."""

    STOP = "stop"
    """The vehicle stays stopped."""
    PATH = "path"
    """The vehicle drives one path in road coordinates, proven together with those of its neighbors in the plan."""
    LEGS = "legs"
    """The vehicle drives legs in the plane. Each is proven when the vehicle has stopped at its start."""


@dataclass(frozen=True)
class PlanPhrase:
    """`future` completes "I will ..." and "May I ...?"; `present` completes "I am ...".

    A parameter of the behavior may stand in braces: `{side}`.
    """

    future: str
    present: str


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
    """The ego where a behavior begins: arc length (m), lateral offset (m), speed (m/s) and heading (rad)."""

    s_m: float
    d_m: float
    speed_mps: float
    yaw_rad: float = 0.0


class Behavior(FrozenModel, ABC):
    """One behavior of the closed list. An instance holds the parameters of one call.

    The class attributes and the methods with a default are the facts that other modules ask for.
    """

    summary: ClassVar[str]
    """One sentence that says what it does, shown to models and in the documentation."""
    phrase: ClassVar[PlanPhrase]
    """How sentences for passengers and operators name it."""
    approval_note: ClassVar[str | None] = None
    """Sentence for the person who is asked to approve it, if the phrase alone does not say enough."""

    executor: ClassVar[ExecutorKind] = ExecutorKind.PATH
    checks: ClassVar[tuple[Check, ...]] = ()
    """The guard's checks that it must pass."""
    stopping_place_detail: ClassVar[str | None] = None
    """Detail of the rejection if it stands still where a vehicle must not stop; None if it may be done there."""
    abort_after_commit: ClassVar[AbortAction] = AbortAction.FINISH
    reverse: ClassVar[bool] = False
    """The behavior backs up. `view` and `start` are then in the frame of `FrenetScene.backwards`."""
    prepares: ClassVar[bool] = False
    """The behavior only prepares the next one, so the vehicle need not have moved on after it."""
    starts_at_roadside: ClassVar[bool] = False
    """It starts where the ego is stopped safely beside the traffic. The solver waits there after any rejection."""
    release: ClassVar[ApprovalLevel] = ApprovalLevel.AUTONOMOUS
    """Who must approve it, unless the policy says otherwise."""

    intents: ClassVar[tuple[GuidanceIntent, ...]] = ()
    """The intents of a passenger that it carries out, the main one first. They authorize a plan that contains it."""
    shifts_laterally: ClassVar[bool] = False
    """It moves the ego sideways, to pass an object or to prepare a pass. "Go" does not authorize a plan with it."""
    stays_behind_blocker: ClassVar[bool] = False
    """It moves the ego along the lane only, so that it does not pass an object in the lane."""
    calls_person: ClassVar[bool] = False
    """It stops the ego and calls a person for help."""
    solution_rank: ClassVar[int | None] = None
    """Rank among the behaviors of a plan that helped. The plan is remembered by the main intent of the lowest rank.

    None for requests and last resorts, which are not remembered.
    """
    outranks_replan: ClassVar[bool] = False
    """A plan that ends with a new route is remembered by this behavior and not by the new route."""

    name: str

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        """True if the scene has something that it can act on; otherwise it is left out of the prompt."""
        return True

    def precondition(self, view: FrenetScene) -> str | None:
        """Return why it cannot be done here now, or None."""
        return None

    @abstractmethod
    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath | None:
        """Return the path from `start`, in the road coordinates of `view`.

        Returns:
            The path; None for a behavior that stands still or follows no road.

        Raises:
            CannotPlan: There is no path here.
        """

    def done(self, view: FrenetScene) -> bool:
        """True if its purpose has been achieved before the end of its path or its time allowance."""
        return False

    def time_allowance_s(self, expected_s: float) -> float:
        """Return the time after which it is given up (s), given its expected duration (s)."""
        return 2.0 * expected_s + 5.0

    def directive(self) -> Replan | SafeStop | None:
        """Return the directive that performs it; None if it is performed by `Execute`."""
        return None

    def guided_parameters(self, reading: Interpretation, limits: GuidanceLimits) -> dict[str, float]:
        """Return the values that a passenger gave to its parameters, by name. The caller keeps them within the bounds.

        A distance counts for a behavior that carries out the intent. "Overtake" says nothing about the path's length.
        Speeds are not among the values, because every behavior takes them as an upper limit.
        """
        asked = reading.intent in self.intents and reading.intent is not GuidanceIntent.OVERTAKE
        if limits.distance_m is None or not asked or "distance_m" not in type(self).model_fields:
            return {}
        return {"distance_m": limits.distance_m}

    @property
    def stands_still(self) -> bool:
        """True if the vehicle stays stopped."""
        return self.executor is ExecutorKind.STOP

    @property
    def passing_side(self) -> DirectedSide | None:
        """Side on which it passes an object; None if it passes none."""
        return None

    @property
    def may_cross_red_light(self) -> bool:
        """True if an operator may be asked to approve a red light on its path, when the plan has no other behavior."""
        return False

    @property
    def hazard_lights_on(self) -> bool | None:
        """Whether it switches the hazard lights on or off; None if it leaves them as they are."""
        return None


class StationaryBehavior(Behavior):
    """A behavior without a path: the vehicle stops where it is and stays."""

    executor: ClassVar[ExecutorKind] = ExecutorKind.STOP

    def precondition(self, view: FrenetScene) -> str | None:
        return no_place_to_stand(view)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath | None:
        """Return None: it stands still."""
        return None


class LegBehavior(Behavior):
    """A behavior without a path along the road: its legs are paths in the plane."""

    executor: ClassVar[ExecutorKind] = ExecutorKind.LEGS

    speed_mps: float

    @abstractmethod
    def legs(self, view: FrenetScene) -> tuple[Leg, ...]:
        """Return the remaining legs from where the vehicle is.

        Raises:
            CannotPlan: There are none.
        """

    @abstractmethod
    def must_finish(self, view: FrenetScene) -> bool:
        """True if the vehicle is where it should finish the legs rather than stop, also if the plan is withdrawn."""

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath | None:
        """Return None: the legs are paths in the plane."""
        return None


def drives_legs(behavior: Behavior) -> TypeGuard[LegBehavior]:
    """True if the behavior is executed leg by leg."""
    return behavior.executor is ExecutorKind.LEGS


def no_place_to_stand(view: FrenetScene) -> str | None:
    """Return why the ego must not stay where it is, or None if a stop here is safe."""
    lane = view.ego_lane
    if lane is not None and lane.strip.direction is LaneDirection.OPPOSITE:
        return "the ego is in an oncoming lane, where a stop is not safe"
    if view.zone_at(view.ego_s, ZoneKind.LEVEL_CROSSING) is not None:
        return "the ego is on a level crossing, where a stop is not safe"
    return None


class NoPathError(Exception):
    """There is no path for a behavior here. The message is for people.

    Attributes:
        failure: Code.
        object_id: Object that lacks the most clearance or room; None if no object does.
        short_m: Lack of clearance from this object, or of length along the road (m); None if it is unknown.
    """

    def __init__(
        self,
        failure: PlanFailure,
        text: str,
        *,
        object_id: str | None = None,
        short_m: float | None = None,
        find_back_up: Callable[[], float | None] | None = None,
    ) -> None:
        super().__init__(text)
        self.failure = failure
        self.object_id = object_id
        self.short_m = short_m
        self._find_back_up = find_back_up

    @cached_property
    def back_up_m(self) -> float | None:
        """Distance by which the ego must back up for a path (m); None if backing up is not known to help.

        It is computed when it is read, because it takes as long as several path searches.
        """
        return None if self._find_back_up is None else self._find_back_up()

    def said_as(
        self, failure: PlanFailure, text: str, object_id: str | None = None, short_m: float | None = None
    ) -> NoPathError:
        """Return the same error with another code and text, and with another object and lack (m) if given."""
        object_id, short_m = object_id or self.object_id, self.short_m if short_m is None else short_m
        return NoPathError(failure, text, object_id=object_id, short_m=short_m, find_back_up=self._find_back_up)
