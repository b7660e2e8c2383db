"""Return to the center of the route's lane from anywhere on the road."""

from dataclasses import replace
from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import MOVING_CHECKS, Behavior, BehaviorStart, Check, NoPathError, PlanPhrase
from stucksolver.plan.behaviors.keep_lane import turned_into_lane
from stucksolver.plan.frenet_path import FrenetPath, along_lane, landing_m
from stucksolver.plan.lateral_shift import lateral_shift
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene import Scene

OFF_LANE_M = 0.5
"""At a smaller distance from the center of the route's lane there is nothing to rejoin."""


class RejoinRoute(Behavior):
    """Return to the route's lane, then follow it for a few meters."""

    summary: ClassVar[str] = "Return to the route's lane and follow it for a few metres at up to speed_mps."
    phrase: ClassVar[PlanPhrase] = PlanPhrase("return to my lane", "returning to my lane")
    checks: ClassVar[tuple[Check, ...]] = (
        *(check for check in MOVING_CHECKS if check is not Check.DRIVABLE_AREA),
        Check.ROADSIDE,
        Check.MARKING,
        Check.LANE_ENTRY,
    )
    starts_at_roadside: ClassVar[bool] = True

    name: Literal["rejoin_route"] = "rejoin_route"
    speed_mps: float = Field(default=4.0, gt=0.5, le=11.0)

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        return abs(scene.ego.lateral_offset_m) > OFF_LANE_M

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path back to the route's lane and a few meters along it. See `Behavior.maneuver`."""
        home = view.frame.lane_at(start.s_m, 0.0)
        if home is None:
            raise NoPathError(PlanFailure.NO_LANE, "the route has no lane here")
        here = view.frame.lane_at(start.s_m, start.d_m)
        length_m = landing_m(self.speed_mps) + 2.0
        path = turned_into_lane(view, start, home, length_m, self.speed_mps)
        if path is None:
            out = lateral_shift(view, start, 0.0, self.speed_mps) if abs(start.d_m) > 0.1 else None
            s, d = (start.s_m, start.d_m) if out is None else (out.end_s, out.end_d)
            on = along_lane(home, s, d, length_m, self.speed_mps)
            path = on if out is None else out.then(on)
        return replace(path, enters=() if here is home else (home,), returns=True)
