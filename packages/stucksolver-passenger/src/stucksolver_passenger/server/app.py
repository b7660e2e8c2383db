"""The HTTP API and the page."""

from __future__ import annotations

import base64
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from fastapi import FastAPI, HTTPException, Request, Response
from fastapi.responses import PlainTextResponse, StreamingResponse

from stucksolver.ladder.rung_actions import Person
from stucksolver_passenger.access_tokens import TokenHolder, Tokens
from stucksolver_passenger.api_types import CommandKind, CommandResult, OperatorCall, PersonCommand, VehicleReport
from stucksolver_passenger.server.access import NOT_YOURS, Access, CountedStream
from stucksolver_passenger.server.event_stream import events
from stucksolver_passenger.server.fleet_state import Board, Vehicle
from stucksolver_passenger.server.rate_limits import Limiter
from stucksolver_passenger.server.request_models import (
    ClientRequest,
    OperatorMessageRequest,
    TokenInfo,
    UtteranceRequest,
    YesNoRequest,
)
from stucksolver_passenger.server.static_files import add_pages, add_voice
from stucksolver_passenger.server.vehicle_socket import VehicleSocket
from stucksolver_passenger.socket_frames import Topic
from stucksolver_passenger.speech_recognizer import Recognizer

ABOUT = (
    "Conversation with a car that runs StuckSolver. Every call under /api needs `Authorization: Bearer TOKEN`. "
    "A passenger's token is for one vehicle, an operator's for all of them."
)


def make_app(
    board: Board,
    tokens: Tokens,
    hub: VehicleSocket | None = None,
    drawing: Path | None = None,
    recognizer: Recognizer | None = None,
) -> FastAPI:
    """Return the application.

    Args:
        board: The state of all vehicles.
        tokens: Checks tokens.
        hub: Socket to the vehicles; starts and stops with the application.
        drawing: Folder of the scripts that draw the view from above.
        recognizer: The speech recognizer for the browser.
    """

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        if hub is not None:
            await hub.start()
        yield
        if hub is not None:
            await hub.stop()

    app = FastAPI(
        title="StuckSolver passenger API",
        description=ABOUT,
        version=_version(),
        docs_url=None,  # FastAPI's page loads scripts from other hosts; /docs has its own page
        redoc_url=None,
        lifespan=lifespan,
    )
    access = Access(tokens, board, Limiter())
    _add_reading(app, access)
    _add_talking(app, access)
    _add_operating(app, access)
    add_pages(app, drawing)
    add_voice(app, recognizer)
    _add_schema(app)
    return app


def _add_reading(app: FastAPI, access: Access) -> None:
    """Add the routes that return information to any holder of a token."""
    board = access.board

    @app.get("/api/me")
    async def me(request: Request) -> TokenInfo:
        """Return the role of the token, and the vehicles that it may access."""
        holder = access.holder(request)
        mine = [item for item in board.vehicles if holder.may_use(item.id)]
        vehicle = holder.vehicle or (mine[0].id if mine else None)
        return TokenInfo(role=holder.role, vehicle=vehicle, vehicles={item.id: item.name for item in mine})

    @app.get("/api/vehicles/{vehicle_id}")
    async def now(request: Request, vehicle_id: str) -> VehicleReport:
        """Return the current state of a vehicle."""
        _, vehicle = access.vehicle(request, vehicle_id)
        found = vehicle.now
        if found is None:
            raise HTTPException(404, "The vehicle has not reported anything yet.")
        return found

    @app.get("/api/vehicles/{vehicle_id}/camera.jpg", response_class=Response)
    async def camera(request: Request, vehicle_id: str) -> Response:
        """Return the newest image of the front camera."""
        _, vehicle = access.vehicle(request, vehicle_id)
        picture = vehicle.shown.get(Topic.PICTURE)
        if picture is None:
            raise HTTPException(404, "There is no picture.")
        return Response(base64.b64decode(picture[1]), media_type="image/jpeg")

    @app.get("/api/vehicles/{vehicle_id}/stream", response_class=PlainTextResponse)
    async def stream(request: Request, vehicle_id: str, pictures: bool = True) -> StreamingResponse:
        """Send server-sent events: `now` (as above), and with `pictures` also `scenery`, `view` and `picture`."""
        holder = access.holder(request)
        if not holder.may_use(vehicle_id):
            raise HTTPException(403, NOT_YOURS)
        sending = events(board, vehicle_id, pictures, request.is_disconnected)
        return CountedStream(sending, access.streams, holder)


