"""Messages over a local socket: four bytes of length, big-endian, then UTF-8 JSON."""

from __future__ import annotations

import json
import socket
import struct
from typing import Any

VERSION = 2
LARGEST_BYTES = 64 * 1024 * 1024
"""A town's OpenDRIVE text is the largest thing sent; the largest of CARLA's has 30 MB."""
_LENGTH = struct.Struct(">I")


class WireError(Exception):
    """The other side is gone, silent, or does not speak this protocol."""


class Wire:
    """One end of a connected socket. Raises `WireError` when anything is the matter."""

    def __init__(self, connected: socket.socket) -> None:
        self._socket = connected

    def send(self, message: dict[str, Any]) -> None:
        text = json.dumps(message, separators=(",", ":"), allow_nan=False).encode("utf-8")
        if len(text) > LARGEST_BYTES:
            raise WireError(f"a message of {len(text)} bytes is too long")
        try:
            self._socket.sendall(_LENGTH.pack(len(text)) + text)
        except OSError as error:
            raise WireError(f"cannot send: {error}") from error

    def receive(self, limit_s: float | None = None) -> dict[str, Any]:
        """The next message; `limit_s` bounds each wait for more of it."""
        self._socket.settimeout(limit_s)
        try:
            (length,) = _LENGTH.unpack(self._exactly(_LENGTH.size))
            if length > LARGEST_BYTES:
                raise WireError(f"a message of {length} bytes is announced; that is no message of ours")
            message = json.loads(self._exactly(length).decode("utf-8"))
        except socket.timeout as error:
            raise WireError(f"no answer within {limit_s} s") from error
        except OSError as error:
            raise WireError(f"cannot receive: {error}") from error
        except ValueError as error:
            raise WireError(f"not a message: {error}") from error
        finally:
            self._socket.settimeout(None)
        if not isinstance(message, dict):
            raise WireError("not a message: an object was expected")
        return message

    def close(self) -> None:
        self._socket.close()

    def _exactly(self, count: int) -> bytes:
        parts = []
        while count > 0:
            part = self._socket.recv(count)
            if not part:
                raise WireError("the other side has gone")
            parts.append(part)
            count -= len(part)
        return b"".join(parts)
