"""What crosses the socket between a vehicle's process and the server: a topic, a vehicle, and bytes.

A frame is four bytes of length (big-endian), then a line `TOPIC VEHICLE`, then the payload: JSON, or the bytes of a
picture in base64. The server passes most payloads on as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

LENGTH_BYTES = 4
LONGEST = 4_000_000
"""Bytes of a frame: many times the scenery of a long route. What is longer is not of ours."""


class FrameError(ValueError):
    """Bytes that are no frame; the message says what is wrong with them."""


class Topic(str, Enum):
    """What a frame is about. Of `NOW`, `VIEW` and `PICTURE` only the newest counts."""

    HELLO = "hello"
    """A vehicle joins: its name, as text. A page is told so, too: what it has shown of it is of another drive."""
    SCENERY = "scenery"
    """What stands still in the view from above."""
    NOW = "now"
    VIEW = "view"
    PICTURE = "picture"
    COMMAND = "command"
    """To the vehicle: what a person wants."""
    OUTCOME = "outcome"
    """From the vehicle: what came of it."""
    BYE = "bye"


@dataclass(frozen=True)
class Frame:
    """One message."""

    topic: Topic
    vehicle: str
    payload: bytes = b""

    def packed(self) -> bytes:
        """Its bytes on the socket."""
        body = f"{self.topic.value} {self.vehicle}\n".encode() + self.payload
        return len(body).to_bytes(LENGTH_BYTES, "big") + body


def body_length(head: bytes) -> int:
    """How many bytes follow a frame's first four. Raises `FrameError`."""
    length = int.from_bytes(head, "big")
    if not 0 < length <= LONGEST:
        raise FrameError(f"a frame of {length} bytes; at most {LONGEST} are read")
    return length


def unpacked(body: bytes) -> Frame:
    """The frame in the bytes after its length. Raises `FrameError`."""
    head, _, payload = body.partition(b"\n")
    topic, _, vehicle = head.decode("utf-8", "replace").partition(" ")
    try:
        return Frame(Topic(topic), vehicle, payload)
    except ValueError as error:
        raise FrameError(f"unknown topic {topic!r}") from error