def _add_talking(app: FastAPI, access: Access) -> None:
    """Add the routes for commands of any holder of a token."""

    async def command(request: Request, vehicle_id: str, kind: CommandKind, client: str, **more: Any) -> CommandResult:
        holder, vehicle = access.vehicle(request, vehicle_id, limited=kind is not CommandKind.STOP)
        access.may_command(holder, vehicle, kind, client, more.get("text", ""))
        return await _commanded(access.board, vehicle, holder, kind, client, **more)

    @app.post("/api/vehicles/{vehicle_id}/say")
    async def say(request: Request, vehicle_id: str, body: UtteranceRequest) -> CommandResult:
        """Send an utterance to the car. It is advice: the guard decides about the driving."""
        return await command(request, vehicle_id, CommandKind.SAY, body.client, text=body.text)

    @app.post("/api/vehicles/{vehicle_id}/answer")
    async def answer(request: Request, vehicle_id: str, body: YesNoRequest) -> CommandResult:
        """Answer the open question with yes or no."""
        kind = CommandKind.YES if body.yes else CommandKind.NO
        return await command(request, vehicle_id, kind, body.client, question_id=body.question_id)

    @app.post("/api/vehicles/{vehicle_id}/stop")
    async def stop(request: Request, vehicle_id: str, body: ClientRequest) -> CommandResult:
        """End the current request of the passenger, as soon as that is safe."""
        return await command(request, vehicle_id, CommandKind.STOP, body.client)

    @app.post("/api/vehicles/{vehicle_id}/help")
    async def call_help(request: Request, vehicle_id: str, body: ClientRequest) -> CommandResult:
        """Call an operator."""
        outcome = await command(request, vehicle_id, CommandKind.HELP, body.client)
        vehicle = access.board.vehicle(vehicle_id)
        if vehicle is not None:
            access.board.call_for_help(vehicle, "The passenger asks for help.")
        return outcome


def _add_operating(app: FastAPI, access: Access) -> None:
    """Add the routes for operators."""
    board = access.board

    @app.get("/api/vehicles")
    async def vehicles(request: Request) -> dict[str, str]:
        """Return all vehicles: id and name."""
        access.operator(request)
        return {item.id: item.name for item in board.vehicles}

    @app.get("/api/queue")
    async def queue(request: Request) -> list[OperatorCall]:
        """Return the entries that wait for an operator, the longest waiting first."""
        access.operator(request)
        return list(board.queue())

    @app.post("/api/queue/{call_id}/close")
    async def close(request: Request, call_id: str, body: ClientRequest) -> None:
        """Close a call for help. (A question leaves the queue when it is answered.)"""
        access.operator(request)
        if not board.close_call(call_id):
            raise HTTPException(404, "There is no such call.")

    @app.post("/api/vehicles/{vehicle_id}/tell")
    async def tell(request: Request, vehicle_id: str, body: OperatorMessageRequest) -> CommandResult:
        """Send a message to the passenger. It does not affect the driving."""
        holder = access.operator(request)
        _, vehicle = access.vehicle(request, vehicle_id)
        access.may_command(holder, vehicle, CommandKind.TELL, body.client)
        return await _commanded(board, vehicle, holder, CommandKind.TELL, body.client, text=body.text)


async def _commanded(
    board: Board, vehicle: Vehicle, holder: TokenHolder, kind: CommandKind, client: str, **more: Any
) -> CommandResult:
    role: Person = holder.role
    command = PersonCommand(number=board.number(), kind=kind, by=role, client=client, **more)
    return await board.command(vehicle, command)


def _add_schema(app: FastAPI) -> None:
    """Name the token in the OpenAPI document, so that tools can prompt for one."""
    schema = app.openapi()
    schema["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
    for path, methods in schema["paths"].items():
        for operation in methods.values() if path.startswith("/api/") else ():
            operation["security"] = [{"token": []}]


def _version() -> str:
    try:
        return version("stucksolver")
    except PackageNotFoundError:
        # A source tree that is not installed has no version.
        return "0"
