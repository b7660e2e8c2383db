"""Drive on in the current lane."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import (
    CREEP_MPS,
    MOVING_CHECKS,
    Behavior,
    BehaviorStart,
    Check,
    NoPathError,
    PlanPhrase,
)
from stucksolver.plan.frenet_path import FrenetPath, along_lane
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent
from stucksolver.scene.road import LaneDirection


class KeepLane(Behavior):
    """Drive on in the lane the ego is in when it begins."""

    summary: ClassVar[str] = "Drive on for distance_m metres in the current lane, at up to speed_mps."
    phrase: ClassVar[PlanPhrase] = PlanPhrase("drive on in my lane", "driving on in my lane")
    checks: ClassVar[tuple[Check, ...]] = MOVING_CHECKS
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.GO,)
    stays_behind_blocker: ClassVar[bool] = True
    solution_rank: ClassVar[int | None] = 70

    name: Literal["keep_lane"] = "keep_lane"
    distance_m: float = Field(ge=0.5, le=150.0)
    speed_mps: float = Field(gt=0.5, le=11.0)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path along the ego's lane. See `Behavior.maneuver`."""
        lane = own_lane(view, start)
        return along_lane(lane, start.s_m, start.d_m, self.distance_m, self.speed_mps)

    @property
    def may_cross_red_light(self) -> bool:
        return self.speed_mps <= CREEP_MPS


def own_lane(view: FrenetScene, start: BehaviorStart) -> Lane | None:
    """Return the lane at `start`; None off the lanes.

    Raises:
        CannotPlan: The lane belongs to oncoming traffic.
    """
    lane = view.frame.lane_at(start.s_m, start.d_m)
    if lane is not None and lane.strip.direction is LaneDirection.OPPOSITE:
        raise NoPathError(PlanFailure.NOT_OUR_LANE, "the vehicle is in an oncoming lane and must leave it")
    return lane
