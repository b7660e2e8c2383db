"""The client's TrafficManager for one process: made when it is first wanted, seeded for every run."""

from __future__ import annotations

import socket
from typing import Any


class Traffic:
    """Holds the traffic manager of this process, on a port of its own."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._manager: Any | None = None

    def manager(self, seed: int) -> Any:
        """The manager in synchronous mode with a seed."""
        if self._manager is None:
            self._manager = self._client.get_trafficmanager(_free_port())
        self._manager.set_synchronous_mode(True)
        self._manager.set_random_device_seed(seed)
        return self._manager

    def close(self) -> None:
        """Leave synchronous mode, so that nobody waits for our ticks."""
        if self._manager is not None:
            self._manager.set_synchronous_mode(False)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
