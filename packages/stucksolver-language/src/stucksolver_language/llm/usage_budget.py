"""Budgets of an intervention and of a trip. When one is spent, the ladder escalates to its next rung."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stucksolver.query_budget import QueryBudget
from stucksolver_language.llm.answer_form import Chain
from stucksolver_language.llm.chat import Message, PermanentReasonerError, Tool, Usage
from stucksolver_language.llm.model_families import listed_price
from stucksolver_language.llm.model_options import ModelOptions

INTERVENTION, TRIP_NAME = "intervention", "trip"


class BudgetExceededError(PermanentReasonerError):
    """No query was sent, because the budget is spent, or because the next query is not due yet."""


@dataclass(frozen=True)
class Price:
    """Price in US dollars per million tokens."""

    input_usd: float
    cached_usd: float
    output_usd: float

    def cost_of(self, usage: Usage) -> float:
        """Return the cost of a query (US dollars)."""
        fresh = usage.input_tokens - usage.cached_tokens
        spent = fresh * self.input_usd + usage.cached_tokens * self.cached_usd + usage.output_tokens * self.output_usd
        return spent / 1e6


@dataclass
class BudgetUse:
    """Usage since the start of the budget. `usd` is None if the price of any reply is unknown."""

    queries: int = 0
    """Number of replies, without those that queried the guard."""
    tokens: int = 0
    """Input and output tokens of all replies."""
    cached_tokens: int = 0
    """Input tokens that the server read from its prompt cache."""
    usd: float | None = 0.0
    """Cost of all replies (US dollars)."""

    def add(self, usage: Usage, price: Price | None) -> None:
        """Count one reply. Without a price, the sum in dollars is unknown from then on."""
        self.queries += 1
        self.tokens += usage.input_tokens + usage.output_tokens
        self.cached_tokens += usage.cached_tokens
        self.usd = None if self.usd is None or price is None else self.usd + price.cost_of(usage)


EPISODE = QueryBudget(queries=8, tokens=40_000)
"""Budget of one intervention. Ours: about 8 queries of 5,000 tokens."""
TRIP = QueryBudget(queries=100, tokens=500_000)
"""Budget of one trip. Ours: about 12 interventions."""
FREE_QUERIES = 4
"""Queries of an intervention without a pause between them. Ours: two plans, each with one repair."""
FIRST_PAUSE_S = 10.0
"""Pause before the next query of the intervention (s). It doubles with each: eight queries last 70 s at least. Ours.

