"""Traffic in lockstep, as a program of its own: a client library that hangs can be ended from outside.

Usage: traffic_run.py PORT TRAFFIC_MANAGER_PORT CARS TICKS. Prints one line of JSON.
"""

from __future__ import annotations

import hashlib
import json
import math
import random
import sys

import carla

DT = 0.05
SAMPLE_TICKS = 10


def main(port: int, manager_port: int, count: int, ticks: int) -> dict[str, object]:
    client = carla.Client("127.0.0.1", port)
    client.set_timeout(60.0)
    world = client.get_world()
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, DT
    world.apply_settings(settings)
    # The second run on the same server meets lights and ids as the first did.
    world = client.load_world(world.get_map().name.rsplit("/", 1)[-1], reset_settings=False)
    manager = client.get_trafficmanager(manager_port)
    manager.set_synchronous_mode(True)
    manager.set_random_device_seed(7)
    cars = spawn_cars(world, count)
    world.tick()
    for car in cars:
        car.set_autopilot(True, manager_port)
    start = {car.id: car.get_location() for car in cars}
    offsets, digest = [], hashlib.sha256()
    for tick in range(ticks):
        world.tick()
        if tick % SAMPLE_TICKS == 0:
            offsets += observe(world, cars, digest)
    moved = sum(car.get_location().distance(start[car.id]) > 5.0 for car in cars)
    manager.set_synchronous_mode(False)
    offsets.sort()
    return {
        "cars": len(cars),
        "moved": moved,
        "median_m": offsets[len(offsets) // 2],
        "p95_m": offsets[len(offsets) * 95 // 100],
        "digest": digest.hexdigest(),
    }


def spawn_cars(world, count: int) -> list:
    library = world.get_blueprint_library()
    blueprints = [item for item in library.filter("vehicle.*") if item.get_attribute("base_type").as_str() == "car"]
    blueprints.sort(key=lambda item: item.id)
    spots = world.get_map().get_spawn_points()
    chance = random.Random(5)
    chance.shuffle(spots)
    cars = []
    for spot in spots:
        if len(cars) == count:
            break
        car = world.try_spawn_actor(chance.choice(blueprints), spot)
        if car is not None:
            cars.append(car)
    return cars


def observe(world, cars: list, digest) -> list[float]:
    """Distances of the cars from the middle of their lanes; their poses go into the digest."""
    snapshot, offsets = world.get_snapshot(), []
    for car in cars:
        pose = snapshot.find(car.id).get_transform()
        place = pose.location
        digest.update(repr((place.x, place.y, place.z, pose.rotation.yaw)).encode())
        lane = world.get_map().get_waypoint(place).transform
        right = lane.get_right_vector()
        gap = place - lane.location
        offsets.append(math.fabs(gap.x * right.x + gap.y * right.y))
    return offsets


if __name__ == "__main__":
    print(json.dumps(main(*map(int, sys.argv[1:]))))
