"""Addresses of traffic managers: they run in a client's process and only register here."""

from __future__ import annotations

from typing import Any

from carlette.errors import RequestError
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession

methods = Methods()

LONGEST_ADDRESS = 255
"""Longest address of a traffic manager (characters)."""
LAST_PORT = 65535
"""Highest port number."""


@methods.value("is_traffic_manager_running")
def is_traffic_manager_running(session: ClientSession, port: int) -> bool:
    return port in session.simulator.traffic_managers


@methods.value("get_traffic_manager_running")
def get_traffic_manager_running(session: ClientSession, port: int) -> Any:
    address = session.simulator.traffic_managers.get(port)
    return ["", 0] if address is None else [address, port]


@methods.value("add_traffic_manager_running")
def add_traffic_manager_running(session: ClientSession, endpoint: list[Any]) -> bool:
    """Register the address of a client's TrafficManager; return False if the port is taken.

    Raises:
        RequestError: The port or the address is not valid.
    """
    address, port = str(endpoint[0]), int(endpoint[1])
    if not 0 < port <= LAST_PORT or len(address) > LONGEST_ADDRESS:
        raise RequestError(
            f"add_traffic_manager_running: port {port} at '{address[:40]}'; give a port from 1 to {LAST_PORT} "
            f"and an address of at most {LONGEST_ADDRESS} characters"
        )
    if port in session.simulator.traffic_managers:
        return False
    session.simulator.traffic_managers[port] = address
    session.connection.traffic_managers.add(port)
    return True


@methods.value("destroy_traffic_manager")
def destroy_traffic_manager(session: ClientSession, port: int) -> bool:
    session.connection.traffic_managers.discard(port)
    return session.simulator.traffic_managers.pop(port, None) is not None
