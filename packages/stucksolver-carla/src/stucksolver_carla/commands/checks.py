"""Checks CARLA's client, its agents and a running server for `stucksolver doctor`."""

from __future__ import annotations

import importlib.util
import os
import socket
from collections.abc import Iterator
from pathlib import Path

from stucksolver.commands.doctor import Check, Finding, package

CARLA_PORT = 2000
"""CARLA's default port."""
ANSWER_LIMIT_S = 3.0
"""Time limit for the server's version (s). Ours."""


def _agents() -> Iterator[Finding]:
    folder = os.environ.get("CARLA_AGENTS", "")
    is_found = importlib.util.find_spec("agents") is not None or (folder and Path(folder, "agents").is_dir())
    remedy = "set CARLA_AGENTS to PythonAPI/carla of a CARLA installation; only `attach` and Bench2Drive need it"
    yield Finding("CARLA's agents", "ok" if is_found else "absent", folder or "the package `agents`", remedy)


def _server() -> Iterator[Finding]:
    """Find a server for `--host`. A listening program is queried, because it may not be CARLA."""
    name, address = "CARLA server", f"127.0.0.1:{CARLA_PORT}"
    if not _is_listening(CARLA_PORT):
        remedy = "only `--host` requires one; the commands start carlette by themselves"
        yield Finding(name, "absent", f"no program listens on {address}", remedy)
        return
    if importlib.util.find_spec("carla") is None:
        yield Finding(
            name, "ok", f"a program listens on {address}; it was not queried, because the carla package is missing"
        )
        return
    import carla

    client = carla.Client("127.0.0.1", CARLA_PORT)
    client.set_timeout(ANSWER_LIMIT_S)
    try:
        yield Finding(name, "ok", f"version {client.get_server_version()} answers on {address}")
    except RuntimeError:
        remedy = "start CARLA on another port and set --port, or stop that program"
        yield Finding(name, "broken", f"the program that listens on {address} does not answer like CARLA", remedy)


def _is_listening(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(0.5)
        return probe.connect_ex(("127.0.0.1", port)) == 0


CHECKS: tuple[Check, ...] = (
    package("carla", "the client of CARLA and carlette", "carla", needed=True),
    _agents,
    _server,
)
