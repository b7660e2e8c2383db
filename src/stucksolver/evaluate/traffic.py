"""The client's TrafficManager for one process, and the watch that frees it from its own lost wake-up."""

from __future__ import annotations

import socket
import threading
import time
from typing import Any

STALLED_S = 1.5


class Traffic:
    """Makes the traffic manager when it is first wanted, and ticks the world without ever hanging in it.

    CARLA's `TrafficManagerLocal` (0.9.15, 0.9.16) notifies its worker without holding the mutex, so that a wake-up
    is lost now and then, more often on a busy machine, and `world.tick()` never returns. Leaving synchronous mode
    notifies the worker again: a thread here does that when a tick stalls, which runs the very step that was missed.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self._manager: Any | None = None
        self._tick_started_s: float | None = None
        self._closed = threading.Event()
        self.rescues = 0
        """How often a stalled tick was freed."""

    def manager(self, seed: int) -> Any:
        """The manager in synchronous mode with a seed."""
        if self._manager is None:
            self._manager = self._client.get_trafficmanager(_free_port())
            threading.Thread(target=self._watch, name="traffic-watch", daemon=True).start()
        self._manager.set_synchronous_mode(True)
        self._manager.set_random_device_seed(seed)
        return self._manager

    def tick(self, world: Any) -> None:
        """`world.tick()`. Raises `RuntimeError` when the server does not answer."""
        self._tick_started_s = time.monotonic()
        try:
            world.tick()
        finally:
            self._tick_started_s = None

    def close(self) -> None:
        """Leave synchronous mode and end the watch."""
        self._closed.set()
        if self._manager is not None:
            self._manager.set_synchronous_mode(False)

    def _watch(self) -> None:
        while not self._closed.wait(0.25):
            started = self._tick_started_s
            if started is not None and time.monotonic() - started > STALLED_S and self._manager is not None:
                self.rescues += 1
                self._manager.set_synchronous_mode(False)
                self._manager.set_synchronous_mode(True)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
