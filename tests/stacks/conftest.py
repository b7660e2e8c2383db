"""One server for the session, on the demo town; whatever a test puts into the world goes when it ends."""

from __future__ import annotations

import faulthandler
from collections.abc import Iterator

import pytest

pytest.importorskip("carla")

from townstage import Stage

from stucksolver.evaluate.server import carlette_server

LONGEST_TEST_S = 60


@pytest.fixture(autouse=True)
def no_hang() -> Iterator[None]:
    """The client library waits in C++, where nothing but the end of the process reaches it."""
    faulthandler.dump_traceback_later(LONGEST_TEST_S, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


@pytest.fixture(scope="session")
def _stage() -> Iterator[Stage]:
    with carlette_server("demo_town") as server:
        yield Stage(server.host, server.port)


@pytest.fixture
def stage(_stage: Stage) -> Iterator[Stage]:
    """An empty world in synchronous mode."""
    yield _stage
    _stage.clear()
