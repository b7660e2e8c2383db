"""The language-model reasoner against a real server: the real SDK talks to it."""

from __future__ import annotations

import base64
import functools
import json
import threading
import time
from dataclasses import replace
from importlib.util import find_spec

import pytest
from chat_server import Fault, available_in, call, scene_of

from stucksolver.ladder import PROFILES
from stucksolver.ladder import profile as ladder_profile
from stucksolver.ladder.rungs import ModelRung, ReasonerRung
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane
from stucksolver.query_budget import QueryBudget
from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver.scene import CameraImage, Guidance, LineKind
from stucksolver_language.llm import (
    LanguageModelReasoner,
    ModelSettings,
    PermanentReasonerError,
    Price,
    UsageLimits,
)
from stucksolver_language.llm.capabilities import capabilities_of
from stucksolver_language.llm.dialects import Dialect
from stucksolver_language.llm.model_options import ModelOptions
from stucksolver_language.llm.openai_api import OpenAiChat
from worlds import World, red_light, straight_road, thing

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)

MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
RAW = b"\xff\xd8" + bytes(range(256)) * 8
JPEG = base64.b64encode(RAW)


def scene(road=MULTI, objects=(), controls=(), **update):
    world = World(road, list(objects) or [thing("car", 60.0)], tuple(controls))
    made = world.scene()
    ego = made.ego.model_copy(update={"stopped_for_s": 20.0})
    return made.model_copy(update={"ego": ego, **update})


@functools.cache
def _chat(model, url):
    """Making the SDK's client costs a fifth of a second."""
    return OpenAiChat(model, url)


def reasoner(server, model="reader", usage_limits=None, **settings):
    """By strict tools first, as OpenAI's own server is asked."""
    chat = _chat(model, server.url)
    chat.takes = replace(capabilities_of(model, None, ModelOptions()), notes=[])
    return LanguageModelReasoner(chat, settings=ModelSettings(**settings), usage_limits=usage_limits)


def good(sc):
    """A right answer's arguments, to be spoilt."""
    import mind

    from stucksolver_language.llm.prompt import messages

    return mind.answer(messages(sc)[1].text, available_in(messages(sc)[1].text))


def spoilt(sc, change):
    data = good(sc)
    change(data)
    return Fault(message=call("decide", json.dumps(data)))


# ---- the way there and back


@pytest.mark.integration
def test_model_reasoner_parked_car_is_passed_in_adjacent_lane(server):
    """A parked car in the ego's lane is passed with a change to the free adjacent lane."""
    decision = reasoner(server).decide(ReasonerRequest(scene())).decision
    assert isinstance(decision.plan.behaviors[0], ChangeLane)
    assert [s.id for s in decision.analysis.steps] == ["S2.2", "S2.3", "S2.4", "S2.5"]


def test_a_red_light_means_no_plan(server):
    assert reasoner(server).decide(ReasonerRequest(scene(controls=[red_light(8.0)]))).decision.plan is None


def test_guidance_asks_its_own_question(server):
    words = Guidance(text="please overtake them", time_s=0.0)
    decision = reasoner(server).decide(ReasonerRequest(scene(guidance=words))).decision
    assert [s.id for s in decision.analysis.steps] == ["S2.1"]
    assert decision.plan is not None


def test_model_request_is_one_strict_call_with_image(server):
    """The request forces one call of a strict tool, without parallel calls, and contains the image."""
    reasoner(server).decide(ReasonerRequest(scene(image=CameraImage(width=8, height=8, jpeg=JPEG))))
    request = server.requests[0]
    assert request["tools"][0]["function"]["strict"] is True
    assert request["tool_choice"]["function"]["name"] == "decide"
    assert request["parallel_tool_calls"] is False
    assert request["messages"][1]["content"][1]["image_url"]["url"].startswith("data:image/jpeg;base64,")


def test_distances_are_those_that_were_measured(server):
    sc = scene(controls=[red_light(8.0)])
    decision = reasoner(server).decide(ReasonerRequest(sc)).decision
    assert decision.observation.controls[0].distance_m == sc.controls[0].distance_m


