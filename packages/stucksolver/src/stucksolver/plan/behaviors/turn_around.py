"""Turn round on the road in several legs, to leave a dead end or a closed road."""

import math
from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import CREEP_MPS, Check, LegBehavior, PlanPhrase
from stucksolver.plan.multi_point_turn import TURNED_RAD, Leg, heading_change_rad, multi_point_turn
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent

WAITS_S = 30.0
"""Time allowed beyond the driving time of a leg, to stop and let others pass."""
BEGUN_RAD = math.radians(20.0)
"""An ego that has turned by more than this stands across the road and should finish the turn (rad)."""


class TurnAround(LegBehavior):
    """A turn to the left in at most five legs. Each leg is proven when the vehicle has stopped at its start.

    It has no path along the road: its legs are paths in the plane (`legs`). A new route follows it.
    """

    summary: ClassVar[str] = (
        "Turn round on the road in up to five legs at walking pace, where it is wide enough and nobody comes, to "
        "drive back. Replan the route from there: replan_route, with a waypoint behind as route_start."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase("turn round and drive back", "turning round")
    checks: ClassVar[tuple[Check, ...]] = (Check.TURNING,)
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.TURN_AROUND,)

    name: Literal["turn_round"] = "turn_round"
    speed_mps: float = Field(default=1.4, ge=0.5, le=CREEP_MPS)

    def legs(self, view: FrenetScene) -> tuple[Leg, ...]:
        """Return the remaining legs of the turn from where the vehicle is.

        Raises:
            CannotPlan: The road is too narrow.
        """
        return multi_point_turn(view)

    def must_finish(self, view: FrenetScene) -> bool:
        return abs(view.ego_yaw) > BEGUN_RAD

    def done(self, view: FrenetScene) -> bool:
        return heading_change_rad(view) > TURNED_RAD

    def time_allowance_s(self, expected_s: float) -> float:
        return 2.0 * expected_s + WAITS_S
