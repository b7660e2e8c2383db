"""Answers that wait until something is built, while all other requests are served."""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from carlette.rpc.connection import RpcConnection

LONGEST_HOLD_S = 3.0
"""The client's own patience is 5 s, unless it says otherwise; after this the answer comes before the first picture."""


@dataclass
class Held:
    """An answer, and what it waits for."""

    connection: RpcConnection
    number: int
    result: Any
    until: Sequence[Future[None]]
    due: float
    """Given at this time, whatever happens."""
    rest_s: float
    """Between what it waits for and the answer."""
    is_resting: bool = False


class HeldAnswers:
    """Answers that are not given yet; `woken` becomes readable when one may have become due."""

    def __init__(self) -> None:
        self.woken, self._waker = socket.socketpair()
        self.woken.setblocking(False)
        self._waker.setblocking(False)
        self._held: list[Held] = []

    def hold(
        self,
        connection: RpcConnection,
        number: int,
        result: Any,
        until: Sequence[Future[None]],
        longest_s: float = LONGEST_HOLD_S,
        rest_s: float = 0.0,
    ) -> None:
        """Keeps an answer until the futures are done and a rest is over, but not for long.

        `woken` becomes readable for each of them, also when the answer could not wait for it.
        """
        self._held.append(Held(connection, number, result, until, time.monotonic() + longest_s, rest_s))
        for one in until:
            one.add_done_callback(self._wake)

    def release(self, now: float) -> None:
        """Gives the answers that are due."""
        for one in self._held:
            if not one.is_resting and all(future.done() for future in one.until):
                one.is_resting, one.due = True, now + one.rest_s
        due = [one for one in self._held if now >= one.due]
        self._held = [one for one in self._held if now < one.due]
        for one in due:
            one.connection.reply(one.number, one.result)

    def forget(self, connection: RpcConnection) -> None:
        """Drops the answers for a client that has gone."""
        self._held = [one for one in self._held if one.connection is not connection]

    def wait_s(self, now: float, most_s: float) -> float:
        """How long nothing becomes due by time alone."""
        return max(0.0, min([most_s, *(one.due - now for one in self._held)]))

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
