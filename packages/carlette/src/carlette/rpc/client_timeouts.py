"""How long, and with how much data, the server keeps a peer that does not finish."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, TypeVar

UNFINISHED_S = 60.0
"""A request must be complete this long after its first byte (s): enough for the largest map at 20 Mbit/s."""
UNNAMED_S = 60.0
"""Time within which a peer of the streaming port must name its stream (s); the client does so at once."""
MOST_HELD_BYTES = 256 << 20
"""Most bytes held by all connections together: twice the largest map."""


class Client(Protocol):
    """A connection to the request port."""

    @property
    def unfinished_since(self) -> float | None:
        """When the request that is not answered yet began (s, monotonic)."""

    @property
    def held_bytes(self) -> int:
        """How many bytes it holds."""


class Listener(Protocol):
    """A connection to the streaming port."""

    @property
    def stream_id(self) -> int:
        """The stream to which it listens; 0 until it has named one."""

    @property
    def came(self) -> float:
        """When it connected (s, monotonic)."""


C = TypeVar("C", bound=Client)
L = TypeVar("L", bound=Listener)


def timed_out_clients(clients: Iterable[C], now: float) -> Iterator[tuple[C, str]]:
    """Yield the clients whose request has been unfinished for too long, and the largest ones while all hold too
    much.
    """
    left = []
    for item in clients:
        if item.unfinished_since is not None and now - item.unfinished_since > UNFINISHED_S:
            yield item, f"its request is not complete after {UNFINISHED_S:g} s"
        else:
            left.append(item)
    total = sum(item.held_bytes for item in left)
    for item in sorted(left, key=lambda client: client.held_bytes, reverse=True):
        if total <= MOST_HELD_BYTES:
            return
        total -= item.held_bytes
        yield item, f"it holds {item.held_bytes:,} bytes, and all clients together more than {MOST_HELD_BYTES:,}"


def unnamed_listeners(listeners: Iterable[L], now: float) -> list[L]:
    """Return the listeners that have taken too long to name their stream."""
    return [listener for listener in listeners if not listener.stream_id and now - listener.came > UNNAMED_S]
