"""The model server: our own language-model reasoner can use it, and nothing that is sent makes it fail."""

from __future__ import annotations

import asyncio
import http.client
import json
import re
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager, suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient
from worlds import World, straight_road, thing

from stucksolver.decision import RecoveryPlan
from stucksolver.passenger import PageOptions
from stucksolver.passenger.server.places import PlaceLimits
from stucksolver.passenger.server.serving import make_server, serve
from stucksolver.reason import Request
from stucksolver.reason.distilled import Choice, DistilledReasoner
from stucksolver.reason.distilled.scene_text import write_scene
from stucksolver.reason.llm.prompt import user_text
from stucksolver.reason.llm.read_text import read_prompt
from stucksolver.reason.make import make_reasoner, preflight
from stucksolver.reason.reasoner import ACCEPTED
from stucksolver.scene import Guidance, LineKind
from stucksolver.serve import app as server
from stucksolver.serve.completions import MODEL, Student
from stucksolver.words import find_reader

PATH = "/v1/chat/completions"
ROAD = straight_road(left=LineKind.BROKEN)


def stuck(**update):
    found = World(ROAD, [thing("a", 62.0)], ()).scene()
    return found.model_copy(update={"ego": found.ego.model_copy(update={"stopped_for_s": 40.0}), **update})


@pytest.fixture(scope="module")
def student():
    return Student(DistilledReasoner(), find_reader())


@pytest.fixture(scope="module")
def client(student):
    app = server.behind_doors(server.make_app(student), frozenset({HOST}))
    json_headers = {"content-type": "application/json"}
    return TestClient(app, f"http://{HOST}", raise_server_exceptions=False, headers=json_headers)


HOST = "127.0.0.1:8000"


@contextmanager
def running(student, limits=server.PLACES, **options):
    """Serve on a free port, as the command does."""
    options = PageOptions(**options)
    bound = options.bound()
    addresses = options.addresses(bound.getsockname()[1])
    served = make_server(server.behind_doors(server.make_app(student), frozenset(addresses)), limits)
    thread = threading.Thread(target=lambda: asyncio.run(serve(served, [bound])), daemon=True)
    thread.start()
    try:
        yield f"http://{addresses[0]}/v1"
    finally:
        served.should_exit = True
        thread.join(10)


def body(text, **more):
    return {"model": MODEL, "messages": [{"role": "user", "content": text}], **more}


def wrong(response):
    """The error of a response, which must have OpenAI's form."""
    assert 400 <= response.status_code < 500
    error = response.json()["error"]
    assert set(error) == {"message", "type", "param", "code"}
    assert error["type"] == "invalid_request_error"
    return error


def test_our_language_model_reasoner_drives_with_it(student):
    with running(student) as url:
        model = make_reasoner(f"openai:{MODEL}@{url}")
        assert preflight(model, "student") == ()
        one = stuck()
        answer = model.decide(Request(one))
    own = student.reasoner.decide(Request(read_prompt(user_text(one)))).decision
    assert answer.decision.plan == own.plan
    assert answer.decision.analysis.cause == own.analysis.cause


@pytest.mark.parametrize("dialect", ["strict", "tool", "schema"])
def test_it_answers_in_each_form_that_our_client_asks_for(student, dialect):
    with running(student) as url:
        answer = make_reasoner(f"openai:{MODEL}@{url}#call={dialect}").decide(Request(stuck()))
    assert len(answer.trace.answers) == 1


def test_a_scene_of_the_students_own_text_is_answered_too(client, student):
    one = stuck()
    content = client.post(PATH, json=body(write_scene(one))).json()["choices"][0]["message"]["content"]
    plan = student.reasoner.decide(Request(read_scene_of(one))).decision.plan
    assert json.loads(content)["decision"]["behaviors"] == (
        None if plan is None else plan.model_dump(mode="json")["behaviors"]
    )


def read_scene_of(one):
    from stucksolver.reason.distilled.scene_text import read_scene

    return read_scene(write_scene(one))


def test_the_passengers_words_are_read(client):
    one = stuck(guidance=Guidance(text="please overtake the car", time_s=0.0))
    content = client.post(PATH, json=body(user_text(one))).json()["choices"][0]["message"]["content"]
    assert json.loads(content)["analysis"]["guidance_intent"] == "overtake"


