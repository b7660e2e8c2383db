"""Builds a client's map in a child process first, because the client's library may crash on it or never finish."""

from __future__ import annotations

import faulthandler
import os
import resource
import select
import signal
import warnings
from typing import NoReturn

from carlette.errors import MapError
from carlette.opendrive.map_file import MapFile
from carlette.opendrive.road_network import RoadNetwork
from carlette.world.world import World

LONGEST_S = 30.0
"""Town04, the largest at hand, is built within 2 s on a busy core."""
MOST_MEMORY_BYTES = 16 << 30
"""Address space of the child (bytes); threads and libraries reserve a lot of it."""
_NAME = "OpenDriveMap"
_SOUND = b"."
_LONGEST_REASON = 400


def try_out(text: str, longest_s: float = LONGEST_S) -> None:
    """Raise `MapError` with the reason if a map cannot be built, crashes its builder or takes too long.

    The child is forked, because importing everything again takes longer than building most maps. It has none of the
    server's threads. It builds the map, reports the result, and ends without cleaning up what belongs to the server.
    """
    ear, mouth = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks beside threads, from Python 3.12 on
        child = os.fork()
    if child == 0:
        _build_and_tell(text, mouth)
    os.close(mouth)
    try:
        ended = bool(select.select([ear], [], [], longest_s)[0])
        told = os.read(ear, _LONGEST_REASON) if ended else b""
    finally:
        os.close(ear)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    if not ended:
        raise MapError(f"the map is not built within {longest_s:g} s; give a smaller one")
    if not told:
        raise MapError("building the map crashes the carla library; check its roads, lanes and links")
    if told != _SOUND:
        raise MapError(told.decode(errors="replace"))


def _build_and_tell(text: str, mouth: int) -> NoReturn:
    told = b""
    try:
        faulthandler.disable()
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, MOST_MEMORY_BYTES))
        told = _reason(text).encode("utf-8", "replace")[:_LONGEST_REASON] or _SOUND
    finally:
        if told:
            os.write(mouth, told)
        os._exit(0)


def _reason(text: str) -> str:
    """Return why the server cannot load a map; empty if it can."""
    try:
        roads = RoadNetwork(MapFile(_NAME, text))
        places = roads.spawn_points()
        World(roads)
    except Exception as error:  # noqa: BLE001  (whatever it is, it must not happen in the server)
        return str(error) if isinstance(error, MapError) else f"{type(error).__name__}: {error}"
    return (
        "" if all(place.is_finite() for place in places) else "a lane has no position: its coordinates are not numbers"
    )
