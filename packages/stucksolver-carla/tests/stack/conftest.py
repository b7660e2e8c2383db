"""One server for the session, on the demo town; whatever a test puts into the world goes when it ends."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

pytest.importorskip("carla")

from townstage import Stage

from stucksolver_eval.simulator_server import carlette_server


@pytest.fixture(scope="session")
def _stage() -> Iterator[Stage]:
    with carlette_server("demo_town") as server:
        yield Stage(server.host, server.port)


@pytest.fixture
def stage(_stage: Stage) -> Iterator[Stage]:
    """An empty world in synchronous mode."""
    yield _stage
    _stage.clear()
