"""Budgets by option and by the ladder's rung, what they count, and the estimate before the run."""

from __future__ import annotations

from contextlib import suppress
from importlib.util import find_spec

import pytest
from answer_forms import CHECK, SCENE, bytes_of, called, chat, reasoner_at, tools
from chat_server import Fault

from stucksolver.ladder import parse_ladder, profile_text
from stucksolver.query_budget import QueryBudget
from stucksolver.reasoners import ReasonerError, ReasonerRequest
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver_language.llm import BudgetExceededError
from stucksolver_language.llm.chat import Usage
from stucksolver_language.llm.model_options import parse_options
from stucksolver_language.llm.usage_budget import FREE_QUERIES, TRIP, cost_note, usage_limits_of

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)

OWN = "http://127.0.0.1:8000/v1"


def at(time_s):
    return ReasonerRequest(SCENE.model_copy(update={"time_s": time_s}))


def limits(*options, model="gpt-4o", url=None):
    return usage_limits_of(model, url, parse_options(list(options)))


# ---- bounds by option and by rung


def test_option_sets_the_bounds_of_an_intervention_and_of_a_trip():
    made = limits("intervention.queries=20", "intervention.tokens=off", "trip.usd=0.5")
    assert made.episode == QueryBudget(queries=20) and made.trip == TRIP.model_copy(update={"usd": 0.5})


def test_budget_of_the_option_is_enforced(server):
    reasoner = reasoner_at(server, "#intervention.queries=1")
    reasoner.decide(at(0.0))
    with pytest.raises(BudgetExceededError, match="intervention's budget of 1 queries is spent"):
        reasoner.decide(at(1.0))


def test_budget_in_money_ends_the_queries(server):
    reasoner = make_reasoner(f"openai:reader@{server.url}#price=100/0/100#trip.usd=0.01")
    reasoner.decide(ReasonerRequest(SCENE, deadline_s=20.0))
    with pytest.raises(BudgetExceededError, match=r"trip's budget of 0\.01 US dollars is spent"):
        reasoner.decide(ReasonerRequest(SCENE, deadline_s=20.0))


def test_budget_in_money_without_a_price_is_refused_by_name():
    with pytest.raises(ReasonerNameError, match="needs the price of the model"):
        make_reasoner(f"openai:m@{OWN}#trip.usd=1")


@pytest.mark.parametrize("option", ["trip.usd=-1", "trip.queries=many", "trip.usd=nan", "price=1/2", "price=a/b/c"])
def test_bound_that_is_no_number_is_named(option):
    with pytest.raises(ReasonerNameError, match="unknown option"):
        make_reasoner(f"openai:m@{OWN}#{option}")


@pytest.mark.parametrize(("option", "enforced"), [("", True), ("#intervention.queries=5", False)])
def test_rung_sets_the_budget_unless_the_user_did(server, option, enforced):
    reasoner = make_reasoner(f"openai:reader@{server.url}{option}")
    request = ReasonerRequest(SCENE, deadline_s=20.0, budget=QueryBudget(queries=1))
    reasoner.decide(request)
    if enforced:
        with pytest.raises(BudgetExceededError, match="budget of 1 queries"):
            reasoner.decide(request)
    else:
        reasoner.decide(request)


def test_ladder_file_states_the_budget_of_a_rung():
    text = profile_text("default").replace('kind = "model" ', 'budget = { queries = 20, usd = 0.1 }\nkind = "model" ')
    moves = [rung.move() for rung in parse_ladder(text, "mine.toml").rungs]
    budgets = [move.budget for move in moves if getattr(move, "reasoner", "") == "model"]
    assert budgets == [QueryBudget(queries=20, usd=0.1)]


# ---- what counts


def test_query_to_the_guard_costs_tokens_but_no_query(server):
    server.faults.append(Fault(body=bytes_of(tools(called(CHECK, "check_plan")))))
    reasoner = reasoner_at(server, "#call=tool")
    reasoner.decide(ReasonerRequest(SCENE, check=lambda plan: "accepted"))
    spent = reasoner.usage_limits.spent["intervention"]
    assert len(server.requests) == 2 and spent.queries == 1 and spent.tokens > 3000


USED = {"prompt_tokens": 700, "completion_tokens": 30}


@pytest.mark.parametrize(
    "fault",
    [
        Fault(body=bytes_of({**chat(None, refusal="No."), "usage": USED})),
        Fault(body=bytes_of({"error": {"message": "policy", "code": 400}, "usage": USED})),
        Fault(status=422, body=bytes_of({"error": {"message": "policy"}, "usage": USED})),
    ],
)
def test_refusal_with_a_usage_is_charged_with_it(server, fault):
    server.faults.append(fault)
    reasoner = reasoner_at(server)
    with pytest.raises(ReasonerError) as caught:
        reasoner.decide(ReasonerRequest(SCENE))
    assert reasoner.usage_limits.spent["trip"].tokens == 730
    assert (caught.value.trace.input_tokens, caught.value.trace.output_tokens) == (700, 30)


# ---- pauses


def test_budget_is_not_used_up_in_front_of_a_stream_that_never_opens(server):
    """Asked every 2 s, the eight queries last for more than a minute, and the next eight come after a minute more."""
    reasoner = reasoner_at(server)
    sent_s = []
    for time_s in range(0, 300, 2):
        asked = len(server.requests)
        with suppress(BudgetExceededError):
            reasoner.decide(at(float(time_s)))
        sent_s += [time_s] if len(server.requests) > asked else []
    assert len(sent_s[:FREE_QUERIES]) == FREE_QUERIES
    assert sent_s[:8] == [0, 2, 4, 6, 16, 36, 76, 136]
    assert any(time_s > 190 for time_s in sent_s)


def test_repair_needs_no_pause(server):
    reasoner = reasoner_at(server)
    for _ in range(FREE_QUERIES - 1):
        reasoner.usage_limits.add(Usage(1, 1))
    server.faults.append(Fault(message={"role": "assistant", "content": "{}"}))
    assert reasoner.decide(at(0.0)).decision.plan is not None


# ---- the estimate


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), ["0.016 US dollars a query", "at most about 1.3 US dollars a route"]),
        (("trip.usd=0.5",), ["at most about 0.5 US dollars a route"]),
        (("trip.queries=off", "trip.tokens=off"), ["without a limit for a route"]),
    ],
)
def test_cost_is_estimated_for_a_query_and_a_route(options, words):
    note = cost_note(limits(*options), True)
    assert note is not None and all(word in note for word in words)


@pytest.mark.parametrize(
    ("model", "url", "known"),
    [
        ("gpt-4o-2024-08-06", None, True),
        ("gpt-4o", OWN, False),
        ("claude-opus-4-7", "https://api.anthropic.com/v1", True),
        ("some-model", None, False),
    ],
)
def test_price_is_known_for_the_vendors_own_server_only(model, url, known):
    assert (cost_note(limits(model=model, url=url), True) is not None) is known


def test_preflight_states_the_estimate(server):
    notes = make_reasoner(f"openai:reader@{server.url}#price=2.5/1.25/10").preflight()
    assert any("US dollars a route" in note for note in notes)
