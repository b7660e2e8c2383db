"""Answers that wait until something is built, while all other requests are served."""

from __future__ import annotations

import contextlib
import socket
import time
from concurrent.futures import Future
from typing import Any, NamedTuple

from carlette.rpc.connection import RpcConnection

LONGEST_HOLD_S = 3.0
"""The client's own patience is 5 s, unless it says otherwise; after this the answer comes before the first picture."""


class Held(NamedTuple):
    """An answer, and what it waits for."""

    connection: RpcConnection
    number: int
    result: Any
    until: Future[None]
    deadline: float


class HeldAnswers:
    """Answers that are not given yet; `woken` becomes readable when one may have become due."""

    def __init__(self) -> None:
        self.woken, self._waker = socket.socketpair()
        self.woken.setblocking(False)
        self._waker.setblocking(False)
        self._held: list[Held] = []

    def hold(self, connection: RpcConnection, number: int, result: Any, until: Future[None]) -> None:
        """Keeps an answer until the future is done, but not for long."""
        self._held.append(Held(connection, number, result, until, time.monotonic() + LONGEST_HOLD_S))
        until.add_done_callback(self._wake)

    def release(self, now: float) -> None:
        """Gives the answers that are due."""
        due = [one for one in self._held if one.until.done() or now >= one.deadline]
        self._held = [one for one in self._held if one not in due]
        for one in due:
            one.connection.reply(one.number, one.result)

    def forget(self, connection: RpcConnection) -> None:
        """Drops the answers for a client that has gone."""
        self._held = [one for one in self._held if one.connection is not connection]

    def wait_s(self, now: float, most_s: float) -> float:
        """How long nothing becomes due by time alone."""
        return max(0.0, min([most_s, *(one.deadline - now for one in self._held)]))

    def drain(self) -> None:
        """Takes note of having been woken."""
        with contextlib.suppress(BlockingIOError):
            self.woken.recv(4096)

    def close(self) -> None:
        """Frees the sockets."""
        self._waker.close()
        self.woken.close()

    def _wake(self, _: Future[None]) -> None:
        # From another thread. A full pipe wakes as well, and a server that has ended needs no waking.
        with contextlib.suppress(OSError):
            self._waker.send(b"!")
