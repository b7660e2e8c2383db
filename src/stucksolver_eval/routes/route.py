"""One route of a suite, as its XML states it. Positions are in CARLA's left-handed world frame, metres and degrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Parameter = Mapping[str, str]
"""The attributes of a parameter's XML element as they stand: `{"value": "42"}`, `{"from": "30", "to": "60"}`, ..."""


@dataclass(frozen=True)
class Position:
    x_m: float
    y_m: float
    z_m: float


@dataclass(frozen=True)
class RoutePose:
    """`yaw_deg` grows clockwise, as CARLA's does."""

    position: Position
    yaw_deg: float


@dataclass(frozen=True)
class ScenarioSpec:
    """One scenario on a route: its public type, where it is triggered, and its parameters by element name."""

    name: str
    type: str
    trigger: RoutePose
    parameters: Mapping[str, Parameter]


@dataclass(frozen=True)
class WeatherKey:
    """Weather at one point of the route; `values` are named like the fields of `carla.WeatherParameters`."""

    route_percentage: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class Route:
    """Waypoints to drive by, on a town, with what happens on the way."""

    id: str
    town: str
    waypoints: tuple[Position, ...]
    weathers: tuple[WeatherKey, ...] = ()
    scenarios: tuple[ScenarioSpec, ...] = ()
