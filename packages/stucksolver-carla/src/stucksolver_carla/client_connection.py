"""Connects to a running CARLA server, and reports the reason and the remedy if that fails."""

from __future__ import annotations

import socket
import subprocess
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import carla

CONNECT_LIMIT_S = 5.0
"""Time limit for a connection and for the answer to a version request (s). Ours."""


class ServerError(RuntimeError):
    """The simulator cannot be used: it did not start, has ended, or does not answer. The message gives the reason."""


@dataclass(frozen=True)
class SimulatorServer:
    """The address of a simulator, and its process if it was started here."""

    host: str
    port: int
    process: subprocess.Popen[str] | None = None

    def check(self) -> None:
        """Check that the process is running, if it was started here.

        Raises:
            ServerError: The process has ended.
        """
        if self.process is not None and self.process.poll() is not None:
            raise ServerError(f"the simulator ended with exit code {self.process.returncode}; run the command again")


def remote_server(host: str, port: int) -> SimulatorServer:
    """Return a server that is already running.

    Raises:
        ServerError: No program listens there. The client alone would report this only after its time limit.
    """
    # The C library would connect to port 34463 for 99999, where another server may listen.
    if not 1 <= port <= 65535:
        raise ServerError(f"no CARLA server at {host}:{port}: a port is a number from 1 to 65535; see --port")
    try:
        socket.create_connection((host, port), timeout=CONNECT_LIMIT_S).close()
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
    """Connect to a running server and compare the versions.

    Raises:
        ServerError: The server does not answer, or its version differs from the client's.
    """
    try:
        connect(remote_server(host, port), CONNECT_LIMIT_S)
    except ServerError as error:
        address = f"{host}:{port}"
        raise ServerError(str(error) if address in str(error) else f"{address}: {error}") from error


def _check_versions(client: carla.Client) -> None:
    """Check that a client and its server have the same version.

    Raises:
        ServerError: They differ, or the program at this address is not a CARLA server.
    """
    try:
        client_version, server_version = str(client.get_client_version()), str(client.get_server_version())
    except RuntimeError as error:
        # The client library reports a missing or foreign server with a plain `RuntimeError`.
        raise ServerError(f"the program at this address does not answer like a CARLA server: {error}") from error
    if client_version != server_version:
        raise ServerError(
            f"the carla client has version {client_version}, the server has version {server_version}: "
            f"pip install carla=={server_version}"
        )
