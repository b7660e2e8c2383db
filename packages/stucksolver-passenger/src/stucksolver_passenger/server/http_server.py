"""Runs an application with uvicorn. Each connection gets a slot, from its TLS handshake on."""

from __future__ import annotations

import asyncio
import contextlib
import resource
import socket
import ssl
from collections.abc import Sequence
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from stucksolver_passenger.server.connection_limits import ConnectionLimits, ConnectionSlot, ConnectionSlots
from stucksolver_passenger.server.request_filter import CONNECTION_SLOT, App

ACCEPTED_AT_ONCE = 64
"""Connections that the event loop accepts before it serves the existing ones. asyncio calls it the backlog. Ours."""
ACCEPT_QUEUE = 4096
"""Length of the system's queue of connections that are not yet accepted.

The system may limit it (`net.core.somaxconn`). Ours.
"""
OPEN_FILES = 4096
"""Soft limit of open files that the server sets for its process, if the hard limit allows it. Ours."""
FILES_PER_WAITING = 4
"""Divisor of the number of open files: a fourth of a small number is for connections without a token. Ours."""
SILENT_S = 1
"""Time for which the system holds back a connection without data (s), so that requests come first.

A longer one would fill the system's queue. Ours.
"""
UNSENT_MS = 30_000
"""Time without acknowledged data after which a client counts as gone (ms; RFC 5482). Ours."""
HEAD_BYTES = 16 * 1024
"""Longest head of a request (bytes). Ours."""


class Connection(asyncio.Protocol):
    """One connection. It takes a slot, does the TLS handshake if needed, and then passes all data to uvicorn."""

    slots: ConnectionSlots
    tls: ssl.SSLContext | None

    def __init__(self, **uvicorns: Any) -> None:
        self._uvicorns = uvicorns
        self._http: H11Protocol | None = None
        self._slot: ConnectionSlot | None = None
        self._transport: asyncio.Transport | None = None
        """None until the TLS handshake is complete."""
        self._early = bytearray()
        """Data received before that."""
        self._shaking: asyncio.Task[None] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take a slot."""
        assert isinstance(transport, asyncio.Transport)
        peer = transport.get_extra_info("peername")
        address = str(peer[0]) if isinstance(peer, tuple) and peer else ""
        self._slot = self.slots.take(address, transport.abort)
        _drop_dead(transport.get_extra_info("socket"))
        if self.tls is None:
            self._begin(transport)
        else:
            self._shaking = asyncio.get_running_loop().create_task(self._shake_hands(transport, self.tls))

    def data_received(self, data: bytes) -> None:
        """Pass bytes on."""
        if self._transport is None:
            self._early += data
            return
        if self._http is None:
            # The protocol is created at the first data, so that a silent connection costs as little as possible.
            state = {**self._uvicorns.pop("app_state"), CONNECTION_SLOT: self._slot}
            self._http = H11Protocol(app_state=state, **self._uvicorns)
            self._http.connection_made(self._transport)
        if self._slot is not None:
            self._slot.received(len(data))
        self._http.data_received(data)

    def eof_received(self) -> None:
        """Let the transport close. The server does not support half-closed connections."""

    def pause_writing(self) -> None:
        """Forward the call."""
        if self._http is not None:
            self._http.pause_writing()

    def resume_writing(self) -> None:
        """Forward the call."""
        if self._http is not None:
            self._http.resume_writing()

    def connection_lost(self, error: Exception | None) -> None:
        """Release the slot."""
        if self._slot is not None:
            self._slot.leave()
        if self._http is not None:
            self._http.connection_lost(error)

    async def _shake_hands(self, transport: asyncio.Transport, tls: ssl.SSLContext) -> None:
        loop, limit_s = asyncio.get_running_loop(), self.slots.limits.request_s
        try:
            secured = await loop.start_tls(transport, self, tls, server_side=True, ssl_handshake_timeout=limit_s)
        except (OSError, EOFError, asyncio.TimeoutError):  # ssl.SSLError is an OSError
            # A failed handshake is a client's problem: the connection ends, and the server continues.
            secured = None
        if secured is None or secured.is_closing():
            if self._slot is not None:
                self._slot.abort()
            return
        self._begin(secured)

    def _begin(self, transport: asyncio.Transport) -> None:
        self._transport = transport
        if self._early:
            early, self._early = bytes(self._early), bytearray()
            self.data_received(early)


def make_server(app: App, limits: ConnectionLimits | None = None, tls: ssl.SSLContext | None = None) -> uvicorn.Server:
    """Return a server for an application that informs the slots about the requests."""
    shared = {"slots": ConnectionSlots(limits), "tls": tls}
    config = uvicorn.Config(
        app,
        http=type("PlacedConnection", (Connection,), shared),
        log_level="error",
        access_log=False,
        server_header=False,
        date_header=False,
        proxy_headers=False,
        timeout_keep_alive=int(shared["slots"].limits.idle_s) + 1,  # type: ignore[union-attr]
        h11_max_incomplete_event_size=HEAD_BYTES,
        timeout_graceful_shutdown=1,
        backlog=ACCEPTED_AT_ONCE,
        ws="none",
        lifespan="on",
    )
    return uvicorn.Server(config)


async def serve(server: uvicorn.Server, listening: Sequence[socket.socket]) -> None:
    """Serve until the server gets the order to exit."""
    queueing = asyncio.create_task(_queue(server, listening))
    await server.serve(sockets=list(listening))
    queueing.cancel()


async def _queue(server: uvicorn.Server, listening: Sequence[socket.socket]) -> None:
    """Restore the length of the system's queue.

    asyncio sets it to the number of connections that it accepts at once, so this must follow the start of the server.
    """
    while not server.started:
        await asyncio.sleep(0.02)
    for item in listening:
        # The system may not support an option; the server then works without it.
        with contextlib.suppress(OSError):
            item.listen(ACCEPT_QUEUE)
            item.setsockopt(socket.IPPROTO_TCP, socket.TCP_DEFER_ACCEPT, SILENT_S)


def limits_here(limits: ConnectionLimits | None = None) -> ConnectionLimits:
    """Raise this process's soft limit of open files, and return the limits that it can keep."""
    limits = limits or ConnectionLimits()
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = OPEN_FILES if hard == resource.RLIM_INFINITY else min(OPEN_FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        # Without permission the present limit stays; the result below follows the actual limit.
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    files = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if files == resource.RLIM_INFINITY or files // FILES_PER_WAITING >= limits.waiting:
        return limits
    return ConnectionLimits(
        max(files // FILES_PER_WAITING, 1), limits.request_s, limits.idle_s, limits.answer_s, limits.ahead_bytes
    )


def tls_of(cert: str, key: str) -> ssl.SSLContext:
    """Return the context of a server with this certificate."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(cert, key)
    return context


def _drop_dead(connected: Any) -> None:
    """Let the system end the connection of a client that acknowledges no data, such as a phone out of range."""
    option = getattr(socket, "TCP_USER_TIMEOUT", None)
    if connected is not None and option is not None:
        # The system may not support the option; the connection then ends at the limits of its slot.
        with contextlib.suppress(OSError, ValueError):
            connected.setsockopt(socket.IPPROTO_TCP, option, UNSENT_MS)
