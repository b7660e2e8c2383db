"""Random routes through towns, for drives outside the suites."""

from __future__ import annotations

import math
from random import Random
from typing import TYPE_CHECKING

from stucksolver_carla.client_connection import connect
from stucksolver_eval.routes import Position, Route
from stucksolver_eval.simulator_server import CLIENT_TIMEOUT_S, open_server

if TYPE_CHECKING:
    import carla

NEAREST_M, FARTHEST_M = 120.0, 400.0
"""Range of the straight-line distance from the start of a route to its end (m). Ours."""
_TRIES = 200
"""Number of tries to find a route. Ours."""


class TownError(RuntimeError):
    """A town has no suitable route; the message names the town."""


def town_routes(
    towns: tuple[str, ...], drives: int, seed: int, maps: str | None, host: str | None = None, port: int = 2000
) -> tuple[Route, ...]:
    """Return `drives` random routes in each town, always the same for a seed.

    Raises:
        TownError: A town has no suitable route.
        ServerError: The given server does not respond.
    """
    found: list[Route] = []
    for town in towns:
        with open_server(town, maps, seed, host, port) as server:
            client = connect(server, CLIENT_TIMEOUT_S)
            world = client.get_world() if host is None else client.load_world(town)
            spots = world.get_map().get_spawn_points()
        found += [_route(town, spots, number, Random(f"{seed}:{town}:{number}")) for number in range(drives)]
    return tuple(found)


def _route(town: str, spots: list[carla.Transform], number: int, chance: Random) -> Route:
    for _ in range(_TRIES):
        if len(spots) < 2:
            break
        start, end = (spot.location for spot in chance.sample(spots, 2))
        if NEAREST_M < math.hypot(start.x - end.x, start.y - end.y) < FARTHEST_M:
            waypoints = tuple(Position(float(p.x), float(p.y), float(p.z)) for p in (start, end))
            return Route(f"{town}_{number:03d}", town, waypoints)
    raise TownError(
        f"no route of {NEAREST_M:.0f} to {FARTHEST_M:.0f} m between {len(spots)} spawn points: {town}. Use another town"
    )
