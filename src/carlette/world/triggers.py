"""Which traffic light each vehicle stands at."""

from __future__ import annotations

import numpy as np

from carlette.physics.bodies import Bodies
from carlette.physics.fleet import Fleet
from carlette.world.lights import Color, Lights

PROBES = np.array([1.0, 0.5, 0.0, -0.5, -1.0])
"""Points along a vehicle, in half lengths, that may lie in a trigger box."""


def watch_lights(bodies: Bodies, fleet: Fleet, lights: Lights) -> None:
    """Writes the light whose trigger box each vehicle is in into the vehicle's record."""
    if not len(fleet) or not len(lights):
        return
    rows = fleet.row
    yaw = np.radians(bodies.rotation[rows, 1])
    ahead = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
    gap = bodies.position[rows, None, :] - lights.center[None, :, :]
    near = np.abs(gap).max(axis=2) < 20.0
    car, light = np.nonzero(near)
    probe = gap[car, light, :2][:, None, :] + (
        PROBES[None, :, None] * (bodies.extent[rows[car], 0, None] * ahead[car])[:, None, :]
    )
    axis = lights.ahead[light][:, None, :]
    along = np.abs((probe * axis).sum(axis=2))
    across = np.abs(probe[:, :, 1] * axis[:, :, 0] - probe[:, :, 0] * axis[:, :, 1])
    extent = lights.extent[light]
    inside = ((along <= extent[:, :1]) & (across <= extent[:, 1:2])).any(axis=1)
    inside &= np.abs(gap[car, light, 2]) <= extent[:, 2] + 1.0
    car, light = car[inside], light[inside]
    record = bodies.record
    record["has_light"][rows] = 0
    record["light_state"][rows] = Color.GREEN
    record["light_id"][rows] = 0
    at = rows[car]
    record["has_light"][at] = 1
    record["light_state"][at] = lights.color[light]
    record["light_id"][at] = record["id"][lights.row[light]]
