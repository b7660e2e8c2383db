"""The metrics of a recovery module. The terms are those of the design.

- **episode** (field `met`): the ego was stopped or crept (below 5 km/h) for 10 s or more, or a plan was started, before
  the ego made 15 m of new progress.
- **recovered**: 15 m of new progress within 60 s of a plan's start, without an infraction from then on.
- **false intervention**: a moving plan where waiting was right. The scenario says so, or the paired run of the driver
  alone continued from that position within 60 s.
- **missed**: an immobilization that never ended, without a moving plan, although recovering is right.
- **harm**: infractions and near misses from a plan's start to 10 s after its end, no matter which vehicle is at fault.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from stucksolver_eval.metrics.right_reaction import END_M, NOT_HARM, fault_of
from stucksolver_eval.results.outcome import ImmobilizationEpisode, InterventionRecord, QueryOutcome, RouteOutcome

MET_S = 10.0
"""Shortest stop that counts (s)."""
WITHIN_S = 60.0
"""Longest time to a recovery (s)."""
AFTER_S = 10.0
"""Time after a plan's end for which harm counts (s)."""
SAME_PLACE_M = 10.0
"""Distance within which two positions on the route are the same (m). Ours."""
PROGRESS_M = 15.0
"""New progress that counts as a recovery (m)."""
PASSENGER = "passenger"
WORDS_S = 30.0
"""Longest time from guidance to a plan that follows it (s). Ours."""


@dataclass
class RecoveryMetrics:
    """Sums over routes; times in seconds."""

    routes: int = 0
    met: int = 0
    left: int = 0
    """Immobilizations that were followed by 15 m of progress, by any means."""
    times_s: list[float] = field(default_factory=list)
    """For these, the time from onset to 15 m of progress (s)."""
    by_rung: Counter[str] = field(default_factory=Counter)
    interventions: int = 0
    recovered: int = 0
    false: int = 0
    missed: int = 0
    harm: int = 0
    harm_alone: int | None = None
    """Harm in the same time spans of the paired runs of the driver alone; None without such runs."""
    infractions: int = 0
    infractions_alone: int | None = None
    queries: int = 0
    """Queries of the solver to any reasoner, also to the rules."""
    model_queries: int = 0
    """Queries that reached a language model. If there are any, tokens, cost and latency are the model's alone."""
    dropped: int = 0
    """Queries whose answer was no longer needed, because the situation had cleared."""
    failed: int = 0
    """Queries without an answer: too late, budget spent, or another failure."""
    asked: Counter[str] = field(default_factory=Counter)
    """Queries to each model, and the number of them without a usable answer."""
    unanswered: Counter[str] = field(default_factory=Counter)
    whys: Counter[str] = field(default_factory=Counter)
    """Reason of the last query without a usable answer, on each route."""
    refused: int = 0
    """Answers with a plan that the guard or a rule of the ladder rejected."""
    tokens: int = 0
    usd: float = 0.0
    """Cost of answers whose model has a known price (US dollars)."""
    latencies_s: list[float] = field(default_factory=list)
    """Wall time of the answers (s)."""
    lost_s: float = 0.0
    """Simulated time between queries and answers (s)."""
    driven_km: float = 0.0
    said: Counter[str] = field(default_factory=Counter)
    """A passenger's lines by kind, and those that led to a moving plan within 30 s."""
    followed: Counter[str] = field(default_factory=Counter)
    right: int = 0
    judged: int = 0
    """Routes whose scenario states the right action, and those on which the vehicle took it."""

    @property
    def median_s(self) -> float | None:
        """Median time to recover (s); None without a recovery."""
        return float(np.median(self.times_s)) if self.times_s else None

    @property
    def p95_s(self) -> float | None:
        """95th percentile of the time to recover (s)."""
        return float(np.percentile(self.times_s, 95)) if self.times_s else None

    @property
    def counted_queries(self) -> int:
        """Queries to the language model; in runs without one, to any reasoner."""
        return self.model_queries or self.queries

    @property
    def queries_per_km(self) -> float | None:
        """Queries per kilometer driven, as in `counted_queries`."""
        return self.counted_queries / self.driven_km if self.driven_km > 0 else None


Key = tuple[str, int]


def key_of(outcome: RouteOutcome) -> Key:
    """Return the key that pairs runs: route and seed."""
    return outcome.route_id, outcome.seed


def recovery_figures(
    outcomes: Iterable[RouteOutcome], alone: Mapping[Key, RouteOutcome] | None = None
) -> RecoveryMetrics:
    """Return the metrics of the driven routes. `alone` has outcomes of the driver alone, by `key_of`."""
    figures = RecoveryMetrics()
    if alone is not None:
        figures.harm_alone = figures.infractions_alone = 0
    for outcome in outcomes:
        if outcome.state == "driven":
            _add(figures, outcome, None if alone is None else alone.get(key_of(outcome)))
    return figures


