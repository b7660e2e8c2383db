"""Traffic of carlette's own: it keeps its lanes, its distance and its seed, and needs no client."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

from carlette.geometry import Pose
from carlette.in_process import populate
from carlette.opendrive.map_file import find_map, load_map, map_folders
from carlette.opendrive.road_network import RoadNetwork
from carlette.traffic import Traffic
from carlette.world.spawn import spawn
from carlette.world.traffic_lights import Color
from carlette.world.world import World
from straight import CAR, add, drive, speed_of, straight_world, ticks

pytestmark = pytest.mark.integration

KMH = 1 / 3.6


def busy(roads: RoadNetwork, cars: int, seed: int = 3) -> World:
    """A town with that many cars, which drive themselves."""
    world = World(roads, seed)
    populate(world, cars, seed)
    world.traffic = Traffic(world, seed=seed)
    return world


@pytest.fixture(scope="module")
def demo_roads() -> RoadNetwork:
    return RoadNetwork(find_map("demo_town", map_folders([])))


def collisions(world: World, count: int) -> list[tuple[int, int]]:
    """Who hit whom in so many ticks."""
    sensed = [spawn(world, "sensor.other.collision", {}, Pose(), car.id) for car in list(world.actors.values())[1:4]]
    assert sensed  # sensors along with the cars do no harm
    hits: list[tuple[int, int]] = []
    world._report = lambda contacts: hits.extend((contact.first, contact.second) for contact in contacts)
    distance = np.zeros(len(world.fleet))
    for _ in ticks(world, count):
        distance += np.hypot(*world.bodies.velocity[world.fleet.row, :2].T) * world.step_s
    assert (distance > 5.0).all()
    assert distance.mean() > 100.0
    return hits


@pytest.mark.release
@pytest.mark.slow
def test_fifty_cars_never_touch_in_the_demo_town(demo_roads: RoadNetwork) -> None:
    world = busy(demo_roads, 50)
    assert len(world.fleet) == 50
    assert collisions(world, 1300) == []


@pytest.mark.release
def test_twenty_cars_never_touch_in_town01(town01: Path) -> None:
    assert collisions(busy(RoadNetwork(load_map(town01)), 20), 1300) == []


@pytest.mark.slow
def test_traffic_is_reproducible_by_seed(demo_roads: RoadNetwork) -> None:
    """The same seed gives the same traffic, and another seed gives other traffic."""

    def end(seed: int) -> bytes:
        world = busy(demo_roads, 15)
        world.traffic = Traffic(world, seed=seed)
        for _ in ticks(world, 400):
            pass
        return world.bodies.record.tobytes()

    assert end(1) == end(1) != end(2)


@pytest.mark.slow
def test_forks_go_on_with_the_traffic_bit_for_bit(demo_roads: RoadNetwork) -> None:
    world = busy(demo_roads, 15)
    for _ in ticks(world, 200):
        pass
    fork, copy = world.fork(), pickle.loads(pickle.dumps(world))
    for _ in range(300):
        assert world.tick() == fork.tick() == copy.tick()
    assert world.bodies.record.tobytes() == fork.bodies.record.tobytes() == copy.bodies.record.tobytes()


def test_traffic_in_fork_takes_over_moving_cars() -> None:
    """Traffic in a fork takes over moving cars smoothly, and the original has no traffic."""
    world = straight_world()
    cars = [add(world, CAR, x) for x in (50.0, 90.0)]
    for car in cars:
        drive(world, car, throttle=0.6)
    for _ in ticks(world, 60):
        pass
    fork = world.fork()
    fork.traffic = Traffic(fork)
    before = speed_of(fork, fork.actors[cars[0].id])
    fork.tick()
    assert world.traffic is None
    assert speed_of(fork, fork.actors[cars[0].id]) == pytest.approx(before, abs=0.3)
    for _ in ticks(fork, 600):
        assert abs(fork.bodies.position[fork.fleet.row, 1] - 1.75).max() < 0.1
    assert speed_of(fork, fork.actors[cars[1].id]) == pytest.approx(0.9 * 30 * KMH, abs=1.0)


def test_traffic_stops_behind_blocker_and_resumes_after_removal() -> None:
    """Cars stop behind a blocker in their lane and continue when it is removed."""
    world = straight_world()
    car, wreck = add(world, CAR, 50.0), add(world, CAR, 150.0)
    world.traffic = Traffic(world, [car.id])
    drive(world, wreck, hand_brake=1.0)
    for _ in ticks(world, 500):
        pass
    gap = world.pose(wreck).location.x - world.pose(car).location.x - 2 * car.box.extent.x
    assert speed_of(world, car) < 0.1
    assert 0.5 < gap < 5.0
    world.remove(wreck.id)
    for _ in ticks(world, 100):
        pass
    assert speed_of(world, car) > 4.0


def test_cars_wait_for_people_on_the_road() -> None:
    world = straight_world()
    car, walker = add(world, CAR, 50.0), add(world, "walker.pedestrian.0001", 110.0, z=1.0)
    world.traffic = Traffic(world, [car.id])
    for _ in ticks(world, 400):
        pass
    assert speed_of(world, car) < 0.1
    assert world.pose(car).location.x + car.box.extent.x < world.pose(walker).location.x


def test_nobody_passes_a_red_light(demo_roads: RoadNetwork) -> None:
    world = busy(demo_roads, 30)
    for index in range(len(world.signals.lights)):
        world.signals.set_color(index, Color.RED)
    world.signals.freeze(True)
    for _ in ticks(world, 200):
        pass
    lights, record = world.signals.lights, world.bodies.record
    waiting = set()
    for _ in ticks(world, 400):
        at_red = (record["has_light"][world.fleet.row] == 1) & (
            np.hypot(*world.bodies.velocity[world.fleet.row, :2].T) < 0.1
        )
        waiting |= set(np.flatnonzero(at_red).tolist())
        assert (lights.color == Color.RED).all()
    still = np.hypot(*world.bodies.velocity[world.fleet.row, :2].T) < 0.1
    assert waiting
    assert still[list(waiting)].all()


def test_cars_that_are_destroyed_leave_the_traffic(demo_roads: RoadNetwork) -> None:
    world = busy(demo_roads, 10)
    for _ in ticks(world, 50):
        pass
    traffic = world.traffic
    assert isinstance(traffic, Traffic)
    for actor_id in traffic.ids[2:5]:
        world.remove(actor_id)
    for _ in ticks(world, 50):
        pass
    assert len(traffic.ids) == 7
