"""What a server refuses is omitted from then on, once, with one note; what can pass is waited for."""

from __future__ import annotations

import json
from importlib.util import find_spec

import pytest
from answer_forms import CHECK, OTHER, SCENE, T, bytes_of, called, chat, reasoner_at, tools
from chat_server import Fault, picture_of

from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver.scene import CameraImage
from stucksolver_language.llm import server_memory
from stucksolver_language.llm.capabilities import STEP_UP_AFTER, capabilities_of
from stucksolver_language.llm.dialects import Dialect
from stucksolver_language.llm.model_options import ModelOptions
from stucksolver_language.llm.server_failure import failure_of

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)

SEEN = SCENE.model_copy(update={"image": CameraImage(width=8, height=8, jpeg=b"/9j/AAAA")})


def refusal(message, status=400):
    """A refusal as servers state it: with its status, or inside a response of status 200, as proxies do."""
    return Fault(status=status, body=json.dumps({"error": {"message": message, "code": 400}}).encode())


def in_a_list(message):
    """A refusal as Gemini states it."""
    error = {"code": 400, "message": message, "status": "INVALID_ARGUMENT"}
    return Fault(status=400, body=json.dumps([{"error": error}]).encode())


def inside(message):
    return refusal(message, 200)


@pytest.mark.parametrize("stated", [refusal, in_a_list, inside])
@pytest.mark.parametrize(
    ("said", "options", "note", "changed"),
    [
        ("`temperature` is deprecated for this model", "", "omits temperature", lambda r: "temperature" not in r),
        (
            "Unsupported parameter: 'max_tokens'. Use 'max_completion_tokens' instead.",
            "",
            "omits max_tokens",
            lambda r: "max_tokens" not in r and r["max_completion_tokens"] == 1900,
        ),
        (
            "max_tokens is too large: 1900. This model supports at most 1024 completion tokens",
            "",
            "limits an answer to 1024 tokens",
            lambda r: r["max_tokens"] == 1024,
        ),
        (
            "deepseek-reasoner does not support this tool_choice",
            "#call=tool",
            "uses tool_choice required",
            lambda r: r["tool_choice"] == "required",
        ),
        (
            "The specified schema produces a constraint that has too many states for serving",
            "",
            "omits limits in the schema",
            lambda r: "maxLength" not in json.dumps(r) and "response_format" in r,
        ),
        (
            "For 'array' type, property 'maxItems' is not supported",
            "",
            "omits limits in the schema",
            lambda r: "maxItems" not in json.dumps(r) and "response_format" in r,
        ),
        (
            "This response_format type is unavailable now",
            "",
            "uses tool instead of schema",
            lambda r: "tools" in r and "response_format" not in r,
        ),
        (
            "System role not supported",
            "",
            "gets the system's text in the user's turn",
            lambda r: [m["role"] for m in r["messages"]] == ["user"] and "You never steer" in json.dumps(r["messages"]),
        ),
    ],
)
def test_refusal_changes_the_request_for_good(server, stated, said, options, note, changed):
    """The next request of the same query differs, later queries keep the change, and there is one note."""
    server.faults.append(stated(said))
    reasoner = reasoner_at(server, options)
    for _ in range(2):
        reasoner.decide(ReasonerRequest(SCENE))
    assert len(server.requests) == 3
    assert not changed(server.requests[0]) and changed(server.requests[1]) and changed(server.requests[2])
    notes = reasoner.model.takes.notes
    assert len(notes) == 1 and notes[0].startswith(note) and said[:40] in notes[0]


def test_system_text_joins_a_picture(server):
    server.faults.append(refusal("System role not supported"))
    reasoner_at(server).decide(ReasonerRequest(SEEN))
    assert [part["type"] for part in server.requests[1]["messages"][0]["content"]] == ["text", "text", "image_url"]


def test_tool_choice_is_weakened_step_by_step(server):
    server.faults.extend([refusal("tool_choice: only 'auto' is supported")] * 2)
    reasoner_at(server, "#call=tool").decide(ReasonerRequest(SCENE))
    named, *weaker = [request["tool_choice"] for request in server.requests]
    assert named["function"]["name"] == "decide" and weaker == ["required", "auto"]


def test_schema_refused_as_a_rate_limit_is_understood(server):
    server.faults.append(Fault(status=429, error={"message": "response_format: schema is too complex"}))
    assert reasoner_at(server).decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert "maxLength" not in json.dumps(server.requests[1])


