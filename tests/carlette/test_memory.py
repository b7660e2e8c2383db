"""A server's memory does not grow with the worlds that are loaded in it."""

from __future__ import annotations

import psutil
import pytest
from raw_client import SYNCHRONOUS, Raw
from serving import running_server

pytestmark = pytest.mark.integration

WORLDS = 30
WARM = 10
GROWTH_MB = 5.0
"""Over the worlds after the first few; a town's map alone is larger."""


def test_thirty_worlds_need_no_more_memory_than_ten(town01) -> None:
    pytest.importorskip("carla")
    with running_server("--maps", str(town01.parent)) as port:
        raw = Raw(port)
        raw.call("set_episode_settings", SYNCHRONOUS)
        (server,) = (one for one in psutil.Process().children() if str(port_of(one)) == str(port))
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
    return min((one.laddr.port for one in process.net_connections() if one.status == psutil.CONN_LISTEN), default=0)
