"""A server whose map crashes the client's library ends a command with one line, not with a signal."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

pytest.importorskip("carla")
pytest.importorskip("carlette")

from stucksolver.commands import main
from stucksolver_carla import map_trial
from stucksolver_carla.client_connection import ServerError, SimulatorServer
from stucksolver_carla.map_trial import require_readable_map

pytestmark = pytest.mark.integration

SERVE = """
import sys
from dataclasses import replace
from carlette.client_versions import DEFAULT_VERSION, VERSIONS
from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.server import Server
from carlette.simulator import Simulator
roads = RoadNetwork(load_map(DEMO_TOWN))
server = Server(Simulator(roads, VERSIONS[DEFAULT_VERSION], [], 0), "127.0.0.1", 0)
# Another server may not have tried its map: its roads begin with a late offset.
late = roads.file.text.replace("<laneSection", '<laneOffset s="1" a="0" b="0" c="0" d="0"/><laneSection')
assert late != roads.file.text
if sys.argv[1] == "late":
    roads.file = replace(roads.file, text=late)
print(server.port, flush=True)
server.serve(lambda: True)
"""


@contextmanager
def serving(kind: str) -> Iterator[SimulatorServer]:
    """A server of another program, as the commands see one."""
    with subprocess.Popen([sys.executable, "-c", SERVE, kind], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield SimulatorServer("127.0.0.1", int(process.stdout.readline()))
        finally:
            process.kill()


def test_map_that_crashes_the_client_is_reported_by_address() -> None:
    with serving("late") as server, pytest.raises(ServerError, match=f"{server.port} crashes the carla client"):
        require_readable_map(server, 20.0)


def test_watch_survives_map_that_crashes_the_client(capsys: pytest.CaptureFixture[str]) -> None:
    with serving("late") as server:
        assert main(["watch", "--port", str(server.port)]) == 2
    line = capsys.readouterr().err
    assert line.count("\n") == 1 and "crashes the carla client (SIG" in line and "carlette --map FILE" in line


def test_readable_map_is_accepted() -> None:
    with serving("sound") as server:
        require_readable_map(server, 20.0)


def test_map_that_is_not_read_in_time_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_trial, "LIMIT_S", 0.01)
    with pytest.raises(ServerError, match="is not read within 0 s"):
        require_readable_map(SimulatorServer("127.0.0.1", 1), 20.0)