@pytest.mark.parametrize("said", ["Could not process image", "invalid_image_format", "failed to decode the image"])
def test_one_refused_picture_is_the_only_one_omitted(server, said):
    server.faults.append(refusal(said))
    reasoner = reasoner_at(server)
    traces = [reasoner.decide(ReasonerRequest(SEEN)).trace for _ in range(2)]
    assert ["image_sha256" in trace.prompt for trace in traces] == [False, True]
    assert [picture_of(request) for request in server.requests] == [True, False, True]
    assert len(reasoner.model.takes.notes) == 1


@pytest.mark.parametrize(
    "thought", [{"content": ""}, {"content": "<think>The car"}, {"content": None, "reasoning": "The car"}]
)
def test_model_that_only_thought_gets_room_to_think(server, thought):
    """The limit is raised once, within the query, and stays."""
    server.faults.append(Fault(message={"role": "assistant", **thought}, finish="length"))
    reasoner = reasoner_at(server)
    for _ in range(2):
        assert reasoner.decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert [request["max_tokens"] for request in server.requests] == [1900, 8000, 8000]
    assert reasoner.model.takes.notes[0].startswith("allows an answer 8000 tokens")


@pytest.mark.parametrize(
    ("said", "then"),
    [
        ("max_tokens must be less than or equal to 4096", 4096),
        ("This model's maximum context length is 8192 tokens, and you requested 9900", 1900),
    ],
)
def test_room_to_think_that_the_server_lacks_is_given_back(server, said, then):
    thought = Fault(message={"role": "assistant", "content": ""}, finish="length")
    server.faults.extend([thought, refusal(said)])
    assert reasoner_at(server).decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert [request["max_tokens"] for request in server.requests] == [1900, 8000, then]


# ---- answers that now and then fail


def test_empty_answer_is_requested_again_in_the_same_format(server):
    server.faults.append(Fault(body=bytes_of(chat(""))))
    reasoner = reasoner_at(server)
    assert reasoner.decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert len(server.requests) == 2 and reasoner.model.takes.notes == []
    assert server.requests[0]["response_format"] == server.requests[1]["response_format"]


def test_format_that_got_prose_is_tried_again_after_many_answers(server):
    server.faults.append(Fault(body=bytes_of(chat("I would wait."))))
    reasoner = reasoner_at(server)
    for _ in range(STEP_UP_AFTER):
        reasoner.decide(ReasonerRequest(SCENE))
        reasoner.usage_limits.new_episode()
    assert all("tools" in request for request in server.requests[1:])
    reasoner.decide(ReasonerRequest(SCENE))
    assert "response_format" in server.requests[-1] and reasoner.model.takes.dialect is Dialect.JSON_SCHEMA


def test_format_that_was_refused_is_not_tried_again(server):
    server.faults.append(refusal("response_format is not supported"))
    reasoner = reasoner_at(server)
    for _ in range(STEP_UP_AFTER + 2):
        reasoner.decide(ReasonerRequest(SCENE))
        reasoner.usage_limits.new_episode()
    assert all("tools" in request for request in server.requests[1:])


# ---- the time to wait


@pytest.mark.parametrize(
    ("headers", "body", "wait_s"),
    [
        ({"retry-after-ms": "1500"}, {}, 1.5),
        ({"retry-after": "2"}, {}, 2.0),
        ({}, [{"error": {"details": [{"@type": "google.rpc.RetryInfo", "retryDelay": "34.5s"}]}}], 34.5),
        ({}, {"error": {"message": "Please try again in 20s."}}, 20.0),
        ({}, {"error": {"message": "Please retry in 250ms."}}, 0.25),
        ({"retry-after": "soon"}, {}, None),
        ({"retry-after": "nan"}, {}, None),
        ({}, {"error": {"message": "busy"}}, None),
    ],
)
def test_time_to_wait_is_read_wherever_it_stands(headers, body, wait_s):
    after_s = failure_of(body, 429, "busy", headers).after_s
    assert after_s == wait_s


@pytest.mark.parametrize(
    ("date", "waits"), [("Fri, 31 Dec 2100 23:59:59 GMT", True), ("Sat, 01 Jan 2000 00:00:00 GMT", False)]
)
def test_time_to_wait_may_be_a_date(date, waits):
    after_s = failure_of({}, 429, "busy", {"retry-after": date}).after_s
    assert (after_s > 1e9) if waits else (after_s == 0.0)