@pytest.mark.parametrize(
    ("lacks", "dialect"),
    [
        ({"strict"}, Dialect.TOOL),
        ({"tools"}, Dialect.JSON_SCHEMA),
        ({"tools", "schema"}, Dialect.PROSE),
    ],
)
def test_model_server_lacking_feature_steps_down_dialect_once(server, lacks, dialect):
    """A server that lacks a feature is queried in the next dialect, and later queries keep that dialect."""
    server.lacks = lacks
    asking = reasoner(server)
    assert asking.decide(ReasonerRequest(scene())).decision.plan is not None
    assert asking.model.takes.dialect is dialect
    before = len(server.requests)
    asking.decide(ReasonerRequest(scene()))
    assert len(server.requests) == before + 1


# ---- misbehavior


def test_prose_around_the_answer_is_overlooked(server):
    text = json.dumps(good(scene()))
    server.faults.append(Fault(message={"role": "assistant", "content": f"Sure!\n{text}\nDrive safely."}))
    assert reasoner(server).decide(ReasonerRequest(scene())).decision.plan is not None


SPOILED = {
    "an unknown object": lambda d: d["decision"]["behaviors"].append(
        {"name": "drive_over", "object_id": "ghost", "speed_mps": 1.0}
    ),
    "an unknown waypoint": lambda d: d["decision"].update(replan_route=True, route_start="w99"),
    "an extra field": lambda d: d["decision"].update(steering=0.4),
    "a missing step": lambda d: d["analysis"]["steps"].pop("S2.4"),
    "a number out of bounds": lambda d: d["decision"]["behaviors"][0].update(speed_mps=40.0),
    "a number as text": lambda d: d["decision"]["behaviors"][0].update(speed_mps="4"),
    "an unknown behaviour": lambda d: d["decision"]["behaviors"][0].update(name="fly"),
    "a contradiction": lambda d: d["analysis"].update(immobilized=False),
    "too many behaviours": lambda d: d["decision"].update(behaviors=d["decision"]["behaviors"] * 7),
    "an empty plan": lambda d: d["decision"].update(behaviors=[]),
}


@pytest.mark.parametrize("what", SPOILED)
def test_model_invalid_answer_is_repaired_with_one_request(server, what):
    """An invalid answer is sent back once with its error, and the corrected answer is used."""
    sc = scene()
    server.faults.append(spoilt(sc, SPOILED[what]))
    decision = reasoner(server).decide(ReasonerRequest(sc)).decision
    assert isinstance(decision.plan.behaviors[0], ChangeLane)
    assert len(server.requests) == 2
    told = server.requests[1]["messages"][-1]
    assert told["role"] == "tool" and "cannot be used" in told["content"]


def test_model_answer_still_invalid_after_repair_fails(server):
    """An answer that is still invalid after one repair is a failure of the reasoner."""
    sc = scene()
    server.faults.extend([spoilt(sc, SPOILED["an extra field"])] * 5)
    with pytest.raises(ReasonerError, match="invalid answer"):
        reasoner(server).decide(ReasonerRequest(sc))
    assert len(server.requests) == 2


def test_the_wrong_tool_is_repaired_too(server):
    server.faults.append(Fault(message=call("open_door", '{"side": "left"}')))
    assert reasoner(server).decide(ReasonerRequest(scene())).decision.plan is not None


@pytest.mark.parametrize(
    "body", [b"", b"<html>", b"[]", b'{"choices": []}', b'{"choices": [{}]}', b'{"choices": 3}', b"\xff\xfe"]
)
def test_model_response_without_completion_raises_reasoner_error(server, body):
    """A response body that is not a completion raises a ReasonerError, and no other exception."""
    server.faults.extend([Fault(body=body)] * 20)
    with pytest.raises(ReasonerError):
        reasoner(server, deadline_s=0.6).decide(ReasonerRequest(scene()))


