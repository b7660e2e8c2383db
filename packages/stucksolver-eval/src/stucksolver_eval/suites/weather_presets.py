"""Weather of the routes: CARLA's presets in turn, constant over each route."""

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
"""Step through the presets. It is coprime to their number, so that all are used and neighbors differ."""
_DECIMALS = 3


def weather(number: int) -> tuple[WeatherKey, WeatherKey]:
    """Return the weather of the route with this number, at its start and at its end."""
    preset = getattr(carla.WeatherParameters, weather_name(number))
    values = {name: round(float(getattr(preset, name)), _DECIMALS) for name in FIELDS}
    return WeatherKey(0.0, values), WeatherKey(100.0, values)


def weather_name(number: int) -> str:
    """Return CARLA's name of the weather of the route with this number."""
    return PRESETS[number * _STEP % len(PRESETS)]