def test_server_is_not_asked_sooner_than_it_states(server):
    server.faults.append(Fault(status=429, headers={"retry-after-ms": "60000"}, error={"message": "slow down"}))
    with pytest.raises(ReasonerError, match="slow down"):
        reasoner_at(server, deadline_s=5.0).decide(ReasonerRequest(SCENE))
    assert len(server.requests) == 1


# ---- what goes back to the server


def test_signature_of_thoughts_comes_back_with_its_call(server):
    signed = {"google": {"thought_signature": "AY89=="}}
    server.faults.append(Fault(body=bytes_of(tools(called(CHECK, "check_plan", extra_content=signed)))))
    reasoner_at(server, "#call=tool").decide(ReasonerRequest(SCENE, check=lambda plan: "accepted"))
    (call,) = server.requests[1]["messages"][2]["tool_calls"]
    assert call["extra_content"] == signed


@pytest.mark.parametrize("broken", ["{oops", '{"a": 1', "nice", '"text"', "[1]"])
def test_broken_call_is_quoted_as_text_for_repair(server, broken):
    """A call whose arguments are no JSON object is not sent back as a call, which servers reject."""
    server.faults.append(Fault(body=bytes_of(tools(called(broken)))))
    assert reasoner_at(server, "#call=tool").decide(ReasonerRequest(SCENE)).decision.plan is not None
    answer, response = server.requests[1]["messages"][2:]
    assert "tool_calls" not in answer and broken in answer["content"] and response["role"] == "user"


def test_different_calls_are_answered_one_by_one(server):
    server.faults.append(Fault(body=bytes_of(tools(called(T), called(OTHER, id="c2")))))
    reasoner_at(server, "#call=tool").decide(ReasonerRequest(SCENE))
    responses = [m for m in server.requests[1]["messages"] if m["role"] == "tool"]
    assert [m["tool_call_id"] for m in responses] == ["c1", "c2"]


# ---- one negotiation for all clients


def test_later_client_of_the_same_model_starts_with_what_was_found(server):
    server.faults.append(refusal("`temperature` is deprecated for this model"))
    for _ in range(2):
        reasoner = reasoner_at(server)
        reasoner.decide(ReasonerRequest(SCENE))
    assert ["temperature" in request for request in server.requests] == [True, False, False]
    assert len(reasoner.model.takes.notes) == 1


def test_preflight_hands_down_what_it_found_to_other_processes(server, monkeypatch):
    """A new process has the environment and nothing else."""
    server.faults.extend([refusal("response_format is not supported"), refusal("temperature is not supported")])
    reasoner_at(server).preflight()
    monkeypatch.setattr(server_memory, "_known", {})
    asked = len(server.requests)
    reasoner_at(server).decide(ReasonerRequest(SCENE))
    assert len(server.requests) == asked + 1
    assert "tools" in server.requests[-1] and "temperature" not in server.requests[-1]


@pytest.mark.parametrize("found", ["", "no", "[1]", "null", '{"reader@http://127.0.0.1:9/v1#ModelOptions()": 1}'])
def test_unreadable_environment_is_ignored(monkeypatch, found):
    monkeypatch.setenv(server_memory.VARIABLE, found)
    takes = server_memory.remembered("reader", "http://127.0.0.1:9/v1", ModelOptions())
    assert takes == capabilities_of("reader", "http://127.0.0.1:9/v1", ModelOptions())


@pytest.mark.parametrize(
    "change", [{"pictures": "no", "most_tokens": "many", "dialects": ["shout"]}, {"dialects": 3}, {}]
)
def test_values_of_another_version_are_ignored(monkeypatch, change):
    key = f"reader@http://127.0.0.1:9/v1#{ModelOptions()}"
    monkeypatch.setenv(server_memory.VARIABLE, json.dumps({key: change}))
    takes = server_memory.remembered("reader", "http://127.0.0.1:9/v1", ModelOptions())
    assert takes == capabilities_of("reader", "http://127.0.0.1:9/v1", ModelOptions())


def test_other_options_negotiate_for_themselves(server):
    server.faults.append(refusal("response_format is not supported"))
    reasoner_at(server).decide(ReasonerRequest(SCENE))
    reasoner_at(server, "#call=schema").decide(ReasonerRequest(SCENE))
    assert "response_format" in server.requests[-1]
