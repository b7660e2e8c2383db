"""Stand still."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.decision.behaviors.base import Behavior, Start
from stucksolver.decision.manoeuvre import Manoeuvre
from stucksolver.scene.road import LaneDirection
from stucksolver.scene.view import View


class Wait(Behavior):
    """Stay stopped for a while."""

    summary: ClassVar[str] = "Stay stopped for duration_s seconds."
    stands_still: ClassVar[bool] = True

    name: Literal["wait"] = "wait"
    duration_s: float = Field(ge=0.5, le=20.0)

    def precondition(self, view: View) -> str | None:
        lane = view.ego_lane
        if lane is not None and lane.strip.direction is LaneDirection.OPPOSITE:
            return "the ego is in an oncoming lane, where a stop is not safe"
        return None

    def manoeuvre(self, view: View, start: Start) -> Manoeuvre | None:
        return None

    def time_allowance_s(self, expected_s: float) -> float:
        return self.duration_s + 1.0
