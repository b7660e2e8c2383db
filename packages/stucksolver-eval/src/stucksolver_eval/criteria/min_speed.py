"""The ego's speed compared with the traffic around it (MinimumSpeedRouteTest). Used only for efficiency."""

from __future__ import annotations

from stucksolver_eval.criteria.criterion import Criterion, EgoTick
from stucksolver_eval.criteria.route_completion import WINDOW
from stucksolver_eval.criteria.route_position import RouteWalk

CHECKPOINTS = 20
"""Number of checkpoints of a route. As in MinimumSpeedRouteTest."""
LAST_SHARE = 0.95
"""Share of the route from which its end counts as reached: the start of the last of 20 stretches."""


class MinSpeed(Criterion):
    """One entry per twentieth of the route, and two equal ones for the last if the route's end is reached.

    The benchmark's rule ignores an immobilized end: a checkpoint that is not reached has no entry. `stuck_end` is the
    percentage of that unfinished stretch, or None if the route's end was reached.
    """

    kind = "min_speed_infractions"

    def __init__(self, walk: RouteWalk) -> None:
        super().__init__()
        self._walk = walk
        self._index = 0
        self._from_m = 0.0
        self._ego = self._others = 0.0
        self._samples = 0
        self._time_s = 0.0
        self.stuck_end: float | None = None

    def update(self, moment: EgoTick) -> None:
        self._time_s = moment.time_s
        self._index = self._walk.last_passed(self._index, moment.location, WINDOW)
        here_m = self._walk.s_m[self._index]
        if here_m - self._from_m > self._walk.length_m / CHECKPOINTS:
            self._checkpoint()
            self._from_m = here_m
            self._ego = self._others = 0.0
            self._samples = 0
        if moment.background_mps:
            self._others += sum(moment.background_mps) / len(moment.background_mps)
            self._ego += moment.speed_mps
            self._samples += 1

    def finish(self) -> None:
        if self._walk.s_m[self._index] / self._walk.length_m > LAST_SHARE:
            # scenario_runner ends its criteria twice, so the last value is listed twice.
            self._checkpoint()
            self._checkpoint()
        elif self._samples:
            self.stuck_end = self._value()

    def _value(self) -> float:
        if self._samples == 0 or self._others == 0.0:
            return 100.0
        return round(100.0 * self._ego / self._others, 2)

    def _checkpoint(self) -> None:
        value = self._value()
        self.note(self._time_s, f"on average at {value}% of the speed of the traffic around", value)
