"""Stop at the roadside, as far out of the traffic as the road allows."""

from dataclasses import replace
from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import MOVING_CHECKS, Behavior, BehaviorStart, Check, NoPathError, PlanPhrase
from stucksolver.plan.behaviors.nudge import body_reach
from stucksolver.plan.frenet_path import FrenetPath, lateral, shortest_shift, straight
from stucksolver.scene.failed_attempts import PlanFailure
from stucksolver.scene.frenet import Lane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind

EDGE_M = 0.2
ROADSIDE = (LaneKind.DRIVING, LaneKind.PARKING, LaneKind.SHOULDER)


class PullOver(Behavior):
    """Move to the right edge of the outermost strip on which a vehicle may stop, and stop."""

    summary: ClassVar[str] = "Pull over to the right edge of the road, parking lane and shoulder included, and stop."
    phrase: ClassVar[PlanPhrase] = PlanPhrase("pull over to the right and stop", "pulling over to the right")
    checks: ClassVar[tuple[Check, ...]] = (
        *(check for check in MOVING_CHECKS if check is not Check.DRIVABLE_AREA),
        Check.ROADSIDE,
        Check.LANE_ENTRY,
        Check.STOPPING_PLACE,
    )
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.PULL_OVER, GuidanceIntent.LET_ME_OUT)

    name: Literal["pull_over"] = "pull_over"
    distance_m: float = Field(default=20.0, ge=10.0, le=60.0)
    speed_mps: float = Field(default=3.0, ge=0.5, le=5.5)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        """Return the path to the right edge of the roadside, to a stop. See `Behavior.maneuver`."""
        lanes = _to_the_right(view, start)
        if not lanes:
            raise NoPathError(PlanFailure.NO_LANE, "the vehicle is in no lane in its own direction")
        end = start.s_m + self.distance_m
        target = min(lane.at(end)[0] for lane in lanes) + view.ego.width_m / 2 + EDGE_M
        length = min(max(shortest_shift(start.d_m - target, 1.5 * view.ego.limits.min_turn_radius_m), 4.0), 30.0)
        out = lateral(start.s_m, start.d_m, target, length, self.speed_mps, view)
        # The body turns back later than the path does, and its nose must not swing beyond the edge.
        over = target - view.ego.width_m / 2 - float((out.d - body_reach(out, view)).min())
        target += max(over - EDGE_M, 0.0)
        out = lateral(start.s_m, start.d_m, target, length, self.speed_mps, view)
        rest = max(end - out.end_s, 1.0)
        path = out.then(straight(out.end_s, target, rest, self.speed_mps)).stopping()
        return replace(path, enters=tuple(lanes[1:]), returns=False)


def _to_the_right(view: FrenetScene, start: BehaviorStart) -> list[Lane]:
    """Return the lane at `start` and the strips to its right where a vehicle may stop, up to the first kerb."""
    here = view.frame.lane_at(start.s_m, start.d_m)
    if here is None or here.strip.direction is LaneDirection.OPPOSITE:
        return []
    found = [here]
    while True:
        beside = view.frame.beside(start.s_m, found[-1].at(start.s_m)[1], -1)
        if beside is None or beside.strip.kind not in ROADSIDE or LineKind.KERB in beside.lines(start.s_m, start.s_m):
            return found
        found.append(beside)
