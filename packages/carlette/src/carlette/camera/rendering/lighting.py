"""The effect of weather on light: sun and sky, fog, night and wetness, as numbers for the renderer."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from carlette.camera.arrays import Bytes, Singles
from carlette.camera.models.mesh import Color, mix, shade

(
    CLOUDINESS,
    PRECIPITATION,
    DEPOSITS,
    WIND,
    SUN_AZIMUTH,
    SUN_ALTITUDE,
    FOG_DENSITY,
    FOG_DISTANCE,
    FOG_FALLOFF,
    WETNESS,
    _SCATTERING,
    _MIE,
    _RAYLEIGH,
    DUST,
) = range(14)

DARK_BELOW_DEG = 8.0
"""Altitude of the sun below which street lamps and windows are lit (degrees). Ours."""


@dataclass(frozen=True)
class Light:
    """The light at one time. Colors are 0 to 255. Hashable, so that lit meshes can be cached."""

    sun: tuple[float, float, float]
    """Direction to the sun (or the moon), world frame."""
    direct: tuple[float, float, float]
    """Strength of its light in red, green and blue."""
    ambient: tuple[float, float, float]
    """Strength of the ambient light."""
    zenith: Color
    horizon: Color
    fog: Color
    fog_per_m: float
    """0 = clear air; at a distance d the share of the fog's color is 1 - exp(-d * fog_per_m)."""
    wet: float
    """0 dry, 1 soaked."""
    puddles: float
    """Share of the possible puddles that contain water."""
    rain: float
    clouds: float
    is_dark: bool

    def lit(self, normals: Singles, colors: Bytes, glow: NDArray[np.bool_], tags: Bytes | None = None) -> Bytes:
        """Return colors of quads as they look in this light: (n, 4) uint8."""
        facing = np.maximum(normals @ np.array(self.sun, np.float32), 0.0)
        # The sky is brighter than the ground.
        sky = 0.86 + 0.14 * normals[:, 2]
        strength = sky[:, None] * np.array(self.ambient, np.float32) + facing[:, None] * np.array(
            self.direct, np.float32
        )
        if self.wet > 0 and tags is not None:
            strength[(tags == 1) | (tags == 2) | (tags == 24)] *= 1.0 - 0.30 * self.wet
        strength[glow] = 1.0
        shown: Bytes = colors.copy()
        shown[:, :3] = np.clip(colors[:, :3] * strength, 0, 255)
        return shown


def light_of(weather: tuple[float, ...]) -> Light:
    """Return the light of a weather (the 14 numbers of `carla.WeatherParameters`), in steps too fine to be visible."""
    steps = {SUN_AZIMUTH: 3.0, SUN_ALTITUDE: 1.5, CLOUDINESS: 5.0, FOG_DENSITY: 2.5, WETNESS: 5.0, PRECIPITATION: 5.0}
    rounded = tuple(round(value / steps.get(i, 5.0)) * steps.get(i, 5.0) for i, value in enumerate(weather))
    return _light(rounded)


@lru_cache(maxsize=64)
def _light(weather: tuple[float, ...]) -> Light:
    clouds = _share(weather[CLOUDINESS])
    rain = _share(weather[PRECIPITATION])
    fog = max(_share(weather[FOG_DENSITY]), 0.6 * _share(weather[DUST]))
    altitude = (weather[SUN_ALTITUDE] + 180.0) % 360.0 - 180.0
    day = _smooth((altitude + 9.0) / 17.0)
    low = _smooth(1.0 - abs(altitude - 3.0) / 17.0) * (1.0 - 0.75 * clouds)
    up, around = math.radians(max(altitude, 6.0) if altitude > -4 else 50.0), math.radians(weather[SUN_AZIMUTH])
    sun = (math.cos(up) * math.cos(around), math.cos(up) * math.sin(around), math.sin(up))
    clear = (1.0 - 0.82 * clouds) * (1.0 - 0.7 * fog)
    direct = _scaled(_between((0.55, 0.53, 0.49), (0.72, 0.44, 0.22), low), day * clear)
    direct = tuple(a + b for a, b in zip(direct, _scaled((0.05, 0.06, 0.09), 1.0 - day), strict=True))  # the moon
    gray = 0.67 + 0.08 * clouds - 0.10 * rain
    ambient = _between((0.23, 0.25, 0.33), _between((gray, gray, gray * 1.03), (0.60, 0.51, 0.50), low), day)
    blue, pale = (78, 136, 205), (188, 212, 232)
    zenith = mix(mix(blue, (152, 160, 168), clouds), (108, 114, 122), 0.75 * rain)
    horizon = mix(mix(pale, (190, 195, 200), clouds), (150, 156, 162), 0.75 * rain)
    zenith, horizon = mix(zenith, (98, 96, 140), low), mix(horizon, (250, 160, 92), low)
    zenith, horizon = mix((8, 11, 24), zenith, day), mix((24, 28, 46), horizon, day)
    haze = mix(mix(horizon, (196, 199, 202), min(1.0, fog * 2.5)), (196, 160, 112), 0.8 * _share(weather[DUST]))
    haze = mix(shade(haze, 0.22), haze, day) if day < 1 else haze
    if fog > 0.05:
        zenith, horizon = mix(zenith, haze, min(1.0, 1.3 * fog)), mix(horizon, haze, min(1.0, 2.0 * fog))
    thickness = 0.0004 + 0.0016 * rain + 0.055 * fog**1.6
    wet = max(_share(weather[WETNESS]), 0.8 * rain, 0.7 * _share(weather[DEPOSITS]))
    return Light(
        sun,
        _triple(direct),
        _triple(ambient),
        zenith,
        horizon,
        haze,
        thickness,
        wet,
        max(_share(weather[DEPOSITS]), 0.3 * rain),
        rain,
        clouds,
        altitude < DARK_BELOW_DEG,
    )


def _share(percent: float) -> float:
    return min(max(percent / 100.0, 0.0), 1.0)


def _smooth(x: float) -> float:
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def _scaled(values: tuple[float, ...], factor: float) -> tuple[float, ...]:
    return tuple(value * factor for value in values)


def _between(first: tuple[float, ...], second: tuple[float, ...], share: float) -> tuple[float, ...]:
    return tuple(a + (b - a) * share for a, b in zip(first, second, strict=True))


def _triple(values: tuple[float, ...]) -> tuple[float, float, float]:
    return values[0], values[1], values[2]
