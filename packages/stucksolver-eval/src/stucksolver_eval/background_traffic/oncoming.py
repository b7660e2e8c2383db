"""Traffic in the oncoming lanes of the hero's road."""

from __future__ import annotations

from typing import ClassVar

from stucksolver_eval.actors import Car
from stucksolver_eval.background_traffic.ego_snapshot import EgoSnapshot
from stucksolver_eval.background_traffic.lanes import oncoming_lanes


class OncomingTraffic:
    """Cars spawn 80 m ahead and are removed 80 m behind. They ignore traffic lights and signs."""

    SPACING_M: ClassVar[float] = 40.0
    """Distance between cars (m). As in the leaderboard's background activity."""
    SOURCE_M: ClassVar[float] = 80.0
    """Distance of new cars (m). As in the leaderboard's background activity."""
    KEEP_M: ClassVar[float] = 80.0
    """Distance behind the hero at which cars are removed (m). As in the leaderboard's background activity."""
    MOST: ClassVar[int] = 8
    """Maximum number of cars."""

    def __init__(self, ego: EgoSnapshot) -> None:
        self._ego = ego
        self._cars: list[Car] = []
        self.active = True
        self.spacing_m = self.SPACING_M
        self.cap_mps: float | None = None
        self._keep_off: tuple[float, float] | None = None

    def tick(self) -> None:
        """Spawn and remove cars, and set their speeds."""
        self._retire()
        if self.active:
            self._source()
        speed = self._speed()
        for car in self._cars:
            car.wish_mps = 0.0 if self._stands(car) else speed

    def clear(self) -> None:
        """Remove all cars."""
        self._ego.setting.cars.remove(self._cars)
        self._cars = []

    def keep_off(self, x: float, y: float) -> None:
        """Remove cars within 20 m of a position. From then on, cars that approach it within 30 m stop."""
        self._keep_off = (x, y)
        near = [car for car in self._cars if car.state.distance_m(x, y) < 20.0]
        self._ego.setting.cars.remove(near)
        self._cars = [car for car in self._cars if car not in near]

    def _speed(self) -> float:
        limit = self._ego.limit_mps
        return limit if self.cap_mps is None else min(limit, self.cap_mps)

    def _stands(self, car: Car) -> bool:
        if self._keep_off is None:
            return False
        x, y = self._keep_off
        return car.state.distance_m(x, y) < 30.0 and car.state.ahead_m(x, y) > 0.0

    def _retire(self) -> None:
        hero = self._ego.setting.cast.hero
        gone = [
            car
            for car in self._cars
            if car.done
            or (car.state.distance_m(hero.x, hero.y) > self.KEEP_M and hero.ahead_m(car.state.x, car.state.y) < 0.0)
            or car.state.distance_m(hero.x, hero.y) > 3 * self.KEEP_M
        ]
        self._ego.setting.cars.remove(gone)
        self._cars = [car for car in self._cars if car not in gone]

    def _source(self) -> None:
        ego = self._ego
        if ego.junction_in_m < self.SOURCE_M or len(self._cars) >= self.MOST:
            return
        route = ego.setting.route
        if ego.s_m + self.SOURCE_M > route.length_m:
            return
        for lane in oncoming_lanes(route.waypoint_at(ego.s_m + self.SOURCE_M)):
            place = lane.transform.location
            last = min((car.state.distance_m(place.x, place.y) for car in self._cars), default=1e9)
            if last > self.spacing_m and not lane.is_junction:
                car = ego.spawn(lane, self._speed(), obeys_lights=False)
                if car is not None:
                    self._cars.append(car)
