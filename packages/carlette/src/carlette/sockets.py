"""Listens on two neighboring ports, and sets the options of accepted sockets."""

from __future__ import annotations

import socket

from carlette.errors import StartupError

FREE_PORT_TRIES = 50
"""Number of free ports that are tried for a pair. Ours."""


def prepared(sock: socket.socket) -> socket.socket | None:
    """Return an accepted socket, ready to be served; None if its peer has already disconnected."""
    sock.setblocking(False)
    try:
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # Detect a machine that disappeared without closing the connection.
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    except OSError:
        # The peer has already disconnected.
        sock.close()
        return None
    return sock


def listen_pair(host: str, port: int) -> tuple[socket.socket, socket.socket]:
    """Return sockets on `port` and the next one (0: any free pair).

    Raises:
        StartupError: No such pair is free.
    """
    if port:
        first = _listen(host, port)
        try:
            return first, _listen(host, port + 1)
        except StartupError:
            first.close()
            raise
    for _ in range(FREE_PORT_TRIES):
        first = _listen(host, 0)
        number = int(first.getsockname()[1])
        try:
            return first, _listen(host, number + 1)
        except StartupError:
            # The next port is taken; the loop tries another pair.
            first.close()
    raise StartupError(f"no two neighboring ports are free: {host}. Name one with --port")


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    sock = socket.socket(family, socket.SOCK_STREAM)
    try:
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        sock.bind((host, port))
        sock.listen(64)
    except (OSError, OverflowError) as error:
        sock.close()
        reason = getattr(error, "strerror", None) or str(error)
        raise StartupError(f"cannot listen: {host}:{port} ({reason}). Choose another with --port or --host") from None
    sock.setblocking(False)
    return sock
