"""The client's TrafficManager for one process: made when it is first wanted, seeded for every run.

That of the client 0.9.16 goes on driving on the map on which it was made, whatever `load_world` loads; on CARLA and on
carlette alike, since it runs in the client. One that is made afterwards, on another port, reads the new map.
"""

from __future__ import annotations

import socket
from typing import Any

from stucksolver_eval.server import set_synchronous


class Traffic:
    """Holds the traffic manager of this process, on a port of its own."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._manager: Any | None = None
        self._episode: int | None = None
        """In which the manager was made."""

    def manager(self, seed: int) -> Any:
        """The manager of the world that is loaded now, in synchronous mode with a seed."""
        episode = int(self._client.get_world().id)
        if self._manager is None or episode != self._episode:
            self._manager = self._client.get_trafficmanager(_free_port())
            self._episode = episode
        self._manager.set_synchronous_mode(True)
        self._manager.set_random_device_seed(seed)
        return self._manager

    def let_go(self, world: Any) -> None:
        """Leave a server that stays running on its own clock again, so that it does not wait for our ticks.

        Not for a server that ends with the run: a manager that is no longer synchronous goes on calling it, and the
        client library ends the process when such a call fails.
        """
        if self._manager is not None:
            self._manager.set_synchronous_mode(False)
        set_synchronous(world, None)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
