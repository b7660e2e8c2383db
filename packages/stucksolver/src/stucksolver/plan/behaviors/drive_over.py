"""Drive over an object that is of a soft class, low, and seen long enough to be sure."""

from dataclasses import replace
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
from stucksolver.plan.behaviors.keep_lane import own_lane
from stucksolver.plan.frenet_path import FrenetPath, along_lane
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent
from stucksolver.scene.objects import PASSABLE_KINDS
from stucksolver.scene.scene import Scene

BEYOND_M = 2.0


class DriveOver(Behavior):
    """Drive on slowly in the ego's lane, over one object."""

    summary: ClassVar[str] = (
        "Drive slowly over object_id, an empty bag or litter, at most 0.15 m high; never anything living or unknown."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase("drive slowly over it", "driving slowly over it")
    checks: ClassVar[tuple[Check, ...]] = (*MOVING_CHECKS, Check.CREEP_SPEED, Check.PASSABLE)
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.DRIVE_OVER,)
    solution_rank: ClassVar[int | None] = 20

    name: Literal["drive_over"] = "drive_over"
    object_id: str
    speed_mps: float = Field(default=2.0, ge=0.5, le=CREEP_MPS)

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        return any(o.kind in PASSABLE_KINDS for o in scene.objects)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path over the object. See `Behavior.maneuver`."""
        i = view.index_of(self.object_id)
        if i is None:
            raise NoPathError(PlanFailure.NOT_SEEN, f"object {self.object_id} is not seen")
        past = float(view.s[i] + view.along[i]) + view.ego.length_m / 2 + BEYOND_M - start.s_m
        if not 3.0 < past < 40.0:
            raise NoPathError(PlanFailure.NOT_IN_THE_WAY, f"object {self.object_id} is not just ahead in the lane")
        path = along_lane(own_lane(view, start), start.s_m, start.d_m, past, self.speed_mps)
        return replace(path, over=(self.object_id,))
