"""Move aside within the lane: to see past an obstacle, or to pass it if the lane is wide enough."""

from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from stucksolver.plan.behaviors.behavior import MOVING_CHECKS, Behavior, BehaviorStart, Check, NoPathError, PlanPhrase
from stucksolver.plan.behaviors.keep_lane import own_lane
from stucksolver.plan.frenet_path import FrenetPath, straight
from stucksolver.plan.lateral_shift import lateral_shift
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import DirectedSide, GuidanceIntent, GuidanceLimits, Interpretation

EDGE_M = 0.05
SHARES = (1.0, 0.85, 0.7, 0.5)
"""Fractions of the shift to try, since over a short distance the corners may swing out too far."""


class Nudge(Behavior):
    """Shift sideways within the lane's borders, drive on there, and stop."""

    summary: ClassVar[str] = (
        "Move offset_m metres to `side` within its own lane (no further than its border), drive on for distance_m "
        "metres in all, then stop: to see past an obstacle, or to pass it in a wide lane."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase("move a little to the {side}", "moving a little to the {side}")
    checks: ClassVar[tuple[Check, ...]] = (*MOVING_CHECKS, Check.WITHIN_LANE, Check.STOPPING_PLACE)
    prepares: ClassVar[bool] = True
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.OVERTAKE,)
    shifts_laterally: ClassVar[bool] = True
    solution_rank: ClassVar[int | None] = 50
    outranks_replan: ClassVar[bool] = True

    name: Literal["nudge"] = "nudge"
    side: Literal["left", "right"]
    offset_m: float = Field(ge=0.2, le=1.5)
    distance_m: float = Field(ge=3.0, le=40.0)
    speed_mps: float = Field(default=1.5, ge=0.5, le=5.5)

    @property
    def passing_side(self) -> DirectedSide | None:
        return DirectedSide(self.side)

    def guided_parameters(self, reading: Interpretation, limits: GuidanceLimits) -> dict[str, float]:
        """Return the lateral shift if the words name a side. See `Behavior.guided_parameters`."""
        if limits.distance_m is None or reading.side is None or reading.intent not in self.intents:
            return {}
        return {"offset_m": limits.distance_m}

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path past the obstacle within the lane. See `Behavior.maneuver`."""
        lane = own_lane(view, start)
        if lane is None:
            raise NoPathError(PlanFailure.NO_LANE, "the vehicle is in no lane")
        right, _, left = lane.at(start.s_m + self.distance_m)
        half, turn = view.ego.width_m / 2 + EDGE_M, 1 if self.side == "left" else -1
        target = min(max(start.d_m + turn * self.offset_m, right + half), left - half)
        if (target - start.d_m) * turn < 0.15:
            raise NoPathError(PlanFailure.NO_ROOM_ASIDE, f"the lane leaves no room on the {self.side}")
        start = replace(start, yaw_rad=0.0)  # it ends inside the lane, so it begins by turning back
        for share in SHARES:
            aside = share * (target - start.d_m)
            out = lateral_shift(view, start, start.d_m + aside, self.speed_mps, lanes=(lane,))
            if float((turn * out.d + body_reach(out, view)).max()) <= (left if turn > 0 else -right) + 2 * EDGE_M:
                rest = max(start.s_m + self.distance_m - out.end_s, 0.5)
                return out.then(straight(out.end_s, out.end_d, rest, self.speed_mps)).stopping()
        raise NoPathError(PlanFailure.NO_ROOM_ASIDE, f"the lane leaves no room to turn to the {self.side}")


def body_reach(path: FrenetPath, view: FrenetScene) -> Array:
    """(stations,): half extent of the ego's body across the road (m)."""
    heading = path.body(float(path.heading()[0]), view.ego.limits.wheelbase_m)
    reach: Array = view.ego.width_m / 2 * np.cos(heading) + view.ego.length_m / 2 * np.abs(np.sin(heading))
    return reach
