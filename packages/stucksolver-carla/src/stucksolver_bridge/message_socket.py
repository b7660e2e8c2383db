"""Messages over a local socket: four bytes of length, big-endian, then UTF-8 JSON."""

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
DEEPEST = 50
"""Values nested deeper than this are left out of a message that cannot be sent as it is."""
LARGEST_BYTES = 64 * 1024 * 1024
"""The largest message is a town's OpenDRIVE text; CARLA's largest has 30 MB."""
ANSWER_BYTES = 512 * 1024
"""The solver's largest message is a route: 15 km take 512 KiB, which is read in a fraction of a tick."""
_LENGTH = struct.Struct(">I")
_CHUNK_BYTES = 1 << 16


class WireError(Exception):
    """The other side is gone, silent, or does not speak this protocol."""


class Wire:
    """One end of a connected socket. Its methods raise `WireError` if anything goes wrong.

    Every time limit is for a whole message, however slowly its bytes arrive. `largest_bytes` bounds received messages.
    """

    def __init__(self, connected: socket.socket, largest_bytes: int = LARGEST_BYTES) -> None:
        connected.setblocking(False)
        self._socket = connected
        self._largest = largest_bytes
        self._in = bytearray()
        self._out = bytearray()

    def post(self, message: dict[str, Any]) -> None:
        """Send as much of a message as the other side accepts now; later calls of `send` and `look` send the rest."""
        text = _text(message)
        if len(text) > LARGEST_BYTES:
            raise WireError(f"a message of {len(text)} bytes is too long")
        self._out += _LENGTH.pack(len(text)) + text
        self._push()

    def send(self, message: dict[str, Any], limit_s: float | None = None) -> None:
        """Send a whole message."""
        until = _deadline(limit_s)
        self.post(message)
        while self._out:
            if not self._ready(until - time.monotonic(), reads=False):
                raise WireError(f"nothing was accepted within {limit_s} s")
            self._push()

    def receive(self, limit_s: float | None = None) -> dict[str, Any]:
        """Return the next message."""
        message = self.look(_deadline(limit_s))
        if message is None:
            raise WireError(f"no answer within {limit_s} s")
        return message

    def look(self, until: float, waits: bool = True) -> dict[str, Any] | None:
        """Return the next message if it is complete by an instant of `time.monotonic`; a part of one is kept for later.

        Without `waits`, only data that have already arrived are read.
        """
        while True:
            self._push()
            message = self._whole()
            if message is not None:
                return message
            left = until - time.monotonic()
            if self._ready(left if waits else 0.0):
                self._pull()
            elif not waits:
                return None
            if left <= 0.0:
                return self._whole()

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _ready(self, within_s: float, reads: bool = True) -> bool:
        """Return True if something can be read or sent within this time."""
        poll = select.poll()
        poll.register(self._socket, (select.POLLIN if reads else 0) | (select.POLLOUT if self._out else 0))
        return bool(poll.poll(None if within_s == math.inf else math.ceil(1000.0 * max(within_s, 0.0))))

    def _push(self) -> None:
        if not self._out:
            return
        try:
            # The view is released at once, because a bytearray cannot shrink while a view on it exists.
            with memoryview(self._out) as left:
                sent = self._socket.send(left)
        except BlockingIOError:
            return
        except OSError as error:
            raise WireError(f"cannot send: {error}") from error
        del self._out[:sent]

    def _pull(self) -> None:
        try:
            part = self._socket.recv(_CHUNK_BYTES)
        except BlockingIOError:
            return
        except OSError as error:
            raise WireError(f"cannot receive: {error}") from error
        if not part:
            raise WireError("the other side closed the connection")
        self._in += part

    def _whole(self) -> dict[str, Any] | None:
        """Return the first message if all of it has arrived."""
        if len(self._in) < _LENGTH.size:
            return None
        (length,) = _LENGTH.unpack(self._in[: _LENGTH.size])
        if length > self._largest:
            raise WireError(f"a message of {length} bytes is announced; at most {self._largest} are allowed")
        end = _LENGTH.size + length
        if len(self._in) < end:
            return None
        text = bytes(self._in[_LENGTH.size : end])
        del self._in[:end]
        try:
            message = json.loads(text.decode("utf-8"))
        except (ValueError, RecursionError) as error:
            raise WireError(f"not a message: {error}") from error
        if not isinstance(message, dict):
            raise WireError("not a message: an object was expected")
        return message


def _text(message: dict[str, Any]) -> bytes:
    """Return a message as JSON. A stack may give anything: what JSON does not have is sent as a text that says so."""
    try:
        text = json.dumps(message, separators=(",", ":"), allow_nan=False)
    except (TypeError, ValueError, RecursionError):
        text = json.dumps(_sendable(message, 0), separators=(",", ":"), allow_nan=False)
    return text.encode("utf-8")


def _sendable(value: Any, depth: int) -> Any:
    if depth > DEEPEST:
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
