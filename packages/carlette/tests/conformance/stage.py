"""What the promises are acted out with."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import carla

CAR = "vehicle.lincoln.mkz_2020"
WALKER = "walker.pedestrian.0005"
DT = 0.05


def make_synchronous(world: Any) -> None:
    """The settings of every evaluator."""
    settings = world.get_settings()
    if settings.synchronous_mode and settings.fixed_delta_seconds == DT:
        return
    settings.synchronous_mode, settings.fixed_delta_seconds = True, DT
    world.apply_settings(settings)


def blueprint(world: Any, type_id: str = CAR, **attributes: str) -> Any:
    """A blueprint with attributes set."""
    found = world.get_blueprint_library().find(type_id)
    for name, value in attributes.items():
        found.set_attribute(name, value)
    return found


def spawn(world: Any, transform: Any, type_id: str = CAR, **attributes: str) -> Any:
    """An actor that is in the snapshot already."""
    actor = world.spawn_actor(blueprint(world, type_id, **attributes), transform)
    world.tick()
    return actor


def settled(world: Any, transform: Any, type_id: str = CAR) -> Any:
    """An actor that has come to rest on the ground."""
    actor = spawn(world, transform, type_id)
    run(world, 30)
    return actor


def ahead(transform: Any, meters: float) -> Any:
    """The transform moved along its own x axis."""
    way = transform.get_forward_vector()
    place = carla.Location(way.x * meters, way.y * meters, way.z * meters)
    return carla.Transform(transform.location + place, transform.rotation)


def above(transform: Any, meters: float) -> Any:
    """The transform moved up."""
    return carla.Transform(transform.location + carla.Location(z=meters), transform.rotation)


def run(world: Any, ticks: int) -> None:
    """Ticks."""
    for _ in range(ticks):
        world.tick()


def soon(condition: Callable[[], bool], limit_s: float = 5.0) -> bool:
    """Waits for what another thread brings about."""
    deadline = time.monotonic() + limit_s
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.005)
    return condition()
