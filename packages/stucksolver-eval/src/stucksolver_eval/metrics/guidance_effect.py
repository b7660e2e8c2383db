"""The benefit and the cost of guidance by kind of help: guided minus unguided, route by route."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver_eval.metrics.paired_statistics import Difference, compare_pairs
from stucksolver_eval.metrics.right_reaction import NOT_HARM
from stucksolver_eval.metrics.summary import RouteRow, Summary
from stucksolver_eval.results.outcome import RouteOutcome

KINDS = ("helpful", "late", "unhelpful", "wrong", "dangerous")


@dataclass(frozen=True)
class GuidanceEffect:
    """One kind of help. Differences are guided minus unguided, for the routes with this help.

    Attributes:
        score: Points of driving score.
        success: Percentage points.
        harm: Additional infractions and near misses in all its runs.
        won: Runs that succeed only with guidance.
        lost: Runs that succeed only without it.
    """

    help: str
    kind: str
    drives: int
    score: Difference
    success: Difference
    won: int
    lost: int
    harm: int


Pair = tuple[RouteRow, RouteRow]


def help_figures(unguided: Summary, guided: Summary) -> list[GuidanceEffect]:
    """Return a row for each kind of help, and one for each group of kinds with an empty `help`.

    The order is that of `KINDS`.

    A run counts for the kind of its first line. A run without a line counts for none.
    """
    before = {(row.route.id, row.seed): row for row in unguided.rows}
    groups: dict[tuple[str, str], list[Pair]] = {}
    for row in guided.rows:
        guidance = () if row.outcome is None else row.outcome.guidance
        pair = before.get((row.route.id, row.seed))
        if guidance and pair is not None:
            groups.setdefault((guidance[0].kind, ""), []).append((pair, row))
            groups.setdefault((guidance[0].kind, guidance[0].help), []).append((pair, row))
    order = sorted(groups, key=lambda key: (KINDS.index(key[0]), key[1]))
    return [_figures(kind, name, groups[kind, name]) for kind, name in order]


def _figures(kind: str, name: str, pairs: list[Pair]) -> GuidanceEffect:
    by_route: dict[str, list[Pair]] = {}
    for pair in pairs:
        by_route.setdefault(pair[0].route.id, []).append(pair)
    return GuidanceEffect(
        help=name,
        kind=kind,
        drives=len(pairs),
        score=compare_pairs([[b.score - a.score for a, b in some] for some in by_route.values()]),
        success=compare_pairs([[100.0 * (b.success - a.success) for a, b in some] for some in by_route.values()]),
        won=sum(b.success and not a.success for a, b in pairs),
        lost=sum(a.success and not b.success for a, b in pairs),
        harm=sum(_harm(b.outcome) - _harm(a.outcome) for a, b in pairs),
    )


def _harm(outcome: RouteOutcome | None) -> int:
    if outcome is None:
        return 0
    return len(outcome.near_misses) + sum(infraction.kind not in NOT_HARM for infraction in outcome.infractions)