def test_a_refusal_is_told_as_such(server):
    server.faults.append(Fault(message={"role": "assistant", "content": None, "refusal": "I cannot help with that"}))
    with pytest.raises(PermanentReasonerError, match="declines"):
        reasoner(server).decide(ReasonerRequest(scene()))


@pytest.mark.parametrize("status", [429, 500, 502, 503])
def test_a_busy_server_is_asked_again(server, status):
    server.faults.append(Fault(status=status))
    assert reasoner(server).decide(ReasonerRequest(scene())).decision.plan is not None
    assert len(server.requests) == 2


def test_a_server_that_says_when_is_not_asked_sooner(server):
    server.faults.append(Fault(status=429, headers={"retry-after": "30"}))
    with pytest.raises(ReasonerError, match="limits the rate"):
        reasoner(server, deadline_s=1.0).decide(ReasonerRequest(scene()))
    assert len(server.requests) == 1


def test_a_connection_that_is_cut_is_tried_again(server):
    server.faults.append(Fault(cut_after=40))
    assert reasoner(server).decide(ReasonerRequest(scene())).decision.plan is not None


def test_a_slow_server_ends_at_the_deadline(server):
    server.faults.append(Fault(wait_s=100.0))
    began = time.monotonic()
    with pytest.raises(ReasonerError, match="deadline"):
        reasoner(server, deadline_s=0.3).decide(ReasonerRequest(scene()))
    assert time.monotonic() - began < 50.0


def test_a_question_that_is_withdrawn_ends_before_the_answer(server):
    server.faults.append(Fault(wait_s=100.0))
    asking = reasoner(server, deadline_s=80.0)
    failures: list[BaseException] = []

    def ask():
        try:
            asking.decide(ReasonerRequest(scene()))
        except ReasonerError as error:
            failures.append(error)

    thread = threading.Thread(target=ask)
    thread.start()
    while not server.requests:
        time.sleep(0.01)
    asking.cancel()
    thread.join(50.0)
    assert not thread.is_alive()
    assert "canceled" in str(failures[0])


# ---- what to set


def test_no_key_says_which_variable_to_set(monkeypatch):
    monkeypatch.delenv("OPENAI_API_KEY", raising=False)
    monkeypatch.delenv("OPENAI_BASE_URL", raising=False)
    with pytest.raises(PermanentReasonerError, match="OPENAI_API_KEY"):
        LanguageModelReasoner(OpenAiChat("gpt-4o")).decide(ReasonerRequest(scene()))


def test_a_wrong_key_says_which_variable_to_set(server, monkeypatch):
    monkeypatch.setenv("OPENAI_API_KEY", "wrong")
    server.key = "right"
    with pytest.raises(PermanentReasonerError, match="OPENAI_API_KEY"):
        LanguageModelReasoner(OpenAiChat("reader", server.url)).decide(ReasonerRequest(scene()))


def test_an_unknown_model_is_named(server):
    with pytest.raises(PermanentReasonerError, match="'absent'"):
        reasoner(server, model="absent").decide(ReasonerRequest(scene()))


def test_nobody_there_says_where():
    with pytest.raises(ReasonerError, match=r"127\.0\.0\.1:9.*cannot be reached"):
        asking = LanguageModelReasoner(OpenAiChat("m", "http://127.0.0.1:9/v1"), settings=ModelSettings(deadline_s=0.5))
        asking.decide(ReasonerRequest(scene()))


def test_an_image_that_is_too_large_is_said_to_be(server):
    big = CameraImage(width=8, height=8, jpeg=base64.b64encode(RAW * 3000))
    with pytest.raises(PermanentReasonerError, match="smaller camera"):
        reasoner(server).decide(ReasonerRequest(scene(image=big)))


# ---- the guard may be asked


