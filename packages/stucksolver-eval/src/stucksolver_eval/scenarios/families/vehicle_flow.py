"""A flow of vehicles along a path, with random spacing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stucksolver_eval.actors import Car
from stucksolver_eval.scenarios.scenario import Scenario

if TYPE_CHECKING:
    import carla

MOST = 14
"""Maximum number of vehicles of a flow. Ours."""


class Flow:
    """Vehicles along a path. `tick` spawns and removes them.

    Args:
        scenario: The scenario that owns the flow.
        line: Waypoints of the path.
        speed_mps: Speed of the vehicles.
        spacing_m: Range from which each distance between two vehicles is drawn.
        constant: Vehicles hold their speed, like CARLA's actor flows, until one has touched the hero. Otherwise they
            brake for vehicles ahead.
        offset_m: Offset of the path to the right of the lane's center.
        kinds: Blueprints to draw from; ordinary cars if empty.
        most: Largest number of vehicles at a time.
    """

    def __init__(
        self,
        scenario: Scenario,
        line: Sequence[carla.Waypoint],
        speed_mps: float,
        spacing_m: tuple[float, float],
        *,
        constant: bool = True,
        offset_m: float = 0.0,
        kinds: Sequence[str] = (),
        most: int = MOST,
    ) -> None:
        self._scenario = scenario
        self._line, self._speed_mps, self._spacing_m = list(line), speed_mps, spacing_m
        self._constant, self._offset_m, self._most = constant, offset_m, most
        self._kinds = tuple(kinds) or scenario.cast.car_kinds
        self._next_m = self._draw()
        self.cars: list[Car] = []
        """In driving order, the foremost first."""
        self.spawned = 0

    def fill(self) -> None:
        """Spawn vehicles along the whole path at once, farthest first."""
        places = [(0.0, self._line[0])]
        for before, waypoint in zip(self._line, self._line[1:], strict=False):
            gone = before.transform.location.distance(waypoint.transform.location)
            places.append((places[-1][0] + gone, waypoint))
        wanted_m = places[-1][0] - self._draw() / 2.0
        for index in range(len(places) - 1, -1, -1):
            if places[index][0] <= wanted_m:
                car = self._spawn(index)
                if car is not None:
                    wanted_m = places[index][0] - self._draw()

    def tick(self) -> None:
        """Remove vehicles that have arrived, and spawn the next one if there is space."""
        if any(car.hit_hero for car in self.cars):
            self.relax()
        gone = [car for car in self.cars if car.done]
        if gone:
            self._scenario.cars.remove(gone)
            self.cars = [car for car in self.cars if car not in gone]
        if len(self.cars) < self._most and self._last_m() >= self._next_m and self._spawn(0) is not None:
            self._next_m = self._draw()

    def relax(self) -> None:
        """Make the vehicles brake for vehicles ahead from now on."""
        if self._constant:
            self._constant = False
            for car in self.cars:
                self._scenario.cars.relax(car)

    def let_in(self) -> None:
        """Make vehicles behind the hero brake for it from now on. The others drive on and leave it a gap."""
        if self._constant:
            self._constant = False
            cast = self._scenario.cast
            states = [(car, cast.state(car.member)) for car in self.cars]
            for car, state in states:
                if cast.hero.ahead_m(state.x, state.y) < 0.0:
                    self._scenario.cars.relax(car)

    def clear(self) -> None:
        """Remove all vehicles."""
        self._scenario.cars.remove(self.cars)
        self.cars = []

    def _last_m(self) -> float:
        """Return the distance of the last vehicle from the source (m)."""
        if not self.cars:
            return 1e9
        place = self._line[0].transform.location
        return self._scenario.cast.state(self.cars[-1].member).distance_m(place.x, place.y)

    def _draw(self) -> float:
        return self._scenario.random.uniform(*self._spacing_m)

    def _spawn(self, index: int) -> Car | None:
        scenario = self._scenario
        member = scenario.cast.spawn(scenario.random.choice(self._kinds), self._line[index].transform)
        if member is None:
            return None
        rest = self._line[index:]
        if len(rest) < 2:
            scenario.cast.remove([member])
            return None
        car = scenario.cars.drive(
            member,
            rest,
            self._speed_mps,
            constant=self._constant,
            ends=True,
            offset_m=self._offset_m,
            obeys_lights=False,
        )
        self.cars.append(car)
        self.spawned += 1
        return car


def run_flows(flows: Sequence[Flow], over: Any) -> Any:
    """Script: run the flows until `over()`, then remove them."""
    while not over():
        for flow in flows:
            flow.tick()
        yield
    for flow in flows:
        flow.clear()
