"""One route of a suite, as in its XML. Positions are in CARLA's left-handed world frame, in meters and degrees."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Parameter = Mapping[str, str]
"""The attributes of a parameter's XML element: `{"value": "42"}`, `{"from": "30", "to": "60"}`, ..."""


@dataclass(frozen=True)
class Position:
    x_m: float
    y_m: float
    z_m: float


@dataclass(frozen=True)
class RoutePose:
    """A pose on the route. `yaw_deg` is clockwise, as in CARLA."""

    position: Position
    yaw_deg: float


@dataclass(frozen=True)
class ScenarioSpec:
    """One scenario on a route: its public type, its trigger point, and its parameters by element name."""

    name: str
    type: str
    trigger: RoutePose
    parameters: Mapping[str, Parameter]


@dataclass(frozen=True)
class WeatherKey:
    """Weather at one point of the route; `values` has the field names of `carla.WeatherParameters`."""

    route_percentage: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class Route:
    """The waypoints of a route in a town, with its weather and its scenarios."""

    id: str
    town: str
    waypoints: tuple[Position, ...]
    weathers: tuple[WeatherKey, ...] = ()
    scenarios: tuple[ScenarioSpec, ...] = ()
