"""Walkers and bicycles that cross the hero's path."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from stucksolver_eval.actors import ScenarioActor
from stucksolver_eval.scenarios.scenario import Scenario

ADULTS = tuple(f"walker.pedestrian.{number:04d}" for number in (1, 2, 3, 4, 5, 6, 7, 8))
WALKER_LIFT_M = 0.9
"""Height of a walker's origin above the ground at the spawn (m)."""
BICYCLES = ("vehicle.bh.crossbike", "vehicle.diamondback.century", "vehicle.gazelle.omafiets")


def walk_for(
    scenario: Scenario, walker: ScenarioActor, yaw_deg: float, speed_mps: float, distance_m: float
) -> Iterator[None]:
    """Script: a walker walks `distance_m` with heading `yaw_deg` in CARLA's world frame, then stands."""
    x, y = math.cos(math.radians(yaw_deg)), math.sin(math.radians(yaw_deg))
    start = scenario.cast.state(walker)
    end_s = scenario.cast.time_s + 3.0 * distance_m / speed_mps
    scenario.cast.walk(walker, x, y, speed_mps)
    while True:
        yield
        now = scenario.cast.state(walker)
        if (now.x - start.x) * x + (now.y - start.y) * y >= distance_m or scenario.cast.time_s > end_s:
            break
    scenario.cast.walk(walker, x, y, 0.0)


def together(*scripts: Iterator[None]) -> Iterator[None]:
    """Script: run scripts in parallel until all have ended."""
    running = list(scripts)
    while running:
        running = [script for script in running if next(script, _OVER) is not _OVER]
        if running:
            yield


_OVER: Any = object()
