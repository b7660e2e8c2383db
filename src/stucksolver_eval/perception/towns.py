"""Random routes through towns, for drives that no suite has."""

from __future__ import annotations

import math
from random import Random
from typing import TYPE_CHECKING

from stucksolver_eval.routes import Position, Route
from stucksolver_eval.server import CLIENT_TIMEOUT_S, connect, open_server

if TYPE_CHECKING:
    import carla

NEAREST_M, FARTHEST_M = 120.0, 400.0
"""From the start of a route to its end, as the crow flies."""
_TRIES = 200


class TownError(RuntimeError):
    """No route can be laid there; the message names the town and the remedy."""


def town_routes(
    towns: tuple[str, ...], drives: int, seed: int, maps: str | None, host: str | None = None, port: int = 2000
) -> tuple[Route, ...]:
    """So many routes in each town, the same for the same seed. Raises `TownError` and `ServerError`."""
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
    raise TownError(f"{town}: its {len(spots)} spawn points give no route of {NEAREST_M:.0f} to {FARTHEST_M:.0f} m")
