"""The server's end of the socket to the vehicles' processes."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path

from pydantic import ValidationError

from stucksolver.passenger.frames import LENGTH_BYTES, FrameError, body_length, unpacked
from stucksolver.passenger.server.board import Board


class Hub:
    """Listens on a Unix socket in a folder that only its owner may enter: who gets there is one of our processes."""

    def __init__(self, board: Board, address: Path) -> None:
        self._board = board
        self._address = address
        self._server: asyncio.Server | None = None

    async def start(self) -> None:
        """Listen; called in the loop that the board belongs to."""
        self._server = await asyncio.start_unix_server(self._serve, str(self._address))

    async def stop(self) -> None:
        """Hang up on everybody."""
        if self._server is not None:
            self._server.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        def write(data: bytes) -> None:
            with contextlib.suppress(OSError, RuntimeError):
                writer.write(data)

        try:
            # A frame that is none of ours ends the connection: nothing that follows it can be trusted either.
            with contextlib.suppress(asyncio.IncompleteReadError, OSError, FrameError, ValidationError):
                while True:
                    length = body_length(await reader.readexactly(LENGTH_BYTES))
                    self._board.take(unpacked(await reader.readexactly(length)), write)
        finally:
            self._board.lost(write)
            writer.close()
