"""The sky: a gradient from the horizon up, clouds, sun, moon and stars."""

from __future__ import annotations

import math
from functools import lru_cache
from random import Random

import numpy as np
from numpy.typing import NDArray

from carlette.camera.arrays import Bytes, Singles
from carlette.camera.models.mesh import Builder, Color, Mesh, Point, mix, shade
from carlette.camera.rendering import tags
from carlette.camera.rendering.lighting import Light
from carlette.camera.rendering.view import CameraView

STREAKS = 420
"""Number of streaks in the heaviest rain. Ours."""


def rain_streaks(rain: float, frame: int) -> tuple[Singles, Bytes]:
    """Return thin quads in the camera's frame. Their positions change with the frame, always in the same way."""
    random = np.random.default_rng(frame)
    count = int(STREAKS * rain)
    ahead = random.uniform(2.0, 12.0, count)
    across = random.uniform(-1.3, 1.3, count) * ahead
    up = random.uniform(-0.9, 0.9, count) * ahead
    length, half = random.uniform(0.25, 0.6, count), np.full(count, 0.006) * ahead / 3
    lean = 0.08 * length
    corners = np.empty((count, 4, 3), np.float32)
    for number, (side, low) in enumerate(((-1, 0), (1, 0), (1, 1), (-1, 1))):
        corners[:, number, 0] = ahead
        corners[:, number, 1] = across + side * half + low * lean
        corners[:, number, 2] = up - low * length
    corners = np.concatenate([corners, corners[:, ::-1]])
    colors = np.empty((2 * count, 4, 4), np.uint8)
    colors[:] = (226, 220, 214, 84)
    return np.ascontiguousarray(corners), colors


DISTANCE_M = 880.0
"""Distance of clouds and celestial bodies (m), within the far plane. Ours."""
STEPS = 256
"""Number of colors of the gradient. Ours."""
_LOWEST = -0.25
"""Lowest sine of the elevation in the gradient. Ours."""
OVERCAST = 0.8
"""Share of clouds above which they are one gray ceiling. Ours."""


def fill_sky(buffer: NDArray[np.uint32], view: CameraView, light: Light) -> None:
    """Paint the background of a picture whose pixels are B G R A."""
    table = _gradient(light)
    axes = view.axes()
    across, up = view.tangents
    height, width = buffer.shape
    rows = (1.0 - (np.arange(height, dtype=np.float32) + 0.5) / height * 2.0) * np.float32(up)
    if abs(axes[1, 2]) < 0.01:
        rise = (axes[0, 2] + rows * axes[2, 2]) / np.sqrt(1.0 + rows**2)
        buffer[:] = table[_steps(rise)][:, None]
        return
    columns = ((np.arange(width, dtype=np.float32) + 0.5) / width * 2.0 - 1.0) * np.float32(across)
    rise = axes[0, 2] + rows[:, None] * np.float32(axes[2, 2]) + columns * np.float32(axes[1, 2])
    buffer[:] = table[_steps(rise)]


def _steps(rise: Singles) -> NDArray[np.int64]:
    steps: NDArray[np.int64] = np.clip((rise - _LOWEST) / (1.0 - _LOWEST) * STEPS, 0, STEPS - 1).astype(np.int64)
    return steps


@lru_cache(maxsize=32)
def _gradient(light: Light) -> NDArray[np.uint32]:
    """Return colors by the sine of the elevation, as little-endian B G R A."""
    table = np.empty(STEPS, np.uint32)
    for step in range(STEPS):
        rise = _LOWEST + (step + 0.5) / STEPS * (1.0 - _LOWEST)
        if rise < 0:
            far = mix(light.horizon, _meadow(light), min(1.0, -rise * 6.0) * (0.3 if light.fog_per_m > 0.004 else 0.9))
            red, green, blue = far
        else:
            red, green, blue = mix(light.horizon, light.zenith, min(1.0, rise * 1.7) ** 0.6)
        table[step] = blue | green << 8 | red << 16 | 0xFF000000
    return table


