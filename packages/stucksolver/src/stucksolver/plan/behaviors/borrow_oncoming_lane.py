"""Pass an obstacle through the oncoming lane, and return."""

import math
from dataclasses import replace
from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import (
    CREEP_MPS,
    MOVING_CHECKS,
    AbortAction,
    Behavior,
    BehaviorStart,
    Check,
    NoPathError,
    PlanPhrase,
)
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.plan.lateral_shift import lateral_shift
from stucksolver.plan.passing_geometry import PassPlan, borrowed_lane, find_passing, length_abreast
from stucksolver.plan.return_to_lane import way_back
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import DirectedSide, GuidanceIntent
from stucksolver.scene.road import LaneDirection, LaneKind
from stucksolver.scene.scene import Scene


class BorrowOncomingLane(Behavior):
    """Pass an object, and everything in front of it, through the oncoming lane."""

    summary: ClassVar[str] = (
        "Pass the object past_object_id (and everything before it) through the oncoming lane on the left at up to "
        "speed_mps, then return to its own lane."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase(
        "go round it on the left when the oncoming lane is free", "going round it on the left"
    )
    approval_note: ClassVar[str | None] = "I would use the lane of the oncoming traffic."
    checks: ClassVar[tuple[Check, ...]] = (
        *MOVING_CHECKS,
        Check.MARKING,
        Check.ONCOMING,
        Check.LANE_ENTRY,
        Check.PATIENCE,
    )
    abort_after_commit: ClassVar[AbortAction] = AbortAction.RETURN_TO_LANE
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.OVERTAKE,)
    shifts_laterally: ClassVar[bool] = True
    solution_rank: ClassVar[int | None] = 30

    name: Literal["borrow_oncoming_lane"] = "borrow_oncoming_lane"
    past_object_id: str
    speed_mps: float = Field(gt=0.5, le=11.0)

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        opposite = (lane for lane in scene.lanes if lane.direction is LaneDirection.OPPOSITE)
        return bool(scene.objects) and any(lane.kind is LaneKind.DRIVING for lane in opposite)

    @property
    def passing_side(self) -> DirectedSide | None:
        return DirectedSide.LEFT

    def precondition(self, view: FrenetScene) -> str | None:
        if view.index_of(self.past_object_id) is None:
            return f"object {self.past_object_id} is not seen"
        if borrowed_lane(view, view.ego_s) is None:
            return "there is no oncoming lane on the left"
        return None

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path out into the oncoming lane, past the obstruction and back. See `Behavior.maneuver`."""
        lane = borrowed_lane(view, start.s_m)
        if lane is None:
            raise NoPathError(PlanFailure.NO_LANE, "there is no oncoming lane on the left")
        passing: PassPlan = find_passing(view, start, self.past_object_id, lane, self.speed_mps)
        speed = min(self.speed_mps, CREEP_MPS) if passing.slowly else self.speed_mps
        out = lateral_shift(view, start, passing.offset_m, speed, passing.gentle_m)
        past_s = out.end_s + length_abreast(view, start, out, passing, speed)
        # A short pass ends before the vehicle reaches the allowed speed, because it is still accelerating.
        gains = 2 * view.ego.limits.comfort_acceleration_mps2 * (past_s - start.s_m)
        reached = min(speed, math.sqrt(start.speed_mps**2 + gains))
        back = way_back(view, out, passing, past_s, reached, self.speed_mps)
        return replace(out.then(back), enters=(lane,), passes=passing.ids)
