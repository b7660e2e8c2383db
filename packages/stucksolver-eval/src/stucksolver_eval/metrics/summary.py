"""All metrics of one evaluation, computed from its files only."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from stucksolver_eval.metrics.efficiency import corrected_efficiency, efficiency
from stucksolver_eval.metrics.multi_ability import AbilityCase, ability_scores
from stucksolver_eval.metrics.recovery import RecoveryMetrics, key_of, recovery_figures
from stucksolver_eval.metrics.smoothness import AS_RATED, CORRECTED, smoothness
from stucksolver_eval.results.checkpoint import RouteRecord
from stucksolver_eval.results.manifest import EvaluationManifest
from stucksolver_eval.results.metric_info import read_metric_info
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route

MIN_SPEED = "min_speed_infractions"


@dataclass(frozen=True)
class RouteRow:
    """One route with one seed. `record` is None if there is none. Then the route counts as 0, as in the benchmark."""

    route: Route
    seed: int
    outcome: RouteOutcome | None
    record: RouteRecord | None
    smooth: float | None
    smooth_corrected: float | None

    @property
    def scenario(self) -> str:
        """Type of the route's scenario."""
        return self.route.scenarios[0].type if self.route.scenarios else "None"

    @property
    def score(self) -> float:
        """Driving score, 0 to 100; 0 without a record."""
        return 0.0 if self.record is None else self.record.scores.score_composed

    @property
    def success(self) -> bool:
        """True if the route is a success by Bench2Drive's rule."""
        return self.record is not None and self.record.success


@dataclass(frozen=True)
class Summary:
    """The metrics of an evaluation: percentages unless units say otherwise; None without data.

    `comfort` and `efficiency` are Bench2Drive's, with its errors; the corrected values are separate.
    """

    manifest: EvaluationManifest
    rows: tuple[RouteRow, ...]
    driving_score: float
    success_rate: float
    route_completion: float
    infraction_score: float
    efficiency: float | None
    efficiency_corrected: float | None
    comfort: float | None
    comfort_corrected: float | None
    abilities: dict[str, float | None]
    recovery: RecoveryMetrics
    statuses: Counter[str] = field(default_factory=Counter)

    @property
    def crashed(self) -> int:
        """Number of routes on which the driver or the simulator crashed."""
        return self.statuses["crashed"]

    @property
    def invalid(self) -> int:
        """Number of routes that could not be driven as requested."""
        return self.statuses["invalid"]


def summarize(store: ResultStore, alone: ResultStore | None = None) -> Summary:
    """Compute the metrics of an evaluation. `alone` is the paired evaluation of the driver alone, if there is one.

    Raises:
        StoreError: The files cannot be read.
    """
    rows = _rows(store)
    outcomes = [row.outcome for row in rows if row.outcome is not None]
    pairs = None
    if alone is not None:
        pairs = {key_of(row.outcome): row.outcome for row in _rows(alone, smooth=False) if row.outcome is not None}
    return summary_of(store.manifest(), rows, recovery_figures(outcomes, pairs))


def summary_of(manifest: EvaluationManifest, rows: Sequence[RouteRow], recovery: RecoveryMetrics) -> Summary:
    """Return the metrics of these rows. Routes without a record count as 0, as in the benchmark."""
    records = [row.record for row in rows if row.record is not None]
    count = max(len(rows), 1)
    speeds = [(r.record.infractions.get(MIN_SPEED, []), _stuck_end(r)) for r in rows if r.record is not None]
    smooth = [row.smooth for row in rows if row.smooth is not None]
    corrected = [row.smooth_corrected for row in rows if row.smooth_corrected is not None]
    return Summary(
        manifest=manifest,
        rows=tuple(rows),
        driving_score=sum(row.score for row in rows) / count,
        success_rate=100.0 * sum(row.success for row in rows) / count,
        route_completion=sum(r.scores.score_route for r in records) / count,
        infraction_score=sum(r.scores.score_penalty for r in records) / max(len(records), 1),
        efficiency=efficiency(texts for texts, _ in speeds),
        efficiency_corrected=corrected_efficiency(speeds),
        comfort=100.0 * sum(smooth) / len(smooth) if smooth else None,
        comfort_corrected=100.0 * sum(corrected) / len(corrected) if corrected else None,
        abilities=ability_scores(ability_case(row) for row in rows if row.record is not None),
        recovery=recovery,
        statuses=Counter(_status(row) for row in rows),
    )


def ability_case(row: RouteRow) -> AbilityCase:
    """Return the ability case of a row that has a record."""
    assert row.record is not None
    infractions = row.record.infractions
    return AbilityCase(
        scenario=row.scenario,
        success=row.success,
        completion_pct=row.record.scores.score_route,
        obeyed=not infractions.get("stop_infraction") and not infractions.get("red_light"),
        first_junction=None if row.outcome is None else row.outcome.first_junction,
        points=0 if row.outcome is None else row.outcome.points,
    )


def _stuck_end(row: RouteRow) -> float | None:
    return None if row.outcome is None else row.outcome.stuck_end_pct


def _status(row: RouteRow) -> str:
    if row.outcome is None:
        return "missing"
    return row.outcome.state if row.record is None else row.record.status


def _rows(store: ResultStore, smooth: bool = True) -> list[RouteRow]:
    return [_row(store, route, seed, smooth) for seed in store.seeds() for route in store.routes()]


def _row(store: ResultStore, route: Route, seed: int, smooth: bool) -> RouteRow:
    outcome, record = store.outcome(route, seed), store.record(route, seed)
    path = store.metric_info(route, seed)
    if not smooth or record is None or not path.exists():
        return RouteRow(route, seed, outcome, record, None, None)
    info = read_metric_info(path)
    if len(info["acceleration"]) < 3:
        return RouteRow(route, seed, outcome, record, None, None)
    return RouteRow(route, seed, outcome, record, smoothness(info, AS_RATED), smoothness(info, CORRECTED))
