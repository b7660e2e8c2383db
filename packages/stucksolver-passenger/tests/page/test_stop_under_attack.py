"""Stop and the operator are served whatever others send or hold open. Real servers, as an attacker meets them."""

from __future__ import annotations

import pytest

pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")
from itertools import count as counting

from attacking import attacked, files_for, head, status_of
from page_serving import Serving

from stucksolver_passenger.server.options import PageOptions
from stucksolver_passenger.server.process import PassengerServer

MANY = 2000
FEWER = 600
"""More than the server keeps."""


NUMBERS = counting(1)


@pytest.fixture(scope="module")
def server():
    with PassengerServer() as started:
        yield started


@pytest.fixture
def here(server):
    """Each test has a vehicle of its own, whose buckets are full."""
    with attacked(server, f"car-{next(NUMBERS)}") as found:
        yield found


WRONG = ["", "x", "o.AAAA", "p.car-1.AAAA", "p.car-2", "\u00e4", "a" * 5000]


@pytest.mark.integration
@pytest.mark.parametrize("token", WRONG)
def test_access_after_wrong_tokens_serves_valid_ones(token):
    """Wrong tokens are throttled; nobody else from the same address is."""
    serving, wrong = Serving(), {"authorization": f"Bearer {token}".encode()}
    codes = [serving.client.get("/api/me", headers=wrong).status_code for _ in range(40)]
    assert set(codes[:10]) == {401} and codes[-1] == 429
    assert serving.post("/api/vehicles/car-1/stop").status_code == 200
    assert serving.get("/api/queue", token=serving.operator).status_code == 200
    assert serving.client.get("/api/me", headers=wrong).status_code == 429


def test_stop_after_requests_without_a_token_is_taken(here):
    """As fifteen pictures on a page of another site send them, here to a real server."""
    assert {here.ask(path)[0] for path in ("/api/me", here.stop_path, "/api/queue") * 15} <= {401, 405, 429}
    assert here.stop() == 200
    assert here.ask("/api/queue", here.operator)[0] == 200


@pytest.mark.parametrize("path", ["/api/me", "/api/queue", "/api/vehicles/other"])
def test_stop_after_a_flood_of_valid_requests_is_taken(here, path):
    """The rate of all other requests is not Stop's."""
    for _ in range(200):
        here.ask(path, here.passenger)
    assert here.stop() == 200
    assert here.ask("/api/queue", here.operator)[0] == 200


COMMANDS = {
    "no": ("answer", {"yes": False, "question_id": "q"}),
    "yes": ("answer", {"yes": True, "question_id": "q"}),
    "help": ("help", {}),
    "say": ("say", {"text": "hello"}),
    "say stop": ("say", {"text": "stop!"}),
}


@pytest.mark.parametrize("kind", COMMANDS)
@pytest.mark.parametrize("same_page", [True, False])
def test_stop_after_a_flood_of_commands_is_taken(here, kind, same_page):
    """No other command fills the bucket of Stop, whether it comes from one page or from ever new ones."""
    path, body = COMMANDS[kind]
    clients = ["one" if same_page else f"c{i}" for i in range(60)]
    for client in clients:
        here.ask(here.path(path), here.passenger, {**body, "client": client})
    assert here.stop() == 200
    assert here.stop(here.operator) == 200


def test_operator_stop_after_a_passengers_stops_is_taken(here):
    for _ in range(60):
        here.stop()
    assert here.stop(here.operator) == 200


def test_spoken_stop_after_other_words_is_taken(here):
    say = here.path("say")
    for i in range(60):
        here.ask(say, here.passenger, {"text": "hello", "client": f"c{i}"})
    assert here.ask(say, here.passenger, {"text": "stop!"})[0] == 200


# ---- connections

