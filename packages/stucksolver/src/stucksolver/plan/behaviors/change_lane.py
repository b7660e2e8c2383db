"""Move into the adjacent lane in the same direction."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import MOVING_CHECKS, AbortAction, Behavior, BehaviorStart, Check, NoPathError
from stucksolver.plan.frenet_path import FrenetPath, along_lane, landing_m
from stucksolver.plan.lateral_shift import lateral_shift
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.road import LaneDirection, LaneKind


class ChangeLane(Behavior):
    """Change to the adjacent lane on one side and stay in it for a while."""

    summary: ClassVar[str] = (
        "Change into the adjacent lane in the same direction on `side` and follow it at up to speed_mps, for "
        "distance_m metres in all."
    )
    checks: ClassVar[tuple[Check, ...]] = (*MOVING_CHECKS, Check.MARKING, Check.LANE_ENTRY)
    abort_after_commit: ClassVar[AbortAction] = AbortAction.FINISH

    name: Literal["change_lane"] = "change_lane"
    side: Literal["left", "right"]
    distance_m: float = Field(ge=15.0, le=150.0)
    speed_mps: float = Field(gt=0.5, le=11.0)

    def target(self, view: FrenetScene, start: BehaviorStart) -> Lane:
        """Return the lane to change to.

        Raises:
            CannotPlan: There is no driving lane in the ego's direction on that side.
        """
        lane = view.frame.beside(start.s_m, start.d_m, +1 if self.side == "left" else -1)
        if lane is None or lane.strip.kind is not LaneKind.DRIVING:
            raise NoPathError(PlanFailure.NO_LANE, f"there is no driving lane on the {self.side}")
        if lane.strip.direction is LaneDirection.OPPOSITE:
            raise NoPathError(PlanFailure.NOT_OUR_LANE, f"the lane on the {self.side} belongs to oncoming traffic")
        return lane

    def manoeuvre(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path into the adjacent lane and along it. See `Behavior.manoeuvre`."""
        lane = self.target(view, start)
        sideways = lateral_shift(view, start, lane.at(start.s_m + 15.0)[1], self.speed_mps)
        rest = max(start.s_m + self.distance_m - sideways.end_s, landing_m(self.speed_mps) + 2.0)
        path = sideways.then(along_lane(lane, sideways.end_s, sideways.end_d, rest, self.speed_mps))
        return FrenetPath(path.s, path.d, path.speed, (lane,), (), returns=abs(path.end_d) < 1.0)
