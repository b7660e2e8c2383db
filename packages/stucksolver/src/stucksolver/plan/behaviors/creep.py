"""Drive a short distance slowly and stop: to see more, or to signal the intention to go."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import CREEP_MPS, MOVING_CHECKS, Behavior, BehaviorStart, Check, PlanPhrase
from stucksolver.plan.behaviors.keep_lane import own_lane
from stucksolver.plan.frenet_path import FrenetPath, along_lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent


class Creep(Behavior):
    """Creep forward in the ego's lane and stop."""

    summary: ClassVar[str] = "Creep distance_m metres ahead in its own lane at walking pace, then stop."
    phrase: ClassVar[PlanPhrase] = PlanPhrase("creep forward a little", "creeping forward a little")
    checks: ClassVar[tuple[Check, ...]] = (*MOVING_CHECKS, Check.CREEP_SPEED, Check.NO_WORSE_PLACE)
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.GO,)
    stays_behind_blocker: ClassVar[bool] = True
    solution_rank: ClassVar[int | None] = 80

    name: Literal["creep"] = "creep"
    distance_m: float = Field(ge=1.0, le=15.0)
    speed_mps: float = Field(default=1.5, ge=0.5, le=CREEP_MPS)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path along the ego's lane, to a stop. See `Behavior.maneuver`."""
        lane = own_lane(view, start)
        return along_lane(lane, start.s_m, start.d_m, self.distance_m, self.speed_mps).stopping()