def test_the_same_request_always_gets_the_same_answer(client):
    first, again = (client.post(PATH, json=body(user_text(stuck()))).json()["choices"] for _ in range(2))
    assert first == again


@pytest.mark.parametrize(
    ("sent", "told"),
    [
        (b"nonsense", "Invalid JSON"),
        (b"\xff\xfe", "Invalid JSON"),
        (b"{}", "model: Field required"),
        (b"[]", "the body"),
        (json.dumps(body("hello")).encode(), "no message of the user is a scene"),
        (json.dumps(body("stucksolver-scene/9\n")).encode(), "another version"),
        (json.dumps(body("x", stream=True)).encode(), "stream"),
        (json.dumps({**body("x"), "model": "gpt"}).encode(), "does not exist"),
        (json.dumps({**body("x"), "messages": []}).encode(), "messages"),
        (json.dumps(body("x", tools=[{"function": {"name": "sing"}}])).encode(), "decide"),
    ],
)
def test_a_wrong_request_gets_one_clear_error(client, sent, told):
    assert told in wrong(client.post(PATH, content=sent))["message"]


def test_another_address_is_an_error_that_names_the_right_one(client):
    assert PATH in wrong(client.get("/v1/sing"))["message"]
    assert PATH in wrong(client.get(PATH))["message"]


@pytest.mark.parametrize("size", [server.LARGEST_BYTES + 1, 3 * server.LARGEST_BYTES])
def test_request_that_is_too_large_is_refused(client, size):
    assert "picture" in wrong(client.post(PATH, content=b"x" * size))["message"]


# ---- whom it answers: as the passenger's page


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:8000", "127.0.0.1:9999", "localhost.evil.example:8000", "", "[::1]:8000"]
)
@pytest.mark.parametrize("path", [PATH, "/v1/models", "/health"])
def test_request_for_another_host_is_refused(client, host, path):
    """DNS rebinding: a page whose name points here still sends its own name."""
    sent = {"json": body("x")} if path == PATH else {}
    method = client.post if sent else client.get
    assert wrong(method(path, headers={"host": host}, **sent))


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:8001"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
@pytest.mark.parametrize("path", [PATH, "/v1/models", "/health"])
def test_request_from_a_page_of_another_site_is_refused(client, headers, path):
    method, sent = (client.post, {"json": body("x")}) if path == PATH else (client.get, {})
    assert method(path, headers=headers, **sent).status_code == 403


@pytest.mark.parametrize("kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""])
def test_request_as_a_form_sends_it_is_refused(client, kind):
    """A page may send these kinds to any address without asking first."""
    assert client.post(PATH, content=json.dumps(body("x")), headers={"content-type": kind}).status_code == 415


@pytest.mark.parametrize("host", ["LOCALHOST:{port}", "127.0.0.1:{port}", "Car.Example:{port}"])
def test_host_of_ours_is_answered_in_any_case(student, host):
    with running(student, names=("car.example",)) as url:
        port = int(url.rpartition(":")[2].partition("/")[0])
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
        connection.request("GET", "/v1/models", headers={"host": host.format(port=port)})
        assert connection.getresponse().status == 200
        connection.close()


@pytest.mark.parametrize("sent", ["nothing", "half a head", "a large half body"])
def test_server_beside_held_connections_answers(student, sent):
    """Sixty connections are more than it keeps."""
    with running(student) as url:
        port = int(url.rpartition(":")[2].partition("/")[0])
        start = {
            "nothing": b"",
            "half a head": b"POST " + PATH.encode(),
            "a large half body": f"POST {PATH} HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\ncontent-type: application/json\r\n"
            f"content-length: {server.LARGEST_BYTES}\r\n\r\n".encode()
            + b"x" * (server.LARGEST_BYTES - 1),
        }[sent]
        held = [socket.create_connection(("127.0.0.1", port), timeout=60) for _ in range(60)]
        for one in held:
            with suppress(OSError):  # it was ended, because newer ones came
                one.sendall(start)
        model = make_reasoner(f"openai:{MODEL}@{url}")
        assert model.decide(Request(stuck())).decision is not None
        for one in held:
            one.close()


def test_half_sent_request_is_ended(student):
    with running(student, PlaceLimits(waiting=4, request_s=0.3)) as url:
        port = int(url.rpartition(":")[2].partition("/")[0])
        with socket.create_connection(("127.0.0.1", port), timeout=60) as one:
            one.sendall(f"POST {PATH} HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\ncontent-length: 9\r\n".encode())
            with suppress(ConnectionError):
                assert one.recv(1000) == b""


@pytest.mark.integration
def test_command_without_a_usable_address_names_the_remedy():
    command = [sys.executable, "-m", "stucksolver", "serve-model", "--listen", "nowhere"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2 and "--listen" in done.stderr


JSON = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=12), inner, max_size=4),
    max_leaves=12,
)


