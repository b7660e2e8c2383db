"""Move into the adjacent lane in the same direction."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import (
    MOVING_CHECKS,
    AbortAction,
    Behavior,
    BehaviorStart,
    Check,
    NoPathError,
    PlanPhrase,
)
from stucksolver.plan.frenet_path import FrenetPath, along_lane, landing_m
from stucksolver.plan.lateral_shift import lateral_shift
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import DirectedSide, GuidanceIntent
from stucksolver.scene.road import LaneDirection, LaneKind
from stucksolver.scene.scene import LaneRelation, Scene


class ChangeLane(Behavior):
    """Change to the adjacent lane on one side and stay in it for a while."""

    summary: ClassVar[str] = (
        "Change into the adjacent lane in the same direction on `side` and follow it at up to speed_mps, for "
        "distance_m metres in all."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase(
        "go round it in the lane on the {side}", "changing to the lane on the {side}"
    )
    checks: ClassVar[tuple[Check, ...]] = (*MOVING_CHECKS, Check.MARKING, Check.LANE_ENTRY)
    abort_after_commit: ClassVar[AbortAction] = AbortAction.FINISH
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.OVERTAKE,)
    shifts_laterally: ClassVar[bool] = True
    solution_rank: ClassVar[int | None] = 40
    outranks_replan: ClassVar[bool] = True

    name: Literal["change_lane"] = "change_lane"
    side: Literal["left", "right"]
    distance_m: float = Field(ge=15.0, le=150.0)
    speed_mps: float = Field(gt=0.5, le=11.0)

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        beside = (LaneRelation.LEFT, LaneRelation.RIGHT)
        return any(lane.relation in beside and lane.direction is LaneDirection.SAME for lane in scene.lanes)

    @property
    def passing_side(self) -> DirectedSide | None:
        return DirectedSide(self.side)

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

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path into the adjacent lane and along it. See `Behavior.maneuver`."""
        lane = self.target(view, start)
        sideways = lateral_shift(view, start, lane.at(start.s_m + 15.0)[1], self.speed_mps)
        rest = max(start.s_m + self.distance_m - sideways.end_s, landing_m(self.speed_mps) + 2.0)
        path = sideways.then(along_lane(lane, sideways.end_s, sideways.end_d, rest, self.speed_mps))
        return FrenetPath(path.s, path.d, path.speed, (lane,), (), returns=abs(path.end_d) < 1.0)
