"""Weather of the routes: CARLA's own presets in turn, each constant over its route."""

from __future__ import annotations

import carla

from stucksolver_eval.routes import WeatherKey

PRESETS = (
    "ClearNoon",
    "CloudyNoon",
    "WetNoon",
    "WetCloudyNoon",
    "SoftRainNoon",
    "MidRainyNoon",
    "HardRainNoon",
    "ClearSunset",
    "CloudySunset",
    "WetSunset",
    "WetCloudySunset",
    "SoftRainSunset",
    "MidRainSunset",
    "HardRainSunset",
    "ClearNight",
    "CloudyNight",
    "WetNight",
    "WetCloudyNight",
    "SoftRainNight",
    "MidRainyNight",
    "HardRainNight",
)
FIELDS = (
    "cloudiness",
    "precipitation",
    "precipitation_deposits",
    "wetness",
    "wind_intensity",
    "sun_azimuth_angle",
    "sun_altitude_angle",
    "fog_density",
    "fog_distance",
    "fog_falloff",
)
_STEP = 8
"""Has no divisor in common with the number of presets: all come up, and neighbours differ."""
_DECIMALS = 3


def weather(number: int) -> tuple[WeatherKey, WeatherKey]:
    """The weather of the route of this number, at its start and at its end."""
    preset = getattr(carla.WeatherParameters, weather_name(number))
    values = {name: round(float(getattr(preset, name)), _DECIMALS) for name in FIELDS}
    return WeatherKey(0.0, values), WeatherKey(100.0, values)


def weather_name(number: int) -> str:
    """CARLA's name of the same."""
    return PRESETS[number * _STEP % len(PRESETS)]