def test_the_model_may_ask_the_guard_before_it_commits(server):
    sc = scene(straight_road())
    plan = {"behaviors": [{"name": "borrow_oncoming_lane", "past_object_id": "car", "speed_mps": 5.0}]}
    server.faults.append(Fault(message=call("check_plan", json.dumps(plan))))
    asking, asked = reasoner(server), []
    asking.decide(ReasonerRequest(sc, check=lambda p: asked.append(p) or "refused: oncoming_gap"))
    assert isinstance(asked[0].behaviors[0], BorrowOncomingLane)
    assert server.requests[1]["messages"][-1]["content"] == "refused: oncoming_gap"


def test_questions_to_the_guard_are_bounded(server):
    ask = Fault(message=call("check_plan", '{"behaviors": [{"name": "creep", "distance_m": 2, "speed_mps": 1}]}'))
    server.faults.extend([ask] * 2)
    asking = reasoner(server, checks=2)
    assert asking.decide(ReasonerRequest(scene(), check=lambda plan: "accepted")).decision.plan is not None
    last = server.requests[-1]
    assert [t["function"]["name"] for t in last["tools"]] == ["decide"]


# ---- what it costs


def test_a_trace_tells_prompt_answers_and_tokens(server):
    asking = reasoner(server)
    trace = asking.decide(ReasonerRequest(scene(image=CameraImage(width=8, height=8, jpeg=JPEG)))).trace
    turns = json.loads(trace.prompt)
    assert "image_sha256" in turns[1] and turns[1]["text"] == scene_of(server.requests[0])
    assert json.loads(trace.answers[-1])["choice"]
    assert trace.input_tokens > 100 and trace.output_tokens == 200


def test_a_spent_budget_is_a_failure_without_a_request(server):
    asking = reasoner(server, usage_limits=UsageLimits(None, episode=QueryBudget(queries=2)))
    for _ in range(2):
        asking.decide(ReasonerRequest(scene()))
    with pytest.raises(PermanentReasonerError, match="budget of 2 queries"):
        asking.decide(ReasonerRequest(scene()))
    assert len(server.requests) == 2


def test_progress_begins_a_new_episode_but_not_a_new_trip(server):
    asking = reasoner(
        server, usage_limits=UsageLimits(None, episode=QueryBudget(queries=1), trip=QueryBudget(queries=2))
    )

    def at(left):
        made = scene()
        return made.model_copy(update={"ego": made.ego.model_copy(update={"distance_to_destination_m": left})})

    asking.decide(ReasonerRequest(at(200.0)))
    with pytest.raises(PermanentReasonerError, match="intervention"):
        asking.decide(ReasonerRequest(at(199.0)))
    asking.decide(ReasonerRequest(at(150.0)))
    with pytest.raises(PermanentReasonerError, match="trip"):
        asking.decide(ReasonerRequest(at(100.0)))


def test_money_is_counted_by_the_price(server):
    asking = reasoner(server, usage_limits=UsageLimits(Price(1e6, 0.0, 0.0)))
    trace = asking.decide(ReasonerRequest(scene())).trace
    assert asking.usage_limits.spent["trip"].usd == pytest.approx(trace.input_tokens)
    assert trace.usd == asking.usage_limits.spent["trip"].usd


def test_a_budget_in_money_needs_a_price():
    with pytest.raises(ValueError, match="price"):
        UsageLimits(None, trip=QueryBudget(usd=1.0))


def test_the_prompt_offers_only_what_can_be_done_here(server):
    reasoner(server).decide(ReasonerRequest(scene(straight_road(oncoming=None))))
    names = available_in(scene_of(server.requests[0]))
    assert "change_lane" not in names and "borrow_oncoming_lane" not in names and "drive_over" not in names


EXCHANGE_S = 2.8
"""Duration of an exchange in the paper (s)."""


@pytest.mark.parametrize("profile", PROFILES)
def test_deadline_of_the_rung_allows_every_check_and_the_decision(profile):
    rungs = [rung for rung in ladder_profile(profile).rungs if isinstance(rung, ReasonerRung | ModelRung)]
    needed = (ModelSettings().checks + 1) * EXCHANGE_S
    assert [rung.deadline_s >= needed for rung in rungs] == [True, True]
    assert ModelSettings().deadline_s >= needed and ModelRung().deadline_s >= needed
