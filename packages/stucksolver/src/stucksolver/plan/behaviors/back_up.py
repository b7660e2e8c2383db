"""Back up: to make room for swinging out, to see more, or to leave a place where the ego must not stand."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import CREEP_MPS, Behavior, BehaviorStart, Check, NoPathError, PlanPhrase
from stucksolver.plan.frenet_path import FrenetPath, straight
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent

STANDS_MPS = 0.3


class BackUp(Behavior):
    """Reverse straight along the lane and stop. `view` and `start` are in the frame of `FrenetScene.backwards`."""

    summary: ClassVar[str] = (
        "Reverse distance_m metres along the lane, where the lane behind is seen to be free; over 8 m only to leave a "
        "level crossing, a junction or another place where a vehicle must not stand."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase("back up", "backing up")
    checks: ClassVar[tuple[Check, ...]] = (
        Check.COLLISION,
        Check.DRIVABLE_AREA,
        Check.SPEED,
        Check.CREEP_SPEED,
        Check.SEEN_FREE,
        Check.AUTHORITY,
        Check.NO_WORSE_PLACE,
    )
    reverse: ClassVar[bool] = True
    prepares: ClassVar[bool] = True
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.BACK_UP,)
    stays_behind_blocker: ClassVar[bool] = True
    solution_rank: ClassVar[int | None] = 60

    name: Literal["back_up"] = "back_up"
    distance_m: float = Field(ge=1.0, le=40.0)
    speed_mps: float = Field(default=1.0, ge=0.5, le=CREEP_MPS)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path straight back from rest. See `Behavior.maneuver`."""
        if abs(start.speed_mps) > STANDS_MPS:
            raise NoPathError(PlanFailure.MUST_BE_STOPPED, "the vehicle must stop before it backs up")
        return straight(start.s_m, start.d_m, self.distance_m, self.speed_mps).stopping()
