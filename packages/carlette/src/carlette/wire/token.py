"""Stream tokens: how a client finds a stream."""

from __future__ import annotations

import struct

_TOKEN = struct.Struct("<IHBB16x")
_TCP = 1
_SAME_HOST = 0

WORLD_STREAM = 1
"""The stream of world snapshots, by convention."""


def stream_token(stream_id: int, port: int) -> bytes:
    """A token that sends the client to `port` of the host that it already talks to."""
    return _TOKEN.pack(stream_id, port, _TCP, _SAME_HOST)
