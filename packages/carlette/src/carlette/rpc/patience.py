"""How long, and for how much, the server keeps a peer that does not come to an end."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, TypeVar

UNFINISHED_S = 60.0
"""A request must be complete this long after its first byte: time for the largest map at 20 Mbit/s."""
UNNAMED_S = 60.0
"""A peer of the streaming port must say which stream it wants; the client does so at once."""
MOST_HELD_BYTES = 256 << 20
"""Of all connections together: one map of the largest size and as much again."""


class Client(Protocol):
    """A connection to the request port."""

    @property
    def unfinished_since(self) -> float | None:
        """When the request began that is not answered yet (s, monotonic)."""

    @property
    def held_bytes(self) -> int:
        """How much waits to be sent to it."""


class Listener(Protocol):
    """A connection to the streaming port."""

    @property
    def stream_id(self) -> int:
        """The stream that it listens to."""

    @property
    def came(self) -> float:
        """When it came (s, monotonic)."""


C = TypeVar("C", bound=Client)
L = TypeVar("L", bound=Listener)


def overstayed(clients: Iterable[C], now: float) -> Iterator[tuple[C, str]]:
    """Those whose request has been unfinished for too long, and those who hold most while all hold too much."""
    left = []
    for one in clients:
        if one.unfinished_since is not None and now - one.unfinished_since > UNFINISHED_S:
            yield one, f"its request is not complete after {UNFINISHED_S:g} s"
        else:
            left.append(one)
    total = sum(one.held_bytes for one in left)
    for one in sorted(left, key=lambda client: client.held_bytes, reverse=True):
        if total <= MOST_HELD_BYTES:
            return
        total -= one.held_bytes
        yield one, f"it holds {one.held_bytes:,} bytes, and all clients together more than {MOST_HELD_BYTES:,}"


def unnamed(listeners: Iterable[L], now: float) -> list[L]:
    """Those who have not said for too long which stream they want."""
    return [one for one in listeners if not one.stream_id and now - one.came > UNNAMED_S]
