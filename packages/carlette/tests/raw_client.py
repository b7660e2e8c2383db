"""A client of its own making, to send what the real one never would."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from typing import Any

import msgpack

SYNCHRONOUS = [True, False, [True, 0.05], True, 0.1, 1, 0, True, 1, 1, True]
IMU = [1, "sensor.other.imu", []]
NOWHERE = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
LIMIT_S = 60.0
"""Who takes longer than that hangs; a busy machine may need many seconds."""


class Raw:
    """One connection to the request port."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=LIMIT_S)
        self.unpacker = msgpack.Unpacker()
        self.number = 0
        self.usual_s = 0.0
        """How long some ticks take when nobody else is there, for tests that look at the time."""

    def call(self, method: str, *arguments: Any) -> tuple[Any, Any]:
        """The error and the result of a call."""
        return self.call_together((method, *arguments))[0]

    def call_together(self, *calls: tuple[Any, ...]) -> list[tuple[Any, Any]]:
        """The error and the result of each of some calls that are sent at once."""
        first = self.number + 1
        self.number += len(calls)
        requests = [[0, first + i, method, [[False], *arguments]] for i, (method, *arguments) in enumerate(calls)]
        self.socket.sendall(b"".join(map(msgpack.packb, requests)))
        found: dict[int, tuple[Any, Any]] = {}
        while len(found) < len(calls):
            for kind, number, error, result in self.unpacker:
                assert kind == 1 and first <= number <= self.number
                found[number] = (error, result)
            if len(found) < len(calls):
                data = self.socket.recv(65536)
                assert data, "the server closed the connection"
                self.unpacker.feed(data)
        return [found[number] for number in sorted(found)]


def open_stream(port: int, stream_id: int) -> socket.socket:
    """A subscription to a stream of the server with this request port."""
    stream = socket.create_connection(("127.0.0.1", port + 1), timeout=LIMIT_S)
    stream.sendall(stream_id.to_bytes(4, "little"))
    return stream


def places(stream: socket.socket, actor_id: int, last_frame: int) -> Iterator[tuple[int, float]]:
    """The frame and the actor's x of each snapshot on a world stream, up to one frame."""
    frame = 0
    while frame < last_frame:
        (size,) = struct.unpack("<I", exactly(stream, 4))
        message = exactly(stream, size)
        frame = struct.unpack_from("<Q", message, 8)[0]
        records = [message[at : at + 119] for at in range(84, size, 119)]
        yield (
            frame,
            next(
                struct.unpack_from("<f", record, 5)[0]
                for record in records
                if record[:4] == struct.pack("<I", actor_id)
            ),
        )


def exactly(stream: socket.socket, size: int) -> bytes:
    """The next bytes of a stream."""
    data = b""
    while len(data) < size:
        more = stream.recv(size - len(data))
        assert more, "the server closed the stream"
        data += more
    return data
