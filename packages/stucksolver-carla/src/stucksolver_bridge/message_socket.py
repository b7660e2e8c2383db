"""Sends and receives messages over a local socket: four bytes of length, big-endian, then UTF-8 JSON."""

from __future__ import annotations

import json
import math
import select
import socket
import struct
import time
from typing import Any

VERSION = 3
"""Version of the protocol. Since 3, every message about a tick carries the tick's number."""
MAX_DEPTH = 50
"""Maximum nesting in a message that contains values without a JSON form. Deeper values are left out. Ours."""
LARGEST_BYTES = 64 * 1024 * 1024
"""Maximum size of a message. The largest message is a town's OpenDRIVE text; CARLA's largest has 30 MB."""
ANSWER_BYTES = 512 * 1024
"""Maximum size of a message from the solver. Its largest message is a route: 15 km take 512 KiB, which are read in a
fraction of a tick."""
_LENGTH = struct.Struct(">I")
_CHUNK_BYTES = 1 << 16
"""Number of bytes that one call of `recv` may return. Ours."""


class WireError(Exception):
    """The other end is closed, does not answer, or uses another protocol."""


class Wire:
    """One end of a connected socket. Its methods raise `WireError` on any failure.

    Every time limit covers a whole message, even if its bytes arrive slowly. `largest_bytes` bounds received messages.
    """

    def __init__(self, connected: socket.socket, largest_bytes: int = LARGEST_BYTES) -> None:
        connected.setblocking(False)
        self._socket = connected
        self._largest_bytes = largest_bytes
        self._received = bytearray()
        self._unsent = bytearray()

    def post(self, message: dict[str, Any]) -> None:
        """Send as much of a message as the other end accepts now. Later calls send the rest."""
        text = _json_bytes(message)
        if len(text) > LARGEST_BYTES:
            raise WireError(f"a message has {len(text)} bytes; at most {LARGEST_BYTES} are allowed")
        self._unsent += _LENGTH.pack(len(text)) + text
        self._push()

    def send(self, message: dict[str, Any], limit_s: float | None = None) -> None:
        """Send a whole message."""
        until = _deadline(limit_s)
        self.post(message)
        while self._unsent:
            if not self._ready(until - time.monotonic(), reads=False):
                raise WireError(f"nothing was accepted within {limit_s} s")
            self._push()

    def receive(self, limit_s: float | None = None) -> dict[str, Any]:
        """Return the next message."""
        message = self.poll_message(_deadline(limit_s))
        if message is None:
            raise WireError(f"no answer within {limit_s} s")
        return message

    def poll_message(self, until: float, waits: bool = True) -> dict[str, Any] | None:
        """Return the next message if it is complete at the time `until` of `time.monotonic`, else None.

        The bytes of an incomplete message stay in the buffer. Without `waits`, only data that have already arrived are
        read.
        """
        while True:
            self._push()
            message = self._first_message()
            if message is not None:
                return message
            remaining = until - time.monotonic()
            if self._ready(remaining if waits else 0.0):
                self._pull()
            elif not waits:
                return None
            if remaining <= 0.0:
                return self._first_message()

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _ready(self, within_s: float, reads: bool = True) -> bool:
        """Return True if data can be read or sent within this time."""
        poller = select.poll()
        poller.register(self._socket, (select.POLLIN if reads else 0) | (select.POLLOUT if self._unsent else 0))
        return bool(poller.poll(None if within_s == math.inf else math.ceil(1000.0 * max(within_s, 0.0))))

    def _push(self) -> None:
        if not self._unsent:
            return
        try:
            # The view must be released before the `del` below: a bytearray cannot shrink while a view on it exists.
            with memoryview(self._unsent) as remaining:
                sent = self._socket.send(remaining)
        except BlockingIOError:
            # The other end accepts nothing now. A later call sends the rest.
            return
        except OSError as error:
            raise WireError(f"cannot send: {error}") from error
        del self._unsent[:sent]

    def _pull(self) -> None:
        try:
            data = self._socket.recv(_CHUNK_BYTES)
        except BlockingIOError:
            # Nothing has arrived yet. The caller polls again.
            return
        except OSError as error:
            raise WireError(f"cannot receive: {error}") from error
        if not data:
            raise WireError("the other end closed the connection")
        self._received += data

    def _first_message(self) -> dict[str, Any] | None:
        """Return the first message if all of it has arrived."""
        if len(self._received) < _LENGTH.size:
            return None
        (length,) = _LENGTH.unpack(self._received[: _LENGTH.size])
        if length > self._largest_bytes:
            raise WireError(f"a message has {length} bytes; at most {self._largest_bytes} are allowed")
        end = _LENGTH.size + length
        if len(self._received) < end:
            return None
        text = bytes(self._received[_LENGTH.size : end])
        del self._received[:end]
        try:
            message = json.loads(text.decode("utf-8"))
        except (ValueError, RecursionError) as error:
            raise WireError(f"invalid message: {error}") from error
        if not isinstance(message, dict):
            raise WireError("invalid message: expected an object")
        return message


def _json_bytes(message: dict[str, Any]) -> bytes:
    """Return a message as JSON. Values without a JSON form are sent as strings that describe them."""
    try:
        text = json.dumps(message, separators=(",", ":"), allow_nan=False)
    except (TypeError, ValueError, RecursionError):
        # The stack's values may have any type. An error here would end the stack's control loop.
        text = json.dumps(_sendable(message, 0), separators=(",", ":"), allow_nan=False)
    return text.encode("utf-8")


def _sendable(value: Any, depth: int) -> Any:
    if depth > MAX_DEPTH:
        return "a value nested too deeply"
    if isinstance(value, dict):
        return {str(name): _sendable(item, depth + 1) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_sendable(item, depth + 1) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else repr(float(value))
    return value if value is None or isinstance(value, (bool, int, str)) else "a " + type(value).__name__


def _deadline(limit_s: float | None) -> float:
    return math.inf if limit_s is None else time.monotonic() + limit_s
