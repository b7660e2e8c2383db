"""What a reasoner cost in a run: each query to a language model counts, whatever came of it."""

from __future__ import annotations

from contextlib import suppress

import pytest

from stucksolver.reasoners import ReasonerError, ReasonerRequest, SearchReasoner
from stucksolver.reasoners.fallback import FallbackReasoner
from stucksolver.reasoners.reasoner import ReasonerAnswer, ReasonerTrace
from stucksolver_eval.systems.timed_reasoner import TimedReasoner
from stucksolver_language.llm import BudgetExceededError
from worlds import World, straight_road, thing

REQUEST = ReasonerRequest(World(straight_road(), [thing("car", 60.0)]).scene())
COST = ReasonerTrace(model="m", input_tokens=100, output_tokens=50, usd=0.01, seconds=2.0)


class Model:
    """A language model that answers or fails as told."""

    name = "model"

    def __init__(self, *results) -> None:
        self.results = list(results)

    def preflight(self):
        return ()

    def decide(self, request):
        result = self.results.pop(0)
        if isinstance(result, Exception):
            raise result
        return ReasonerAnswer(SearchReasoner().decide(request).decision, self.name, result)


def failed(trace=COST, kind=ReasonerError):
    error = kind("no usable answer")
    error.trace = trace
    return error


def asked(*results, wrap=lambda model: model):
    timed = TimedReasoner(wrap(Model(*results)))
    for _ in results:
        with suppress(ReasonerError):
            timed.decide(REQUEST)
    return timed


def test_queries_with_and_without_a_usable_answer_are_charged():
    reliability = asked(COST, failed(), COST).reliability
    assert (reliability.queries, reliability.tokens, reliability.asked, reliability.unanswered) == (3, 450, 3, 1)
    assert reliability.usd == pytest.approx(0.03) and reliability.latencies_s == (2.0, 2.0, 2.0)


def test_query_that_was_not_sent_costs_nothing():
    reliability = asked(COST, failed(None, BudgetExceededError)).reliability
    assert (reliability.queries, reliability.tokens, reliability.asked) == (1, 150, 1)


def test_model_whose_place_the_rules_took_is_charged():
    """In a chain, the answer has the name of the rules, and the cost is the model's."""
    timed = asked(failed(), wrap=lambda model: FallbackReasoner([model, SearchReasoner()]))
    assert timed.answered_by == SearchReasoner().name and timed.tokens == 150
    assert timed.reliability.queries == 1


def test_chain_that_fails_is_charged_once():
    timed = asked(failed(), wrap=lambda model: FallbackReasoner([model]))
    assert timed.tokens == 150 and timed.reliability.queries == 1


def test_reasoner_without_tokens_has_no_queries_to_a_model():
    timed = TimedReasoner(SearchReasoner())
    timed.decide(REQUEST)
    assert timed.tokens == 0 and timed.reliability is None
