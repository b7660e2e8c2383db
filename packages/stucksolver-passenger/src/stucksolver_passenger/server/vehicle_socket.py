"""The server's end of the socket to the vehicles' processes."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path

from pydantic import ValidationError

from stucksolver_passenger.server.fleet_state import Board
from stucksolver_passenger.socket_frames import LENGTH_BYTES, SocketMessageError, body_length, unpacked


class VehicleSocket:
    """Listens on a Unix socket in a folder that only its owner may enter, so every client is a process of the owner."""

    def __init__(self, board: Board, address: Path) -> None:
        self._board = board
        self._address = address
        self._server: asyncio.Server | None = None

    async def start(self) -> None:
        """Start to listen. Call this in the board's event loop."""
        self._server = await asyncio.start_unix_server(self._serve, str(self._address))

    async def stop(self) -> None:
        """Close all connections."""
        if self._server is not None:
            self._server.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        def write(data: bytes) -> None:
            # The vehicle's process may have disconnected; the sender of the command gets a timeout.
            with contextlib.suppress(OSError, RuntimeError):
                writer.write(data)

        try:
            # An invalid frame ends the connection, because the data after it cannot be trusted either.
            with contextlib.suppress(asyncio.IncompleteReadError, OSError, SocketMessageError, ValidationError):
                while True:
                    length = body_length(await reader.readexactly(LENGTH_BYTES))
                    self._board.take(unpacked(await reader.readexactly(length)), write)
        finally:
            self._board.lost(write)
            writer.close()
