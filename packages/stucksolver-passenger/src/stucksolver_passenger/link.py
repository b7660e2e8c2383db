"""The vehicle's end of the socket to the server. It never blocks the control loop."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections import OrderedDict
from collections.abc import Callable
from pathlib import Path

from stucksolver_passenger.socket_frames import (
    LENGTH_BYTES,
    SocketMessage,
    SocketMessageError,
    Topic,
    body_length,
    unpacked,
)

CONNECT_S = 5.0
"""Time limit of the connection (s). Ours."""
NEWEST_ONLY = frozenset({Topic.NOW, Topic.VIEW, Topic.PICTURE})
CLOSE_S = 1.0
"""Time limit for sending the remaining frames at the end (s). Ours."""


class LinkError(RuntimeError):
    """The server cannot be reached. The message contains the address."""


class Link:
    """Sends and receives frames. A newer frame replaces an unsent one of its kind.

    The link's own thread calls `receive`. If the server disconnects, the link stops sending and the vehicle drives on.

    Raises:
        LinkError: The server cannot be reached.
    """

    def __init__(self, address: Path, receive: Callable[[SocketMessage], None]) -> None:
        self._receive = receive
        self._waiting: OrderedDict[object, SocketMessage] = OrderedDict()
        self._more = threading.Condition()
        self._open = True
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(CONNECT_S)
        try:
            self._socket.connect(str(address))
        except OSError as error:
            self._socket.close()
            raise LinkError(f"no passenger server at address: {address}: {error}. Start it first") from error
        self._socket.settimeout(None)
        self._sender = threading.Thread(target=self._send_all, name="passenger-send", daemon=True)
        self._sender.start()
        threading.Thread(target=self._receive_all, name="passenger-receive", daemon=True).start()

    def send(self, frame: SocketMessage) -> None:
        """Queue a frame without blocking."""
        with self._more:
            if not self._open:
                return
            newest = frame.topic in NEWEST_ONLY
            self._waiting[(frame.topic, frame.vehicle) if newest else object()] = frame
            self._more.notify()

    def close(self) -> None:
        """Send the queued frames and disconnect."""
        with self._more:
            self._open = False
            self._more.notify()
        self._sender.join(CLOSE_S)
        self._shut_down()

    def _send_all(self) -> None:
        # A broken connection ends the sending; the vehicle drives on without the server.
        with contextlib.suppress(OSError):
            while (frames := self._next_frames()) is not None:
                self._socket.sendall(b"".join(frame.packed() for frame in frames))
        self._drop()

    def _next_frames(self) -> list[SocketMessage] | None:
        """Return the frames to send now, in order; None if the link is closed and the queue is empty."""
        with self._more:
            while self._open and not self._waiting:
                self._more.wait()
            frames = list(self._waiting.values())
            self._waiting.clear()
            return frames or None

    def _receive_all(self) -> None:
        # A broken connection or an invalid frame ends the receiving; the vehicle drives on without the server.
        with contextlib.suppress(OSError, EOFError, SocketMessageError):
            while True:
                self._receive(unpacked(self._read(body_length(self._read(LENGTH_BYTES)))))
        self._drop()

    def _read(self, count: int) -> bytes:
        parts = []
        while count:
            part = self._socket.recv(min(count, 1 << 16))
            if not part:
                raise EOFError
            parts.append(part)
            count -= len(part)
        return b"".join(parts)

    def _drop(self) -> None:
        """Stop sending."""
        with self._more:
            self._open = False
            self._waiting.clear()
            self._more.notify()

    def _shut_down(self) -> None:
        # The server may have disconnected already.
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
