"""Traffic on the other roads of the hero's next junction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from stucksolver_eval.actors import Car
from stucksolver_eval.background_traffic.ego_snapshot import EgoSnapshot
from stucksolver_eval.background_traffic.lanes import RouteJunction, adjacent_lane, back, entries, slots

if TYPE_CHECKING:
    import carla


@dataclass(eq=False)
class _Source:
    entry: carla.Waypoint
    """The last waypoint before the junction."""
    place: Any
    spawned: int = 0
    last: Car | None = None


class CrossingTraffic:
    """Traffic at the junction.

    It appears when the hero is near: up to 40 m before the other entries, and two cars on each lane of its exit.
    """

    SPACING_M: ClassVar[float] = 15.0
    """Distance between cars (m). As in the leaderboard's background activity."""
    SOURCE_M: ClassVar[float] = 40.0
    """Largest distance of new cars from their entry (m). As in the leaderboard's background activity."""
    NEAREST_SOURCE_M: ClassVar[float] = 15.0
    """Smallest distance of new cars from their entry (m). As in the leaderboard's background activity."""
    FIRST_CAR_PROB: ClassVar[float] = 0.8
    """Probability of each of the first cars. As in the leaderboard's background activity."""
    MOST_EACH: ClassVar[int] = 6
    """Maximum number of cars of one entry. As in the leaderboard's background activity."""
    MOST: ClassVar[int] = 10
    """Maximum number of cars at the junction."""
    EXIT_GAP_M: ClassVar[float] = 30.0
    """Length of the hero's exit without cars (m)."""
    EXIT_CARS: ClassVar[int] = 2
    """Number of cars on each lane of the hero's exit. As in the leaderboard's background activity."""
    GONE_M: ClassVar[float] = 70.0
    """Distance from the hero at which cars are removed (m)."""

    def __init__(self, ego: EgoSnapshot) -> None:
        self._ego = ego
        self._junction: RouteJunction | None = None
        self._sources: list[_Source] = []
        self._cars: list[Car] = []
        self._exit_cars: list[Car] = []
        self._quiet_roads: set[int] = set()
        self._quiet = False
        self.exit_gap_m = self.EXIT_GAP_M

    @property
    def cars(self) -> list[Car]:
        """All cars of this traffic."""
        return list(self._cars)

    def tick(self) -> None:
        """Spawn and remove cars, and set their speeds."""
        ego = self._ego
        if self._junction is not None and ego.junction is not self._junction:
            self._leave()
        if self._junction is None and ego.junction is not None and ego.near_junction:
            self._arrive(ego.junction)
        if not self._quiet:
            for source in self._sources:
                self._feed(source)
        for car in self._cars:
            car.wish_mps = ego.limit_mps
        self._retire()

    def hand_over(self) -> list[Car]:
        """Return new cars on the hero's exit, once. From then on they belong to the road's traffic."""
        cars, self._exit_cars = self._exit_cars, []
        return cars

    def quiet(self, clear_middle: bool, roads: set[int], stop_entries: bool) -> None:
        """See `Background.handle_junction_scenario`."""
        self._quiet_roads |= roads
        self._quiet = self._quiet or stop_entries
        gone = [car for car in self._cars if self._is_on(car, roads) or (clear_middle and self._inside(car))]
        self._ego.setting.cars.remove(gone)
        self._cars = [car for car in self._cars if car not in gone]

    def _arrive(self, junction: RouteJunction) -> None:
        self._junction = junction
        route = self._ego.setting.route
        own = route.waypoints[max(junction.first - 1, 0)].road_id
        for entry in entries(route.waypoints[junction.first]):
            if entry.road_id == own or entry.road_id in self._quiet_roads:
                continue
            distances = (self.SOURCE_M, 30.0, 20.0, self.NEAREST_SOURCE_M)
            place = next((p for p in (back(entry, d) for d in distances) if p is not None), None)
            if place is not None and self._ego.setting.random.random() < self.FIRST_CAR_PROB:
                self._sources.append(_Source(entry, place))
        self._fill_exit(junction)

    def _fill_exit(self, junction: RouteJunction) -> None:
        """Spawn two waiting cars on each lane of the hero's exit."""
        ego, route = self._ego, self._ego.setting.route
        if junction.last + 1 >= len(route.waypoints) or (self._quiet and self.exit_gap_m == self.EXIT_GAP_M):
            return
        leave_s = float(route.s_m[junction.last])
        for k in range(self.EXIT_CARS):
            s = leave_s + self.exit_gap_m + k * self.SPACING_M
            way = route.waypoints[junction.last + 1 : route.index_at(s) + 1]
            if s > route.length_m or any(waypoint.is_junction for waypoint in way):
                return
            for slot in slots(route.waypoint_at(s)):
                lane = adjacent_lane(route.waypoint_at(s), slot)
                car = None if lane is None else ego.spawn(lane, 0.0)
                if car is not None:
                    self._exit_cars.append(car)

    def _feed(self, source: _Source) -> None:
        if len(self._cars) >= self.MOST or source.spawned >= self.MOST_EACH:
            return
        place = source.place.transform.location
        if source.last is not None and source.last.state.distance_m(place.x, place.y) < self.SPACING_M:
            return
        car = self._ego.spawn(source.place, 0.0, lane_chooser=self._anywhere)
        if car is not None:
            source.last = car
            source.spawned += 1
            self._cars.append(car)

    def _anywhere(self, options: Sequence[Any]) -> Any:
        return self._ego.setting.random.choice(list(options))

    def _leave(self) -> None:
        self._junction = None
        self._sources = []
        self._quiet_roads.clear()
        self._quiet = False
        self.exit_gap_m = self.EXIT_GAP_M

    def _retire(self) -> None:
        hero = self._ego.setting.cast.hero
        gone = [car for car in self._cars if self._is_gone(car, car.state.distance_m(hero.x, hero.y))]
        self._ego.setting.cars.remove(gone)
        self._cars = [car for car in self._cars if car not in gone]

    def _is_gone(self, car: Car, far_m: float) -> bool:
        left = bool(car.path.crossings) and car.s > car.path.crossings[0].leave_s + 40.0
        reach_m = self.GONE_M if self._junction is None else 2.5 * self.GONE_M
        return car.done or far_m > reach_m or (left and far_m > 30.0)

    def _inside(self, car: Car) -> bool:
        return any(crossing.enter_s <= car.s <= crossing.leave_s for crossing in car.path.crossings)

    @staticmethod
    def _is_on(car: Car, roads: set[int]) -> bool:
        return car.start_road in roads
