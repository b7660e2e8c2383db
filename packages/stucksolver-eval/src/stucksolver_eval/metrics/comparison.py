"""Compares two evaluations of the same routes, with the uncertainty of the difference."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver.commands.terminal_text import filled
from stucksolver_eval.metrics.columns import RECOVERY_HEAD as RECOVERY
from stucksolver_eval.metrics.columns import number, recovery_row, run_name
from stucksolver_eval.metrics.paired_statistics import Difference, Interval, bootstrap, compare_pairs
from stucksolver_eval.metrics.summary import RouteRow, Summary
from stucksolver_eval.terminal_table import table

FIGURES: dict[str, Callable[[RouteRow], float]] = {
    "driving score": lambda row: row.score,
    "success rate %": lambda row: 100.0 * row.success,
    "route completion %": lambda row: 0.0 if row.record is None else row.record.scores.score_route,
}


class ComparisonError(ValueError):
    """Two evaluations cannot be compared. The message says why."""


Compared = dict[str, tuple[Interval, Interval, Difference]]


def comparison(first: Summary, second: Summary) -> Compared:
    """Return each metric of both, and of the paired difference.

    Raises:
        ComparisonError: They have no routes or seeds in common.
    """
    ours, theirs = first.manifest, second.manifest
    if ours.suite_digest != theirs.suite_digest:
        raise ComparisonError(
            f"different routes: A has {ours.routes} of {ours.suite}, B has {theirs.routes} of {theirs.suite}. "
            "Compare evaluations of the same routes"
        )
    if not set(ours.seeds) & set(theirs.seeds):
        raise ComparisonError(f"no seed in common: {ours.seeds} and {theirs.seeds}. Run both with the same seeds")
    return {name: _compared(first, second, figure) for name, figure in FIGURES.items()}


def _compared(
    first: Summary, second: Summary, figure: Callable[[RouteRow], float]
) -> tuple[Interval, Interval, Difference]:
    a, b = _by_route(first, figure), _by_route(second, figure)
    differences = [[b[route][seed] - a[route][seed] for seed in a[route] if seed in b[route]] for route in a]
    return (
        bootstrap([list(values.values()) for values in a.values()]),
        bootstrap([list(values.values()) for values in b.values()]),
        compare_pairs(differences),
    )


def _by_route(summary: Summary, figure: Callable[[RouteRow], float]) -> dict[str, dict[int, float]]:
    found: dict[str, dict[int, float]] = {}
    for row in summary.rows:
        found.setdefault(row.route.id, {})[row.seed] = figure(row)
    return found


def comparison_text(first: Summary, second: Summary, compared: Compared) -> str:
    """Return tables for a terminal, and the routes on which the two differ in success."""
    head = ("", f"A: {run_name(first)}", f"B: {run_name(second)}", "B - A [95 %]", "p", "routes")
    rows = [
        (name, _interval(a), _interval(b), _interval(d.difference), f"{d.p:.4f}", str(d.pairs))
        for name, (a, b, d) in compared.items()
    ]
    parts = [table(head, rows), table(RECOVERY, [recovery_row(first), recovery_row(second)])]
    won, lost = _flips(first, second)
    flips = (f"won by B: {', '.join(won) or 'none'}", f"lost by B: {', '.join(lost) or 'none'}")
    parts.append("\n".join(map(filled, flips)))
    return "\n\n".join(parts)


def _interval(interval: Interval) -> str:
    return f"{number(interval.mean)} [{number(interval.low)}, {number(interval.high)}]"


def _flips(first: Summary, second: Summary) -> tuple[list[str], list[str]]:
    before = {(row.route.id, row.seed): row.success for row in first.rows}
    named = [
        (f"{row.route.id} {row.scenario}", before.get((row.route.id, row.seed)), row.success) for row in second.rows
    ]
    won = [name for name, was, now in named if was is False and now]
    lost = [name for name, was, now in named if was is True and not now]
    return won, lost
