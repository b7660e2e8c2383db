"""Checks of `stucksolver doctor` on CARLA's client, its agents and a running server."""

from __future__ import annotations

import importlib.util
import os
import socket
from collections.abc import Iterator
from pathlib import Path

from stucksolver.commands.doctor import Check, Finding, package

CARLA_PORT = 2000


SERVER_ANSWERS_S = 3.0


def _agents() -> Iterator[Finding]:
    told = os.environ.get("CARLA_AGENTS", "")
    found = importlib.util.find_spec("agents") is not None or (told and Path(told, "agents").is_dir())
    remedy = "set CARLA_AGENTS to PythonAPI/carla of a CARLA installation; only `attach` and Bench2Drive need it"
    yield Finding("CARLA's agents", "ok" if found else "absent", told or "the package `agents`", remedy)


def _server() -> Iterator[Finding]:
    """Look for a server for `--host`. Whatever listens is queried, because it may be another program."""
    name, where = "CARLA server", f"127.0.0.1:{CARLA_PORT}"
    if not _listens(CARLA_PORT):
        remedy = "only `--host` needs one; the commands start carlette by themselves"
        yield Finding(name, "absent", f"nothing listens on {where}", remedy)
        return
    if importlib.util.find_spec("carla") is None:
        yield Finding(
            name, "ok", f"something listens on {where}; it was not queried, since the carla package is missing"
        )
        return
    import carla

    client = carla.Client("127.0.0.1", CARLA_PORT)
    client.set_timeout(SERVER_ANSWERS_S)
    try:
        yield Finding(name, "ok", f"version {client.get_server_version()} answers on {where}")
    except RuntimeError:
        remedy = "start CARLA on another port and name it by --port, or stop that program"
        yield Finding(name, "broken", f"the program that listens on {where} does not answer like CARLA", remedy)


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        probe.settimeout(0.5)
        return probe.connect_ex(("127.0.0.1", port)) == 0


CHECKS: tuple[Check, ...] = (
    package("carla", "the client of CARLA and carlette", "carla", needed=True),
    _agents,
    _server,
)
