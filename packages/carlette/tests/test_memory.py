"""A server's memory does not grow with the worlds that are loaded in it."""

from __future__ import annotations

import ctypes
import weakref

import numpy as np
import psutil
import pytest

from carlette.allocator import release_memory
from carlette.cli import _parser, _simulator
from carlette.geometry import Pose
from carlette.world.spawn import spawn
from raw_client import SYNCHRONOUS, Raw
from serving import running_server

pytestmark = pytest.mark.integration

WORLDS = 18
WARM = 8
GROWTH_MB = 2.5
"""Over the worlds after the first few; a town's map alone is larger."""


@pytest.mark.release
def test_eighteen_worlds_need_no_more_memory_than_eight(town01) -> None:
    pytest.importorskip("carla")
    with running_server("--maps", str(town01.parent)) as port:
        raw = Raw(port)
        raw.call("set_episode_settings", SYNCHRONOUS)
        (server,) = (child for child in psutil.Process().children() if str(port_of(child)) == str(port))
        for number in range(WORLDS):
            if number == WARM:
                warm = server.memory_info().rss
            assert raw.call("load_new_episode", ("Town01", "demo_town")[number % 2], False, 0xFFFF)[1] == [[False]]
            car = [1, "vehicle.tesla.model3", []]
            for x in (0.0, 20.0, 40.0):
                raw.call("spawn_actor", car, [[x, 0.0, 5.0], [0.0, 0.0, 0.0]])
            for _ in range(5):
                raw.call("tick_cue")
        assert (server.memory_info().rss - warm) / 1e6 < GROWTH_MB


def port_of(process: psutil.Process) -> int:
    """The lowest port that a process listens on; 0 = none."""
    return min(
        (connection.laddr.port for connection in process.net_connections() if connection.status == psutil.CONN_LISTEN),
        default=0,
    )


def test_a_map_goes_with_its_episode_the_first_one_too() -> None:
    pytest.importorskip("carla")
    simulator = _simulator(_parser().parse_args([]))
    spawn(simulator.world, "sensor.other.imu", {}, Pose())
    simulator.tick()
    maps = [weakref.ref(simulator.world.roads)]
    for town in ("interurban", "demo_town"):
        simulator.load_map(town, False)
        assert [item() for item in maps] == [None] * len(maps)
        maps.append(weakref.ref(simulator.world.roads))


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="a C library without malloc_trim")
def test_free_pages_between_used_ones_are_handed_back() -> None:
    blocks = [np.ones(4096) for _ in range(3000)]
    del blocks[:-1]
    before = psutil.Process().memory_info().rss
    release_memory()
    assert before - psutil.Process().memory_info().rss > 50e6
