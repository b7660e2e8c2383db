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
"""Time limit of the build (s). Ours; Town04, the largest map we have, is built within 2 s on a busy core."""
MOST_MEMORY_BYTES = 16 << 30
"""Address space of the child (bytes). Ours; threads and libraries reserve a lot of it."""
_NAME = "OpenDriveMap"
_SOUND = b"."
_LONGEST_REASON = 400
"""Maximum number of bytes of the reason that the child reports. Ours."""


def try_out(text: str, longest_s: float = LONGEST_S) -> None:
    """Raise `MapError` with the reason if a map cannot be built, crashes its builder or takes too long.

    The child is forked, because importing everything again takes longer than building most maps. It has none of the
    server's threads. It builds the map, reports the result, and ends without cleaning up the server's resources.
    """
    ear, mouth = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks next to threads, from Python 3.12 on
        child = os.fork()
    if child == 0:
        _build_and_tell(text, mouth)
    os.close(mouth)
    try:
        ended = bool(select.select([ear], [], [], longest_s)[0])
        reason = os.read(ear, _LONGEST_REASON) if ended else b""
    finally:
        os.close(ear)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    if not ended:
        raise MapError(f"the map is not built within {longest_s:g} s; give a smaller one")
    if not reason:
        raise MapError("building the map crashes the carla library; check its roads, lanes and links")
    if reason != _SOUND:
        raise MapError(reason.decode(errors="replace"))


def _build_and_tell(text: str, mouth: int) -> NoReturn:
    reason = b""
    try:
        faulthandler.disable()
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, MOST_MEMORY_BYTES))
        reason = _reason(text).encode("utf-8", "replace")[:_LONGEST_REASON] or _SOUND
    finally:
        if reason:
            os.write(mouth, reason)
        os._exit(0)


def _reason(text: str) -> str:
    """Return the reason why the server cannot load a map; empty if it can."""
    try:
        roads = RoadNetwork(MapFile(_NAME, text))
        places = roads.spawn_points()
        World(roads)
    except Exception as error:  # noqa: BLE001
        # Catch everything: the child reports the error, so that it does not happen in the server.
        return str(error) if isinstance(error, MapError) else f"{type(error).__name__}: {error}"
    return (
        "" if all(place.is_finite() for place in places) else "a lane has no position: its coordinates are not numbers"
    )
