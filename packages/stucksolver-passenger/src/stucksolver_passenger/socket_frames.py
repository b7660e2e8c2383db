"""The messages on the socket between a vehicle's process and the server: a topic, a vehicle, and bytes.

A frame is four bytes of length (big-endian), then a line `TOPIC VEHICLE`, then the payload: JSON, or a JPEG image. The
server forwards JSON unchanged and encodes images for the pages, which saves work in the vehicle's process.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

LENGTH_BYTES = 4
LONGEST = 4_000_000
"""Longest frame (bytes): many times the scenery of a long route. Ours."""


class SocketMessageError(ValueError):
    """The bytes are not a frame. The message describes the error."""


class Topic(str, Enum):
    """Subject of a frame. For `NOW`, `VIEW` and `PICTURE` only the newest frame counts."""

    HELLO = "hello"
    """A vehicle joins, with its name as text. Pages get it too, because their content belongs to an earlier drive."""
    SCENERY = "scenery"
    """The static part of the view from above."""
    NOW = "now"
    VIEW = "view"
    PICTURE = "picture"
    COMMAND = "command"
    """A person's command to the vehicle."""
    OUTCOME = "outcome"
    """The result of a command from the vehicle."""
    BYE = "bye"


@dataclass(frozen=True)
class SocketMessage:
    """One message."""

    topic: Topic
    vehicle: str
    payload: bytes = b""

    def packed(self) -> bytes:
        """Return the frame as bytes."""
        body = f"{self.topic.value} {self.vehicle}\n".encode() + self.payload
        return len(body).to_bytes(LENGTH_BYTES, "big") + body


def body_length(head: bytes) -> int:
    """Return the number of bytes that follow the first four bytes of a frame.

    Raises:
        SocketMessageError: The frame is too long.
    """
    length = int.from_bytes(head, "big")
    if not 0 < length <= LONGEST:
        raise SocketMessageError(f"frame too long: {length} bytes, at most {LONGEST}")
    return length


def unpacked(body: bytes) -> SocketMessage:
    """Return the frame from the bytes after its length.

    Raises:
        SocketMessageError: The bytes are not a frame.
    """
    head, _, payload = body.partition(b"\n")
    topic, _, vehicle = head.decode("utf-8", "replace").partition(" ")
    try:
        return SocketMessage(Topic(topic), vehicle, payload)
    except ValueError as error:
        raise SocketMessageError(f"unknown topic: {topic!r}") from error
