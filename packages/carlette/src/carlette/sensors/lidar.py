"""The ray-cast LiDARs, plain and semantic: lasers stacked on a rotating head.

As in CARLA, one message holds the sweep of the head in one tick, all of it from the pose of the sensor at the end of
the tick. At 20 ticks per second and 10 turns per second, that is half a turn.
"""

from __future__ import annotations

import logging
import math
import struct
from abc import abstractmethod
from concurrent.futures import Future
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from carlette.errors import RequestError
from carlette.geometry import Floats
from carlette.sensors.gnss import seeded
from carlette.sensors.ray_surfaces import Indices, Singles
from carlette.sensors.sensor import Body, LateSensor, SensorAttributes, SensorTick
from carlette.sensors.sensor_scene import RaySweep, SensorScene
from carlette.sensors.workers import build_faces, caster
from carlette.world.world import World

MOST_CHANNELS = 1024
"""Maximum number of channels. Ours."""
MOST_POINTS_PER_S = 20_000_000
"""Maximum number of points per second. Ours."""
MOST_RAYS = 4_000_000
"""Maximum number of rays in one message. Ours; further rays are not cast."""
MOST_RANGE_M = 2000.0
"""Longest range (m). Ours."""
STEEPEST_DEG = 89.99
"""Steepest elevation of a laser (degrees): the tangent of 90° is infinite."""
_NOTHING: Singles = np.zeros((0, 0), np.float32)

log = logging.getLogger(__name__)


class Losses(NamedTuple):
    """Losses and errors of the rays of a sweep, (columns, channels) each."""

    intensity: Singles
    """Intensity of the returned ray."""
    is_kept: NDArray[np.bool_]
    off_m: Singles
    """Range error (m, positive if too long); empty if exact."""


class Points(NamedTuple):
    """Points that the lasers hit, channel after channel."""

    rows: Singles
    """(n, 4): x, y, z in the sensor's frame, intensity."""
    sources: Indices
    """(n,): flat index of each point's ray in the sweep."""
    counts: NDArray[np.uint32]
    """Number of points of each channel."""


class HeadRotation(NamedTuple):
    """Sweep of the head in one tick."""

    azimuths: Floats
    """Azimuths (rad), in the order of time."""
    angle_rad: float
    """Angle of the head after the sweep (rad)."""


