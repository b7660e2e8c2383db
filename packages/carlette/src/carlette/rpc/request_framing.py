"""Splits what a client sends into requests, and limits how much it may leave unfinished.

Until a request is complete, its bytes are kept and not decoded: an empty list takes one byte on the wire and seventy
in memory.
"""

from __future__ import annotations

import msgpack

from carlette.opendrive.map_file import LARGEST_MAP_BYTES

LARGEST_REQUEST_BYTES = 4 << 20
"""Largest request without the text of a map (bytes); a batch that spawns 1,000 vehicles has 1.5 MB."""
WITH_A_MAP = "copy_opendrive_to_file"
"""The one call that carries a long text, as its first argument."""
_HEAD_BYTES = 128
_STR_32 = 0xDB

BAD_BYTES = (msgpack.UnpackException, ValueError, TypeError, OverflowError, RecursionError, MemoryError)
"""What decoding invalid bytes raises; a map with a list as its key, for example, is a TypeError."""


class RequestTooLargeError(ValueError):
    """A request exceeds its limit."""


class RequestBuffer:
    """The bytes that have arrived, and the ends of the requests in them."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._scanner = self._fresh()
        self._cut = 0
        """How much the scanner has read of what was already cut off."""

    @property
    def held_bytes(self) -> int:
        """Bytes of requests that have not been taken yet, complete or not."""
        return len(self._bytes)

    def feed(self, data: bytes) -> None:
        """Add what has arrived."""
        self._bytes += data
        self._scanner.feed(data)

    def next(self) -> bytes | None:
        """Return the next complete request, or None. Raise `BAD_BYTES` if it is not msgpack or is too large."""
        try:
            self._scanner.skip()
        except msgpack.OutOfData:
            if len(self._bytes) > LARGEST_REQUEST_BYTES and len(self._bytes) > allowance(self._bytes[:_HEAD_BYTES]):
                raise RequestTooLargeError(
                    f"a request of more than {len(self._bytes):,} bytes; send it in parts"
                ) from None
            return None
        end = self._scanner.tell()
        frame = bytes(memoryview(self._bytes)[: end - self._cut])
        del self._bytes[: end - self._cut]
        self._cut = end
        if len(frame) > LARGEST_REQUEST_BYTES and len(frame) > allowance(frame[:_HEAD_BYTES]):
            raise RequestTooLargeError(f"a request of {len(frame):,} bytes; send it in parts")
        return frame

    @staticmethod
    def _fresh() -> msgpack.Unpacker:
        return msgpack.Unpacker(max_buffer_size=2 * (LARGEST_REQUEST_BYTES + LARGEST_MAP_BYTES))


def allowance(head: bytes | bytearray) -> int:
    """Return how many bytes a request with this beginning may have: more only for a map's text, by its length."""
    reader = msgpack.Unpacker(unicode_errors="surrogateescape")
    reader.feed(head)
    try:
        reader.read_array_header()
        reader.skip()
        reader.skip()
        if reader.unpack() != WITH_A_MAP:
            return LARGEST_REQUEST_BYTES
        reader.read_array_header()
        reader.skip()
        at = reader.tell()
    except (*BAD_BYTES, msgpack.OutOfData):
        return LARGEST_REQUEST_BYTES
    if head[at] != _STR_32:
        return LARGEST_REQUEST_BYTES
    text_bytes = int.from_bytes(head[at + 1 : at + 5], "big")
    return LARGEST_REQUEST_BYTES + (text_bytes if text_bytes <= LARGEST_MAP_BYTES else 0)
