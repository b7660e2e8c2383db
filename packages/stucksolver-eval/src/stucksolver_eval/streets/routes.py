"""Routes past such sites, found on the map of a simulator that is started for the search."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from stucksolver_carla.client_connection import ServerError, connect
from stucksolver_carla.map_trial import require_readable_map
from stucksolver_eval.routes import Position, Route, RoutePose, ScenarioSpec
from stucksolver_eval.simulator_server import CLIENT_TIMEOUT_S, open_server

if TYPE_CHECKING:
    import carla

MARKS_EVERY_M = 20
"""Distance between the waypoints of a route (m): short enough that the path between them is unambiguous. Ours."""

Found = TypeVar("Found")


@dataclass(frozen=True)
class SimulatorTarget:
    """A map and its simulator: carlette, or a running CARLA server at `host` and `port`."""

    map_name: str
    maps: str | None = None
    seed: int = 1
    host: str | None = None
    port: int = 2000


def with_map(where: SimulatorTarget, find: Callable[[Any, Any], Found]) -> Found:
    """Call `find` with a `carla.World` and its `carla.Map`. Raises `ServerError`, and the errors of `find`."""
    with open_server(where.map_name, where.maps, where.seed, where.host, where.port) as server:
        try:
            client = connect(server, CLIENT_TIMEOUT_S)
            world = client.get_world() if where.host is None else client.load_world(where.map_name)
            require_readable_map(server, CLIENT_TIMEOUT_S)
            return find(world, world.get_map())
        except RuntimeError as error:
            if isinstance(error, ServerError):
                raise
            # The client library reports a lost simulator with a bare `RuntimeError`.
            server.check()
            raise ServerError(
                f"no answer of the simulator at {server.host}:{server.port}: {error}. Run again"
            ) from error


def street_route(
    route_id: str, town: str, waypoints: Sequence[carla.Waypoint], kind: str, parameters: Mapping[str, float]
) -> Route:
    """Return a route along waypoints 1 m apart, with one scenario of type `kind` that starts with it."""
    marks = [*waypoints[:-1:MARKS_EVERY_M], waypoints[-1]]
    trigger = RoutePose(_position(waypoints[0]), math.remainder(waypoints[0].transform.rotation.yaw, 360.0))
    values = {name: {"value": f"{value:g}"} for name, value in parameters.items()}
    spec = ScenarioSpec(f"{kind}_1", kind, trigger, values)
    return Route(route_id, town, tuple(_position(mark) for mark in marks), scenarios=(spec,))


def _position(waypoint: carla.Waypoint) -> Position:
    place = waypoint.transform.location
    return Position(place.x, place.y, place.z)