Without it, they were used up within 20 s in front of traffic that never left a gap.
"""
MOST_PAUSE_S = 60.0
"""Longest pause between two queries of an intervention (s): that of a new budget. Ours."""


class UsageLimits:
    """Enforces the budgets of an intervention and of a trip.

    The budget of an intervention begins with the first query after a pause (`new_episode`).

    Args:
        price: Price of the model; None if it is unknown.
        episode: Budget of an intervention.
        trip: Budget of a trip.
        fixed: Names of the bounds of an intervention that a rung of the ladder does not replace.

    Raises:
        ValueError: A bound in money is set for a model of unknown price.
    """

    def __init__(
        self,
        price: Price | None,
        episode: QueryBudget = EPISODE,
        trip: QueryBudget = TRIP,
        fixed: frozenset[str] = frozenset(),
    ) -> None:
        if price is None and (episode.usd is not None or trip.usd is not None):
            raise ValueError(
                "a budget in money needs the price of the model: give the price, or set the budget in tokens"
            )
        self.price, self.episode, self.trip, self._fixed = price, episode, trip, fixed
        self.spent = {INTERVENTION: BudgetUse(), TRIP_NAME: BudgetUse()}
        self._last_s: float | None = None

    def new_episode(self) -> None:
        """Start the budget of a new intervention: reset its usage."""
        self.spent[INTERVENTION] = BudgetUse()
        self._last_s = None

    def check(self, rung: QueryBudget | None = None, now_s: float | None = None) -> None:
        """Check the budgets.

        Args:
            rung: Bounds of the ladder's rung for an intervention, which replace those that the user did not set.
            now_s: Time of the scene (s), for the pause between queries. None for a repair, which needs no pause.

        Raises:
            BudgetExceededError: A bound has been reached, or the next query is not due yet.
        """
        for name, bound in ((INTERVENTION, self._on_rung(rung)), (TRIP_NAME, self.trip)):
            spent = self.spent[name]
            for what, limit, used in (
                ("queries", bound.queries, spent.queries),
                ("tokens", bound.tokens, spent.tokens),
                ("US dollars", bound.usd, spent.usd),
            ):
                if limit is not None and used is not None and used >= limit:
                    raise BudgetExceededError(f"the {name}'s budget of {limit:g} {what} is spent")
                if limit is not None and used is None:
                    raise BudgetExceededError(f"the {name}'s budget in {what} needs the price of the model")
        self._check_pause(now_s)

    def begin_query(self, now_s: float) -> None:
        """Note that a query is sent at a time of the scene (s)."""
        self._last_s = now_s

    def add(self, usage: Usage) -> None:
        """Count the usage of a query, measured or estimated (`estimate`)."""
        for spent in self.spent.values():
            spent.add(usage, self.price)

    def refund_check(self) -> None:
        """Take back the count of a reply that queried the guard. Its tokens and its cost stay."""
        for spent in self.spent.values():
            spent.queries -= 1

    def _on_rung(self, rung: QueryBudget | None) -> QueryBudget:
        stated = {} if rung is None else rung.model_dump(exclude_none=True)
        return self.episode.model_copy(update={k: v for k, v in stated.items() if k not in self._fixed})

    def _check_pause(self, now_s: float | None) -> None:
        beyond = self.spent[INTERVENTION].queries - FREE_QUERIES
        if now_s is None or self._last_s is None or beyond < 0 or self.episode.queries is None:
            return
        left_s = self._last_s + min(FIRST_PAUSE_S * 2**beyond, MOST_PAUSE_S) - now_s
        if left_s > 0:
            raise BudgetExceededError(f"the next query of the intervention is due in {left_s:.0f} s")


def usage_limits_of(model: str, base_url: str | None, options: ModelOptions) -> UsageLimits:
    """Return the limits for a model: the user's options, and ours for the bounds that they do not set.

    Raises:
        ValueError: A bound in money is set for a model of unknown price.
    """
    stated = options.price or listed_price(model, base_url)
    set_by_user = dict(options.limits)
    return UsageLimits(
        None if stated is None else Price(*stated),
        _budget(EPISODE, INTERVENTION, set_by_user),
        _budget(TRIP, TRIP_NAME, set_by_user),
        frozenset(name.partition(".")[2] for name in set_by_user if name.startswith(INTERVENTION)),
    )


def _budget(ours: QueryBudget, scope: str, limits: Mapping[str, float]) -> QueryBudget:
    bounds: dict[str, float | None] = {}
    for name, bound in limits.items():
        of, _, what = name.partition(".")
        if of == scope:
            bounds[what] = None if bound == math.inf else bound if what == "usd" else int(bound)
    return ours.model_copy(update=bounds)


CHARACTERS_FOR_A_TOKEN = 3
"""Characters per token, rounded down. Measured on prompts of this package: 3.3 with SmolLM2's encoding."""
PICTURE_TOKENS = 1_000
"""Approximate cost of a camera image of 800 x 450 (tokens). Each provider counts in its own way."""
QUERY_TOKENS: dict[Chain, int] = {"short": 5_000, "long": 5_900}
ANSWER_TOKENS: dict[Chain, int] = {"short": 120, "long": 700}
"""Tokens of a usual query with the schema as a function, without the picture, and of its answer.

Measured with SmolLM2's encoding (`lab.benchmarks.answer_forms`): 2,400 for the messages with a menu, 2,620 and 3,460
for the schema; 60 to 90 and 310 to 380 for an answer, to which real models add.
"""


def estimate(messages: Sequence[Message], tools: Sequence[Tool], answer_tokens: int) -> Usage:
    """Estimate the tokens of a query whose answer was late, or whose server does not count tokens."""
    text = sum(len(m.text) for m in messages) + sum(len(json.dumps(t.parameters)) for t in tools)
    pictures = sum(m.image is not None for m in messages)
    return Usage(text // CHARACTERS_FOR_A_TOKEN + pictures * PICTURE_TOKENS, answer_tokens)


def cost_note(limits: UsageLimits, pictures: bool, chain: Chain = "short") -> str | None:
    """Return an estimate of the cost of a query and of a route before the run; None if the price is unknown.

    A route is a trip. The cost of thoughts is not known before the run, but the bound of the route includes them.
    """
    if limits.price is None:
        return None
    usual = Usage(QUERY_TOKENS[chain] + (PICTURE_TOKENS if pictures else 0), ANSWER_TOKENS[chain])
    query_usd = limits.price.cost_of(usual)
    trip = limits.trip
    bounds = [] if trip.queries is None else [trip.queries * query_usd]
    bounds += [] if trip.tokens is None else [trip.tokens * query_usd / (usual.input_tokens + usual.output_tokens)]
    bounds += [] if trip.usd is None else [trip.usd]
    most = f"and at most about {min(bounds):.2g} US dollars a route" if bounds else "without a limit for a route"
    return (
        f"costs about {query_usd:.2g} US dollars a query ({usual.input_tokens} tokens read, {usual.output_tokens} "
        f"written; thoughts and checks cost more), {most} (#trip.usd=N sets the limit)"
    )
