"""All criteria of one route together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.plugins import plugins
from stucksolver_eval.criteria.agent_blocked import Blocked
from stucksolver_eval.criteria.collision import Collisions
from stucksolver_eval.criteria.criterion import Criterion, EgoTick, Infraction
from stucksolver_eval.criteria.in_route import InRoute
from stucksolver_eval.criteria.min_speed import MinSpeed
from stucksolver_eval.criteria.outside_lanes import OutsideLanes
from stucksolver_eval.criteria.red_light import RedLights
from stucksolver_eval.criteria.route_completion import RouteCompletion
from stucksolver_eval.criteria.route_position import RouteWalk
from stucksolver_eval.criteria.route_timeout import RouteTimeout, TickRuntime
from stucksolver_eval.criteria.scenario_events import ScenarioEvents
from stucksolver_eval.criteria.stop_sign import StopSigns
from stucksolver_eval.routes.route_line import RouteLine

if TYPE_CHECKING:
    import carla


class ScenarioFeed(Protocol):
    """Input from scenarios (see `scenarios.player`)."""

    @property
    def events(self) -> Sequence[Any]:
        """Results of the scenarios up to now."""

    @property
    def suspended(self) -> frozenset[str]:
        """Criteria that a scenario suspends now, by their kind."""

    @property
    def extra_criteria(self) -> frozenset[str]:
        """Criteria that a scenario adds now, by their kind."""


class CriteriaMonitor:
    """Judges one ego on one route. Call `update` once per tick, `finish` once at the end, then `close`.

    Other distributions add criteria by entry points in `stucksolver.criteria`: a class that is called with the world,
    its map, the ego and the route's line, and implements `Criterion`. Its infractions are reported; only those of the
    benchmark's kinds cost points.
    """

    def __init__(
        self, world: carla.World, carla_map: carla.Map, ego: carla.Vehicle, line: RouteLine, stage: ScenarioFeed
    ) -> None:
        self._walk = walk = RouteWalk(line)
        self._line = line
        self._world, self._ego, self._stage = world, ego, stage
        self.completion = RouteCompletion(walk)
        self.min_speed = MinSpeed(walk)
        self._extra: Collisions | None = None
        self._criteria: list[Criterion] = [
            self.completion,
            OutsideLanes(carla_map, walk, ego.get_location()),
            Collisions(world, ego),
            RedLights(world, carla_map, ego),
            StopSigns(world, carla_map),
            self.min_speed,
            InRoute(walk),
            Blocked(),
            RouteTimeout(walk, ego),
            TickRuntime(),
            ScenarioEvents(stage.events),
            *(plugin.load()(world, carla_map, ego, line) for plugin in plugins("criteria")),
        ]

    def update(self, moment: EgoTick) -> str | None:
        """Judge one tick.

        Returns:
            The failure that ends the route, `""` at its end, else None.
        """
        self._second_collision_test()
        if self.completion.complete:
            # The benchmark ends a route on the tick after the one that completes it.
            return ""
        for criterion in self._criteria:
            criterion.update(moment)
        return next((c.ends_route for c in self._criteria if c.ends_route is not None), None)

    @property
    def line(self) -> RouteLine:
        """The route of the criteria."""
        return self._line

    def reroute(self, line: RouteLine) -> None:
        """Replace the rest of the route: a scenario may permit a new route in place of the original one."""
        self._line = self._line.joined(self.completion.index, line)
        self._walk.change(self._line)

    def finish(self) -> None:
        """Let every criterion judge the whole route, once, at its end."""
        for criterion in self._criteria:
            criterion.finish()

    def close(self) -> None:
        """Destroy the sensors."""
        for criterion in self._criteria:
            criterion.close()

    @property
    def infractions(self) -> list[Infraction]:
        """All infractions up to now, in order of time."""
        return sorted((i for c in self._criteria for i in c.infractions), key=lambda i: i.time_s)

    def _second_collision_test(self) -> None:
        """Count each collision twice while `VehicleTurningRoutePedestrian` runs, as the benchmark does."""
        wanted = "collision" in self._stage.extra_criteria
        if wanted and self._extra is None:
            self._extra = Collisions(self._world, self._ego)
            self._criteria.append(self._extra)
        elif not wanted and self._extra is not None:
            self._extra.finish()
            self._extra.close()
            self._extra.rest()
            self._extra = None