HOLD = {
    "silent": lambda name: b"",
    "half a head": lambda name: head("GET", "/", name)[:-4],
    "half a body": lambda name: head("POST", "/api/vehicles/car-1/stop", name, length=1000) + b"{",
    "half a body with a wrong token": lambda name: (
        head("POST", "/api/vehicles/car-1/stop", name, token="o.x", length=1000) + b"{"
    ),
    "answers that nobody reads": lambda name: head("GET", "/files/page.css", name) * 8,
    "a body that a GET has not": lambda name: head("GET", "/", name, length=1000) + b"x",
    "no request": lambda name: b"\r\n\r\n",
    "another host": lambda name: head("GET", "/", "evil.example"),
}


@pytest.mark.parametrize("kind", HOLD)
def test_stop_beside_held_connections_is_answered(here, kind):
    """While all of them are still open on the attacker's side."""
    count = MANY if kind == "silent" else FEWER
    with files_for(count) as enough:
        if not enough:
            pytest.skip("this system allows too few open files")
        held = []
        try:
            for _ in range(count):
                held.append(here.connect())
                if sent := HOLD[kind](here.name):
                    held[-1].sendall(sent)
            assert here.stop() == 200
            assert here.stop(here.operator) == 200
            assert here.ask("/", None)[0] == 200
            assert all(item.fileno() >= 0 for item in held)
        finally:
            for item in held:
                item.close()


@pytest.mark.parametrize("token", ["passenger", "operator"])
def test_stop_beside_half_sent_requests_of_a_token_is_answered(here, token):
    """A holder of a token cannot hold the connections either."""
    secret = getattr(here, token)
    with files_for(FEWER) as enough:
        if not enough:
            pytest.skip("this system allows too few open files")
        held = []
        try:
            for i in range(FEWER):
                held.append(here.connect())
                path = here.path("stop" if i % 2 else "say")
                held[-1].sendall(head("POST", path, here.name, token=secret, length=1000) + b"{")
            assert here.stop() == 200
            assert here.stop(here.operator) == 200
        finally:
            for item in held:
                item.close()


def test_streams_of_one_passenger_leave_room_for_the_operator(here):
    stream = here.path("stream?pictures=false")
    opened = [here.opened(stream, here.passenger) for _ in range(105)]
    try:
        codes = [status for status, _ in opened]
        assert codes.count(200) <= 8 and set(codes) <= {200, 429}
        assert here.stop() == 200
        status, own = here.opened(stream, here.operator)
        opened.append((status, own))
        assert status == 200
        assert here.ask("/api/queue", here.operator)[0] == 200
    finally:
        for _, item in opened:
            item.close()


def test_streams_opened_at_once_are_counted(here):
    """All requests are sent before the first answer is read."""
    stream = here.path("stream?pictures=false")
    held = [here.connect() for _ in range(40)]
    try:
        for item in held:
            item.sendall(head("GET", stream, here.name, token=here.passenger))
        assert [status_of(item) for item in held].count(200) <= 8
    finally:
        for item in held:
            item.close()


@pytest.mark.integration
def test_stop_on_ipv6_beside_held_connections_is_answered():
    with (
        PassengerServer(PageOptions(listen="::1")) as server,
        attacked(server, host="::1") as here,
        files_for(FEWER) as enough,
    ):
        if not enough:
            pytest.skip("this system allows too few open files")
        held = [here.connect() for _ in range(FEWER)]
        try:
            assert here.stop() == 200
        finally:
            for item in held:
                item.close()


@pytest.mark.integration
def test_requests_in_a_pipeline_are_all_answered(here):
    """One connection, three requests sent at once, of which the second needs a token and has none."""
    with here.connect() as one:
        stop = head("POST", here.stop_path, here.name, token=here.passenger, length=2) + b"{}"
        one.sendall(head("GET", "/", here.name) + head("GET", "/api/me", here.name) + stop)
        text = b""
        while text.count(b"HTTP/1.1 ") < 3 or b'"taken"' not in text:
            part = one.recv(1 << 16)
            assert part, text[-300:]
            text += part
    first, refused, last = (int(line.split()[0]) for line in text.split(b"HTTP/1.1 ")[1:])
    # 429 if the tests before have just used up what this address may fail.
    assert (first, last) == (200, 200) and refused in (401, 429)
