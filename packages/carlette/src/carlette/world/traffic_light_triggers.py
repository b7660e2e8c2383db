"""Finds the traffic light of each vehicle in a trigger box."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from carlette.geometry import Floats
from carlette.physics.bodies import BodyTable
from carlette.physics.vehicle_dynamics import Vehicles
from carlette.world.traffic_lights import Color, Lights

PROBES = np.array([1.0, 0.5, 0.0, -0.5, -1.0])
"""Points along a vehicle, in half lengths, that may lie in a trigger box. Ours."""
NEAR_M = 20.0
"""Distance in x or y beyond which boxes are not examined (m). Ours."""


def watch_lights(bodies: BodyTable, fleet: Vehicles, lights: Lights) -> None:
    """Write the light whose trigger box contains a vehicle into the vehicle's record."""
    if not len(fleet) or not len(lights):
        return
    rows = fleet.row
    record = bodies.record
    record["has_light"][rows] = 0
    record["light_state"][rows] = Color.GREEN
    record["light_id"][rows] = 0
    position = bodies.position[rows]
    gap_x = position[:, :1] - lights.center[:, 0]
    gap_y = position[:, 1:2] - lights.center[:, 1]
    near = np.maximum(np.abs(gap_x), np.abs(gap_y)) < NEAR_M
    car, light = near.nonzero()
    if not len(car):
        return
    inside = _inside(bodies, rows[car], lights, light, (gap_x[near], gap_y[near]))
    light = light[inside]
    at = rows[car[inside]]
    record["has_light"][at] = 1
    record["light_state"][at] = lights.color[light]
    record["light_id"][at] = record["id"][lights.row[light]]


def _inside(
    bodies: BodyTable, row: NDArray[np.int64], lights: Lights, light: NDArray[np.int64], gap: tuple[Floats, Floats]
) -> NDArray[np.bool_]:
    """Return which pairs of a vehicle's row and a light, `gap` apart in x and y, touch."""
    yaw = np.radians(bodies.rotation[row, 1])
    reach = bodies.extent[row, :1] * PROBES
    x = gap[0][:, None] + reach * np.cos(yaw)[:, None]
    y = gap[1][:, None] + reach * np.sin(yaw)[:, None]
    ahead, extent = lights.ahead[light], lights.extent[light]
    along = np.abs(x * ahead[:, :1] + y * ahead[:, 1:])
    across = np.abs(y * ahead[:, :1] - x * ahead[:, 1:])
    level = np.abs(bodies.position[row, 2] - lights.center[light, 2]) <= extent[:, 2] + 1.0
    inside: NDArray[np.bool_] = ((along <= extent[:, :1]) & (across <= extent[:, 1:2])).any(axis=1) & level
    return inside
