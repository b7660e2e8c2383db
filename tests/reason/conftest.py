"""The worlds of the core's tests serve here too; one chat server for all of a module."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "core"))

from chat_server import ChatServer

from stucksolver.reason.llm import preflight, reasoner


@pytest.fixture(scope="module")
def shared_server():
    with ChatServer() as server:
        yield server


@pytest.fixture
def server(shared_server, monkeypatch):
    """The chat server as it is at first, asked again after a pause that nobody notices."""
    monkeypatch.setattr(reasoner, "FIRST_PAUSE_S", 0.01)
    monkeypatch.setattr(preflight, "BUSY_PAUSE_S", 0.01)
    shared_server.reset()
    return shared_server
