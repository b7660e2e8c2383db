"""One server for each town, shared by all tests here; a hang fails instead of hanging."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import pytest

carla = pytest.importorskip("carla")

from playing import Playing, Theatre  # noqa: E402

from stucksolver_eval.simulator_server import carlette_server  # noqa: E402


@pytest.fixture(scope="session")
def theatre() -> Iterator[Theatre]:
    with contextlib.ExitStack() as stack:
        clients: dict[str, Any] = {}

        def client_of(town: str) -> Any:
            if town not in clients:
                server = stack.enter_context(carlette_server(town))
                clients[town] = carla.Client(server.host, server.port)
                clients[town].set_timeout(60.0)
            return clients[town]

        yield Theatre(client_of)


@pytest.fixture
def play(theatre: Theatre) -> Iterator[Callable[..., Playing]]:
    """Begins a play of the suite by the name of its scenario; all are ended with the test."""
    begun: list[Playing] = []

    def begin(name: str, **options: Any) -> Playing:
        begun.append(theatre.play(name, **options))
        return begun[-1]

    yield begin
    for item in begun:
        item.close()
