"""Who gets which stream: subscribers announce a stream's id and then only read."""

from __future__ import annotations

import select
import socket
import struct
import time
from collections import defaultdict, deque
from concurrent.futures import Future

MAX_BACKLOG_BYTES = 64 * 1024 * 1024
"""A subscriber that lags this far behind is dropped (it reconnects by itself)."""
MAX_WAIT_S = 2.0
"""How long the world stands still for a reader of large messages that is far behind, before that happens."""
MOST_KEPT = 8
"""Messages for a reader that nobody waits for any more, but who may still come (a client on a busy machine)."""
MOST_AWAITED = 4096
"""Streams whose token was asked for in one tick."""
MOST_LATE = 256
"""Of such readers."""
MOST_PARTS = 64
"""Of what is unsent, that one call of the system takes."""

Part = bytes | bytearray | memoryview
_SIZE = struct.Struct("<I")


class Subscriber:
    """One connection to the streaming port."""

    def __init__(self, sock: socket.socket) -> None:
        self.socket = sock
        self.came = time.monotonic()
        self.stream_id = 0
        """0 until the client has sent the id."""
        self._received = b""
        self._unsent: deque[memoryview] = deque()
        self._backlog = 0
        self._was_waited_for = False
        """In vain; not again."""

    @property
    def wants_to_write(self) -> bool:
        """True while a message could not be sent completely."""
        return bool(self._unsent)

    @property
    def is_paused(self) -> bool:
        """Never: a subscriber has nothing to say that could wait."""
        return False

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

    def send(self, *framed: Part) -> None:
        """Queues the parts of a message, of which the first carries its size, and sends what the socket takes.

        The parts are not copied: nobody may change them any more.
        """
        for part in framed:
            if len(part):
                self._unsent.append(memoryview(part).cast("B"))
                self._backlog += len(self._unsent[-1])
        self.write()

    @property
    def lags(self) -> bool:
        """True when the reader is so far behind that it must be dropped."""
        return self._backlog > MAX_BACKLOG_BYTES

    def write(self) -> None:
        """Sends as much as the socket takes."""
        try:
            while self._unsent:
                sent = self.socket.sendmsg([self._unsent[i] for i in range(min(len(self._unsent), MOST_PARTS))])
                self._drop(sent)
        except BlockingIOError:
            return
        except OSError:
            self._unsent.clear()
            self._backlog = 0

    def catch_up(self, limit_s: float = MAX_WAIT_S) -> None:
        """Waits until half of the backlog that is allowed is free, but not for long."""
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


class Hub:
    """All subscribers by stream."""

    def __init__(self) -> None:
        self.subscribers: set[Subscriber] = set()
        self.awaited: set[int] = set()
        """Streams whose token was asked for and whose subscriber has not come yet."""
        self._late: dict[int, list[tuple[Part, ...]]] = {}
        """Those that were awaited in vain, and what they missed since."""
        self.waits_for_readers = False
        """A reader of large messages that is far behind holds the world up for a moment, so that it misses none."""
        self._partings: defaultdict[int, list[Future[None]]] = defaultdict(list)

    def expect(self, stream_id: int) -> None:
        """A client asked for the token of a stream: it is about to subscribe."""
        if len(self.awaited) < MOST_AWAITED:
            self.awaited.add(stream_id)

    def arrived(self, subscriber: Subscriber) -> None:
        """A subscriber has announced its stream."""
        self.awaited.discard(subscriber.stream_id)
        for parts in self._late.pop(subscriber.stream_id, ()):
            self._send([subscriber], parts)

    def wait_no_longer(self) -> None:
        """Lets the world go on without the streams that are awaited.

        Whoever waits for the first measurement of a sensor waits for ever if it was sent before it came.
        """
        for stream_id in self.awaited:
            if len(self._late) < MOST_LATE:
                self._late[stream_id] = []
        self.awaited.clear()

    def forget_late(self) -> None:
        """Drops what is kept for readers that did not come: their streams have ended."""
        self._late.clear()

    def left(self, subscriber: Subscriber) -> None:
        """A subscriber's connection is over."""
        self.subscribers.discard(subscriber)
        if not self.listens(subscriber.stream_id):
            for one in self._partings.pop(subscriber.stream_id, []):
                one.set_result(None)

    def parting(self, stream_id: int) -> Future[None]:
        """Done when nobody subscribes to a stream any more."""
        future: Future[None] = Future()
        if self.listens(stream_id):
            self._partings[stream_id].append(future)
        else:
            future.set_result(None)
        return future

    def publish(self, stream_id: int, *parts: Part) -> None:
        """Sends one message to all subscribers of a stream."""
        readers = [one for one in self.subscribers if one.stream_id == stream_id]
        if readers:
            self._send(readers, parts)
        elif stream_id in self._late:
            self._late[stream_id].append(parts)
            if len(self._late[stream_id]) > MOST_KEPT:
                del self._late[stream_id]

    def _send(self, readers: list[Subscriber], parts: tuple[Part, ...]) -> None:
        size = _SIZE.pack(sum(memoryview(one).nbytes for one in parts))
        for one in readers:
            one.send(size, *parts)
            if self.waits_for_readers:
                one.catch_up()

    def is_wanted(self, stream_id: int) -> bool:
        """True when somebody subscribed to a stream, or is expected to."""
        return stream_id in self.awaited or stream_id in self._late or self.listens(stream_id)

    def listens(self, stream_id: int) -> bool:
        """True when somebody subscribed to a stream."""
        return any(one.stream_id == stream_id for one in self.subscribers)
