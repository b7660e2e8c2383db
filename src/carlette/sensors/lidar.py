"""The ray-cast LiDARs, plain and semantic: lasers one above the other on a head that turns.

As in CARLA, one message holds what the head sweeps over in one tick, all of it seen from where the sensor is at the
end of the tick. At 20 ticks per second and 10 turns per second that is half a turn.
"""

from __future__ import annotations

import logging
import math
import struct
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from carlette.errors import RequestError
from carlette.geometry import Floats
from carlette.sensors.base import Body, Moment, Sensor, Settings
from carlette.sensors.frames import axes
from carlette.sensors.scene import Sweep

MOST_CHANNELS = 1024
MOST_POINTS_PER_S = 20_000_000
MOST_RAYS = 4_000_000
"""In one message; what a client asks for beyond that is not cast."""
MOST_RANGE_M = 2000.0
STEEPEST_DEG = 89.99
_NO_CHANCES, _NO_NOISE = np.zeros((0, 0, 0), np.float32), np.zeros((0, 0), np.float32)

log = logging.getLogger(__name__)


class Points(NamedTuple):
    """What the lasers met, channel after channel."""

    rows: NDArray[np.float32]
    """(n, 4): x, y, z in the sensor's frame, intensity."""
    faces: NDArray[np.int32]
    """(n,): which face of the scene."""
    counts: NDArray[np.uint32]
    """Points of each channel."""


