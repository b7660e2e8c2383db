"""Checks who is asking, and whether they ask too much. Every route with a token uses it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from fastapi import HTTPException, Request

from stucksolver.passenger.roles import Holder, Tokens
from stucksolver.passenger.server.board import Board, Vehicle
from stucksolver.passenger.server.limits import (
    ALL_COMMANDS,
    COMMANDS,
    FAILURES,
    REQUESTS,
    STOPS,
    STREAMS,
    Limiter,
)
from stucksolver.passenger.told import CommandKind

TOO_MUCH = "That is too much at once. Please wait a moment."
NO_TOKEN = "This needs the token that the server printed at start."
NOT_YOURS = "This token is not for this vehicle."


def too_much(after_s: int = 1) -> HTTPException:
    """Return the answer to someone who asks too often."""
    return HTTPException(429, TOO_MUCH, {"retry-after": str(after_s)})


@dataclass
class Access:
    """Checks tokens and rates. `streams` is the number of open pages."""

    tokens: Tokens
    board: Board
    limiter: Limiter
    streams: int = 0

    def holder(self, request: Request) -> Holder:
        """Return the holder of the request's token.

        Raises:
            HTTPException: 401 for a foreign token, 429 for too many tries.
        """
        address = request.client.host if request.client else ""
        if self.limiter.exhausted(FAILURES, "failures", address):
            raise too_much(5)
        scheme, _, token = request.headers.get("authorization", "").partition(" ")
        holder = self.tokens.holder(token) if scheme.lower() == "bearer" else None
        if holder is None:
            self.limiter.allows(FAILURES, "failures", address)
            raise HTTPException(401, NO_TOKEN, {"www-authenticate": "Bearer"})
        if not self.limiter.allows(REQUESTS, "requests", address):
            raise too_much()
        return holder

    def operator(self, request: Request) -> Holder:
        """Return the holder of an operator's token.

        Raises:
            HTTPException: 401 for a foreign token, 403 for a passenger's, 429 for too many tries.
        """
        holder = self.holder(request)
        if holder.role != "operator":
            raise HTTPException(403, "This is for operators.")
        return holder

    def vehicle(self, request: Request, vehicle_id: str) -> tuple[Holder, Vehicle]:
        """Return the holder and the vehicle.

        Raises:
            HTTPException: 403 for a foreign vehicle, whether it exists or not; 404 if there is none.
        """
        holder = self.holder(request)
        if not holder.may_use(vehicle_id):
            raise HTTPException(403, NOT_YOURS)
        vehicle = self.board.vehicle(vehicle_id)
        if vehicle is None:
            raise HTTPException(404, "There is no such vehicle, or it has not come yet.")
        return holder, vehicle

    def may_command(self, vehicle: Vehicle, kind: CommandKind, client: str) -> None:
        """Check the rate of commands. Stops have their own limit.

        Raises:
            HTTPException: 429 if there are too many.
        """
        if kind in (CommandKind.STOP, CommandKind.NO):
            allowed = self.limiter.allows(STOPS, "stops", vehicle.id)
        else:
            allowed = self.limiter.allows(COMMANDS, "commands", vehicle.id, client) and self.limiter.allows(
                ALL_COMMANDS, "all", vehicle.id
            )
        if not allowed:
            raise too_much()

    def may_stream(self) -> None:
        """Check the number of open pages.

        Raises:
            HTTPException: 503 if there are too many.
        """
        if self.streams >= STREAMS:
            raise HTTPException(503, "Too many pages are open. Please close one.", {"retry-after": "10"})

    @contextmanager
    def one_stream(self) -> Iterator[None]:
        """Count a page as long as it is open."""
        self.streams += 1
        try:
            yield
        finally:
            self.streams -= 1
