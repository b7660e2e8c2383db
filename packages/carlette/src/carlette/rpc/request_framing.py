"""Splits the bytes of a client into requests, and limits the size of an incomplete request.

The bytes of a request are stored without decoding until it is complete: an empty list takes one byte on the wire and
seventy in memory.
"""

from __future__ import annotations

import msgpack

from carlette.opendrive.map_file import LARGEST_MAP_BYTES

LARGEST_REQUEST_BYTES = 4 << 20
"""Largest request without the text of a map (bytes).

Ours; a batch that spawns 1,000 vehicles has 1.5 MB.
"""
WITH_A_MAP = "copy_opendrive_to_file"
"""The one call with a long text, its first argument."""
_HEAD_BYTES = 128
"""Number of bytes at the start of a request that are decoded for its size limit. Ours."""
_STR_32 = 0xDB
"""First byte of a msgpack text with a 32-bit length."""

BAD_BYTES = (msgpack.UnpackException, ValueError, TypeError, OverflowError, RecursionError, MemoryError)
"""Errors of decoding invalid bytes. A map with a list as its key, for example, is a TypeError."""


class RequestTooLargeError(ValueError):
    """A request exceeds its limit."""


class RequestBuffer:
    """The received bytes, and the ends of the requests in them."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._scanner = self._fresh()
        self._cut = 0
        """Position of the scanner in bytes that were already cut off."""

    @property
    def held_bytes(self) -> int:
        """Number of bytes of requests that have not been handled yet, complete or not."""
        return len(self._bytes)

    def feed(self, data: bytes) -> None:
        """Add received bytes."""
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
    """Return the size limit of a request with this beginning (bytes). Only a map's text has a larger one."""
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
        # A beginning that cannot be decoded gets the usual limit. The decoding of the complete request reports
        # the error.
        return LARGEST_REQUEST_BYTES
    if head[at] != _STR_32:
        return LARGEST_REQUEST_BYTES
    text_bytes = int.from_bytes(head[at + 1 : at + 5], "big")
    return LARGEST_REQUEST_BYTES + (text_bytes if text_bytes <= LARGEST_MAP_BYTES else 0)