class Fan(LateSensor):
    """The rotating head of both kinds of LiDAR."""

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        require_kernels(settings.type_id)
        self.reach_m = settings.number("range", 0.0, MOST_RANGE_M)
        self._channels = settings.whole("channels", 1, MOST_CHANNELS)
        self._points_per_s = settings.whole("points_per_second", 0, MOST_POINTS_PER_S)
        self._turns_per_s = settings.number("rotation_frequency", 0.0, 1e4)
        self._width_deg = settings.number("horizontal_fov", 0.1, 360.0)
        upper, lower = (settings.number(item, -90.0, 90.0) for item in ("upper_fov", "lower_fov"))
        lasers = np.clip(np.linspace(upper, lower, self._channels), -STEEPEST_DEG, STEEPEST_DEG)
        self._tangents = np.tan(np.radians(lasers))
        self._turned_deg = 0.0
        """Angle of the head, 0 up to the width (degrees)."""
        self._has_warned = False

    def load(self, world: World) -> Future[None]:
        return build_faces(world.roads)

    def pass_over(self, moment: SensorTick) -> None:
        self._turned_deg = math.fmod(self._turned_deg + self._step_deg(moment), self._width_deg)

    def begin(self, moment: SensorTick) -> Future[list[Body]]:
        moment.scene.hold()
        turn = self._turn(moment)
        return caster().submit(lambda: self._scan(moment, turn))

    def _turn(self, moment: SensorTick) -> HeadRotation:
        steps = self._steps(moment)
        spread = self._turned_deg + self._step_deg(moment) / max(steps, 1) * np.arange(steps)
        azimuths = np.radians(np.fmod(spread, self._width_deg) - self._width_deg / 2.0)
        self.pass_over(moment)
        return HeadRotation(azimuths, math.radians(self._turned_deg))

    def _scan(self, moment: SensorTick, turn: HeadRotation) -> list[Body]:
        columns, rows = np.argsort(turn.azimuths, kind="stable"), np.argsort(self._tangents, kind="stable")
        azimuths = turn.azimuths[columns]
        sweep = moment.scene.sweep(moment.pose, azimuths, self._tangents[rows][None, :], self.reach_m)
        points = self._points(sweep, azimuths, _inverse(columns), rows, self.losses(sweep))
        header = struct.pack("<fI", turn.angle_rad, self._channels) + points.counts.tobytes()
        return [(header, _as_bytes(self.rows(moment.scene, sweep, points)))]

    @abstractmethod
    def rows(self, scene: SensorScene, sweep: RaySweep, points: Points) -> Singles:
        """Return the points in the form of the message, one per row."""

    def losses(self, sweep: RaySweep) -> Losses:
        """Return losses and errors of the rays, each (columns, rows). Here all rays return exactly."""
        return Losses(sweep.nearness, sweep.hit >= 0, _NOTHING)

    def _points(self, sweep: RaySweep, azimuths: Floats, column_of: Indices, rows: Indices, losses: Losses) -> Points:
        """Return the points; `column_of` is the column of each step, `rows` the channel of each row of tangents."""
        from carlette.sensors.kernels import place_points

        intensity, is_kept, off_m = losses
        counts = np.zeros(self._channels, np.int64)
        counts[rows] = np.count_nonzero(is_kept, axis=0)
        starts = (np.cumsum(counts) - counts)[rows]
        found, sources = np.empty((counts.sum(), 4), np.float32), np.empty(counts.sum(), np.int64)
        lasers = np.arctan(self._tangents[rows])
        ways, levels = (np.stack([np.cos(item), np.sin(item)], axis=1) for item in (azimuths, lasers))
        place_points(sweep.nearness, is_kept, column_of, starts, ways, levels, off_m, intensity, found, sources)
        return Points(found, sources, counts.astype(np.uint32))

    def _step_deg(self, moment: SensorTick) -> float:
        return self._turns_per_s * self._width_deg * moment.delta_s

    def _steps(self, moment: SensorTick) -> int:
        wanted = math.floor(self._points_per_s * moment.delta_s / self._channels + 0.5)
        most = max(1, MOST_RAYS // self._channels)
        if wanted > most and not self._has_warned:
            self._has_warned = True
            asked, granted = wanted * self._channels, most * self._channels
            log.warning("LiDAR %d asks for %d rays in a tick; it gets %d", moment.actor.id, asked, granted)
        return min(wanted, most)


class LidarSensor(Fan):
    """Points whose intensity falls with the distance; with dropout and range noise if the client sets them."""

    wire_type = 11

    def __init__(self, settings: SensorAttributes) -> None:
        super().__init__(settings)
        self._general = settings.number("dropoff_general_rate", 0.0, 1.0)
        self._limit = settings.number("dropoff_intensity_limit")
        self._at_zero = settings.number("dropoff_zero_intensity", 0.0, 1.0)
        self._attenuation = settings.number("atmosphere_attenuation_rate", 0.0)
        self._noise_stddev = settings.number("noise_stddev", 0.0)
        self._random = seeded(settings)

    def rows(self, scene: SensorScene, sweep: RaySweep, points: Points) -> Singles:
        return points.rows

    def losses(self, sweep: RaySweep) -> Losses:
        """Return the rays' intensity, whether they return, and their range error (m), each (columns, rows).

        The intensity falls off as exp(-attenuation * distance). Rays are lost at random at the general rate, and more
        often at low intensity, as CARLA's documentation of `sensor.lidar.ray_cast` describes.
        """
        random, shape = self._random, sweep.hit.shape
        intensity = np.exp(np.float32(-self._attenuation) / sweep.nearness)
        is_kept, off_m = sweep.hit >= 0, _NOTHING
        if self._general > 0.0:
            is_kept &= random.random(shape, np.float32) >= self._general
        if self._at_zero > 0.0 and self._limit > 0.0:
            chance = intensity * np.float32(self._at_zero / self._limit) + np.float32(1.0 - self._at_zero)
            is_kept &= (intensity > self._limit) | (random.random(shape, np.float32) < chance)
        if self._noise_stddev > 0.0:
            off_m = random.standard_normal(shape, np.float32) * np.float32(self._noise_stddev)
        return Losses(intensity, is_kept, off_m)


class SemanticLidarSensor(Fan):
    """Points with the cosine of the angle of incidence, the actor's id and the semantic tag."""

    wire_type = 10

    def rows(self, scene: SensorScene, sweep: RaySweep, points: Points) -> Singles:
        from carlette.sensors.kernels import label_points

        labelled = np.empty((len(points.rows), 6), np.float32)
        label_points(
            points.rows, points.sources, *sweep, scene.face_actors, scene.face_tags, labelled, labelled.view(np.uint32)
        )
        return labelled


def _as_bytes(rows: Singles) -> memoryview:
    return rows.reshape(-1).view(np.uint8).data


def _inverse(order: Indices) -> Indices:
    """Return the inverse of the permutation `order`."""
    places = np.empty(len(order), np.int64)
    places[order] = np.arange(len(order))
    return places


def require_kernels(type_id: str) -> None:
    """Raise `RequestError` if numba, which compiles the rays' loops, is not installed."""
    if find_spec("numba") is None:
        raise RequestError(f"Spawn of '{type_id}' refused: it needs the package 'numba'; pip install numba")
