"""The radar: random rays in a cone, each with range, direction and closing speed of the point that it hit."""

from __future__ import annotations

import math
from concurrent.futures import Future

import numpy as np

from carlette.geometry import Floats
from carlette.sensors.lidar import MOST_POINTS_PER_S, MOST_RANGE_M, MOST_RAYS, require_kernels
from carlette.sensors.rotations import axes
from carlette.sensors.sensor import Body, LateSensor, SensorAttributes, SensorTick
from carlette.sensors.workers import build_faces, caster
from carlette.world.world import World


class RadarSensor(LateSensor):
    """Detections: velocity (m/s, negative = approaching), azimuth and altitude (rad), depth (m).

    The rays fill an elliptical cone, denser toward its center, and end on the plane `range` ahead, as in CARLA.
    """

    wire_type = 9

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        require_kernels(settings.type_id)
        self._reach_m = settings.number("range", 0.0, MOST_RANGE_M)
        self._points_per_s = settings.whole("points_per_second", 0, MOST_POINTS_PER_S)
        self._spread = [
            math.tan(math.radians(settings.number(item, 0.0, 179.0)) / 2) for item in ("horizontal_fov", "vertical_fov")
        ]
        self._random: np.random.Generator | None = None
        self._before: tuple[float, Floats] | None = None
        """Time and position of the last measurement; None before the first."""

    def load(self, world: World) -> Future[None]:
        return build_faces(world.roads)

    def begin(self, moment: SensorTick) -> Future[list[Body]]:
        moment.scene.hold()
        own, ways = self._velocity(moment), self._rays(moment)
        self.pass_over(moment)
        return caster().submit(lambda: self._detections(moment, own, ways))

    def _detections(self, moment: SensorTick, own: Floats, ways: Floats) -> list[Body]:
        length = np.linalg.norm(ways, axis=1)
        azimuths = np.arctan2(ways[:, 1], ways[:, 0])
        altitudes = np.arctan2(ways[:, 2], np.hypot(ways[:, 0], ways[:, 1]))
        farthest = self._reach_m * float(length.max(initial=0.0))
        sweep = moment.scene.sweep(moment.pose, azimuths, np.tan(altitudes)[:, None], farthest)
        depths, faces = 1.0 / sweep.nearness[:, 0], sweep.hit[:, 0]
        met = (faces >= 0) & (depths <= self._reach_m * length)
        units = (ways[met] / length[met, None]) @ axes(moment.pose.rotation).T
        speeds = ((moment.scene.velocities(faces[met]) - own) * units).sum(axis=1)
        rows = np.stack([speeds, azimuths[met], altitudes[met], depths[met]], axis=1)
        return [(rows.astype(np.float32).tobytes(),)]

    def pass_over(self, moment: SensorTick) -> None:
        self._before = (moment.scene.world.elapsed_s, np.array(moment.pose.location))

    def _rays(self, moment: SensorTick) -> Floats:
        """Return directions in the radar's frame with x = 1, (n, 3), in ascending azimuth."""
        if self._random is None:
            self._random = np.random.default_rng(moment.actor.id)
        count = min(int(self._points_per_s * moment.delta_s), MOST_RAYS)
        radius, angle = self._random.random(count), self._random.random(count) * math.tau
        across = self._spread[0] * radius * np.cos(angle)
        ways = np.stack([np.ones(count), across, self._spread[1] * radius * np.sin(angle)], axis=1)
        ascending: Floats = ways[np.argsort(across)]
        return ascending

    def _velocity(self, moment: SensorTick) -> Floats:
        """Return the radar's velocity from its own path (m/s, world frame). Its position on the vehicle matters."""
        if self._before is None or moment.scene.world.elapsed_s <= self._before[0]:
            carried: Floats = moment.scene.world.bodies.velocity[moment.actor.row]
            return carried
        moved: Floats = np.array(moment.pose.location) - self._before[1]
        return moved / (moment.scene.world.elapsed_s - self._before[0])
