"""Moments and straight routes for tests of criteria, without a world."""

from __future__ import annotations

import carla
import numpy as np

from stucksolver_eval.criteria import Criterion, EgoTick
from stucksolver_eval.criteria.route_position import RouteWalk

DT_S = 0.05


class StraightLine:
    """What `RouteWalk` reads of a line: points a meter apart along x."""

    def __init__(self, length_m: int) -> None:
        self.s_m = np.arange(length_m + 1, dtype=np.float64)
        self.xyz = np.stack([self.s_m, 0 * self.s_m, 0 * self.s_m], axis=1)
        self.forward = np.tile([1.0, 0.0, 0.0], (length_m + 1, 1))


def straight(length_m: int) -> RouteWalk:
    return RouteWalk(StraightLine(length_m))  # type: ignore[arg-type]


def moment(
    time_s: float,
    x: float,
    y: float = 0.0,
    speed_mps: float = 5.0,
    suspended: frozenset[str] = frozenset(),
    background_mps: tuple[float, ...] = (),
) -> EgoTick:
    return EgoTick(
        frame=round(time_s / DT_S),
        time_s=time_s,
        transform=carla.Transform(carla.Location(x, y, 0.0)),
        velocity=carla.Vector3D(speed_mps, 0.0, 0.0),
        suspended=suspended,
        background_mps=background_mps,
    )


def drive(criterion: Criterion, from_m: float, to_m: float, speed_mps: float = 10.0, y: float = 0.0) -> float:
    """Along x at a speed, tick by tick; the time at the end."""
    steps = round((to_m - from_m) / (speed_mps * DT_S))
    for k in range(steps + 1):
        criterion.update(moment(k * DT_S, from_m + k * speed_mps * DT_S, y, speed_mps))
    return steps * DT_S
