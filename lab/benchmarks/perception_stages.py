"""Time of each perception stage (ms) among parked cars in carlette's grid town, and of a whole cycle.

Perception runs at 10 Hz, the stages of its front camera at 5 Hz and that of the rear one at 2.5 Hz. `cycle_ms` is the
time of one cycle, with these stages counted at a half and a quarter. `of_its_time` is `cycle_ms` divided by the
available 100 ms: below 1, perception is fast enough on one core.
"""

from __future__ import annotations

import resource
import statistics

import carla

from stucksolver_carla.client_connection import connect
from stucksolver_eval.simulator_server import carlette_server, set_synchronous
from stucksolver_perception.carla import EgoPerception

STEP_S = 0.05
"""Step of the simulation (s)."""
PERIOD_MS = 100.0
"""Period of perception (ms)."""
CARS = 25
"""Number of parked cars."""
SHARES = {"attributes": 0.5, "lights": 0.5, "far": 0.5, "far_view": 0.5, "rear": 0.25}
"""Shares of the cycles that contain these stages."""


def run(smoke: bool) -> dict[str, float]:
    """Return medians of each stage and of the whole cycle, and the memory of this process (MB)."""
    with carlette_server("grid_town", scenery=True) as server:
        world = connect(server, 30.0).get_world()
        set_synchronous(world, STEP_S)
        ego = _street(world)
        times: dict[str, list[float]] = {}
        eyes = EgoPerception(ego, world.get_map())
        try:
            ego.apply_control(carla.VehicleControl(throttle=0.4))
            for _ in range(20 if smoke else 200):
                world.tick()
                before = eyes.percept
                eyes.tick()
                if eyes.percept is not None and eyes.percept is not before:
                    for stage, took in eyes.percept.stages_ms.items():
                        times.setdefault(stage, []).append(took)
        finally:
            eyes.close()
    figures = {f"{stage}_ms": statistics.median(took) for stage, took in times.items()}
    cycle = sum(value * SHARES.get(name.removesuffix("_ms"), 1.0) for name, value in figures.items())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    return {**figures, "cycle_ms": cycle, "of_its_time": cycle / PERIOD_MS, "process_mb": memory}


def _street(world: carla.World) -> carla.Vehicle:
    """Spawn the ego and parked cars around it; return the ego."""
    library, spots = world.get_blueprint_library(), world.get_map().get_spawn_points()
    ego: carla.Vehicle = world.spawn_actor(library.find("vehicle.lincoln.mkz_2020"), spots[0])
    here = spots[0].location
    near = sorted(spots[1:], key=lambda spot: spot.location.distance(here))[:CARS]
    for spot in near:
        world.try_spawn_actor(library.find("vehicle.tesla.model3"), spot)
    world.tick()
    return ego
