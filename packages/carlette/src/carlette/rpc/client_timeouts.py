"""Limits of time and data for peers that do not finish a request."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, TypeVar

UNFINISHED_S = 60.0
"""Time within which a request must be complete after its first byte (s).

Ours; enough for the largest map at 20 Mbit/s.
"""
UNNAMED_S = 60.0
"""Time within which a peer of the streaming port must name its stream (s). Ours; the client does so at once."""
MOST_HELD_BYTES = 256 << 20
"""Maximum number of bytes that all connections together may hold. Ours: twice the largest map."""


class Client(Protocol):
    """A connection to the request port."""

    @property
    def unfinished_since(self) -> float | None:
        """Start of the request that is not answered yet (s, monotonic); None without one."""

    @property
    def held_bytes(self) -> int:
        """Number of bytes that the connection holds."""


class Listener(Protocol):
    """A connection to the streaming port."""

    @property
    def stream_id(self) -> int:
        """Stream of the connection; 0 until the peer has named one."""

    @property
    def came(self) -> float:
        """Time of the connection (s, monotonic)."""


C = TypeVar("C", bound=Client)
L = TypeVar("L", bound=Listener)


def timed_out_clients(clients: Iterable[C], now: float) -> Iterator[tuple[C, str]]:
    """Yield the clients with a request that is too old. If all hold too much, also yield the largest."""
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
