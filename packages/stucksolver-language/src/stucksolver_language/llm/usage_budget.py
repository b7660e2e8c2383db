"""Budgets of an intervention and of a trip. When one is spent, the ladder escalates to its next rung."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

from stucksolver_language.llm.chat import Message, PermanentReasonerError, Tool, Usage


class BudgetExceededError(PermanentReasonerError):
    """No query was sent, because the budget is spent."""


@dataclass(frozen=True)
class Budget:
    """Upper bounds; None means unlimited. `usd` is in US dollars, with the prices of `PRICES` or of the user."""

    queries: int | None = None
    tokens: int | None = None
    usd: float | None = None


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


PRICES = {
    "gpt-4o-2024-08-06": Price(2.50, 1.25, 10.00),
    "gpt-4o": Price(2.50, 1.25, 10.00),
    "gpt-4o-mini": Price(0.15, 0.075, 0.60),
    "gpt-4.1": Price(2.00, 0.50, 8.00),
    "gpt-4.1-mini": Price(0.40, 0.10, 1.60),
    "gpt-5": Price(1.25, 0.125, 10.00),
    "gpt-5-mini": Price(0.25, 0.025, 2.00),
}
"""OpenAI's published list prices for these models. The price of another model comes from the user, or is unknown."""


@dataclass
class BudgetUse:
    """Usage since the start of the budget. `usd` is None if the price of any reply is unknown."""

    queries: int = 0
    """Number of replies."""
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


EPISODE = Budget(queries=8, tokens=40_000)
"""Budget of one intervention. Ours: about 8 queries of 5,000 tokens."""
TRIP = Budget(queries=100, tokens=500_000)
"""Budget of one trip. Ours: about 12 interventions."""


class UsageLimits:
    """Enforces the budgets of an intervention and of a trip.

    The budget of an intervention begins with the first query after a pause (`new_episode`).

    Raises:
        ValueError: A bound in money is set for a model of unknown price.
    """

    def __init__(self, price: Price | None, episode: Budget = EPISODE, trip: Budget = TRIP) -> None:
        if price is None and (episode.usd is not None or trip.usd is not None):
            raise ValueError(
                "a budget in money needs the price of the model: give the price, or set the budget in tokens"
            )
        self.price, self._bounds = price, {"episode": episode, "trip": trip}
        self.spent = {"episode": BudgetUse(), "trip": BudgetUse()}

    def new_episode(self) -> None:
        """Start the budget of a new intervention: reset its usage."""
        self.spent["episode"] = BudgetUse()

    def check(self) -> None:
        """Check the budgets.

        Raises:
            BudgetExceededError: A bound has been reached.
        """
        for name, bound in self._bounds.items():
            spent = self.spent[name]
            for what, limit, used in (
                ("queries", bound.queries, spent.queries),
                ("tokens", bound.tokens, spent.tokens),
                ("US dollars", bound.usd, spent.usd),
            ):
                if limit is not None and used is not None and used >= limit:
                    raise BudgetExceededError(f"the {name}'s budget of {limit:g} {what} is spent")

    def add(self, usage: Usage) -> None:
        """Count the usage of a query, measured or estimated (`estimate`)."""
        for spent in self.spent.values():
            spent.add(usage, self.price)


CHARACTERS_FOR_A_TOKEN = 3
"""Characters per token, rounded down. Measured on prompts of this package: 3.3 with SmolLM2's encoding."""
PICTURE_TOKENS = 1_000
"""Approximate cost of a camera image of 800 x 450 (tokens). Each provider counts in its own way."""


def estimate(messages: Sequence[Message], tools: Sequence[Tool], answer_tokens: int) -> Usage:
    """Estimate the tokens of a query whose answer was late, or whose server does not count tokens."""
    text = sum(len(m.text) for m in messages) + sum(len(json.dumps(t.parameters)) for t in tools)
    pictures = sum(m.image is not None for m in messages)
    return Usage(text // CHARACTERS_FOR_A_TOKEN + pictures * PICTURE_TOKENS, answer_tokens)
