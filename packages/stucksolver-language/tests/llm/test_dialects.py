"""One decision in the forms in which models and servers give it: each is read at once, and as the same decision."""

from __future__ import annotations

import json
from importlib.util import find_spec

import pytest
from answer_forms import CHECK, CHECKS, OTHER, READ, SCENE, T, bytes_of, called, chat, reasoner_at, tools
from chat_server import Fault

from stucksolver.reasoners import ReasonerRequest
from stucksolver_language.llm import parse_answer

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)


def plain(decision):
    return decision.model_dump(exclude={"rationale"})


@pytest.mark.parametrize("form", READ)
def test_answer_form_is_read(server, form):
    """A decision is read at once, whatever form it has, and is the decision that the model gave."""
    server.faults.append(Fault(body=bytes_of(READ[form])))
    answer = reasoner_at(server).decide(ReasonerRequest(SCENE))
    assert plain(answer.decision) == plain(parse_answer(T, SCENE))
    assert "parked" in answer.decision.rationale
    assert len(server.requests) == 1


@pytest.mark.parametrize("form", CHECKS)
def test_query_to_the_guard_form_is_executed(server, form):
    server.faults.append(Fault(body=bytes_of(CHECKS[form])))
    asked = []
    request = ReasonerRequest(SCENE, check=lambda plan: asked.append(plan) or "accepted")
    assert reasoner_at(server, "#call=tool").decide(request).decision.plan is not None
    assert [b.name for b in asked[0].behaviors] == ["creep"] and len(server.requests) == 2


def test_different_decisions_in_one_answer_are_returned_for_repair(server):
    server.faults.append(Fault(body=bytes_of(tools(called(T), called(OTHER, id="c2")))))
    assert reasoner_at(server).decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert "more than one" in json.dumps(server.requests[1]["messages"][-2:])


def test_of_several_queries_to_the_guard_the_first_is_executed(server):
    """Each call gets its own response. Only the first is checked."""
    other = json.dumps({"behaviors": [{"name": "creep", "distance_m": 3, "speed_mps": 1}]})
    both = tools(called(CHECK, "check_plan"), called(other, "check_plan", id="c2"))
    server.faults.append(Fault(body=bytes_of(both)))
    asked = []
    request = ReasonerRequest(SCENE, check=lambda plan: asked.append(plan) or "accepted")
    reasoner_at(server, "#call=tool").decide(request)
    responses = [m["content"] for m in server.requests[1]["messages"] if m["role"] == "tool"]
    assert len(asked) == 1 and responses == ["accepted", "Not considered: one call at a time."]


def test_draft_in_thoughts_that_were_cut_off_is_no_answer(server):
    server.faults.append(Fault(body=bytes_of(chat("", "length", reasoning_content=T))))
    reasoner_at(server, "#tokens=1900").decide(ReasonerRequest(SCENE))
    assert "while the model was thinking" in json.dumps(server.requests[1]["messages"][-1])
