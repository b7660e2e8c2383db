"""Car following: drive on behind a lead vehicle as long as it stays ahead."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import MOVING_CHECKS, Behavior, BehaviorStart, Check, NoPathError, PlanPhrase
from stucksolver.plan.behaviors.keep_lane import own_lane
from stucksolver.plan.frenet_path import FrenetPath, along_lane
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import MOTOR_VEHICLES
from stucksolver.scene.scene import Scene

RANGE_M = 50.0
LEADS_MPS = 0.5


class FollowVehicle(Behavior):
    """Follow a moving lead vehicle in the ego's lane; the stack keeps its distance as usual."""

    summary: ClassVar[str] = (
        "Follow the moving vehicle leader_id ahead in its own lane for up to distance_m metres at up to speed_mps."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase("follow the vehicle ahead", "following the vehicle ahead")
    checks: ClassVar[tuple[Check, ...]] = MOVING_CHECKS
    stays_behind_blocker: ClassVar[bool] = True

    name: Literal["follow_vehicle"] = "follow_vehicle"
    leader_id: str
    distance_m: float = Field(ge=5.0, le=150.0)
    speed_mps: float = Field(gt=0.5, le=11.0)

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        return any(o.in_path and o.kind in MOTOR_VEHICLES and o.speed_along_mps > LEADS_MPS for o in scene.objects)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path along the lane behind the leader. See `Behavior.maneuver`."""
        i = view.index_of(self.leader_id)
        if i is None or not self._leads(view, i):
            why = f"{self.leader_id} cannot be followed: it must be moving ahead in the ego's lane"
            raise NoPathError(PlanFailure.NOT_LEADING, why)
        return along_lane(own_lane(view, start), start.s_m, start.d_m, self.distance_m, self.speed_mps)

    def done(self, view: FrenetScene) -> bool:
        i = view.index_of(self.leader_id)
        return i is None or not (0.0 < view.gap[i] < 2 * RANGE_M and view.in_corridor(view.ego.width_m / 2)[i])

    @staticmethod
    def _leads(view: FrenetScene, i: int) -> bool:
        in_lane = bool(view.in_corridor(view.ego.width_m / 2)[i])
        return in_lane and 0.0 < view.gap[i] < RANGE_M and view.vs[i] > LEADS_MPS
