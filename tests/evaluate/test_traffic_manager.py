"""The TrafficManager drives on the map that is loaded, not on the first one of its process."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

pytest.importorskip("carla")

pytestmark = pytest.mark.integration

SCRIPT = """
import json, os, sys
import carla
from stucksolver_eval.server import carlette_server, set_synchronous
from stucksolver_eval.traffic import Traffic

def farthest_off_the_road(world, manager):
    blueprint = world.get_blueprint_library().find("vehicle.tesla.model3")
    places = world.get_map().get_spawn_points()[:6]
    cars = [car for car in (world.try_spawn_actor(blueprint, place) for place in places) if car]
    world.tick()
    for car in cars:
        car.set_autopilot(True, manager.get_port())
    for _ in range(200):
        world.tick()
    places = [car.get_location() for car in cars]
    return max(world.get_map().get_waypoint(place).transform.location.distance(place) for place in places)

with carlette_server("demo_town") as server:
    client = carla.Client(server.host, server.port)
    client.set_timeout(60.0)
    traffic, world, found = Traffic(client), client.get_world(), []
    for town in ("demo_town", "grid_town"):
        if town != "demo_town":
            world = client.load_world(town)
        set_synchronous(world, 0.05)
        world.tick()
        found.append(farthest_off_the_road(world, traffic.manager(1)))
        assert traffic.manager(1) is traffic.manager(1)
    print(json.dumps(found), flush=True)
    os._exit(0)  # a manager that outlives its server ends the process with a fault
"""


@pytest.mark.integration
def test_after_another_town_is_loaded_its_cars_keep_to_the_roads_of_that_town():
    said = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, timeout=300, check=False)
    found = json.loads(said.stdout.splitlines()[-1]) if said.stdout else said.stderr
    assert max(found) < 1.5, (found, said.stderr)
