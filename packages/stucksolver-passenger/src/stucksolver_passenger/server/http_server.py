"""Runs an application with uvicorn: each connection gets a place, and TLS handshakes count as well."""

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

from stucksolver_passenger.server.connection_limits import Place, PlaceLimits, Places
from stucksolver_passenger.server.request_filter import PLACE, App

ACCEPTED_AT_ONCE = 64
"""Connections that the event loop accepts before it serves those it has. asyncio calls it the backlog."""
ACCEPT_QUEUE = 4096
"""Connections that the system keeps until they are accepted; it may allow fewer (`net.core.somaxconn`)."""
OPEN_FILES = 4096
"""Soft limit of open files that the server sets for its process, if the hard limit allows it."""
FILES_PER_WAITING = 4
"""With fewer open files, a fourth of them is for connections without a token."""
SILENT_S = 1
"""The system holds back a connection on which nothing was sent for about this long (s), so that requests come first.
Longer would fill the system's queue.
"""
UNSENT_MS = 30_000
"""A client that takes nothing for this long is gone (RFC 5482)."""
HEAD_BYTES = 16 * 1024


class Connection(asyncio.Protocol):
    """One connection: it takes a place, shakes hands if there is TLS, and then passes everything to uvicorn."""

    places: Places
    tls: ssl.SSLContext | None

    def __init__(self, **uvicorns: Any) -> None:
        self._uvicorns = uvicorns
        self._http: H11Protocol | None = None
        self._place: Place | None = None
        self._transport: asyncio.Transport | None = None
        """None until the TLS handshake is complete."""
        self._early = bytearray()
        """Received before that."""
        self._shaking: asyncio.Task[None] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Take a place."""
        assert isinstance(transport, asyncio.Transport)
        peer = transport.get_extra_info("peername")
        address = str(peer[0]) if isinstance(peer, tuple) and peer else ""
        self._place = self.places.take(address, transport.abort)
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
            # Only now: connections that stay silent cost as little as possible.
            state = {**self._uvicorns.pop("app_state"), PLACE: self._place}
            self._http = H11Protocol(app_state=state, **self._uvicorns)
            self._http.connection_made(self._transport)
        if self._place is not None:
            self._place.received(len(data))
        self._http.data_received(data)

    def eof_received(self) -> None:
        """Let the transport close: nobody sends half of a conversation."""

    def pause_writing(self) -> None:
        """Pass it on."""
        if self._http is not None:
            self._http.pause_writing()

    def resume_writing(self) -> None:
        """Pass it on."""
        if self._http is not None:
            self._http.resume_writing()

    def connection_lost(self, error: Exception | None) -> None:
        """Give the place back."""
        if self._place is not None:
            self._place.leave()
        if self._http is not None:
            self._http.connection_lost(error)

    async def _shake_hands(self, transport: asyncio.Transport, tls: ssl.SSLContext) -> None:
        loop, limit_s = asyncio.get_running_loop(), self.places.limits.request_s
        try:
            secured = await loop.start_tls(transport, self, tls, server_side=True, ssl_handshake_timeout=limit_s)
        except (OSError, EOFError, asyncio.TimeoutError):  # ssl.SSLError is an OSError
            secured = None
        if secured is None or secured.is_closing():
            if self._place is not None:
                self._place.abort()
            return
        self._begin(secured)

    def _begin(self, transport: asyncio.Transport) -> None:
        self._transport = transport
        if self._early:
            early, self._early = bytes(self._early), bytearray()
            self.data_received(early)


def make_server(app: App, limits: PlaceLimits | None = None, tls: ssl.SSLContext | None = None) -> uvicorn.Server:
    """Return a server for an application behind `Doors`, which tell the places what is asked."""
    shared = {"places": Places(limits), "tls": tls}
    config = uvicorn.Config(
        app,
        http=type("PlacedConnection", (Connection,), shared),
        log_level="error",
        access_log=False,
        server_header=False,
        date_header=False,
        proxy_headers=False,
        timeout_keep_alive=int(shared["places"].limits.idle_s) + 1,  # type: ignore[union-attr]
        h11_max_incomplete_event_size=HEAD_BYTES,
        timeout_graceful_shutdown=1,
        backlog=ACCEPTED_AT_ONCE,
        ws="none",
        lifespan="on",
    )
    return uvicorn.Server(config)


async def serve(server: uvicorn.Server, listening: Sequence[socket.socket]) -> None:
    """Serve until the server is told to exit."""
    queueing = asyncio.create_task(_queue(server, listening))
    await server.serve(sockets=list(listening))
    queueing.cancel()


async def _queue(server: uvicorn.Server, listening: Sequence[socket.socket]) -> None:
    """Make the system's queue long again, which asyncio sets to what it accepts at once."""
    while not server.started:
        await asyncio.sleep(0.02)
    for item in listening:
        with contextlib.suppress(OSError):
            item.listen(ACCEPT_QUEUE)
            item.setsockopt(socket.IPPROTO_TCP, socket.TCP_DEFER_ACCEPT, SILENT_S)


def limits_here(limits: PlaceLimits | None = None) -> PlaceLimits:
    """Raise this process's soft limit of open files, and return the limits that it can keep."""
    limits = limits or PlaceLimits()
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = OPEN_FILES if hard == resource.RLIM_INFINITY else min(OPEN_FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    files = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if files == resource.RLIM_INFINITY or files // FILES_PER_WAITING >= limits.waiting:
        return limits
    return PlaceLimits(
        max(files // FILES_PER_WAITING, 1), limits.request_s, limits.idle_s, limits.answer_s, limits.ahead_bytes
    )


def tls_of(cert: str, key: str) -> ssl.SSLContext:
    """Return the context of a server with this certificate."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(cert, key)
    return context


def _drop_dead(connected: Any) -> None:
    """Let the system end the connection of a client that no longer takes what is sent, such as a phone out of range."""
    option = getattr(socket, "TCP_USER_TIMEOUT", None)
    if connected is not None and option is not None:
        with contextlib.suppress(OSError, ValueError):
            connected.setsockopt(socket.IPPROTO_TCP, option, UNSENT_MS)