def _add(f: RecoveryMetrics, o: RouteOutcome, pair: RouteOutcome | None) -> None:
    f.routes += 1
    f.driven_km += max((place for _, place in o.track), default=0.0) / 1000.0
    spells = [s for s in o.spells if is_immobilization(s, o)]
    f.met += len(spells)
    for spell in spells:
        _add_spell(f, spell, o)
    moving = [i for i in o.interventions if i.moves]
    f.interventions += len(moving)
    for intervention in moving:
        if recovers(intervention, o):
            f.recovered += 1
            f.by_rung[intervention.rung] += 1
        f.false += is_false(intervention, o, pair)
    spans = _merged([(i.start_s, i.end_s + AFTER_S) for i in moving])
    f.harm += harm_within(o, spans)
    f.infractions += harm_within(o, [(0.0, float("inf"))])
    if pair is not None and f.harm_alone is not None and f.infractions_alone is not None:
        f.harm_alone += harm_within(pair, spans)
        f.infractions_alone += harm_within(pair, [(0.0, float("inf"))])
    _add_queries(f, o)
    for line in o.guidance:
        f.said[line.kind] += 1
        f.followed[line.kind] += any(i.rung == PASSENGER and 0.0 <= i.start_s - line.time_s <= WORDS_S for i in moving)
    if o.expected is not None:
        f.judged += 1
        f.right += responded_correctly(o)


def _add_spell(f: RecoveryMetrics, spell: ImmobilizationEpisode, o: RouteOutcome) -> None:
    if spell.recovered_after_s is not None:
        f.left += 1
        f.times_s.append(spell.recovered_after_s)
    elif o.expected in (None, "recover", "reroute", "leave") and not any(i.moves for i in _during(spell, o)):
        f.missed += 1


def _add_queries(f: RecoveryMetrics, o: RouteOutcome) -> None:
    f.queries += len(o.queries)
    f.dropped += sum(q.outcome is None for q in o.queries)
    f.failed += sum(q.outcome is QueryOutcome.FAILED for q in o.queries)
    for item in o.reliability:
        f.asked[item.reasoner] += item.asked
        f.unanswered[item.reasoner] += item.unanswered
        f.whys[item.why] += bool(item.why)
    f.refused += sum(q.outcome is QueryOutcome.REFUSED for q in o.queries)
    _add_cost(f, o)
    f.lost_s += sum(q.answered_s - q.asked_s for q in o.queries if q.answered_s is not None)


def _add_cost(f: RecoveryMetrics, o: RouteOutcome) -> None:
    """Add tokens, cost and latency: those of the language models, or those of the answers in runs without one.

    Outcomes of earlier versions have them with the answers only.
    """
    models = [item for item in o.reliability if item.queries]
    if not models:
        if not f.model_queries:
            f.latencies_s += [q.took_s for q in o.queries if q.took_s is not None]
        f.tokens += sum(q.tokens for q in o.queries)
        f.usd += sum(q.usd or 0.0 for q in o.queries)
        return
    if not f.model_queries:
        # Latencies of the rules on earlier routes are none of the model's.
        f.latencies_s.clear()
    for item in models:
        f.model_queries += item.queries
        f.tokens += item.tokens
        f.usd += item.usd or 0.0
        f.latencies_s += item.latencies_s


def _during(spell: ImmobilizationEpisode, o: RouteOutcome) -> list[InterventionRecord]:
    return [i for i in o.interventions if spell.onset_s <= i.start_s <= spell.ended_s]


def is_immobilization(spell: ImmobilizationEpisode, o: RouteOutcome) -> bool:
    """True if an episode is an immobilization."""
    return spell.ended_s - spell.onset_s >= MET_S or any(i.moves for i in _during(spell, o))


def recovers(intervention: InterventionRecord, o: RouteOutcome) -> bool:
    """True for 15 m of new progress within 60 s of the start without an infraction in between."""
    start_s = intervention.start_s
    reached = [t for t, place in o.track if t >= start_s and place >= intervention.place_m + PROGRESS_M]
    if not reached or reached[0] > start_s + WITHIN_S:
        return False
    return not any(i.kind not in NOT_HARM and start_s <= i.time_s <= reached[0] for i in o.infractions)


def is_false(intervention: InterventionRecord, o: RouteOutcome, pair: RouteOutcome | None) -> bool:
    """True if waiting was right when this plan started."""
    if o.expected == "wait":
        return intervention.start_s < o.marks.get("free", float("inf"))
    if o.expected is not None or pair is None:
        return False
    for spell in pair.spells:
        if abs(spell.place_m - intervention.place_m) <= SAME_PLACE_M:
            return spell.recovered_after_s is not None and spell.recovered_after_s <= WITHIN_S
    return False


def responded_correctly(o: RouteOutcome) -> bool:
    """True if the vehicle took the stated action: to wait, no moving plan; to ask, a call for help; otherwise progress.

    If asking is right because the vehicle has no path of its own, a plan that recovers it is right as well. With a time
    limit, `right_reaction` judges.
    """
    if o.within_s is not None:
        return not fault_of(o)
    moved = any(i.moves for i in o.interventions)
    if o.expected == "wait":
        return not moved
    if o.expected == "ask":
        return o.asked_s is not None or any(i.moves and recovers(i, o) for i in o.interventions)
    return bool(o.track) and o.track[-1][1] >= o.length_m - END_M


def harm_within(o: RouteOutcome, spans: Iterable[tuple[float, float]]) -> int:
    """Count infractions and near misses in time spans."""
    times = [i.time_s for i in (*o.infractions, *o.near_misses) if i.kind not in NOT_HARM]
    return sum(any(a <= t <= b for a, b in spans) for t in times) if (spans := list(spans)) else 0


def _merged(spans: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Merge overlapping spans, so that no infraction counts twice."""
    found: list[tuple[float, float]] = []
    for start, end in sorted(spans):
        if found and start <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end))
        else:
            found.append((start, end))
    return found
