"""Checks the token and the rate of every request with a token."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

from fastapi import HTTPException, Request
from fastapi.responses import JSONResponse, StreamingResponse

from stucksolver_language.intent.lexical_safeguards import is_stop_phrase
from stucksolver_passenger.access_tokens import TokenHolder, Tokens
from stucksolver_passenger.api_types import CommandKind
from stucksolver_passenger.server.connection_limits import ConnectionSlot, source_of
from stucksolver_passenger.server.fleet_state import Board, Vehicle
from stucksolver_passenger.server.rate_limits import (
    ALL_COMMANDS,
    ALL_PASSENGER_REQUESTS,
    ALL_PASSENGER_STREAMS,
    ALL_STOP_REQUESTS,
    COMMANDS,
    FAILURES,
    NOES,
    OPERATOR_REQUESTS,
    OPERATOR_STREAMS,
    PASSENGER_REQUESTS,
    PASSENGER_STREAMS,
    REQUESTS,
    SPOKEN_STOPS,
    STOP_REQUESTS,
    STOPS,
    Limiter,
    RateLimit,
)
from stucksolver_passenger.server.request_filter import CONNECTION_SLOT, Receive, Scope, Send

TOO_MUCH = "That is too much at once. Please wait a moment."
NO_TOKEN = "This needs the token that the server printed at start."
NOT_YOURS = "This token is not for this vehicle."
TOO_MANY_PAGES = "Too many pages are open with this token. Please close one."
STOP_PATH = "/stop"


def too_much(after_s: int = 1) -> HTTPException:
    """Return the response to a client with too many requests."""
    return HTTPException(429, TOO_MUCH, {"retry-after": str(after_s)})


def holder_of(tokens: Tokens, authorization: str) -> TokenHolder | None:
    """Return the holder of a token in a header `Authorization`; None for an invalid one."""
    scheme, _, token = authorization.partition(" ")
    return tokens.holder(token) if scheme.lower() == "bearer" else None


@dataclass(frozen=True)
class Sharing:
    """Shares of connections that each kind of token may hold."""

    tokens: Tokens

    def of_request(self, path: str, authorization: str) -> tuple[tuple[Hashable, int], ...]:
        """Return the shares in which a request counts, as in `Shares`."""
        holder = holder_of(self.tokens, authorization)
        if holder is None:
            return ()
        if path.endswith(STOP_PATH):
            return (("stops", holder), STOP_REQUESTS), ("stops", ALL_STOP_REQUESTS)
        if holder.role == "operator":
            return ((holder, OPERATOR_REQUESTS),)
        return (holder, PASSENGER_REQUESTS), ("passengers", ALL_PASSENGER_REQUESTS)


@dataclass
class Streams:
    """Counts the open pages, separately for each kind of token."""

    open: Counter[Hashable] = field(default_factory=Counter)

    def enter(self, holder: TokenHolder) -> bool:
        """Count one more page. Returns False without counting it if there are too many."""
        shares = _stream_shares(holder)
        if any(self.open[name] >= most for name, most in shares):
            return False
        self.open.update(name for name, _ in shares)
        return True

    def leave(self, holder: TokenHolder) -> None:
        """Count one page less."""
        self.open.subtract(name for name, _ in _stream_shares(holder))
        self.open += Counter()  # removes entries of zero


def _stream_shares(holder: TokenHolder) -> tuple[tuple[Hashable, int], ...]:
    if holder.role == "operator":
        return ((holder, OPERATOR_STREAMS),)
    return (holder, PASSENGER_STREAMS), ("passengers", ALL_PASSENGER_STREAMS)


class CountedStream(StreamingResponse):
    """A page's stream, counted while it is open.

    It is counted and checked in one step, so parallel requests cannot both pass.
    """

    def __init__(self, content: Any, streams: Streams, holder: TokenHolder) -> None:
        super().__init__(content, media_type="text/event-stream")
        self._streams, self._holder = streams, holder

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the stream, or reject it."""
        if not self._streams.enter(self._holder):
            refused = JSONResponse({"detail": TOO_MANY_PAGES}, 429, {"retry-after": "10"})
            await refused(scope, receive, send)
            return
        try:
            slot: ConnectionSlot | None = scope.get("state", {}).get(CONNECTION_SLOT)
            if slot is not None:
                slot.stays()
            await super().__call__(scope, receive, send)
        finally:
            self._streams.leave(self._holder)


@dataclass
class Access:
    """Checks tokens and rates."""

    tokens: Tokens
    board: Board
    limiter: Limiter
    streams: Streams = field(default_factory=Streams)

    def holder(self, request: Request, *, limited: bool = True) -> TokenHolder:
        """Return the holder of the request's token.

        Invalid tokens are counted only after the check, so that they never block a valid one.

        Args:
            request: The request.
            limited: Count the request in the rate of its token's requests.

        Raises:
            HTTPException: 401 for an invalid token, 429 for too many tries.
        """
        address = source_of(request.client.host if request.client else "")
        holder = holder_of(self.tokens, request.headers.get("authorization", ""))
        if holder is None:
            if not self.limiter.allows(FAILURES, "failures", address):
                raise too_much(5)
            raise HTTPException(401, NO_TOKEN, {"www-authenticate": "Bearer"})
        if limited and not self.limiter.allows(REQUESTS, "requests", *_named(holder), address):
            raise too_much()
        return holder

    def operator(self, request: Request) -> TokenHolder:
        """Return the holder of an operator's token.

        Raises:
            HTTPException: 401 for an invalid token, 403 for a passenger's, 429 for too many tries.
        """
        holder = self.holder(request)
        if holder.role != "operator":
            raise HTTPException(403, "This is for operators.")
        return holder

    def vehicle(self, request: Request, vehicle_id: str, *, limited: bool = True) -> tuple[TokenHolder, Vehicle]:
        """Return the holder and the vehicle; `limited` as for `holder`.

        Raises:
            HTTPException: 403 for a vehicle of another token, whether it exists or not; 404 if there is none.
        """
        holder = self.holder(request, limited=limited)
        if not holder.may_use(vehicle_id):
            raise HTTPException(403, NOT_YOURS)
        vehicle = self.board.vehicle(vehicle_id)
        if vehicle is None:
            raise HTTPException(404, "There is no such vehicle, or it has not come yet.")
        return holder, vehicle

    def may_command(
        self, holder: TokenHolder, vehicle: Vehicle, kind: CommandKind, client: str, text: str = ""
    ) -> None:
        """Check the rate of commands. Stops, noes and spoken stops each have their own bucket.

        Raises:
            HTTPException: 429 if there are too many.
        """
        own = _own_rate(kind, text)
        if own is not None:
            name, rate = own
            allowed = self.limiter.allows(rate, name, vehicle.id, holder.role)
        else:
            allowed = self.limiter.allows(
                COMMANDS, "commands", vehicle.id, holder.role, client
            ) and self.limiter.allows(ALL_COMMANDS, "all", vehicle.id, holder.role)
        if not allowed:
            raise too_much()


def _own_rate(kind: CommandKind, text: str) -> tuple[str, RateLimit] | None:
    """Return the name and the rate of a command with its own bucket; None for other commands."""
    if kind is CommandKind.STOP:
        return "stops", STOPS
    if kind is CommandKind.NO:
        return "noes", NOES
    if kind is CommandKind.SAY and is_stop_phrase(text):
        return "spoken stops", SPOKEN_STOPS
    return None


def _named(holder: TokenHolder) -> tuple[str, str]:
    return holder.role, holder.vehicle or ""
