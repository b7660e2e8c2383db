"""Distributes the streams: a subscriber announces a stream's id and then only reads."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections import defaultdict, deque
from concurrent.futures import Future

MAX_BACKLOG_BYTES = 64 * 1024 * 1024
"""Backlog above which a subscriber is dropped (bytes). Ours; it reconnects by itself."""
MAX_WAIT_S = 2.0
"""Time for which the world waits for a slow reader of large messages before it is dropped (s). Ours."""
MOST_KEPT = 8
"""Number of messages stored for a reader that may still come (a client on a busy machine). Ours."""
MOST_AWAITED = 4096
"""Maximum number of streams whose token is requested within one tick. Ours."""
MOST_LATE = 256
"""Maximum number of late readers. Ours."""
MOST_PARTS = 64
"""Maximum number of unsent parts per system call. Ours."""

Part = bytes | bytearray | memoryview
_SIZE = struct.Struct("<I")


class Subscriber:
    """One connection to the streaming port."""

    def __init__(self, sock: socket.socket) -> None:
        self.socket = sock
        self.came = time.monotonic()
        self.stream_id = 0
        """Stream of the subscriber; 0 until the client has sent the id."""
        self._received = b""
        self._unsent: deque[memoryview] = deque()
        self._backlog = 0
        self._was_waited_for = False
        """True if the world already waited for this subscriber and timed out."""

    @property
    def wants_to_write(self) -> bool:
        """True while a part of a message is not sent."""
        return bool(self._unsent)

    @property
    def is_paused(self) -> bool:
        """Always False: a subscriber sends nothing that could wait."""
        return False

    def read(self) -> bool:
        """Read the stream id; return False when the connection has ended."""
        try:
            data = self.socket.recv(64)
        except BlockingIOError:
            # No data is available now; the selector reports the next data.
            return True
        except OSError:
            # The connection is broken; the server drops the subscriber.
            return False
        if not data:
            return False
        if not self.stream_id:
            self._received += data
            if len(self._received) >= _SIZE.size:
                self.stream_id = _SIZE.unpack_from(self._received)[0]
        return True

    def send(self, *framed: Part) -> None:
        """Queue the parts of a message, the first of which holds its size, and send what the socket takes.

        The parts are not copied, so they must not change afterward.
        """
        for part in framed:
            if len(part):
                self._unsent.append(memoryview(part).cast("B"))
                self._backlog += len(self._unsent[-1])
        self.write()

    @property
    def lags(self) -> bool:
        """True if the reader is so far behind that it must be dropped."""
        return self._backlog > MAX_BACKLOG_BYTES

    def write(self) -> None:
        """Send as much as the socket takes."""
        try:
            while self._unsent:
                sent = self.socket.sendmsg([self._unsent[i] for i in range(min(len(self._unsent), MOST_PARTS))])
                self._drop(sent)
        except BlockingIOError:
            # The socket is full; the selector reports when it accepts data again.
            return
        except OSError:
            # The peer is gone. The read side detects it and drops the subscriber.
            self._unsent.clear()
            self._backlog = 0

    def catch_up(self, limit_s: float = MAX_WAIT_S) -> None:
        """Wait, for at most `limit_s` (s), until half of the allowed backlog is free."""
        if self._backlog <= MAX_BACKLOG_BYTES // 2 or self._was_waited_for:
            return
        deadline = time.monotonic() + limit_s
        room = select.poll()
        room.register(self.socket, select.POLLOUT)
        while self._backlog > MAX_BACKLOG_BYTES // 2:
            rest_s = deadline - time.monotonic()
            if rest_s <= 0.0:
                self._was_waited_for = True
                return
            room.poll(1000.0 * rest_s)
            self.write()

    def _drop(self, sent: int) -> None:
        self._backlog -= sent
        while self._unsent and sent >= len(self._unsent[0]):
            sent -= len(self._unsent.popleft())
        if sent:
            self._unsent[0] = self._unsent[0][sent:]


class StreamHub:
    """All subscribers by stream."""

    def __init__(self) -> None:
        self.subscribers: set[Subscriber] = set()
        self.awaited: set[int] = set()
        """Streams whose token was requested and whose subscriber has not connected yet."""
        self._late: dict[int, list[tuple[Part, ...]]] = {}
        """Streams whose reader timed out, and the messages that it has missed since then."""
        self.waits_for_readers = False
        """True if a slow reader of large messages may delay the world, so that it misses none."""
        self._partings: defaultdict[int, list[Future[None]]] = defaultdict(list)

    def expect(self, stream_id: int) -> None:
        """Note that a client has requested a stream's token and will subscribe."""
        if len(self.awaited) < MOST_AWAITED:
            self.awaited.add(stream_id)

    def arrived(self, subscriber: Subscriber) -> None:
        """Note that a subscriber has announced its stream."""
        self.awaited.discard(subscriber.stream_id)
        for parts in self._late.pop(subscriber.stream_id, ()):
            self._send([subscriber], parts)

    def wait_no_longer(self) -> None:
        """Stop waiting for the awaited streams.

        Their messages are stored: a client would wait forever for a first measurement sent before it subscribed.
        """
        for stream_id in self.awaited:
            if len(self._late) < MOST_LATE:
                self._late[stream_id] = []
        self.awaited.clear()

    def forget_late(self) -> None:
        """Drop the stored messages for readers that did not connect. Their streams have ended."""
        self._late.clear()

    def note_departure(self, subscriber: Subscriber) -> None:
        """Note that a subscriber's connection has ended."""
        self.subscribers.discard(subscriber)
        if not self.listens(subscriber.stream_id):
            for item in self._partings.pop(subscriber.stream_id, []):
                item.set_result(None)

    def parting(self, stream_id: int) -> Future[None]:
        """Return a future that is done when a stream has no subscriber left."""
        future: Future[None] = Future()
        if self.listens(stream_id):
            self._partings[stream_id].append(future)
        else:
            future.set_result(None)
        return future

    def publish(self, stream_id: int, *parts: Part) -> None:
        """Send one message to all subscribers of a stream."""
        readers = [subscriber for subscriber in self.subscribers if subscriber.stream_id == stream_id]
        if readers:
            self._send(readers, parts)
        elif stream_id in self._late:
            self._late[stream_id].append(parts)
            if len(self._late[stream_id]) > MOST_KEPT:
                del self._late[stream_id]

    def _send(self, readers: list[Subscriber], parts: tuple[Part, ...]) -> None:
        size = _SIZE.pack(sum(memoryview(part).nbytes for part in parts))
        for reader in readers:
            reader.send(size, *parts)
            if self.waits_for_readers:
                reader.catch_up()

    def is_wanted(self, stream_id: int) -> bool:
        """True if a stream has a subscriber, or one is expected."""
        return stream_id in self.awaited or stream_id in self._late or self.listens(stream_id)

    def listens(self, stream_id: int) -> bool:
        """True if a stream has a subscriber."""
        return any(subscriber.stream_id == stream_id for subscriber in self.subscribers)
