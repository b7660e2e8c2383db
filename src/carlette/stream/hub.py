"""Who gets which stream: subscribers announce a stream's id and then only read."""

from __future__ import annotations

import socket
import struct

MAX_BACKLOG_BYTES = 64 * 1024 * 1024
"""A subscriber that lags this far behind is dropped (it reconnects by itself)."""

_SIZE = struct.Struct("<I")


class Subscriber:
    """One connection to the streaming port."""

    def __init__(self, sock: socket.socket) -> None:
        self.socket = sock
        self.stream_id = 0
        """0 until the client has sent the id."""
        self._received = b""
        self._unsent = bytearray()

    @property
    def wants_to_write(self) -> bool:
        """True while a message could not be sent completely."""
        return bool(self._unsent)

    def read(self) -> bool:
        """Takes the stream id; False when the connection is over."""
        try:
            data = self.socket.recv(64)
        except BlockingIOError:
            return True
        except OSError:
            return False
        if not data:
            return False
        if not self.stream_id:
            self._received += data
            if len(self._received) >= _SIZE.size:
                self.stream_id = _SIZE.unpack_from(self._received)[0]
        return True

    def send(self, framed: bytes) -> None:
        """Queues a message that carries its size already, and sends what the socket takes."""
        self._unsent += framed
        self.write()

    @property
    def lags(self) -> bool:
        """True when the reader is so far behind that it must be dropped."""
        return len(self._unsent) > MAX_BACKLOG_BYTES

    def write(self) -> None:
        """Sends as much as the socket takes."""
        try:
            sent = self.socket.send(self._unsent)
        except BlockingIOError:
            return
        except OSError:
            self._unsent.clear()
            return
        del self._unsent[:sent]


class Hub:
    """All subscribers by stream."""

    def __init__(self) -> None:
        self.subscribers: set[Subscriber] = set()
        self.awaited: set[int] = set()
        """Streams whose token was asked for and whose subscriber has not come yet."""

    def expect(self, stream_id: int) -> None:
        """A client asked for the token of a stream: it is about to subscribe."""
        self.awaited.add(stream_id)

    def arrived(self, subscriber: Subscriber) -> None:
        """A subscriber has announced its stream."""
        self.awaited.discard(subscriber.stream_id)

    def publish(self, stream_id: int, *parts: bytes | bytearray | memoryview) -> None:
        """Sends one message to all subscribers of a stream."""
        readers = [one for one in self.subscribers if one.stream_id == stream_id]
        if readers:
            framed = b"".join((_SIZE.pack(sum(map(len, parts))), *parts))
            for one in readers:
                one.send(framed)

    def listens(self, stream_id: int) -> bool:
        """True when somebody subscribed to a stream."""
        return any(one.stream_id == stream_id for one in self.subscribers)
