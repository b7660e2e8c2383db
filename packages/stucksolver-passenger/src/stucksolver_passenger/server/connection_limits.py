"""Places for connections.

Connections without a token get few slots for a short time, so that they cannot occupy the server.
"""

from __future__ import annotations

import asyncio
import ipaddress
from collections import Counter, OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from enum import Enum

MAPPED_PREFIX = 64
"""Prefix length of the IPv6 network that usually belongs to one client (RFC 6177)."""


@dataclass(frozen=True)
class ConnectionLimits:
    """Limits of a server's connections."""

    waiting: int = 400
    """Maximum number of connections without a request with a valid token.

    A new connection replaces the oldest one of the address with the most connections. Ours.
    """
    request_s: float = 10.0
    """Time from the first to the last byte of a request, including the TLS handshake (s). Ours."""
    idle_s: float = 30.0
    """Time without a request (s). Ours."""
    answer_s: float = 120.0
    """Time for sending an answer (s): 40 MB, the recognizer's files, at 2.7 Mbit/s. Ours."""
    ahead_bytes: int = 64 * 1024
    """Maximum number of bytes that a client may send before its previous request is answered. Ours."""


class Phase(Enum):
    """State of a connection."""

    IDLE = "idle"
    REQUEST = "request"
    ANSWER = "answer"


class ConnectionSlot:
    """The slot of one connection, from its first byte to its end. Only one event loop may use it."""

    def __init__(self, slots: ConnectionSlots, source: str, abort: Callable[[], None]) -> None:
        self.source = source
        self.held_for: tuple[Hashable, ...] = ()
        """The shares that count this connection while a request with a valid token is served."""
        self._slots = slots
        self._abort = abort
        self._phase = Phase.REQUEST
        self._ahead = 0
        self._timer: asyncio.TimerHandle | None = None
        self._left = False
        self._within(slots.limits.request_s)

    def received(self, count: int) -> None:
        """Record that the client sent `count` bytes."""
        if self._phase is Phase.IDLE:
            self._phase = Phase.REQUEST
            self._within(self._slots.limits.request_s)
        elif self._phase is Phase.ANSWER:
            self._ahead += count
            if self._ahead > self._slots.limits.ahead_bytes:
                self.abort()

    def hold(self, *shares: tuple[Hashable, int]) -> bool:
        """Protect this connection from replacement by newer ones until its answer is sent.

        Args:
            shares: Names of shares, and the number of connections that each may hold.

        Returns:
            False if a share is used up: the connection is served all the same, but a newer one may replace it.
        """
        return not self._left and self._slots.hold(self, shares)

    def request_read(self) -> None:
        """Record that the request is complete."""
        self._phase = Phase.ANSWER
        self._within(self._slots.limits.answer_s)

    def stays(self) -> None:
        """Record that the answer is a stream without an end."""
        self._within(None)

    def answered(self) -> None:
        """Record that the answer is sent."""
        if self._left:
            return
        self._phase, self._ahead = Phase.IDLE, 0
        self._within(self._slots.limits.idle_s)
        self._slots.release(self)

    def leave(self) -> None:
        """Record that the connection has ended. Repeated calls do nothing."""
        if not self._left:
            self._left = True
            self._within(None)
            self._slots.remove(self)

    def abort(self) -> None:
        """End the connection at once."""
        self.leave()
        self._abort()

    def _within(self, limit_s: float | None) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._timer = None
        if limit_s is not None and not self._left:
            self._timer = asyncio.get_running_loop().call_later(limit_s, self.abort)


class ConnectionSlots:
    """All slots of a server."""

    def __init__(self, limits: ConnectionLimits | None = None) -> None:
        self.limits = limits or ConnectionLimits()
        self._waiting: dict[str, OrderedDict[ConnectionSlot, None]] = {}
        """Connections by address, the oldest first."""
        self._count = 0
        self._held: Counter[Hashable] = Counter()

    def take(self, address: str, abort: Callable[[], None]) -> ConnectionSlot:
        """Give a new connection from an address a slot. `abort` ends the connection."""
        slot = ConnectionSlot(self, source_of(address), abort)
        self._wait(slot)
        return slot

    def hold(self, slot: ConnectionSlot, shares: tuple[tuple[Hashable, int], ...]) -> bool:
        """Stop counting a slot as waiting, if none of the shares is used up."""
        if slot.held_for:
            return True
        if any(self._held[name] >= most for name, most in shares):
            return False
        self._unwait(slot)
        slot.held_for = tuple(name for name, _ in shares)
        self._held.update(slot.held_for)
        return True

    def release(self, slot: ConnectionSlot) -> None:
        """Count a slot as waiting again, as the newest."""
        if slot.held_for:
            self._unhold(slot)
        else:
            self._unwait(slot)
        self._wait(slot)

    def remove(self, slot: ConnectionSlot) -> None:
        """Remove a slot."""
        if slot.held_for:
            self._unhold(slot)
        else:
            self._unwait(slot)

    @property
    def waiting(self) -> int:
        """Number of connections without a valid token."""
        return self._count

    def _wait(self, slot: ConnectionSlot) -> None:
        self._waiting.setdefault(slot.source, OrderedDict())[slot] = None
        self._count += 1
        if self._count > self.limits.waiting:
            crowded = max(self._waiting.values(), key=len)
            next(iter(crowded)).abort()

    def _unwait(self, slot: ConnectionSlot) -> None:
        here = self._waiting.get(slot.source, OrderedDict())
        if slot in here:
            del here[slot]
            self._count -= 1
            if not here:
                del self._waiting[slot.source]

    def _unhold(self, slot: ConnectionSlot) -> None:
        self._held.subtract(slot.held_for)
        self._held += Counter()  # removes entries of zero
        slot.held_for = ()


def source_of(address: str) -> str:
    """Return the key of one client: an IPv4 address, or the network of an IPv6 address."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        # Names such as those of the test client have no network.
        return address
    if isinstance(found, ipaddress.IPv6Address):
        if found.ipv4_mapped is not None:
            return str(found.ipv4_mapped)
        return str(ipaddress.ip_network((found, MAPPED_PREFIX), strict=False))
    return str(found)
