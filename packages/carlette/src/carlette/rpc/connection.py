"""One client's connection to the request port: msgpack-rpc over a non-blocking socket."""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Callable
from typing import Any

import msgpack

from carlette.rpc.request_framing import BAD_BYTES, RequestBuffer

READ_BYTES = 1 << 20
"""Maximum number of bytes per read. Ours."""
MOST_UNREAD_BYTES = 16 << 20
"""Size of the unread answers above which a client's further requests wait (bytes). Ours."""
LONGEST_TURN_S = 0.25
"""Time after which the requests of other clients come first (s). Ours."""

log = logging.getLogger(__name__)

Dispatch = Callable[["RpcConnection", int, str, list[Any]], None]


class RpcConnection:
    """Reads requests, hands them to `dispatch` in order, and writes replies."""

    def __init__(self, sock: socket.socket, dispatch: Dispatch, clock: Callable[[], float] = time.monotonic) -> None:
        self.socket = sock
        self.host = _peer(sock)
        self.dispatch = dispatch
        self.traffic_managers: set[int] = set()
        """Ports of the traffic managers that this client registered."""
        self.is_behind = False
        """True if complete requests have not been handled yet."""
        self.unfinished_since: float | None = None
        """Start of the incomplete request, on the clock (s); None without one."""
        self._clock = clock
        self._frames = RequestBuffer()
        self._packer = msgpack.Packer(unicode_errors="surrogateescape")
        self._unsent = bytearray()

    @property
    def wants_to_write(self) -> bool:
        """True while a part of a reply is not sent."""
        return bool(self._unsent)

    @property
    def is_paused(self) -> bool:
        """True while too many answers are unread, so that no further requests are handled."""
        return len(self._unsent) > MOST_UNREAD_BYTES

    @property
    def held_bytes(self) -> int:
        """Memory of the connection (bytes): requests not yet handled and answers not yet read."""
        return self._frames.held_bytes + len(self._unsent)

    def read(self) -> bool:
        """Handle the received requests for a limited time; return False when the connection has ended."""
        if not self.is_behind:
            try:
                data = self.socket.recv(READ_BYTES)
            except BlockingIOError:
                # No data is available now; the selector reports the next data.
                return True
            except OSError:
                # The connection is broken; the server closes it.
                return False
            if not data:
                return False
            try:
                self._frames.feed(data)
            except BAD_BYTES as error:
                # The rest of the stream cannot be split into requests, so the connection ends.
                log.warning("closing a connection that sends too much at once: %s", error)
                return False
        return self._handle()

    def _handle(self) -> bool:
        until = self._clock() + LONGEST_TURN_S
        finished = self.is_behind
        self.is_behind = True
        while not self.is_paused and self._clock() <= until:
            try:
                frame = self._frames.next()
                if frame is None:
                    self.is_behind = False
                    break
                number, method, parameters = _request(frame)
            except BAD_BYTES as error:
                # The bytes after a broken message cannot be interpreted, so the connection ends.
                log.warning("closing a connection that does not speak msgpack-rpc: %s", error)
                return False
            finished = True
            # The first parameter is the caller's metadata: whether it waits for the reply.
            self.dispatch(self, number, method, parameters[1:])
        self._note_the_unfinished(finished)
        return True

    def _note_the_unfinished(self, has_finished_one: bool) -> None:
        if self.is_behind or not self._frames.held_bytes:
            self.unfinished_since = None
        elif has_finished_one or self.unfinished_since is None:
            self.unfinished_since = self._clock()

    def reply(self, number: int, result: Any, error: str | None = None) -> None:
        """Answer request `number`."""
        self._unsent += self._packer.pack([1, number, error, result])
        self.write()

    def write(self) -> None:
        """Send as much as the socket takes."""
        try:
            sent = self.socket.send(self._unsent)
        except BlockingIOError:
            # The socket is full; the selector reports when it accepts data again.
            return
        except OSError:
            # The peer is gone. The read side detects it and closes.
            self._unsent.clear()
            return
        del self._unsent[:sent]


def _request(frame: bytes) -> tuple[int, str, list[Any]]:
    """Return id, method and parameters; raise `BAD_BYTES` for anything but a request."""
    message = msgpack.unpackb(frame, raw=False, unicode_errors="surrogateescape", strict_map_key=False)
    if not (isinstance(message, list) and len(message) == 4 and message[0] == 0):
        raise ValueError("a message is not a request [0, id, method, parameters]")
    _, number, method, parameters = message
    if not (isinstance(method, str) and isinstance(number, int) and isinstance(parameters, list)):
        raise ValueError("a request's id, method or parameters have the wrong type")
    return number, method, parameters


def _peer(sock: socket.socket) -> str:
    """Return the address of the other end; empty if it has disconnected since it was accepted."""
    try:
        return str(sock.getpeername()[0])
    except OSError:
        # The peer has disconnected; the next read closes the connection.
        return ""