def _meadow(light: Light) -> Color:
    strength = sum(light.ambient) / 3 + 0.6 * sum(light.direct) / 3
    return shade((112, 138, 74), min(1.0, strength))


@lru_cache(maxsize=16)
def dome(light: Light) -> Mesh:
    """Return clouds, sun, moon and stars around the origin. They are drawn behind everything else."""
    builder = Builder(tags.SKY)
    random = Random(5)
    night = sum(light.ambient) < 1.0
    hidden = light.fog_per_m > 0.01 or light.clouds > OVERCAST
    if night and not hidden:
        for _ in range(90):
            _disc(
                builder,
                _way(random.uniform(-180, 180), random.uniform(6, 70)),
                random.uniform(0.7, 1.5),
                (225, 228, 240),
                4,
                far=1.1,
            )
    if not hidden:
        for share, color in _sun_rings(light, night):
            _disc(builder, light.sun, 22.0 * share, color, 16, far=1.08 + 0.01 * share)
    if light.fog_per_m < 0.01 and light.clouds <= OVERCAST:
        white = mix((252, 252, 252), light.horizon, 0.25)
        white = shade(white, 0.25) if night else mix(white, (150, 154, 162), 0.8 * light.clouds**2)
        for _ in range(int(5 + 34 * light.clouds)):
            _cloud(builder, random, white, mix(white, light.zenith, 0.45))
    elif light.clouds > OVERCAST and light.fog_per_m < 0.01:
        for _ in range(26):
            _cloud(builder, random, shade(mix(light.zenith, light.horizon, 0.5), 0.96), shade(light.zenith, 0.93))
    return builder.mesh()


def _sun_rings(light: Light, night: bool) -> list[tuple[float, Color]]:
    if night:
        return [(1.0, (228, 230, 238))]
    warm = mix((255, 252, 232), (255, 190, 110), min(1.0, max(0.0, 1.2 - 2.5 * light.sun[2])))
    return [(2.2, mix(light.horizon, warm, 0.55)), (1.0, warm)]


def _way(azimuth_deg: float, elevation_deg: float) -> Point:
    around, up = math.radians(azimuth_deg), math.radians(elevation_deg)
    return (math.cos(up) * math.cos(around), math.cos(up) * math.sin(around), math.sin(up))


def _cloud(builder: Builder, random: Random, white: Color, below: Color) -> None:
    azimuth, elevation = random.uniform(-180, 180), 7 + 32 * random.random() ** 1.3
    size = random.uniform(42, 95)
    puffs = [(random.uniform(-1.7, 1.7), random.uniform(0.0, 0.35), random.uniform(0.5, 1.0)) for _ in range(5)]
    for drop, color in ((-0.14, below), (0.0, white)):
        for aside, rise, scale in puffs:
            way = _way(
                azimuth + math.degrees(aside * size / DISTANCE_M),
                elevation + math.degrees((rise + drop) * size / DISTANCE_M),
            )
            _disc(builder, way, size * scale, color, 12, flat=0.42, far=1.0 if color == white else 1.04)


def _disc(
    builder: Builder, way: Point, radius: float, color: Color, sides: int, *, flat: float = 1.0, far: float = 1.0
) -> None:
    """Build a flat disc far away that faces the origin."""
    aside = np.cross((0.0, 0.0, 1.0), way)
    aside /= max(float(np.linalg.norm(aside)), 1e-6)
    up = np.cross(way, aside)
    middle = np.array(way) * DISTANCE_M * far
    turns = [2 * math.pi * side / sides for side in range(sides)]
    ring = [middle + radius * (math.cos(a) * aside + flat * math.sin(a) * up) for a in turns]
    points = [(float(p[0]), float(p[1]), float(p[2])) for p in ring]
    builder.face(points, color, (-way[0], -way[1], -way[2]), glow=True)
