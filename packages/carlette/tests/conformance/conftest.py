"""Runs the promises against carlette, or against any CARLA server that is named.

pytest packages/carlette/tests/conformance                            starts carlette by itself
pytest packages/carlette/tests/conformance --host H --port P          asks a server that runs already, such as CARLA
itself

A promise marked `carlette_only` is one that CARLA does not make; it is left out when a server is named.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from stage import make_synchronous

from serving import running_server

carla = pytest.importorskip("carla")

HERE = Path(__file__).parent
OURS = ("vehicle.", "walker.", "sensor.", "static.", "controller.")


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("conformance")
    group.addoption("--host", default=None, help="ask the server there instead of starting carlette")
    group.addoption("--port", type=int, default=2000, help="its request port (default: 2000)")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "carlette_only: CARLA does not promise this")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if HERE in item.path.parents:
            item.add_marker(pytest.mark.integration)
    if config.getoption("--host", default=None):
        left_out = pytest.mark.skip(reason="CARLA does not promise this")
        for item in items:
            if item.get_closest_marker("carlette_only"):
                item.add_marker(left_out)


@pytest.fixture(scope="session")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where carlette keeps its logs; it is not there until one is recorded."""
    return tmp_path_factory.mktemp("state") / "recordings"


@pytest.fixture(scope="session")
def address(pytestconfig: pytest.Config, recordings: Path) -> Iterator[tuple[str, int]]:
    """Host and request port of the server."""
    host = pytestconfig.getoption("--host", default=None)
    if host:
        yield host, pytestconfig.getoption("--port")
        return
    version = carla.Client("127.0.0.1", 1, 1).get_client_version()
    with running_server("--map", "demo_town", "--client-version", version, "--recordings", str(recordings)) as port:
        yield "127.0.0.1", port


@pytest.fixture(scope="session")
def timeout_s() -> float:
    """Long enough for a busy machine; who takes longer hangs."""
    return 60.0


@pytest.fixture(scope="session")
def new_client(address: tuple[str, int], timeout_s: float) -> Any:
    """Makes one more client of the server."""

    def make() -> Any:
        one = carla.Client(*address)
        one.set_timeout(timeout_s)
        return one

    return make


@pytest.fixture(scope="session")
def client(new_client: Any) -> Iterator[Any]:
    one = new_client()
    yield one
    settings = one.get_world().get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = False, None
    one.get_world().apply_settings(settings)


@pytest.fixture
def world(client: Any) -> Iterator[Any]:
    """The world in synchronous mode, without actors of an earlier test."""
    found = client.get_world()
    make_synchronous(found)
    yield found
    clear(client)


@pytest.fixture
def spots(world: Any) -> Any:
    """Where cars can be spawned."""
    return world.get_map().get_spawn_points()


def clear(client: Any) -> None:
    """Takes all actors away that a client can have brought."""
    found = client.get_world()
    make_synchronous(found)
    found.tick()
    ours = [actor for actor in found.get_actors() if actor.type_id.startswith(OURS)]
    # The tick comes below: one in the batch waits with Python's lock, which a sensor that ends may need.
    client.apply_batch_sync([carla.command.DestroyActor(our) for our in ours])
    found.freeze_all_traffic_lights(False)
    found.reset_all_traffic_lights()
    found.tick()
