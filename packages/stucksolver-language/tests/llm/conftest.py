"""The worlds of the core's tests serve here too; one chat server for all of a module."""

from __future__ import annotations

import pytest
from chat_server import ChatServer

from stucksolver_language.llm import llm_reasoner, preflight, server_memory


@pytest.fixture(scope="module")
def shared_server():
    with ChatServer() as server:
        yield server


@pytest.fixture(autouse=True)
def _no_server_is_known():
    server_memory.forget()
    yield
    server_memory.forget()


@pytest.fixture
def server(shared_server, monkeypatch):
    """The chat server as it is at first, asked again after a pause that nobody notices."""
    monkeypatch.setattr(llm_reasoner, "FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr(preflight, "BUSY_PAUSE_S", 0.01)
    shared_server.reset()
    return shared_server
