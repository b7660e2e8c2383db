"""Bench2Drive's driving efficiency: the ego's speed relative to the traffic around it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

MOST_PCT = 1000.0
"""Largest entry that counts (%). As in Bench2Drive's tool."""
_PERCENTAGE = re.compile(r"\b(\d+\.?\d*)%")


def percentages(texts: Iterable[str]) -> list[float]:
    """Return the percentages in a record's minimum speed entries.

    Raises:
        ValueError: An entry has none.
    """
    found = []
    for text in texts:
        match = _PERCENTAGE.search(text)
        if match is None:
            raise ValueError(f"no percentage in a minimum speed entry: {text!r}")
        found.append(float(match[1]))
    return found


def route_efficiency(texts: Iterable[str]) -> float | None:
    """Return the mean of the entries up to 1000 %; None without any (the public tool divides by zero)."""
    counted = [value for value in percentages(texts) if value <= MOST_PCT]
    return sum(counted) / len(counted) if counted else None


def efficiency(routes: Iterable[Sequence[str]]) -> float | None:
    """Return the mean over the routes that have entries; None without any."""
    values = [value for texts in routes if (value := route_efficiency(texts)) is not None]
    return sum(values) / len(values) if values else None


def corrected_efficiency(routes: Iterable[tuple[Sequence[str], float | None]]) -> float | None:
    """Return the same value without the benchmark's two errors.

    The stretch on which a route got immobilized counts as well (the benchmark records a stretch only when its end is
    reached), and the last stretch counts once, not twice. Each route has the percentage on its unfinished stretch, or
    None if it reached its end.
    """
    values = []
    for texts, stuck_end in routes:
        entries = percentages(texts)
        if stuck_end is not None:
            entries.append(stuck_end)
        elif len(entries) > 1:
            entries.pop()
        counted = [value for value in entries if value <= MOST_PCT]
        if counted:
            values.append(sum(counted) / len(counted))
    return sum(values) / len(values) if values else None
