"""Traffic on the hero's own road, ahead of it and behind it, in all lanes of its direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from stucksolver_eval.actors import Car
from stucksolver_eval.actors.lane_path import Chooser, straightest
from stucksolver_eval.background_traffic.ego_snapshot import EgoSnapshot
from stucksolver_eval.background_traffic.lanes import adjacent_lane, back, is_driving, slots

if TYPE_CHECKING:
    import carla

MAX_MPS = 90.0 / 3.6
"""Largest speed of the traffic (m/s): 90 km/h. As in the leaderboard's background activity."""


@dataclass(eq=False)
class _RoadCar:
    car: Car
    ahead_m: float = 0.0
    slot: int = 0
    """Lanes from the route's lane toward the road's edge; negative away from it."""


class RoadTraffic:
    """Two cars ahead and two behind in each lane, 15 m apart. New cars spawn at least 30 m behind the hero."""

    SPACING_M: ClassVar[float] = 15.0
    """Distance between cars (m). As in the leaderboard's background activity."""
    AHEAD: ClassVar[int] = 2
    """Number of cars ahead in each lane. As in the leaderboard's background activity."""
    BEHIND: ClassVar[int] = 2
    """Number of cars behind in each lane. As in the leaderboard's background activity."""
    MOST: ClassVar[int] = 4
    """Maximum number of cars in each lane."""
    SOURCE_M: ClassVar[float] = 30.0
    """Smallest distance of new cars behind the hero (m)."""
    LOST_M: ClassVar[float] = 150.0
    """Distance from the hero at which cars are removed (m)."""

    def __init__(self, ego: EgoSnapshot) -> None:
        self._ego = ego
        self._cars: list[_RoadCar] = []
        self._closed: set[tuple[int, int]] = set()
        self._closed_slots: set[int] = set()
        self.spacing_m = self.SPACING_M
        self.extra_space_m = 0.0
        self.cap_mps: float | None = None
        self.sources = True
        self.front_stopped = self.back_stopped = False

    @property
    def cars(self) -> list[Car]:
        """All cars of this traffic."""
        return [car.car for car in self._cars]

    @property
    def ahead(self) -> list[Car]:
        """The cars ahead of the hero."""
        return [car.car for car in self._cars if car.ahead_m > 0.0]

    def populate(self) -> None:
        """Spawn the first cars."""
        for slot in slots(self._ego.waypoint):
            lane = adjacent_lane(self._ego.waypoint, slot)
            if lane is None or self._is_closed(lane):
                continue
            ahead = lane
            for _ in range(self.AHEAD):
                next_waypoint = _waypoint_ahead(ahead, self.SPACING_M)
                if next_waypoint is None:
                    break
                ahead = next_waypoint
                self._spawn(ahead, slot, 0.0)
            for k in range(1, self.BEHIND + 1):
                behind = back(lane, k * self.SPACING_M)
                if behind is not None:
                    self._spawn(behind, slot, 0.0)

    def tick(self) -> None:
        """Spawn and remove cars, and set their speeds."""
        self._place()
        self._retire()
        if self.sources:
            self._source()
        for car in self._cars:
            car.car.wish_mps = self._wish(car)
            car.car.brakes_hard = self.front_stopped and car.ahead_m > 0.0

    def adopt(self, car: Car) -> None:
        """Add a car that has turned onto the hero's road."""
        self._cars.append(_RoadCar(car))

    def leave_space(self, space_m: float) -> None:
        """Move the cars ahead forward until the nearest is `space_m` away. Remove those without space on the road."""
        self._place()
        ahead = [car for car in self._cars if car.ahead_m > 0.0]
        lacking = space_m - min((obj.ahead_m for obj in ahead), default=space_m)
        if lacking <= 0.0:
            return
        cast, cars, route = self._ego.setting.cast, self._ego.setting.cars, self._ego.setting.route
        # The farthest car moves first, so that no car is placed onto another.
        for obj in sorted(ahead, key=lambda other: -other.ahead_m):
            s = self._ego.s_m + obj.ahead_m + lacking
            there = adjacent_lane(route.waypoint_at(s), obj.slot) if s < route.length_m else None
            if there is None or there.is_junction or self._crosses_junction(obj.ahead_m, lacking):
                self._remove([obj])
                continue
            transform = there.transform
            transform.location.z += 0.2
            cast.teleport(obj.car.member, transform)
            cars.redirect(obj.car, there, lane_chooser=self._route_chooser())

    def close_lane(self, waypoint: carla.Waypoint) -> None:
        """Remove the cars of a lane, and keep it empty."""
        slot = self._slot_of(waypoint)
        self._closed_slots.add(slot)
        self._place()
        self._remove([car for car in self._cars if car.slot == slot])

    def open_lane(self, waypoint: carla.Waypoint) -> None:
        """Reopen a closed lane."""
        self._closed_slots.discard(self._slot_of(waypoint))

    def remove_ahead(self) -> None:
        """Remove the cars ahead."""
        self._place()
        self._remove([car for car in self._cars if car.ahead_m > 0.0])

    def remove_behind(self) -> None:
        """Remove the cars behind in the hero's lane."""
        self._place()
        self._remove([car for car in self._cars if car.ahead_m <= 0.0 and car.slot == 0])

    def _wish(self, car: _RoadCar) -> float:
        """Return a car's target speed (m/s).

        Cars ahead wait for the hero, except in junctions; cars behind catch up.
        """
        ego = self._ego
        near_m = 2.0 * self.SPACING_M + 1.7 * ego.speed_mps + self.extra_space_m
        share = (abs(car.ahead_m) - near_m) / self.SPACING_M
        share = min(max(share, 0.0), 1.0)
        if car.ahead_m > 0.0:
            if self.front_stopped:
                return 0.0
            factor = 1.0 if car.car.in_junction else 1.0 - share
        else:
            if self.back_stopped:
                return 0.0
            factor = 1.0 + share
        return min(ego.limit_mps * factor, MAX_MPS if self.cap_mps is None else self.cap_mps)

    def _place(self) -> None:
        width_m = max(self._ego.waypoint.lane_width, 2.5)
        for car in self._cars:
            car.ahead_m, edge_m = self._ego.along(car.car)
            car.slot = round(edge_m / width_m)

    def _retire(self) -> None:
        ego = self._ego
        hero = ego.setting.cast.hero
        gone = [
            car
            for car in self._cars
            if car.car.done
            or car.car.state.distance_m(hero.x, hero.y) > self.LOST_M
            or (abs(car.slot) > 5 and car.car.state.distance_m(hero.x, hero.y) > 40.0)
        ]
        self._remove(gone)
        for slot in {car.slot for car in self._cars}:
            lane = sorted((car for car in self._cars if car.slot == slot), key=lambda car: car.ahead_m)
            ahead = [item for item in lane if item.ahead_m > 0.0]
            if len(ahead) > self.AHEAD and len(lane) >= self.MOST and ahead[-1].ahead_m > 40.0:
                self._remove([ahead[-1]])

    def _source(self) -> None:
        ego = self._ego
        here = ego.waypoint
        if here.is_junction:
            return
        for slot in slots(here):
            if slot in self._closed_slots:
                continue
            lane = [car for car in self._cars if car.slot == slot]
            last_m = min((item.ahead_m for item in lane), default=0.0)
            if len(lane) >= self.MOST or last_m < -self.SOURCE_M:
                continue
            source_m = max(self.SOURCE_M, self.spacing_m - last_m)
            beside_hero = adjacent_lane(here, slot)
            place = None if beside_hero is None else back(beside_hero, source_m)
            if place is not None and is_driving(place):
                self._spawn(place, slot, min(ego.speed_mps + 2.0, ego.limit_mps))

    def _spawn(self, waypoint: carla.Waypoint, slot: int, speed_mps: float) -> None:
        if slot in self._closed_slots:
            return
        car = self._ego.spawn(waypoint, speed_mps, lane_chooser=self._route_chooser())
        if car is not None:
            self._cars.append(_RoadCar(car, slot=slot))

    def _remove(self, some: Sequence[_RoadCar]) -> None:
        self._ego.setting.cars.remove([item.car for item in some])
        self._cars = [car for car in self._cars if car not in some]

    def _slot_of(self, waypoint: carla.Waypoint) -> int:
        place = waypoint.transform.location
        route = self._ego.setting.route
        index = route.project(place, self._ego.index)
        fx, fy = route.forward[index, :2]
        dx, dy = place.x - route.xyz[index, 0], place.y - route.xyz[index, 1]
        return round(float(-dx * fy + dy * fx) / max(float(waypoint.lane_width), 2.5))

    def _is_closed(self, waypoint: carla.Waypoint) -> bool:
        return self._slot_of(waypoint) in self._closed_slots

    def _crosses_junction(self, from_m: float, by_m: float) -> bool:
        ego = self._ego
        return bool(from_m < ego.junction_in_m <= from_m + by_m)

    def _route_chooser(self) -> Chooser:
        """Return a chooser that follows the route at forks where possible, and goes straight on otherwise."""
        lanes = self._ego.route_lanes

        def choose(options: Sequence[Any]) -> Any:
            on_route = [option for option in options if (option.road_id, option.lane_id) in lanes]
            return on_route[0] if on_route else straightest(options)

        return choose


def _waypoint_ahead(waypoint: carla.Waypoint, distance_m: float) -> Any | None:
    """Return the waypoint `distance_m` ahead on the lane, or None if a junction or fork is in between."""
    here = waypoint
    for _ in range(max(round(distance_m / 5.0), 1)):
        after = here.next(5.0)
        if len(after) != 1 or after[0].is_junction or not is_driving(after[0]):
            return None
        here = after[0]
    return here
