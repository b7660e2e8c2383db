"""Threads beside the server's: one builds what takes long, once for each map; one draws, one casts rays.

Drawing and casting let go of Python's lock, so both run while the server's thread moves the world on.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache
from weakref import WeakKeyDictionary

from carlette.camera.studio import stage_of
from carlette.opendrive.roads import RoadNetwork
from carlette.sensors.faces import static_faces

_stages: WeakKeyDictionary[RoadNetwork, Future[None]] = WeakKeyDictionary()
_faces: WeakKeyDictionary[RoadNetwork, Future[None]] = WeakKeyDictionary()


def build_stage(roads: RoadNetwork) -> Future[None]:
    """Begins to build what cameras see of a map, unless that was begun already."""
    return _begun(_stages, roads, lambda: stage_of(roads))


def build_faces(roads: RoadNetwork) -> Future[None]:
    """Begins to build what rays meet of a map, and to compile their loops (seconds where nothing is cached)."""
    return _begun(_faces, roads, lambda: _make_faces(roads))


@lru_cache(maxsize=1)
def drawers() -> ThreadPoolExecutor:
    """Draws pictures one after the other: there is one rasteriser."""
    return ThreadPoolExecutor(1, "carlette-camera")


@lru_cache(maxsize=1)
def casters() -> ThreadPoolExecutor:
    """Casts rays, scan after scan, so that what is left to chance comes in a fixed order."""
    return ThreadPoolExecutor(1, "carlette-rays")


@lru_cache(maxsize=1)
def _builders() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1, "carlette-builder")


def _begun(
    known: WeakKeyDictionary[RoadNetwork, Future[None]], roads: RoadNetwork, build: Callable[[], object]
) -> Future[None]:
    found = known.get(roads)
    if found is None:
        # The result must not be kept: it would keep its key, and so the map, for ever.
        found = known[roads] = _builders().submit(lambda: (build(), None)[1])
    return found


def _make_faces(roads: RoadNetwork) -> None:
    from carlette.sensors.warmth import warm_up  # numba takes half a second to load

    warm_up()
    static_faces(roads)
