"""Reads the numbers of tokens that a response states."""

from __future__ import annotations

from typing import Any

from stucksolver_language.llm.chat import Usage


def usage_in(body: Any) -> Usage | None:
    """Return the tokens that a body states, in the names of any provider; None if it states none."""
    usage = body.get("usage") if isinstance(body, dict) else None
    places = [place for place in (usage, body) if isinstance(place, dict)]
    read = _count(places, ("prompt_tokens", "input_tokens", "prompt_eval_count"))
    if read is None:
        return None
    details = usage.get("prompt_tokens_details") if isinstance(usage, dict) else None
    cached = _count([details], ("cached_tokens",)) if isinstance(details, dict) else None
    written = _count(places, ("completion_tokens", "output_tokens", "eval_count"))
    return Usage(read, written or 0, cached or 0)


def _count(places: list[dict[str, Any]], names: tuple[str, ...]) -> int | None:
    stated = [place.get(name) for place in places for name in names]
    return next((n for n in stated if isinstance(n, int) and not isinstance(n, bool) and 0 <= n < 2**40), None)
