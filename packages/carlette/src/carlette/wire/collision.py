"""The message of a collision sensor."""

from __future__ import annotations

from typing import Any

import msgpack

from carlette.geometry import Vector


def encode(actor: Any, other: Any, impulse: Vector) -> bytes:
    """A `CollisionEvent`: two actors as the client reads them, and the impulse on the first in N·s."""
    packed: bytes = msgpack.packb([actor, other, list(impulse)], unicode_errors="surrogateescape")
    return packed
