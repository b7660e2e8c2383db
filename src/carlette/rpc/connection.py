"""One client's connection to the request port: msgpack-rpc over a non-blocking socket."""

from __future__ import annotations

import logging
import socket
from collections.abc import Callable
from typing import Any

import msgpack

MAX_MESSAGE_BYTES = 256 * 1024 * 1024
"""OpenDRIVE texts arrive in one message."""
READ_BYTES = 1 << 20
MAX_UNREAD_BYTES = 256 * 1024 * 1024
"""A client that asks and never reads its answers is dropped here."""

BAD_BYTES = (msgpack.UnpackException, ValueError, TypeError, OverflowError, RecursionError, MemoryError)
"""What reading bytes that are no request raises; a map with a list as its key, for one, is a TypeError."""

log = logging.getLogger(__name__)

Dispatch = Callable[["RpcConnection", int, str, list[Any]], None]


class RpcConnection:
    """Reads requests, hands them to `dispatch` in order, and writes replies."""

    def __init__(self, sock: socket.socket, dispatch: Dispatch) -> None:
        self.socket = sock
        self.host = _peer(sock)
        self.dispatch = dispatch
        self.traffic_managers: set[int] = set()
        """Ports of the traffic managers that this client registered."""
        self._unpacker = msgpack.Unpacker(
            raw=False, unicode_errors="surrogateescape", strict_map_key=False, max_buffer_size=MAX_MESSAGE_BYTES
        )
        self._packer = msgpack.Packer(unicode_errors="surrogateescape")
        self._unsent = bytearray()

    @property
    def wants_to_write(self) -> bool:
        """True while a reply could not be sent completely."""
        return bool(self._unsent)

    def read(self) -> bool:
        """Handles what has arrived; False when the connection is over."""
        try:
            data = self.socket.recv(READ_BYTES)
        except BlockingIOError:
            return True
        except OSError:
            return False
        if not data:
            return False
        try:
            self._unpacker.feed(data)
        except BAD_BYTES as error:
            log.warning("closing a connection that sends too much at once: %s", error)
            return False
        while True:
            try:
                number, method, parameters = self._next_request()
            except msgpack.OutOfData:
                return len(self._unsent) <= MAX_UNREAD_BYTES
            except BAD_BYTES as error:
                log.warning("closing a connection that does not speak msgpack-rpc: %s", error)
                return False
            # The first parameter is the caller's metadata: whether it waits for the reply.
            self.dispatch(self, number, method, parameters[1:])

    def _next_request(self) -> tuple[int, str, list[Any]]:
        """Id, method and parameters; raises `OutOfData` where none is complete, and `BAD_BYTES` for anything else."""
        message = self._unpacker.unpack()
        if not (isinstance(message, list) and len(message) == 4 and message[0] == 0):
            raise ValueError("a message is not a request [0, id, method, parameters]")
        _, number, method, parameters = message
        if not (isinstance(method, str) and isinstance(number, int) and isinstance(parameters, list)):
            raise ValueError("a request's id, method or parameters have the wrong type")
        return number, method, parameters

    def reply(self, number: int, result: Any, error: str | None = None) -> None:
        """Answers request `number`."""
        self._unsent += self._packer.pack([1, number, error, result])
        self.write()

    def write(self) -> None:
        """Sends as much as the socket takes."""
        try:
            sent = self.socket.send(self._unsent)
        except BlockingIOError:
            return
        except OSError:
            # The peer is gone; the read side notices and closes.
            self._unsent.clear()
            return
        del self._unsent[:sent]


def _peer(sock: socket.socket) -> str:
    """The other end's address; empty when it has gone since it was accepted."""
    try:
        return str(sock.getpeername()[0])
    except OSError:
        return ""
