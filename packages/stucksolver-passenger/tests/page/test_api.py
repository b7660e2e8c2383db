"""The HTTP API as a passenger, an operator and a stranger meet it."""

from __future__ import annotations

import pytest

pytest.importorskip("fastapi")
from page_serving import QUESTION, Serving

from stucksolver_passenger.access_tokens import TokenHolder
from stucksolver_passenger.api_types import CommandKind
from stucksolver_passenger.server.access import Streams
from stucksolver_passenger.server.rate_limits import (
    ALL_PASSENGER_STREAMS,
    COMMANDS,
    FAILURES,
    OPERATOR_STREAMS,
    PASSENGER_STREAMS,
)
from stucksolver_passenger.socket_frames import SocketMessage, Topic

READ = ("/api/me", "/api/vehicles/car-1", "/api/vehicles/car-1/camera.jpg", "/api/vehicles/car-1/stream")
SAID = [
    ("/api/vehicles/car-1/say", {"text": "hello"}),
    ("/api/vehicles/car-1/answer", {"yes": True, "question_id": "q1"}),
    ("/api/vehicles/car-1/stop", {}),
    ("/api/vehicles/car-1/help", {}),
]
OPERATING = [("get", "/api/vehicles"), ("get", "/api/queue"), ("post", "/api/queue/h1/close")]


@pytest.fixture
def serving():
    return Serving()


@pytest.mark.parametrize("token", ["", "x", "p.car-1.AAAA", "o.AAAA", "p.car-2", "\u00e4", "a" * 5000])
@pytest.mark.parametrize("path", READ)
def test_without_the_token_nothing_is_told(serving, path, token):
    answer = serving.client.get(path, headers={"authorization": f"Bearer {token}".encode()})
    assert answer.status_code == 401
    assert "I am standing" not in answer.text


@pytest.mark.parametrize(("path", "body"), SAID)
def test_without_the_token_nothing_is_done(serving, path, body):
    assert serving.post(path, body, token="wrong").status_code == 401
    assert serving.commands == []


@pytest.mark.parametrize(("path", "body"), SAID)
def test_what_a_passenger_does_reaches_the_vehicle(serving, path, body):
    answer = serving.post(path, body)
    assert (answer.status_code, answer.json()["taken"]) == (200, True)
    (command,) = serving.commands
    assert command.by == "passenger"


def test_a_passenger_of_one_car_has_no_say_in_another(serving):
    serving.join("car-2", "Car 2")
    assert serving.get("/api/vehicles/car-2").status_code == 403
    assert serving.post("/api/vehicles/car-2/say", {"text": "stop"}).status_code == 403
    assert serving.get("/api/vehicles/car-2/stream").status_code == 403
    assert serving.get("/api/me").json()["vehicles"] == {"car-1": "Car 1"}


def test_a_passenger_does_not_learn_which_cars_there_are(serving):
    assert serving.get("/api/vehicles/car-9").status_code == serving.get("/api/vehicles/car-1x").status_code == 403


@pytest.mark.parametrize(("method", "path"), OPERATING)
def test_a_passenger_is_no_operator(serving, method, path):
    assert getattr(serving, method)(path).status_code == 403


def test_an_operator_sees_and_speaks_to_all(serving):
    serving.join("car-2", "Car 2")
    assert serving.get("/api/vehicles", token=serving.operator).json() == {"car-1": "Car 1", "car-2": "Car 2"}
    serving.post("/api/vehicles/car-2/say", {"text": "wait"}, token=serving.operator)
    assert serving.commands[-1].by == "operator"


def test_operator_queue_lists_requests_of_all_vehicles(serving):
    """The queue lists the questions and calls for help of all vehicles that wait for an operator."""
    serving.join("car-2", "Car 2")
    serving.show("car-2", question=QUESTION)
    serving.post("/api/vehicles/car-1/help")
    queue = serving.get("/api/queue", token=serving.operator).json()
    assert {(call["vehicle"], call["kind"]) for call in queue} == {("car-1", "help"), ("car-2", "question")}


def test_an_answered_question_and_a_closed_call_leave_the_queue(serving):
    serving.show("car-1", question=QUESTION)
    serving.post("/api/vehicles/car-1/help")
    (call,) = [item for item in serving.get("/api/queue", token=serving.operator).json() if item["kind"] == "help"]
    assert serving.post(f"/api/queue/{call['id']}/close", token=serving.operator).status_code == 200
    serving.show("car-1")
    assert serving.get("/api/queue", token=serving.operator).json() == []


def test_help_is_called_once_however_often_it_is_pressed(serving):
    for _ in range(3):
        serving.post("/api/vehicles/car-1/help")
    assert len(serving.get("/api/queue", token=serving.operator).json()) == 1


def test_the_picture_is_an_image_and_nothing_else(serving):
    serving.board.take(SocketMessage(Topic.PICTURE, "car-1", b"\xff\xd8\xff\x00"), lambda data: None)
    answer = serving.get("/api/vehicles/car-1/camera.jpg")
    assert (answer.headers["content-type"], answer.content) == ("image/jpeg", b"\xff\xd8\xff\x00")


def test_a_car_that_has_left_says_so(serving):
    serving.board.take(SocketMessage(Topic.BYE, "car-1"), lambda data: None)
    answer = serving.say("hello")
    assert (answer.json()["taken"], answer.json()["told"]) == (False, "This ride is over.")


def test_api_requests_above_burst_are_rejected(serving):
    """Requests above the permitted burst get status 429; none within it does."""
    codes = [serving.say("hello", client="one").status_code for _ in range(4 * int(COMMANDS.burst))]
    assert codes[: int(COMMANDS.burst)] == [200] * int(COMMANDS.burst)
    assert 429 in codes


def test_a_stop_is_heard_however_much_was_said_before(serving):
    assert 429 in [serving.say("hello", client=f"c{i}").status_code for i in range(60)]
    assert serving.post("/api/vehicles/car-1/stop").status_code == 200
    assert serving.commands[-1].kind is CommandKind.STOP


def test_tokens_cannot_be_tried_for_ever(serving):
    codes = [serving.get("/api/me", token=f"p.car-1.{i}").status_code for i in range(int(FAILURES.burst) + 2)]
    assert codes[-1] == 429


def test_streams_of_each_kind_of_token_are_counted_apart():
    """Passengers with many vehicles' tokens leave the operators their pages."""
    streams, operator = Streams(), TokenHolder("operator")
    vehicles = [TokenHolder("passenger", f"car-{i}") for i in range(1 + ALL_PASSENGER_STREAMS // PASSENGER_STREAMS)]
    opened = [holder for holder in vehicles for _ in range(PASSENGER_STREAMS + 1) if streams.enter(holder)]
    assert opened.count(vehicles[0]) == PASSENGER_STREAMS and len(opened) == ALL_PASSENGER_STREAMS
    assert [streams.enter(operator) for _ in range(OPERATOR_STREAMS + 1)] == [True] * OPERATOR_STREAMS + [False]
    streams.leave(vehicles[0])
    assert streams.enter(vehicles[-1])


def test_openapi_document_has_every_call_with_token(serving):
    """The OpenAPI document lists the calls, and every call requires the token."""
    schema = serving.client.get("/openapi.json").json()
    assert set(schema["paths"]) >= {"/api/me", "/api/vehicles/{vehicle_id}/say", "/api/queue"}
    assert all(method["security"] for methods in schema["paths"].values() for method in methods.values())
