"""The server without its process: the app behind its doors, and a vehicle that answers by itself."""

from __future__ import annotations

from pathlib import Path

from fastapi.testclient import TestClient

import stucksolver_eval.report
from stucksolver.solver import QuestionKind
from stucksolver_passenger.access_tokens import Tokens
from stucksolver_passenger.api_types import CommandResult, OpenQuestion, PersonCommand, VehicleReport
from stucksolver_passenger.server.app import make_app
from stucksolver_passenger.server.fleet_state import Board
from stucksolver_passenger.server.request_filter import RequestFilter
from stucksolver_passenger.socket_frames import LENGTH_BYTES, SocketMessage, Topic, unpacked

HOST = "127.0.0.1:8000"
DRAWING = Path(stucksolver_eval.report.__file__).parent / "assets"
QUESTION = OpenQuestion(id="q1", to="operator", kind=QuestionKind.ASSISTANCE, text="May I try again?")


class Serving:
    """`client` talks to the app; `commands` are those that reached the vehicle `car-1`."""

    def __init__(self) -> None:
        self.tokens, self.board = Tokens(b"a secret of thirty-two bytes ....."), Board()
        self.commands: list[PersonCommand] = []
        app = RequestFilter(make_app(self.board, self.tokens, drawing=DRAWING), frozenset({HOST}), "http")
        self.client = TestClient(app, base_url=f"http://{HOST}", raise_server_exceptions=False)
        self.passenger, self.operator = self.tokens.passenger("car-1"), self.tokens.operator()
        self.join("car-1", "Car 1")

    def join(self, vehicle, name):
        self.board.take(SocketMessage(Topic.HELLO, vehicle, name.encode()), self._deliver)
        self.show(vehicle)

    def show(self, vehicle, **more):
        told = VehicleReport(
            time_s=1.0, speed_mps=0.0, state="monitoring, driving", thought="I am standing.", intention="", **more
        )
        self.board.take(SocketMessage(Topic.NOW, vehicle, told.model_dump_json().encode()), self._deliver)

    def _deliver(self, data: bytes) -> None:
        frame = unpacked(data[LENGTH_BYTES:])
        command = PersonCommand.model_validate_json(frame.payload)
        self.commands.append(command)
        outcome = CommandResult(number=command.number, taken=True, told="Heard.")
        self.board.take(SocketMessage(Topic.OUTCOME, frame.vehicle, outcome.model_dump_json().encode()), self._deliver)

    def get(self, path, token=None, **more):
        return self.client.get(path, headers=self._headers(token) | more.pop("headers", {}), **more)

    def post(self, path, body=None, token=None, **more):
        headers = self._headers(token) | more.pop("headers", {})
        return self.client.post(path, json=body if body is not None else {}, headers=headers, **more)

    def say(self, text, **more):
        return self.post("/api/vehicles/car-1/say", {"text": text, **more})

    def _headers(self, token):
        return {"authorization": f"Bearer {self.passenger if token is None else token}"}
