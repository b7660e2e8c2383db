"""Servers of today, as their public reports describe them: one behavior of a server, one test."""

from __future__ import annotations

import json
from importlib.util import find_spec

import pytest
from answer_forms import CHECK, SCENE, T, bytes_of, called, chat, reasoner_at, tools
from chat_server import Fault

from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver_language.llm.capabilities import STEP_UP_AFTER
from stucksolver_language.llm.dialects import Dialect

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)


def refused(message, status=400):
    return Fault(status=status, body=bytes_of({"error": {"message": message, "code": status}}))


def repairs_refused(request):
    """True if a request brings back a call of the model."""
    return any("tool_calls" in message or message["role"] == "tool" for message in request["messages"])


# ---- errors as a list


def test_list_of_errors_stops_with_its_words(server):
    error = [{"error": {"code": 400, "message": "User location is not supported", "status": "FAILED_PRECONDITION"}}]
    server.faults.extend([Fault(status=400, body=bytes_of(error))] * 3)
    with pytest.raises(ReasonerError, match="User location is not supported"):
        reasoner_at(server).decide(ReasonerRequest(SCENE))
    assert len(server.requests) == 1


# ---- schemas that are too large


@pytest.mark.parametrize("status", [400, 429])
def test_schema_too_large_twice_leads_to_the_next_format(server, status):
    """The smaller schema has too many states as well."""
    server.faults.extend([refused("The constraint has too many states for serving.", status)] * 2)
    reasoner = reasoner_at(server)
    assert reasoner.decide(ReasonerRequest(SCENE)).decision.plan is not None
    full, smaller, other = server.requests
    assert "maxLength" in json.dumps(full) and "maxLength" not in json.dumps(smaller)
    assert "response_format" in smaller and "response_format" not in other
    reasoner.decide(ReasonerRequest(SCENE))
    assert len(server.requests) == 4


# ---- signatures


@pytest.mark.parametrize(
    "signed",
    [
        {"extra_content": {"google": {"thought_signature": "AY89=="}}},
        {"provider_specific_fields": {"thought_signature": "AY89=="}},
        {"thought_signature": "AY89=="},
    ],
)
def test_signature_comes_back_with_the_call_of_a_repair(server, signed):
    """Gemini's own endpoint, LiteLLM and other proxies put the signature in different fields."""
    wrong = json.dumps({**json.loads(T), "analysis": {}})
    server.faults.append(Fault(body=bytes_of(tools(called(wrong, **signed)))))
    assert reasoner_at(server, "#call=tool").decide(ReasonerRequest(SCENE)).decision.plan is not None
    (call,) = server.requests[1]["messages"][2]["tool_calls"]
    assert signed.items() <= call.items()


@pytest.mark.parametrize(
    "thoughts", [{"reasoning_content": "Hm."}, {"reasoning_details": [{"type": "reasoning.encrypted", "data": "x"}]}]
)
def test_thoughts_that_must_come_back_with_a_call_are_kept(server, thoughts):
    """DeepSeek and OpenRouter require them while a call is open."""
    answer = tools(called(CHECK, "check_plan"))
    answer["choices"][0]["message"].update(thoughts)
    server.faults.append(Fault(body=bytes_of(answer)))
    reasoner_at(server, "#call=tool").decide(ReasonerRequest(SCENE, check=lambda plan: "accepted"))
    assert thoughts.items() <= server.requests[1]["messages"][2].items()


# ---- answers that now and then are empty


def test_three_empty_answers_in_a_hundred_keep_the_format(server):
    reasoner = reasoner_at(server)
    for count in range(100):
        if count in (9, 40, 77):
            server.faults.append(Fault(body=bytes_of(chat(""))))
        assert reasoner.decide(ReasonerRequest(SCENE)).decision.plan is not None
        reasoner.usage_limits.new_episode()
        reasoner.usage_limits.spent["trip"].queries = reasoner.usage_limits.spent["trip"].tokens = 0
    assert len(server.requests) == 103
    assert reasoner.model.takes.dialect is Dialect.JSON_SCHEMA and reasoner.model.takes.notes == []


def test_format_after_two_empty_answers_is_left_for_a_while(server):
    """Two empty answers in a row are enough. The record says so, and says when the format is tried again."""
    server.faults.extend([Fault(body=bytes_of(chat("")))] * 2)
    reasoner = reasoner_at(server)
    traces = []
    for _ in range(STEP_UP_AFTER + 1):
        traces.append(reasoner.decide(ReasonerRequest(SCENE)).trace)
        reasoner.usage_limits.new_episode()
    assert len(traces[0].notes) == 1 and traces[0].notes[0].startswith("uses tool instead of schema")
    assert [trace.notes for trace in traces[1:-2]] == [()] * (STEP_UP_AFTER - 2)
    assert any(note.startswith("tries schema again") for trace in traces[-2:] for note in trace.notes)
    assert "response_format" in server.requests[-1]


# ---- calls that may not come back


@pytest.mark.parametrize(
    "said",
    [
        "Invalid function_call in message 2",
        "messages[2].tool_calls[0].function.arguments: not the function's schema",
        "Expected last role User or Tool (or Assistant with prefix True) for serving but got tool",
        "Tool call id was c1 but must be a-z, A-Z, 0-9, with a length of 9.",
    ],
)
def test_call_that_may_not_come_back_is_quoted_in_the_repair(server, said):
    wrong = json.dumps({**json.loads(T), "analysis": {}})
    server.faults.extend([Fault(body=bytes_of(tools(called(wrong)))), refused(said)])
    reasoner = reasoner_at(server, "#call=tool")
    assert reasoner.decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert [repairs_refused(request) for request in server.requests] == [False, True, False]
    assert "That answer cannot be used" in json.dumps(server.requests[2]["messages"][-1])
    assert "tools" in server.requests[2] and reasoner.model.takes.dialect is Dialect.TOOL


# ---- halves of characters


@pytest.mark.parametrize("where", ["text", "call", "thoughts", "model"])
def test_half_of_a_character_is_replaced_in_the_trace(server, where):
    """A file cannot store it: it ended the record of the trip."""
    broken = T.replace("pass it", "pass \\ud83d it")
    body = {"text": chat(broken), "call": tools(called(broken)), "thoughts": chat(T, reasoning="a\ud83d")}.get(
        where, {**chat(T), "model": "m\ud83d"}
    )
    server.faults.append(Fault(body=bytes_of(body)))
    answer = reasoner_at(server).decide(ReasonerRequest(SCENE))
    written = answer.trace.model_dump_json() + answer.decision.model_dump_json()
    written.encode("utf-8")
    if where in ("text", "call"):
        assert "pass \N{REPLACEMENT CHARACTER} it" in answer.decision.rationale
        assert any("\N{REPLACEMENT CHARACTER}" in text for text in answer.trace.answers)
