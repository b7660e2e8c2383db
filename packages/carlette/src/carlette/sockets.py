"""Listening on two neighbouring ports, and what every accepted socket is set to."""

from __future__ import annotations

import socket

from carlette.errors import UsageError

FREE_PORT_TRIES = 50


def prepared(sock: socket.socket) -> socket.socket | None:
    """An accepted socket, ready to be served; None where its peer has gone already."""
    sock.setblocking(False)
    try:
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        # A machine that went away without a word is noticed in the end.
        sock.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    except OSError:
        sock.close()
        return None
    return sock


def listen_pair(host: str, port: int) -> tuple[socket.socket, socket.socket]:
    """Sockets on `port` and the one after it (0 = any free pair); raises `UsageError` where it cannot."""
    if port:
        first = _listen(host, port)
        try:
            return first, _listen(host, port + 1)
        except UsageError:
            first.close()
            raise
    for _ in range(FREE_PORT_TRIES):
        first = _listen(host, 0)
        number = int(first.getsockname()[1])
        try:
            return first, _listen(host, number + 1)
        except UsageError:
            first.close()
    raise UsageError(f"no two neighbouring ports are free on {host}; name one with --port")


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
        raise UsageError(f"cannot listen on {host}:{port}: {reason}; choose another with --port or --host") from None
    sock.setblocking(False)
    return sock
