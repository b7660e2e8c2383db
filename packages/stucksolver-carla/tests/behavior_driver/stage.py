"""A stage on the simulator: a straight lane to set scenes on, and a drive that is recorded tick by tick."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import carla
import numpy as np

from stucksolver_carla.drivers.behavior import BehaviorDriver, DrivePoint
from stucksolver_carla.drivers.behavior.route_line import smooth_step
from stucksolver_eval.scenarios.families.street import into_gear

TICK_S = 0.05


class Tick(NamedTuple):
    """What is kept of each tick: a number each, or a column of them for a whole drive."""

    speed: Any
    gap: Any
    lateral: Any


@contextmanager
def simulator(map_file: Path) -> Iterator[Any]:
    """A running carlette on a free port, in synchronous mode; gives the `carla.World`."""
    command = [sys.executable, "-m", "carlette", "--port", "0", "--map", str(map_file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            port = re.search(r":(\d+) ", server.stdout.readline())
            assert port, "the simulator did not tell its port"
            client = carla.Client("127.0.0.1", int(port[1]))
            client.set_timeout(60.0)
            world = client.get_world()
            settings = world.get_settings()
            settings.synchronous_mode, settings.fixed_delta_seconds = True, TICK_S
            world.apply_settings(settings)
            world.tick()
            yield world
        finally:
            server.terminate()
            server.wait(timeout=60.0)


class Stage:
    """Actors placed along one lane, by meters from its start and meters to the right of its center."""

    def __init__(self, world: Any, road: int, lane: int) -> None:
        self.world = world
        self.lane = [_lane_start(world, road, lane)]
        while ahead := [w for w in self.lane[-1].next(1.0) if (w.road_id, w.lane_id) == (road, lane)]:
            self.lane.append(ahead[0])
        self.actors: list[Any] = []

    def place(self, s: int, right: float = 0.0, turn: float = 0.0, up: float = 0.2) -> Any:
        """A transform on the lane; `turn` in degrees."""
        at = self.lane[s].transform
        yaw = math.radians(at.rotation.yaw)
        x, y = at.location.x - right * math.sin(yaw), at.location.y + right * math.cos(yaw)
        return carla.Transform(carla.Location(x, y, at.location.z + up), carla.Rotation(yaw=at.rotation.yaw + turn))

    def add(self, blueprint: str, s: int, right: float = 0.0, turn: float = 0.0, speed: float = 0.0) -> Any:
        """An actor; a vehicle given a speed (m/s) keeps it."""
        library = self.world.get_blueprint_library()
        actor = self.world.spawn_actor(library.find(blueprint), self.place(s, right, turn))
        self.actors.append(actor)
        if blueprint.startswith("vehicle"):
            into_gear(actor)
            self.world.tick()
        if speed:
            actor.enable_constant_velocity(carla.Vector3D(speed, 0.0, 0.0))
        return actor

    def ego(self, s: int, to: int, **driver: Any) -> tuple[Any, BehaviorDriver]:
        """A car with its driver, sent to another place of the lane."""
        car = self.add("vehicle.tesla.model3", s)
        self.world.tick()
        behavior = BehaviorDriver(car, **driver)
        behavior.set_destination(self.lane[to].transform.location)
        return car, behavior

    def clear(self) -> None:
        """Take everything off the stage."""
        for actor in self.actors:
            actor.destroy()
        self.actors.clear()
        self.world.tick()

    def drive(self, car: Any, driver: BehaviorDriver, seconds: float, until: Callable[[], bool] | None = None) -> Tick:
        """Let the driver drive; the result's columns are those of `Tick`."""
        return drive(self.world, car, driver, seconds, until)

    def shifted(self, car: Any, right: float, over: float, length: float, speed: float) -> list[DrivePoint]:
        """A path from the car along the lane that shifts `right` meters within `over` meters of travel."""
        begin = car.get_location()
        start = min(range(len(self.lane)), key=lambda i: self.lane[i].transform.location.distance(begin))
        points = []
        for k in range(int(length) + 1):
            offset = right * float(smooth_step(np.array([(k - 0.5) / over]))[0])
            place = self.place(start + k, offset).location
            points.append(DrivePoint(place.x, place.y, speed))
        return points


def drive(
    world: Any, car: Any, driver: BehaviorDriver, seconds: float, until: Callable[[], bool] | None = None
) -> Tick:
    """Tick the world with the driver's controls; each field of the result has a value for each tick."""
    ticks = []
    for _ in range(round(seconds / TICK_S)):
        car.apply_control(driver.run_step())
        world.tick()
        gap = driver.hazard.gap if driver.hazard else math.inf
        velocity = car.get_velocity()
        ticks.append(Tick(math.hypot(velocity.x, velocity.y), gap, driver.lateral_error_m))
        if until is not None and until():
            break
    return Tick(*np.array(ticks).T)


def _lane_start(world: Any, road: int, lane: int) -> Any:
    entries = (entry for entry, _ in world.get_map().get_topology())
    return next(entry for entry in entries if (entry.road_id, entry.lane_id) == (road, lane))
