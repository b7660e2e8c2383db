"""Go round what is in the way through the lane of the oncoming traffic, and come back."""

from dataclasses import replace
from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.decision.behaviors.base import CREEP_MPS, MOVING_CHECKS, Abort, Behavior, CannotPlan, Check, Start
from stucksolver.decision.lateral_shift import lateral_shift
from stucksolver.decision.manoeuvre import Manoeuvre, along_lane, landing_m, lateral, shortest_shift
from stucksolver.decision.passing import Passing, borrowed_lane, find_passing, length_abreast, standing_beyond
from stucksolver.scene.attempts import PlanFailure
from stucksolver.scene.view import FrenetScene

STOP_GAP_M, STRAIGHT_M, LEAST_BACK_M = 2.0, 1.0, 6.0
"""Left free before what stands beyond, with the wheels straight for the last metre; and the shortest way back."""


class BorrowOncomingLane(Behavior):
    """Pass an object, and all that stands before it, through the oncoming lane."""

    summary: ClassVar[str] = (
        "Pass the object past_object_id (and everything between) through the lane of the oncoming traffic on the "
        "left at up to speed_mps, then come back to the own lane."
    )
    checks: ClassVar[tuple[Check, ...]] = (
        *MOVING_CHECKS,
        Check.MARKING,
        Check.ONCOMING,
        Check.LANE_ENTRY,
        Check.PATIENCE,
    )
    abort_after_commit: ClassVar[Abort] = Abort.RETURN_TO_LANE

    name: Literal["borrow_oncoming_lane"] = "borrow_oncoming_lane"
    past_object_id: str
    speed_mps: float = Field(gt=0.5, le=11.0)

    def precondition(self, view: FrenetScene) -> str | None:
        if view.index_of(self.past_object_id) is None:
            return f"object {self.past_object_id} is not seen"
        if borrowed_lane(view, view.ego_s) is None:
            return "there is no oncoming lane on the left"
        return None

    def manoeuvre(self, view: FrenetScene, start: Start) -> Manoeuvre:
        lane = borrowed_lane(view, start.s_m)
        if lane is None:
            raise CannotPlan(PlanFailure.NO_LANE, "there is no oncoming lane on the left")
        passing: Passing = find_passing(view, start, self.past_object_id, lane)
        speed = min(self.speed_mps, CREEP_MPS) if passing.slowly else self.speed_mps
        out = lateral_shift(view, start, passing.offset_m, speed)
        abreast = length_abreast(view, start, out, passing, speed)
        beside = along_lane(None, out.end_s, out.end_d, abreast, speed)
        back = self._back(view, beside, standing_beyond(view, passing))
        return replace(out.then(beside).then(back), enters=(lane,), passes=passing.ids)

    def _back(self, view: FrenetScene, beside: Manoeuvre, beyond_s: float) -> Manoeuvre:
        """Into the own lane and on in it; or, where something stands there soon, to a stop behind that."""
        gentle_m, landing = max(2.5 * float(beside.speed[-1]), 12.0), landing_m(self.speed_mps) + 2.0
        room_m = beyond_s - STOP_GAP_M - view.ego.length_m / 2 - beside.end_s
        stops = room_m < gentle_m + landing
        if stops:
            shortest_m = shortest_shift(beside.end_d, view.ego.limits.min_turn_radius_m)
            gentle_m = max(min(gentle_m, room_m - STRAIGHT_M), shortest_m, LEAST_BACK_M)
            landing = max(room_m - gentle_m, STRAIGHT_M)
        back = lateral(beside.end_s, beside.end_d, 0.0, gentle_m, self.speed_mps, view)
        back = back.then(along_lane(None, back.end_s, 0.0, landing, self.speed_mps))
        return back.stopping() if stops else back
