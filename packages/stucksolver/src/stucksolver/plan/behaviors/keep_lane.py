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
from stucksolver.plan.frenet_path import STEP_M, FrenetPath, along_lane
from stucksolver.plan.lateral_shift import lanes_between
from stucksolver.plan.object_gaps import bounded_speed, comes_too_near
from stucksolver.plan.path_search import Goal, search_path
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent
from stucksolver.scene.road import LaneDirection

ASKEW_RAD = 0.1
"""Heading to the road from which the path begins in the ego's direction (rad): `TrackingPolicy.askew_rad`."""
SETTLES_M = 15.0
"""Distance ahead at which a turned ego is in the center of its lane (m). Ours."""


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
        path = turned_into_lane(view, start, lane, self.distance_m, self.speed_mps)
        return path or along_lane(lane, start.s_m, start.d_m, self.distance_m, self.speed_mps)

    @property
    def may_cross_red_light(self) -> bool:
        return self.speed_mps <= CREEP_MPS


def turned_into_lane(
    view: FrenetScene, start: BehaviorStart, lane: Lane | None, distance_m: float, speed_mps: float
) -> FrenetPath | None:
    """Return the path of an ego that is turned away from the road's direction, to the center of a lane and along it.

    None if it is not turned, or if no path fits: the guard then judges the path of an ego that steers onto its lane.

    Args:
        view: Surroundings in road coordinates.
        start: Start, with the ego's heading.
        lane: Lane to enter or to stay in, if any.
        distance_m: Length of the path (m); it is longer if the ego needs more to be in the lane.
        speed_mps: Upper bound on the speed (m/s).
    """
    if lane is None or abs(start.yaw_rad) < ASKEW_RAD:
        return None
    lanes = lanes_between(view, start, lane.at(start.s_m)[1])
    goal = Goal(lane.at(start.s_m + SETTLES_M)[1], view.frame.end_m)
    try:
        path = search_path(view, start, goal, lanes).within(speed_mps)
    except NoPathError:
        return None
    rest_m = start.s_m + distance_m - path.end_s
    if rest_m > STEP_M:
        path = path.then(along_lane(lane, path.end_s, path.end_d, rest_m, speed_mps))
    return None if comes_too_near(view, path, start.yaw_rad) else bounded_speed(view, path, start.yaw_rad)


def own_lane(view: FrenetScene, start: BehaviorStart) -> Lane | None:
    """Return the lane at `start`; None off the lanes.

    Raises:
        CannotPlan: The lane belongs to oncoming traffic.
    """
    lane = view.frame.lane_at(start.s_m, start.d_m)
    if lane is not None and lane.strip.direction is LaneDirection.OPPOSITE:
        raise NoPathError(PlanFailure.NOT_OUR_LANE, "the vehicle is in an oncoming lane and must leave it")
    return lane
