"""Builds a map in a child process first, because the client's library may crash on it or never finish."""

from __future__ import annotations

import faulthandler
import hashlib
import os
import resource
import select
import signal
import warnings
from typing import Any, NoReturn

from carlette.errors import MapError
from carlette.maps import SHIPPED
from carlette.opendrive.document import parse
from carlette.opendrive.faults import explain
from carlette.opendrive.map_file import MapFile
from carlette.opendrive.road_network import RoadNetwork, carla_library
from carlette.world.world import World

LONGEST_S = 30.0
"""Time limit of the build (s). Ours; Town04, the largest map we have, is built within 2 s on a busy core."""
LONGEST_AT_START_S = 120.0
"""Time limit of the build before the server listens, when nobody waits for an answer (s). Ours."""
MOST_MEMORY_BYTES = 16 << 30
"""Address space of the child (bytes). Ours; threads and libraries reserve a lot of it."""
STEP_M = 20.0
"""Distance between the places at which the child looks at lanes, and length of its steps along them (m). Ours."""
_SOUND = b"."
_LONGEST_REASON = 1000
"""Maximum number of bytes of the reason that the child reports. Ours."""
_tried: set[bytes] = set()
"""Digests of the texts that this process has tried."""


def open_roads(file: MapFile, longest_s: float = LONGEST_S) -> RoadNetwork:
    """Return the roads of a map, built after a trial in a child process.

    The shipped maps need no trial, and no text needs a second one.

    Raises:
        MapError: The map cannot be built, crashes the library or takes too long.
    """
    digest = hashlib.sha256(file.text.encode("utf-8", "surrogateescape")).digest()
    if digest not in _tried and not _is_shipped(file):
        try_out(file, longest_s)
    _tried.add(digest)
    return RoadNetwork(file)


def try_out(file: MapFile, longest_s: float = LONGEST_S) -> None:
    """Raise `MapError` with the reason if a map cannot be built, crashes its builder or takes too long.

    The child is forked, because importing everything again takes longer than building most maps. It has none of the
    server's threads. It builds the map, reports the result, and ends without cleaning up the server's resources.
    """
    carla_library()  # in this process, so that no child has to load it
    ear, mouth = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of forks next to threads, from Python 3.12 on
        child = os.fork()
    if child == 0:
        _build_and_tell(file, mouth)
    os.close(mouth)
    try:
        ended = bool(select.select([ear], [], [], longest_s)[0])
        reason = os.read(ear, _LONGEST_REASON) if ended else b""
    finally:
        os.close(ear)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    if not ended:
        raise MapError(f"map '{file.source}' is not built within {longest_s:g} s; give a smaller one")
    if not reason:
        raise MapError(f"map '{file.source}' crashes the carla library: {explain(parse(file.text))}")
    if reason != _SOUND:
        raise MapError(reason.decode(errors="replace"))


def _is_shipped(file: MapFile) -> bool:
    shipped = SHIPPED / f"{file.name}.xodr"
    return shipped.is_file() and shipped.read_text(encoding="utf-8") == file.text


def _build_and_tell(file: MapFile, mouth: int) -> NoReturn:
    reason = b""
    try:
        faulthandler.disable()
        # The library's warnings come again when the server builds the map.
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, 1)
        os.dup2(silence, 2)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, MOST_MEMORY_BYTES))
        reason = _reason(file).encode("utf-8", "replace")[:_LONGEST_REASON] or _SOUND
    finally:
        if reason:
            os.write(mouth, reason)
        os._exit(0)


def _reason(file: MapFile) -> str:
    """Return the reason why the server cannot load a map; empty if it can."""
    try:
        roads = RoadNetwork(file)
        places = roads.spawn_points()
        World(roads)
        _look_around(roads)
    except Exception as error:  # noqa: BLE001
        # Catch everything: the child reports the error, so that it does not happen in the server.
        if isinstance(error, MapError):
            return str(error)
        return f"map '{file.source}' cannot be used ({type(error).__name__}: {error}): {explain(parse(file.text))}"
    return "" if places else f"map '{file.source}': no lane has a position: {explain(parse(file.text))}"


def _look_around(roads: RoadNetwork) -> None:
    """Call what clients call on a map. The library may crash there, in the client, on a map that it has built."""
    town = roads.map
    junctions: dict[int, Any] = {}
    for waypoint in town.generate_waypoints(STEP_M):
        waypoint.next(STEP_M), waypoint.previous(STEP_M)
        waypoint.get_left_lane(), waypoint.get_right_lane(), waypoint.left_lane_marking
        if waypoint.is_junction and waypoint.junction_id not in junctions:
            junctions[waypoint.junction_id] = waypoint.get_junction().get_waypoints(roads.carla.LaneType.Any)
    town.get_topology(), town.get_crosswalks(), town.get_all_landmarks()