class Fan(Sensor):
    """The head: what both kinds have in common."""

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        require_kernels(settings.type_id)
        self.reach_m = settings.number("range", 0.0, MOST_RANGE_M)
        self._channels = settings.whole("channels", 1, MOST_CHANNELS)
        self._points_per_s = settings.whole("points_per_second", 0, MOST_POINTS_PER_S)
        self._turns_per_s = settings.number("rotation_frequency", 0.0, 1e4)
        self._width_deg = settings.number("horizontal_fov", 0.1, 360.0)
        upper, lower = (settings.number(one, -90.0, 90.0) for one in ("upper_fov", "lower_fov"))
        lasers = np.clip(np.linspace(upper, lower, self._channels), -STEEPEST_DEG, STEEPEST_DEG)
        tangents = np.tan(np.radians(lasers))
        self._ascending = np.sort(tangents)
        self._order = np.argsort(np.argsort(tangents, kind="stable"), kind="stable")
        self._turned_deg = 0.0
        """How far the head has turned, 0 up to the width."""
        self._warned = False

    def pass_over(self, moment: Moment) -> None:
        self._turned_deg = math.fmod(self._turned_deg + self._step_deg(moment), self._width_deg)

    def look(self, moment: Moment) -> Points:
        """Sweeps over one tick's part of a turn."""
        steps = self._steps(moment)
        spread = self._turned_deg + self._step_deg(moment) / max(steps, 1) * np.arange(steps)
        angles = np.radians(np.fmod(spread, self._width_deg) - self._width_deg / 2.0)
        self.pass_over(moment)
        ascending = np.argsort(angles, kind="stable")
        azimuths = angles[ascending]
        place = np.empty(steps, np.int64)
        place[ascending] = np.arange(steps)
        sweep = moment.scene.sweep(moment.pose, azimuths, self._ascending[None, :], self.reach_m)
        return self._packed(moment, sweep, place, azimuths)

    def header(self, counts: NDArray[np.uint32]) -> bytes:
        """The head's angle (rad), the number of channels, and the points of each."""
        return struct.pack("<fI", math.radians(self._turned_deg), self._channels) + counts.tobytes()

    def _packed(self, moment: Moment, sweep: Sweep, place: NDArray[np.int64], azimuths: Floats) -> Points:
        from carlette.sensors.kernels import pack_points

        lost = self.losses(moment, (self._channels, len(place)))
        rows = np.empty((sweep.hit.size, 4), np.float32)
        faces = np.empty(sweep.hit.size, np.int32)
        counts = pack_points(
            sweep.distance,
            sweep.hit,
            place,
            self._order,
            azimuths,
            self._ascending,
            *lost,
            rows,
            faces,
        )
        total = int(counts.sum())
        return Points(rows[:total], faces[:total], counts)

    def losses(self, moment: Moment, shape: tuple[int, int]) -> tuple[Floats, NDArray[np.float32], NDArray[np.float32]]:
        """What `kernels.pack_points` wants to know: nothing is lost here."""
        del moment, shape
        return np.zeros(5), _NO_CHANCES, _NO_NOISE

    def _step_deg(self, moment: Moment) -> float:
        return self._turns_per_s * self._width_deg * moment.delta_s

    def _steps(self, moment: Moment) -> int:
        wanted = math.floor(self._points_per_s * moment.delta_s / self._channels + 0.5)
        most = max(1, MOST_RAYS // self._channels)
        if wanted > most and not self._warned:
            self._warned = True
            log.warning(
                "LiDAR %d asks for %d rays in a tick; it gets %d",
                moment.actor.id,
                wanted * self._channels,
                most * self._channels,
            )
        return min(wanted, most)


class LidarSensor(Fan):
    """Points with an intensity that falls with the distance; some are lost, all are a little off, if asked for."""

    wire_type = 11

    def __init__(self, settings: Settings) -> None:
        super().__init__(settings)
        general = settings.number("dropoff_general_rate", 0.0, 1.0)
        limit = settings.number("dropoff_intensity_limit")
        at_zero = settings.number("dropoff_zero_intensity", 0.0, 1.0)
        attenuation = settings.number("atmosphere_attenuation_rate", 0.0)
        slope = at_zero / limit if limit > 0.0 else 0.0
        self._losses = np.array([general, attenuation, limit, slope, 1.0 - at_zero])
        self._loses = general > 0.0 or (at_zero > 0.0 and limit > 0.0)
        self._noise_stddev = settings.number("noise_stddev", 0.0)
        self._random: np.random.Generator | None = None

    def measure(self, moment: Moment) -> Iterator[Body]:
        points = self.look(moment)
        yield self.header(points.counts), points.rows.tobytes()

    def losses(self, moment: Moment, shape: tuple[int, int]) -> tuple[Floats, NDArray[np.float32], NDArray[np.float32]]:
        if self._random is None:
            self._random = np.random.default_rng(moment.actor.id)
        chances = self._random.random((2, *shape), np.float32) if self._loses else _NO_CHANCES
        noise = _NO_NOISE
        if self._noise_stddev > 0.0:
            noise = self._random.standard_normal(shape, np.float32) * np.float32(self._noise_stddev)
        return self._losses, chances, noise


class SemanticLidarSensor(Fan):
    """Points with what they lie on: the cosine of the angle of incidence, the actor's id and the semantic tag."""

    wire_type = 10

    def measure(self, moment: Moment) -> Iterator[Body]:
        points = self.look(moment)
        scene = moment.scene
        count = len(points.rows)
        rows = np.empty((count, 6), np.float32)
        rows[:, :3] = points.rows[:, :3]
        normals = scene.face_normals[points.faces] @ axes(moment.pose.rotation)
        length = np.maximum(np.linalg.norm(rows[:, :3], axis=1), 1e-6)
        rows[:, 3] = -(normals * rows[:, :3]).sum(axis=1) / length
        labels = rows.view(np.uint32)
        labels[:, 4] = scene.face_actors[points.faces]
        labels[:, 5] = scene.face_tags[points.faces]
        yield self.header(points.counts), rows.tobytes()


def require_kernels(type_id: str) -> None:
    """Loads the compiled loops while the client waits for its sensor, not in the middle of a tick."""
    try:
        from carlette.sensors.warmth import warm_up
    except ImportError as error:
        raise RequestError(
            f"Spawn of '{type_id}' refused: it needs the package 'numba' ({error}); install 'stucksolver[sim]'"
        ) from None
    warm_up()
