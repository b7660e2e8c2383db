"""Upper bounds on the use of a reasoner that costs money."""

from __future__ import annotations

from pydantic import Field

from stucksolver.scene.base_model import FrozenModel


class QueryBudget(FrozenModel):
    """Upper bounds on queries, tokens and money. None means unlimited, or the reasoner's own bound on a rung."""

    queries: int | None = Field(default=None, ge=0)
    """Number of queries. Checks of a plan before the decision do not count."""
    tokens: int | None = Field(default=None, ge=0)
    """Input and output tokens."""
    usd: float | None = Field(default=None, ge=0)
    """Cost (US dollars), with the price of the model."""
