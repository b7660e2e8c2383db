"""Connects to a running CARLA server, and says what is wrong if that fails."""

from __future__ import annotations

import socket
import subprocess
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import carla

REACH_S = 5.0


class ServerError(RuntimeError):
    """The simulator did not start, or ended. The message is its own."""


@dataclass(frozen=True)
class SimulatorServer:
    """The address of a simulator."""

    host: str
    port: int
    process: subprocess.Popen[str] | None = None

    def check(self) -> None:
        """Check the process.

        Raises:
            ServerError: It has ended.
        """
        if self.process is not None and self.process.poll() is not None:
            raise ServerError(f"the simulator ended with exit code {self.process.returncode}; run again")


def remote_server(host: str, port: int) -> SimulatorServer:
    """Return a server that is already running.

    Raises:
        ServerError: Nobody listens there, which the client would find out late.
    """
    if not 1 <= port <= 65535:  # the C library takes port 99999 for 34463, where another server may listen
        raise ServerError(f"no CARLA server at {host}:{port}: a port is a number from 1 to 65535; see --port")
    try:
        socket.create_connection((host, port), timeout=REACH_S).close()
    except OSError as error:
        reason = getattr(error, "strerror", None) or error
        raise ServerError(f"no CARLA server at {host}:{port}: {reason}; start one, or see --host and --port") from error
    return SimulatorServer(host, port)


def connect(server: SimulatorServer, timeout_s: float) -> Any:
    """Return a connected client.

    Raises:
        ServerError: The versions differ, or the server does not answer.
    """
    import carla

    client = carla.Client(server.host, server.port)
    client.set_timeout(timeout_s)
    _check_versions(client)
    return client


def check_remote(host: str, port: int) -> None:
    """Ask a running server for its version.

    Raises:
        ServerError: It cannot be used.
    """
    try:
        connect(remote_server(host, port), REACH_S)
    except ServerError as error:
        place = f"{host}:{port}"
        raise ServerError(str(error) if place in str(error) else f"{place}: {error}") from error


def _check_versions(client: carla.Client) -> None:
    """Check that a client and its server have the same version.

    Raises:
        ServerError: They differ, or it is not a CARLA server.
    """
    try:
        ours, theirs = str(client.get_client_version()), str(client.get_server_version())
    except RuntimeError as error:
        # The client library reports a missing or foreign server with a bare `RuntimeError`.
        raise ServerError(f"the program that listens there does not answer like a CARLA server: {error}") from error
    if ours != theirs:
        raise ServerError(f"the carla client is {ours} but the server is {theirs}: pip install carla=={theirs}")
