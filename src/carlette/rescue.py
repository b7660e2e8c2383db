"""Frees clients that hang in the lost wake-up of their own traffic manager.

Pacing makes the loss rare, but on a loaded machine a thread may be late by any time. A client that lost it calls
nothing any more: its main thread waits inside `world.tick()` for a worker that waits to be woken. The traffic manager
still answers on its own port, and there leaving synchronous mode wakes the worker (`TrafficManagerLocal` of CARLA
0.9.15 and 0.9.16), which then makes the very step that was missed. So a silent client is asked whether it is well,
told to leave synchronous mode, and told to enter it again.
"""

from __future__ import annotations

import logging
import socket
import threading
from collections.abc import Iterable
from typing import Any

import msgpack

STALLED_S = 0.5
"""A client in step with the server calls within microseconds of a snapshot."""
ANSWER_S = 2.0

log = logging.getLogger(__name__)


class Rescue:
    """Notices a client that went silent after the snapshot it had asked for. Times are monotonic seconds."""

    def __init__(self) -> None:
        self.count = 0
        """How often a client was freed."""
        self._waiting: tuple[float, str, tuple[int, ...]] | None = None

    def published(self, now: float, host: str, managers: Iterable[int]) -> None:
        """The snapshot that a client at `host` with these traffic manager ports cued is out."""
        ports = tuple(managers)
        self._waiting = (now, host, ports) if ports else None

    def heard(self) -> None:
        """That client called again: it is well."""
        self._waiting = None

    def look(self, now: float) -> None:
        """Free the client if it has been silent for too long; called now and then."""
        if self._waiting is None or now - self._waiting[0] < STALLED_S:
            return
        _, host, ports = self._waiting
        self._waiting = None
        threading.Thread(target=self._free, args=(host, ports), name="carlette-rescue", daemon=True).start()

    def _free(self, host: str, ports: tuple[int, ...]) -> None:
        for port in ports:
            self._wake(host, port)

    def _wake(self, host: str, port: int) -> None:
        try:
            wake(host, port)
        except (OSError, msgpack.UnpackException) as error:
            log.info("the traffic manager at %s:%d was not woken: %s", host, port, error)
            return
        self.count += 1
        log.warning("woke the traffic manager at %s:%d from a lost wake-up", host, port)


def wake(host: str, port: int) -> None:
    """Have a traffic manager leave and enter synchronous mode. Raises `OSError` when it does not answer."""
    with socket.create_connection((host, port), timeout=ANSWER_S) as sock:
        # A process that is merely stopped answers nothing, and is left alone.
        for number, (method, arguments) in enumerate(
            (("health_check_remote_TM", []), ("set_synchronous_mode", [False]), ("set_synchronous_mode", [True]))
        ):
            _call(sock, number, method, arguments)


def _call(sock: socket.socket, number: int, method: str, arguments: list[Any]) -> None:
    sock.sendall(msgpack.packb([0, number, method, arguments]))
    unpacker = msgpack.Unpacker()
    while True:
        data = sock.recv(4096)
        if not data:
            raise ConnectionError("it closed the connection")
        unpacker.feed(data)
        if next(iter(unpacker), None) is not None:
            return
