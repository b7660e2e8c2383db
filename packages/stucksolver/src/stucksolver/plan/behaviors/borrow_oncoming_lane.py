"""Pass an obstacle through the oncoming lane, and return."""

import math
from dataclasses import replace
from functools import partial
from typing import ClassVar, Literal

import numpy as np
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
from stucksolver.plan.lateral_shift import lanes_between, lateral_shift
from stucksolver.plan.object_gaps import lack_toward_objects
from stucksolver.plan.passing_geometry import PassPlan, borrowed_lane, find_passing, length_abreast
from stucksolver.plan.return_to_lane import searched_way_home, way_back
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import DirectedSide, GuidanceIntent
from stucksolver.scene.road import LaneDirection, LaneKind
from stucksolver.scene.scene import Scene

OFFSETS = 5
"""Number of offsets beside the passed objects that are tried, each nearer to them. Ours."""


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
        passing = find_passing(view, start, self.past_object_id, lane, self.speed_mps)
        speed = min(self.speed_mps, CREEP_MPS) if passing.slowly else self.speed_mps
        path = self._path(view, start, passing, speed)
        return replace(path, enters=(lane,), passes=passing.ids, returns=True)

    def _path(self, view: FrenetScene, start: BehaviorStart, passing: PassPlan, speed_mps: float) -> FrenetPath:
        """Return two shifts, or a searched path where they do not fit or lead toward another object too closely."""
        shifted = partial(self._shifted, view, start, speed_mps=speed_mps)
        lanes = lanes_between(view, start, passing.offset_m)
        found: list[tuple[float, FrenetPath]] = []
        why: NoPathError | None = None
        least_m = min(passing.offset_m, passing.least_offset_m)
        for offset_m in np.linspace(passing.offset_m, least_m, OFFSETS if least_m < passing.offset_m else 1):
            try:
                path = shifted(passing=replace(passing, offset_m=float(offset_m)))
            except NoPathError as error:
                why = why or error
                continue
            lack_m = lack_toward_objects(view, path, start.yaw_rad)
            if lack_m <= 0.0:
                return path
            found.append((lack_m, path))
        try:
            path = searched_way_home(view, start, passing, speed_mps, self.speed_mps, lanes)
            found.append((lack_toward_objects(view, path, start.yaw_rad), path))
        except NoPathError as error:
            why = why or error
        if not found:
            raise why or NoPathError(PlanFailure.NO_SPACE_TO_PULL_AROUND, "no path")
        return min(found, key=lambda pair: pair[0])[1]

    def _shifted(self, view: FrenetScene, start: BehaviorStart, passing: PassPlan, speed_mps: float) -> FrenetPath:
        """Return a shift out, a stretch beside the objects, and a shift back."""
        out = lateral_shift(view, start, passing.offset_m, speed_mps, passing.gentle_m)
        past_s = out.end_s + length_abreast(view, start, out, passing, speed_mps)
        # A short pass ends before the vehicle reaches the allowed speed, because it is still accelerating.
        gains = 2 * view.ego.limits.comfort_acceleration_mps2 * (past_s - start.s_m)
        reached = min(speed_mps, math.sqrt(start.speed_mps**2 + gains))
        return out.then(way_back(view, out, passing, past_s, reached, self.speed_mps))
