"""Threads besides the server's: one builds slow things once per map, one draws, and one casts rays.

Drawing and casting release Python's global lock, so both run while the server's thread advances the world.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import lru_cache
from queue import SimpleQueue
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from carlette.allocator import release_memory
from carlette.camera.rendering.scene_capture import static_scene_of
from carlette.opendrive.road_network import RoadNetwork
from carlette.sensors.ray_surfaces import static_faces

T = TypeVar("T")

_static_scenes: WeakKeyDictionary[RoadNetwork, Future[None]] = WeakKeyDictionary()
_faces: WeakKeyDictionary[RoadNetwork, Future[None]] = WeakKeyDictionary()


def build_static_scene(roads: RoadNetwork) -> Future[None]:
    """Start building the parts of a map that cameras draw, unless that has already started."""
    return _begun(_static_scenes, roads, lambda: _make_static_scene(roads))


def build_faces(roads: RoadNetwork) -> Future[None]:
    """Start building the surfaces of a map that rays hit, and compiling their loops (seconds without a cache)."""
    return _begun(_faces, roads, lambda: _make_faces(roads))


class Worker:
    """A thread that runs one job after the other. It does not keep the server from ending."""

    def __init__(self, name: str) -> None:
        self._jobs: SimpleQueue[tuple[Future[Any], Callable[[], Any]]] = SimpleQueue()
        threading.Thread(target=self._work, name=name, daemon=True).start()

    def submit(self, job: Callable[[], T]) -> Future[T]:
        """Queue a job. The future gets its result or error."""
        future: Future[T] = Future()
        self._jobs.put((future, job))
        return future

    def _work(self) -> None:
        while True:
            _do(*self._jobs.get())


def _do(future: Future[Any], job: Callable[[], Any]) -> None:
    # A separate function, so that the thread holds no references while it waits for the next job.
    try:
        future.set_result(job())
    except BaseException as error:  # noqa: BLE001
        # The caller gets the error from the future.
        future.set_exception(error)


@lru_cache(maxsize=1)
def drawer() -> Worker:
    """Return the worker that draws pictures, one after the other: all cameras share one renderer."""
    return Worker("carlette-camera")


@lru_cache(maxsize=1)
def caster() -> Worker:
    """Return the worker that casts rays, scan after scan, so that random numbers are drawn in a fixed order."""
    return Worker("carlette-rays")


@lru_cache(maxsize=1)
def _builder() -> Worker:
    return Worker("carlette-builder")


def _begun(
    known: WeakKeyDictionary[RoadNetwork, Future[None]], roads: RoadNetwork, build: Callable[[], object]
) -> Future[None]:
    found = known.get(roads)
    if found is None:
        found = known[roads] = _builder().submit(lambda: _finish(build))
    return found


def _finish(build: Callable[[], object]) -> None:
    # Do not return the result: it would hold its key, and so the map, forever.
    build()
    release_memory()


def _make_static_scene(roads: RoadNetwork) -> None:
    from carlette.camera.rendering.raster import warm_up  # numba takes half a second to load

    warm_up()
    static_scene_of(roads)


def _make_faces(roads: RoadNetwork) -> None:
    from carlette.sensors.kernels import warm_up  # numba takes half a second to load

    warm_up()
    static_faces(roads)
