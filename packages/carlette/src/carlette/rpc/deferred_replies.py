"""Answers that are delayed until something is built, while all other requests are served."""

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
"""Maximum delay of an answer (s).

Ours: the client's default timeout is 5 s. Pictures that take longer come after the answer.
"""


@dataclass
class DeferredReply:
    """A delayed answer and its conditions."""

    connection: RpcConnection
    number: int
    result: Any
    until: Sequence[Future[None]]
    due: float
    """Time at which the answer is sent in any case (s, monotonic)."""
    rest_s: float
    """Time between the end of the wait and the answer (s)."""
    is_resting: bool = False


class DeferredReplies:
    """Answers that have not been sent yet. `woken` becomes readable when one may be due."""

    def __init__(self) -> None:
        self.woken, self._waker = socket.socketpair()
        self.woken.setblocking(False)
        self._waker.setblocking(False)
        self._held: list[DeferredReply] = []

    def hold(
        self,
        connection: RpcConnection,
        number: int,
        result: Any,
        until: Sequence[Future[None]],
        longest_s: float = LONGEST_HOLD_S,
        rest_s: float = 0.0,
    ) -> None:
        """Hold an answer until the futures are done and a rest time has passed, up to a time limit.

        `woken` becomes readable for each future, also if the answer was sent before it was done.
        """
        self._held.append(DeferredReply(connection, number, result, until, time.monotonic() + longest_s, rest_s))
        for item in until:
            item.add_done_callback(self._wake)

    def release(self, now: float) -> None:
        """Send the answers that are due."""
        for item in self._held:
            if not item.is_resting and all(future.done() for future in item.until):
                item.is_resting, item.due = True, now + item.rest_s
        due = [item for item in self._held if now >= item.due]
        self._held = [item for item in self._held if now < item.due]
        for item in due:
            item.connection.reply(item.number, item.result)

    def forget(self, connection: RpcConnection) -> None:
        """Drop the answers for a client that has disconnected."""
        self._held = [item for item in self._held if item.connection is not connection]

    def wait_s(self, now: float, most_s: float) -> float:
        """Return the time until the next answer is due (s), at most `most_s`. It ignores the futures."""
        return max(0.0, min([most_s, *(item.due - now for item in self._held)]))

    def drain(self) -> None:
        """Clear the wake-up signal."""
        # The signal may be empty: an answer can be due by time alone.
        with contextlib.suppress(BlockingIOError):
            self.woken.recv(4096)

    def close(self) -> None:
        """Free the sockets."""
        self._waker.close()
        self.woken.close()

    def _wake(self, _: Future[None]) -> None:
        # Called from other threads. A full pipe also wakes the server, and a server that has ended needs no signal.
        with contextlib.suppress(OSError):
            self._waker.send(b"!")
