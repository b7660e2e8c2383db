"""The results of a driven route."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.solver import Event
from stucksolver_eval.results.checkpoint import RouteRecord
from stucksolver_eval.results.metric_info import MetricInfo
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.run_log import RunLog


@dataclass(frozen=True)
class RouteResult:
    """The results of a route."""

    record: RouteRecord
    outcome: RouteOutcome
    metric_info: MetricInfo
    replay: RunLog | None
    events: tuple[Event, ...] = ()
    """Events of the solver, if requested; times since the start of the route (s)."""