@pytest.mark.integration
@given(
    st.dictionaries(st.sampled_from(["model", "messages", "tools", "tool_choice", "stream", "response_format"]), JSON)
)
@settings(max_examples=150, deadline=None)
def test_no_request_makes_it_fail(client, sent):
    wrong(client.post(PATH, json=sent))


@pytest.mark.integration
@given(st.data())
@settings(max_examples=100, deadline=None)
def test_a_damaged_scene_never_makes_it_fail(client, data):
    text = data.draw(st.sampled_from([user_text(stuck()), write_scene(stuck())]))
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(start + 40, len(text))))
    damaged = text[:start] + data.draw(st.text(max_size=10)) + text[end:]
    response = client.post(PATH, json=body(damaged))
    assert response.status_code == 200 or wrong(response)


@pytest.mark.integration
def test_missing_weights_end_the_command_with_the_remedy(tmp_path):
    command = [sys.executable, "-m", "stucksolver", "serve-model", "--weights", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    assert re.search(r"error: .*no student is there; train it again", done.stderr)


# ---- the guard, as the client offers it


def abandoned():
    """So long that the student no longer expects the wait to end."""
    one = stuck()
    return one.model_copy(update={"ego": one.ego.model_copy(update={"stopped_for_s": 70.0})})


def test_it_asks_the_guard_about_the_plan_that_it_proposes(student):
    asked: list[RecoveryPlan] = []

    def accept(plan: RecoveryPlan) -> str:
        asked.append(plan)
        return ACCEPTED

    with running(student) as url:
        answer = make_reasoner(f"openai:{MODEL}@{url}#call=strict").decide(Request(abandoned(), accept))
    assert asked == [answer.decision.plan]
    assert len(answer.trace.answers) == 2


def test_what_the_guard_refuses_is_not_proposed_while_there_is_another_plan():
    student = Student(DistilledReasoner(choice=Choice(unlikely=0.0)), find_reader())
    asked: list[RecoveryPlan] = []

    def refuse(plan: RecoveryPlan) -> str:
        asked.append(plan)
        return "collision: no"

    with running(student) as url:
        answer = make_reasoner(f"openai:{MODEL}@{url}#call=strict").decide(Request(abandoned(), refuse))
    # Our client lets a model ask twice.
    assert len(set(asked)) == 2
    assert answer.decision.plan is not None and answer.decision.plan not in asked


def test_a_client_that_always_offers_the_check_is_answered_in_the_end(client):
    tools = [{"type": "function", "function": {"name": name}} for name in ("decide", "check_plan")]
    messages = [{"role": "user", "content": user_text(abandoned())}]
    for _ in range(Choice().tried + 1):
        reply = client.post(PATH, json={"model": MODEL, "messages": messages, "tools": tools}).json()["choices"][0]
        (call,) = reply["message"]["tool_calls"]
        if call["function"]["name"] == "decide":
            break
        told = {"role": "tool", "tool_call_id": call["id"], "content": "sight: no"}
        messages += [reply["message"], told]
    assert call["function"]["name"] == "decide"
    assert len(messages) >= 3


def test_who_must_decide_does_not_ask(client):
    tools = [{"type": "function", "function": {"name": name}} for name in ("decide", "check_plan")]
    sent = body(user_text(abandoned()), tools=tools, tool_choice=tools[0])
    (call,) = client.post(PATH, json=sent).json()["choices"][0]["message"]["tool_calls"]
    assert call["function"]["name"] == "decide"


def test_a_call_of_the_check_without_a_plan_is_an_error(client):
    made = {"id": "x", "type": "function", "function": {"name": "check_plan", "arguments": "{}"}}
    sent = body(user_text(abandoned()))
    sent["messages"] += [
        {"role": "assistant", "content": None, "tool_calls": [made]},
        {"role": "tool", "tool_call_id": "x", "content": "accepted"},
    ]
    assert "check_plan holds no plan" in wrong(client.post(PATH, json=sent))["message"]
