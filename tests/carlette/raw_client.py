"""A client of its own making, to send what the real one never would."""

from __future__ import annotations

import socket
from typing import Any

import msgpack

SYNCHRONOUS = [True, False, [True, 0.05], True, 0.1, 1, 0, True, 1, 1, True]


class Raw:
    """One connection to the request port."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=5)
        self.unpacker = msgpack.Unpacker()
        self.number = 0

    def call(self, method: str, *arguments: Any) -> tuple[Any, Any]:
        """The error and the result of a call."""
        self.number += 1
        self.socket.sendall(msgpack.packb([0, self.number, method, [[False], *arguments]]))
        while True:
            for message in self.unpacker:
                kind, number, error, result = message
                assert (kind, number) == (1, self.number)
                return error, result
            data = self.socket.recv(65536)
            assert data, "the server closed the connection"
            self.unpacker.feed(data)


def open_stream(port: int, stream_id: int) -> socket.socket:
    """A subscription to a stream of the server with this request port."""
    stream = socket.create_connection(("127.0.0.1", port + 1), timeout=5)
    stream.sendall(stream_id.to_bytes(4, "little"))
    return stream
