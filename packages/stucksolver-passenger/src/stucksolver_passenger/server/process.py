"""Runs the server in its own process."""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import os
import socket
import tempfile
import threading
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType

from stucksolver.interrupts import uninterrupted
from stucksolver_passenger.access_tokens import Tokens
from stucksolver_passenger.server.options import PageOptions

START_S = 30.0
"""Time limit of the server's start (s). Ours."""
LEAVE_S = 5.0
"""Time limit of the server's end, before it is killed (s). Ours."""
NICE = 10
"""Increment of the server's niceness, so that fifty pages that reload do not delay the control loop on the same cores.

Ours.
"""
HUB = "desk"
"""Name of the socket in its folder."""


class ServerExitedError(RuntimeError):
    """The server's process ended unexpectedly. The message says when."""


@dataclass(frozen=True)
class _ServerArguments:
    """The arguments of the server's process."""

    options: PageOptions
    address: Path
    secret: bytes


class PassengerServer:
    """Starts the server on entry and ends it on exit. The server also ends when this process ends.

    Raises:
        ServerOptionsError: The server cannot listen.
        ServerExitedError: Its process ended unexpectedly.
    """

    def __init__(self, options: PageOptions | None = None, tokens: Tokens | None = None) -> None:
        self.options = options or PageOptions()
        self.options.check()
        self.tokens = tokens or Tokens()
        self._folder = tempfile.TemporaryDirectory(prefix="stucksolver-")  # mode 0700: other users may not enter
        self.address = Path(self._folder.name) / HUB
        """The address for gateways."""
        self.port = 0
        self._process: multiprocessing.process.BaseProcess | None = None
        self._ours: Connection | None = None

    def url(self, token: str) -> str:
        """Return the page's address. The token follows the #, and browsers never send that part to a server."""
        return f"{self.options.scheme}://{self.options.addresses(self.port)[0]}/#{token}"

    def __enter__(self) -> PassengerServer:
        listening = self.options.bound()
        self.port = int(listening.getsockname()[1])
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        arguments = _ServerArguments(self.options, self.address, self.tokens.secret)
        self._process = context.Process(target=_serve, args=(arguments, listening, theirs), daemon=True)
        # Ctrl-C reaches every process of a terminal. Only this process handles it, and then ends the server. Python's
        # resource tracker starts first, because its start would remove the block of the signal.
        resource_tracker.ensure_running()
        with uninterrupted():
            self._process.start()
        theirs.close()
        listening.close()
        try:
            ready = self._ours.poll(START_S) and self._ours.recv()
        except EOFError:
            # The server's process closed the pipe without a message, so its start failed.
            ready = False
        if not ready:
            self.close()
            raise ServerExitedError("the passenger server ended during its start; see its output")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the server."""
        process = self._process
        if process is not None and process.is_alive():
            process.terminate()
            process.join(LEAVE_S)
            if process.is_alive():
                process.kill()
                process.join()
        if self._ours is not None:
            self._ours.close()
        self._folder.cleanup()


def _serve(arguments: _ServerArguments, listening: socket.socket, theirs: Connection) -> None:
    """Run the server, in the server's process."""
    os.nice(NICE)
    threading.Thread(target=_end_with_parent, args=(theirs,), daemon=True).start()
    asyncio.run(_serving(arguments, listening, theirs))


async def _serving(arguments: _ServerArguments, listening: socket.socket, theirs: Connection) -> None:
    from stucksolver_passenger.server.access import Sharing
    from stucksolver_passenger.server.app import make_app
    from stucksolver_passenger.server.fleet_state import Board
    from stucksolver_passenger.server.http_server import limits_here, make_server, serve, tls_of
    from stucksolver_passenger.server.request_filter import RequestFilter
    from stucksolver_passenger.server.vehicle_socket import VehicleSocket

    options, board, tokens = arguments.options, Board(), Tokens(arguments.secret)
    app = make_app(board, tokens, VehicleSocket(board, arguments.address), options.drawing, options.recognizer)
    hosts = frozenset(options.addresses(int(listening.getsockname()[1])))
    doors = RequestFilter(
        app, hosts, options.scheme, compiles=options.recognizer is not None, shares=Sharing(tokens).of_request
    )
    tls = None if options.cert is None or options.key is None else tls_of(str(options.cert), str(options.key))
    server = make_server(doors, limits_here(), tls)
    telling = asyncio.create_task(_tell_when_up(server, theirs))
    await serve(server, [listening])
    telling.cancel()


async def _tell_when_up(server: object, theirs: Connection) -> None:
    while not getattr(server, "started", False):
        await asyncio.sleep(0.02)
    # The parent may have ended meanwhile; the other thread then ends this process.
    with contextlib.suppress(OSError):
        theirs.send(True)


def _end_with_parent(theirs: Connection) -> None:
    """End the server when the pipe closes, because that means that the parent has ended."""
    # Either error means that the parent has closed its end.
    with contextlib.suppress(EOFError, OSError):
        theirs.recv()
    os._exit(0)
