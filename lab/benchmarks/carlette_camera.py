"""Frames per second of carlette's cameras, alone on one core, in a street with twenty cars.

CPU time is measured instead of wall time, so that other programs have little effect. Each rate is also given as a ratio
to a baseline in the same run. The baseline, 2x2 averaging of a 1600x900 image in plain numpy, shows the current speed
of the machine.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from carlette.blueprints import load_catalog
from carlette.camera.rendering.lighting import FOG_DENSITY, PRECIPITATION, SUN_ALTITUDE
from carlette.camera.rendering.renderer import Renderer
from carlette.camera.rendering.scene_capture import static_scene_of, take
from carlette.camera.rendering.view import CameraView
from carlette.geometry import Pose, Rotation, Vector
from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.physics.vehicle_dynamics import THROTTLE
from carlette.world.settings import CLEAR_NOON
from carlette.world.spawn import spawn
from carlette.world.world import World

CARS, SPOT = 20, 20
"""Number of cars, and index of the spawn point of the cameras."""
ROUNDS = 5
"""Number of rounds whose median counts."""


def run(smoke: bool) -> dict[str, float]:
    """Return `fps_*` for each camera and `ratio_*` to `fps_baseline`; `build_s` is the time to build the town."""
    frames = 1 if smoke else 40
    network = RoadNetwork(load_map(DEMO_TOWN))
    start = time.process_time()
    static_scene_of(network)
    figures = {"build_s": time.process_time() - start}
    world, renderer = _street(network), Renderer()
    baseline = figures["fps_baseline"] = _rate(_average, frames)
    small, large = (_front_view(network, *size) for size in ((800, 450), (1600, 900)))
    jobs: dict[str, Callable[[], Any]] = {
        "rgb_800x450": lambda: renderer.rgb(take(world), small),
        "depth_800x450": lambda: renderer.depth(take(world), small),
        "semantic_800x450": lambda: renderer.tags(take(world), small),
        "rgb_1600x900": lambda: renderer.rgb(take(world), large),
        "six_rgb_1600x900": lambda: _six(renderer, world, network),
        "take": lambda: take(world),
    }
    for name, job in jobs.items():
        _measure(figures, name, _ticking(world, job), frames, baseline)
    for name, index, value in (
        ("fog", FOG_DENSITY, 60.0),
        ("rain", PRECIPITATION, 80.0),
        ("night", SUN_ALTITUDE, -40.0),
    ):
        world.weather = tuple(value if i == index else item for i, item in enumerate(CLEAR_NOON))
        _measure(figures, f"rgb_{name}_800x450", _ticking(world, jobs["rgb_800x450"]), frames, baseline)
    return figures


def _measure(figures: dict[str, float], name: str, job: Callable[[], Any], frames: int, baseline: float) -> None:
    rate = _rate(job, frames)
    figures[f"fps_{name}"], figures[f"ratio_{name}"] = rate, rate / baseline


def _rate(job: Callable[[], Any], frames: int) -> float:
    """Return the median rate over several rounds, in runs per second of CPU time."""
    job()
    rates = []
    for _ in range(ROUNDS):
        start = time.process_time()
        for _ in range(frames):
            job()
        rates.append(frames / max(time.process_time() - start, 1e-9))
    return statistics.median(rates)


def _ticking(world: World, job: Callable[[], Any]) -> Callable[[], Any]:
    def both() -> Any:
        world.tick()
        return job()

    return both


def _street(network: RoadNetwork) -> World:
    """Return a world with cars around the spot, one of them driving."""
    world = World(network)
    definition = load_catalog().definitions["vehicle.lincoln.mkz_2020"]
    attributes = {attribute.id: (attribute.type, attribute.value) for attribute in definition.attributes}
    middle = network.spawn_points()[SPOT].location
    spots = sorted(
        network.spawn_points(),
        key=lambda point: (point.location.x - middle.x) ** 2 + (point.location.y - middle.y) ** 2,
    )
    for pose in spots[1 : CARS + 1]:
        spawn(world, definition.id, attributes, pose)
    world.fleet.control[0, THROTTLE] = 0.3
    return world


def _front_view(network: RoadNetwork, width: int, height: int, turn_deg: float = 0.0) -> CameraView:
    spot = network.spawn_points()[SPOT]
    eye = Vector(spot.location.x, spot.location.y, spot.location.z + 1.5)
    return CameraView(Pose(eye, Rotation(-3.0, spot.rotation.yaw + turn_deg, 0.0)), width, height, 90.0)


def _six(renderer: Renderer, world: World, network: RoadNetwork) -> None:
    shot = take(world)
    for number in range(6):
        renderer.rgb(shot, _front_view(network, 1600, 900, 60.0 * number))


def _average() -> Any:
    return _PICTURE.reshape(450, 2, 800, 2, 4).mean(axis=(1, 3), dtype=np.float32)


_PICTURE = np.zeros((900, 1600, 4), np.uint8)
"""Picture of the baseline."""
