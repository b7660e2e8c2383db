"""Turn the nose out to the border of the next lane and wait there for a gap."""

from typing import ClassVar, Literal

import numpy as np
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
from stucksolver.plan.behaviors.nudge import body_reach
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.plan.lateral_shift import lateral_shift
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Array
from stucksolver.scene.frenet_scene import SURE_SDS, FrenetScene
from stucksolver.scene.road import LaneKind

LEAST_M = 1.0
"""A shorter way turns the nose by too little to help."""
OFF_M = 0.1
"""By sensors it stops this much further in, besides the uncertainty of its place: that varies, and so does the path."""


class NoseOut(Behavior):
    """Drive the first meters of a lane change, up to the border of the own lane, and come to rest."""

    summary: ClassVar[str] = (
        "Turn out towards the neighbouring lane on `side` until the nose is at the border of the own lane, and stop "
        "there. A lane change or a pass that follows in the same plan waits there for its gap, and needs a shorter one."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase(
        "turn out to the {side} and wait for a gap", "waiting for a gap on the {side}"
    )
    checks: ClassVar[tuple[Check, ...]] = (*MOVING_CHECKS, Check.CREEP_SPEED, Check.WITHIN_LANE, Check.STOPPING_PLACE)
    prepares: ClassVar[bool] = True
    shifts_laterally: ClassVar[bool] = True

    name: Literal["nose_out"] = "nose_out"
    side: Literal["left", "right"]
    speed_mps: float = Field(default=1.5, ge=0.5, le=CREEP_MPS)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path of the nose to the edge of the lane beside, to a stop. See `Behavior.maneuver`."""
        turn = 1 if self.side == "left" else -1
        own, beside = view.frame.lane_at(start.s_m, start.d_m), view.frame.beside(start.s_m, start.d_m, turn)
        if own is None or beside is None or beside.strip.kind is not LaneKind.DRIVING:
            raise NoPathError(PlanFailure.NO_LANE, f"there is no driving lane on the {self.side}")
        path = lateral_shift(view, start, beside.at(start.s_m)[1], self.speed_mps)
        border: Array = np.interp(path.s, own.s, own.left if turn > 0 else own.right)
        sd_m = view.ego.position_sd_m
        doubt_m = 0.0 if sd_m is None else SURE_SDS * sd_m + OFF_M
        over = np.flatnonzero(turn * (path.d - border) + body_reach(path, view) + doubt_m > 0.0)
        count = int(over[0]) if len(over) else len(path.s)
        if count < 2 or float(path.s[count - 1]) - start.s_m < LEAST_M:
            raise NoPathError(PlanFailure.NO_ROOM_ASIDE, f"the nose is at the border on the {self.side} already")
        # It may stop a little short. `lateral_shift` raises if there is no room to go on from there.
        short = max(count - 2, 0)
        yaw = float(path.body(start.yaw_rad, view.ego.limits.wheelbase_m)[short])
        lateral_shift(
            view, BehaviorStart(float(path.s[short]), float(path.d[short]), 0.0, yaw), path.end_d, self.speed_mps
        )
        return FrenetPath(path.s[:count], path.d[:count], path.speed[:count]).stopping()
