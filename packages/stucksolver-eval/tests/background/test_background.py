"""Background traffic around a hero that stands, drives, or comes to a junction; and the scenarios' hooks."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator
from typing import Any

import pytest

carla = pytest.importorskip("carla")

from stucksolver_carla.drivers.behavior import RoutePoint  # noqa: E402
from stucksolver_eval.background_traffic import Background  # noqa: E402
from stucksolver_eval.background_traffic.lanes import route_junctions  # noqa: E402
from stucksolver_eval.routes.route_line import RouteLine  # noqa: E402
from stucksolver_eval.scenarios import ScenarioContext, ScenarioPlayer  # noqa: E402
from stucksolver_eval.simulator_server import carlette_server  # noqa: E402

pytestmark = pytest.mark.integration
TICK_S = 0.05


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with carlette_server("demo_town") as server:
        found = carla.Client(server.host, server.port)
        found.set_timeout(60.0)
        yield found


class Drive:
    """A hero on the ring's two lanes, driven at a constant speed by the cars' own means."""

    def __init__(
        self, client: Any, road: int = 3, start_m: float = 60.0, length_m: int = 250, empty: bool = False
    ) -> None:
        self.world = client.load_world("demo_town")
        settings = self.world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, TICK_S
        self.world.apply_settings(settings)
        carla_map = self.world.get_map()
        here = carla_map.get_waypoint_xodr(road, -2, start_m)
        line = [here]
        while len(line) < length_m:
            onward = line[-1].next(1.0)
            line.append(max(onward, key=lambda w: (w.lane_id, w.road_id)) if len(onward) > 1 else onward[0])
        self.route = RouteLine.along([RoutePoint(w, "lane_follow") for w in line])
        blueprint = self.world.get_blueprint_library().find("vehicle.lincoln.mkz_2020")
        blueprint.set_attribute("role_name", "hero")
        place = here.transform
        place.location.z += 0.3
        self.hero = self.world.spawn_actor(blueprint, place)
        self.world.tick()
        self.setting = ScenarioContext(client, self.world, carla_map, self.hero, self.route, random.Random(5))
        self.background = Background(self.setting, empty=empty)
        self.play = ScenarioPlayer([], self.setting, self.background)
        self.index = 0

    def run(self, seconds: float, speed_mps: float | None = None) -> None:
        if speed_mps is not None:
            self.setting.cars.drive(
                self.setting.cast.hero_member, self.route.waypoints[self.index :], speed_mps, ends=True
            )
        for _ in range(round(seconds / TICK_S)):
            self.world.tick()
            self.index = self.route.project(self.hero.get_location(), self.index)
            now_s = self.world.get_snapshot().timestamp.elapsed_seconds
            self.play.tick(now_s, float(self.route.s_m[self.index]))

    def ahead_m(self) -> dict[int, list[float]]:
        """How far ahead each car of the hero's road is, by its lane (0 is the hero's)."""
        found: dict[int, list[float]] = {}
        for car in self.background.road._cars:
            found.setdefault(car.slot, []).append(car.ahead_m)
        return {slot: sorted(values) for slot, values in found.items()}

    def close(self) -> None:
        self.play.close()
        self.hero.destroy()


@pytest.fixture
def drive(client: Any) -> Iterator[Any]:
    begun: list[Drive] = []

    def begin(**options: Any) -> Drive:
        begun.append(Drive(client, **options))
        return begun[-1]

    yield begin
    for item in begun:
        item.close()


def test_background_start_places_two_cars_ahead_and_behind(drive):
    """At the start, each lane has two cars ahead of the ego and two behind, 15 m apart."""
    start = drive()
    start.run(0.25)
    assert {slot: [round(m) for m in values] for slot, values in start.ahead_m().items()} == {
        -1: [-30, -15, 15, 30],
        0: [-30, -15, 15, 30],
    }


def test_cars_ahead_wait_for_a_hero_that_stands(drive):
    stood = drive()
    stood.run(15.0)
    ahead = [m for values in stood.ahead_m().values() for m in values if m > 0.0]
    assert ahead and max(ahead) < 60.0
    # Beside the hero cars pass; in its own lane the farthest has come to a stand where traffic waits, 45 m ahead.
    farthest = max((car for car in stood.background.road._cars if car.slot == 0), key=lambda car: car.ahead_m)
    assert farthest.ahead_m > 40.0
    assert farthest.car.speed_mps < 0.3


def test_traffic_goes_along_with_the_hero(drive):
    going = drive()
    going.run(12.0, speed_mps=9.0)
    lanes = going.ahead_m()
    assert set(lanes) == {-1, 0} and all(2 <= len(values) <= 5 for values in lanes.values())
    assert any(m > 0.0 for m in lanes[0]) and any(m < 0.0 for m in lanes[-1])
    speeds = [car.speed_mps for car in going.background.road.cars]
    assert 6.0 < sum(speeds) / len(speeds) < 14.0


@pytest.mark.slow
def test_nobody_of_the_traffic_touches_anybody(drive):
    going = drive(road=5, start_m=40.0, length_m=330)
    sensors = []
    hits: list[str] = []
    going.run(0.2, speed_mps=8.0)
    blueprint = going.world.get_blueprint_library().find("sensor.other.collision")
    for _ in range(30):
        known = {sensor.parent.id for sensor in sensors}
        for member in [m for m in going.setting.cast.members.values() if m.id not in known]:
            sensors.append(going.world.spawn_actor(blueprint, carla.Transform(), attach_to=member.actor))
            sensors[-1].listen(lambda event: hits.append(f"{event.actor.type_id} - {event.other_actor.type_id}"))
        going.run(1.0)
    assert not hits and len(sensors) >= 6
    for sensor in sensors:
        if sensor.is_alive:
            sensor.destroy()


def test_a_junction_gets_cars_from_its_other_entries(drive):
    coming = drive(road=5, start_m=40.0, length_m=330)
    junction = route_junctions(coming.route)[0]
    near_s = float(coming.route.s_m[junction.first]) - 25.0
    place = coming.route.waypoint_at(near_s).transform
    place.location.z += 0.3
    coming.hero.set_transform(place)
    coming.run(3.0)
    others = coming.background.crossing.cars
    own_road = coming.route.waypoints[junction.first - 1].road_id
    assert others and all(car.start_road != own_road for car in others)
    # Behind the exit two cars wait for the hero.
    assert any(m > 30.0 for m in coming.ahead_m().get(0, []))


@pytest.mark.parametrize("before_m", [15.0, *(pytest.param(item, marks=pytest.mark.release) for item in (30.0, 40.0))])
def test_nobody_waits_for_the_hero_in_a_junction(drive, before_m):
    waiting = drive(road=5, start_m=40.0, length_m=330)
    for light in waiting.world.get_actors().filter("*traffic_light*"):
        light.set_state(carla.TrafficLightState.Green)
        light.freeze(True)
    junction = route_junctions(waiting.route)[0]
    place = waiting.route.waypoint_at(float(waiting.route.s_m[junction.first]) - before_m).transform
    place.location.z += 0.3
    waiting.hero.set_transform(place)
    waiting.run(25.0)
    standing = [item.car for item in waiting.background.road._cars if item.car.speed_mps < 0.2]
    beyond = [car for car in standing if car.path.crossings and car.s > car.path.crossings[0].leave_s]
    assert beyond and not any(car.in_junction for car in standing)


def test_lights_are_heeded(drive):
    coming = drive(road=5, start_m=40.0, length_m=330)
    for light in coming.world.get_actors().filter("*traffic_light*"):
        light.set_state(carla.TrafficLightState.Red)
        light.freeze(True)
    coming.run(30.0, speed_mps=7.0)
    inside = [
        car
        for car in coming.setting.cars._cars.values()
        if coming.setting.map.get_waypoint(car.member.actor.get_location()).is_junction
        and car.member is not coming.setting.cast.hero_member
        and car not in coming.background.oncoming._cars
    ]
    assert not inside


def test_an_empty_background_stays_empty_and_takes_every_wish(drive):
    alone = drive(empty=True)
    alone.background.leave_space_in_front(50.0)
    alone.background.stop_front()
    alone.background.remove_behind()
    alone.background.handle_junction_scenario()
    alone.background.leave_crossing_space(0.0, 0.0)
    alone.run(1.0)
    assert not alone.setting.cast.members


# The hooks.


def test_space_is_left_in_front(drive):
    asked = drive()
    asked.run(0.25)
    asked.background.leave_space_in_front(50.0)
    asked.run(0.25)
    ahead = [m for values in asked.ahead_m().values() for m in values if m > 0.0]
    assert len(ahead) == 4 and min(ahead) > 49.0


def test_background_removed_lane_stays_empty_until_readded(drive):
    """A lane that a scenario removes becomes empty and stays so until the scenario adds it again."""
    asked = drive()
    asked.run(0.25)
    lane = asked.route.waypoint_at(20.0).get_left_lane()
    asked.background.remove_road_lane(lane)
    asked.run(6.0, speed_mps=9.0)
    assert -1 not in asked.ahead_m() and 0 in asked.ahead_m()
    asked.background.readd_road_lane(lane)
    asked.run(5.0)
    assert -1 in asked.ahead_m()


def test_speed_is_capped(drive):
    asked = drive()
    asked.background.set_max_speed(3.0)
    asked.run(8.0, speed_mps=4.0)
    assert max(car.speed_mps for car in asked.background.road.cars) < 3.5


def test_the_front_stops_and_starts_and_so_does_the_back(drive):
    asked = drive()
    asked.run(1.5)
    road = asked.background.road
    behind = [item.car for item in road._cars if item.ahead_m < 0.0]
    assert all(car.speed_mps > 1.0 for car in (*road.ahead[:1], *behind[-1:]))
    asked.background.stop_front()
    asked.background.stop_back()
    asked.run(2.5)
    assert road.ahead and all(car.speed_mps < 0.2 for car in (*road.ahead, *behind))
    asked.background.start_front()
    asked.background.start_back()
    asked.run(1.5)
    assert any(car.speed_mps > 1.0 for car in road.ahead) and any(car.speed_mps > 1.0 for car in behind)


def test_oncoming_traffic_keeps_its_spacing_and_can_be_switched_off(drive):
    asked = drive()
    asked.background.change_opposite_behavior(spawn_m=60.0)
    asked.run(10.0, speed_mps=6.0)
    cars = asked.background.oncoming._cars
    assert len(cars) >= 2
    by_lane: dict[int, list[Any]] = {}
    for car in cars:
        by_lane.setdefault(car.path.waypoint.lane_id, []).append(car)
    gaps = [
        item.state.distance_m(other.state.x, other.state.y)
        for lane in by_lane.values()
        for item, other in itertools.pairwise(lane)
    ]
    assert all(gap > 50.0 for gap in gaps)
    asked.background.change_opposite_behavior(active=False)
    asked.background.clear_opposite()
    asked.run(5.0)
    assert not asked.background.oncoming._cars


def test_the_crossing_is_kept_free_of_oncoming_cars(drive):
    asked = drive()
    asked.run(6.0, speed_mps=5.0)
    place = asked.route.waypoint_at(float(asked.route.s_m[asked.index]) + 40.0).transform.location
    asked.background.leave_crossing_space(place.x, place.y)
    asked.run(4.0)
    for car in asked.background.oncoming._cars:
        # Those from 20 to 30 m away are told to stop, which takes them 12 m at 30 km/h.
        away_m, ahead_m = car.state.distance_m(place.x, place.y), car.state.ahead_m(place.x, place.y)
        assert away_m > 17.0 or ahead_m < 0.0 or (ahead_m > 4.0 and car.state.speed_mps < 0.1)


def test_sources_behind_can_be_switched_off(drive):
    asked = drive()
    asked.run(0.25)
    asked.background.switch_route_sources(False)
    asked.background.remove_behind()
    asked.run(5.0)
    assert all(m > 0.0 for m in asked.ahead_m()[0])
