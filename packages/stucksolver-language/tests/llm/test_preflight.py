"""The preflight proves with the real schema what a server enforces, and says what it waits for."""

from __future__ import annotations

import json
from importlib.util import find_spec

import pytest
from answer_forms import SCENE, bytes_of, chat, reasoner_at
from chat_server import BEGUN, Fault, picture_of, said, schema_of

from stucksolver.reasoners import ReasonerRequest
from stucksolver_language.llm import preflight as preflight_module
from stucksolver_language.llm import waiting_notes
from stucksolver_language.llm.dialects import Dialect

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)


@pytest.mark.parametrize("ignored", ["READY", "Sure! READY.", '{"ready": true}', "```json\n{}\n```"])
def test_format_that_is_not_enforced_is_given_up_before_the_drive(server, ignored):
    """Ollama while thinking is off, and llama.cpp with some templates, accept a schema and do not keep to it."""
    server.faults.append(Fault(message=said(ignored)))
    reasoner = reasoner_at(server)
    (note,) = reasoner.preflight()
    assert "uses tool instead of schema" in note and reasoner.model.takes.dialect is Dialect.TOOL
    asked = len(server.requests)
    assert reasoner.decide(ReasonerRequest(SCENE)).decision.plan is not None
    assert len(server.requests) == asked + 1 and "tools" in server.requests[-1]


def test_server_that_enforces_nothing_gets_the_schema_as_text(server):
    server.think = lambda request: said("READY")
    reasoner = reasoner_at(server)
    reasoner.preflight()
    assert reasoner.model.takes.dialect is Dialect.PROSE


@pytest.mark.parametrize(
    "begun", [BEGUN, '{"analysis": {"steps"', '{\n  "obs', "<think></think>\n" + BEGUN, '{"observation"']
)
def test_answer_that_begins_as_the_schema_does_proves_it(server, begun):
    server.faults.append(Fault(message=said(begun), finish="length"))
    reasoner = reasoner_at(server)
    assert reasoner.preflight() == ()
    assert reasoner.model.takes.dialect is Dialect.JSON_SCHEMA


def test_schema_refused_in_the_drive_is_refused_in_the_preflight(server):
    """The preflight sends the schema of the drive, so no query of the drive is spent on a refusal."""

    def refuse_large(request):
        return "maxLength" in json.dumps(schema_of(request))

    server.refuses = (refuse_large, "The constraint has too many states for serving")
    reasoner = reasoner_at(server)
    (note,) = reasoner.preflight()
    assert "omits limits in the schema" in note
    asked = len(server.requests)
    reasoner.decide(ReasonerRequest(SCENE))
    assert len(server.requests) == asked + 1


def test_model_that_thinks_is_found_with_few_tokens(server):
    server.faults.append(Fault(body=bytes_of(chat(None, "length", reasoning="The user asks"))))
    reasoner = reasoner_at(server)
    (note,) = reasoner.preflight()
    assert "allows an answer 8000 tokens" in note and server.requests[0]["max_tokens"] == 32
    assert reasoner.model.takes.dialect is Dialect.JSON_SCHEMA


def test_picture_that_takes_no_tokens_was_dropped(server):
    """transformers serve accepts pictures for a model that reads text only."""
    server.counts_pictures = False
    reasoner = reasoner_at(server)
    (note,) = reasoner.preflight()
    assert "omits pictures" in note and "as many tokens as without" in note
    assert [picture_of(request) for request in server.requests] == [True, False]


def test_slow_server_is_named_with_what_is_waited_for(server, monkeypatch, capsys):
    monkeypatch.setattr(waiting_notes, "FIRST_NOTE_S", 0.1)
    server.faults.append(Fault(wait_s=0.5))
    reasoner_at(server).preflight()
    lines = capsys.readouterr().err.splitlines()
    assert "waiting for the answer to a short query with the schema of a decision, 0.1 of at most 120 s" in lines[0]
    assert 2 <= len(lines) <= 3 and preflight_module.LIMIT_S == 120.0


def test_server_that_answers_in_time_is_not_mentioned(server, capsys):
    reasoner_at(server).preflight()
    assert capsys.readouterr().err == "" and waiting_notes.FIRST_NOTE_S == 10.0
