"""The metrics of one run on its page. They equal those in the summary of the same run."""

from __future__ import annotations

from stucksolver_eval.metrics.recovery import is_immobilization, recovery_figures
from stucksolver_eval.results.checkpoint import RouteRecord
from stucksolver_eval.results.outcome import ImmobilizationEpisode, RouteOutcome
from stucksolver_eval.results.run_log import RunResult


def run_result(record: RouteRecord, outcome: RouteOutcome | None, decisions: int) -> RunResult:
    """Return the metrics of a run. `decisions` is the number of decisions on its page."""
    counts = {kind: len(found) for kind, found in record.infractions.items() if found}
    counts.pop("min_speed_infractions", None)
    if outcome is not None and outcome.near_misses:
        counts["near_miss"] = len(outcome.near_misses)
    figures = recovery_figures([] if outcome is None else [outcome])
    stopped_s = None if outcome is None else outcome.stopped_s
    return RunResult(
        status=record.status,
        route_completion_pct=record.scores.score_route,
        infractions=counts,
        stopped_s=None if stopped_s is None else round(stopped_s, 2),
        time_to_recover_s=figures.median_s,
        immobilizations=figures.met,
        recoveries=figures.left,
        decisions=decisions,
        plans_accepted=0 if outcome is None else len(outcome.interventions),
        duration_s=record.meta.duration_game,
        distance_m=round(record.scores.score_route / 100.0 * record.meta.route_length, 1),
    )


def immobilizations(outcome: RouteOutcome) -> list[ImmobilizationEpisode]:
    """Return the immobilizations of a run that count: not the start, and no short stop without a plan."""
    return [spell for spell in outcome.spells if is_immobilization(spell, outcome)]
