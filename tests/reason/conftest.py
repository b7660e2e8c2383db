"""The worlds of the core's tests serve here too; one chat server for all of a module."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent.parent / "core"))

from chat_server import ChatServer


@pytest.fixture(scope="module")
def shared_server():
    with ChatServer() as server:
        yield server


@pytest.fixture
def server(shared_server):
    shared_server.reset()
    return shared_server
