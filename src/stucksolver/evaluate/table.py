"""Runs as a table for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from stucksolver.evaluate.runlog import RunLog
from stucksolver.evaluate.terminal import table

HEAD = (
    "run",
    "ended",
    "completion %",
    "infractions",
    "stopped s",
    "recovered after s",
    "decisions",
    "plans",
)


def runs_table(runs: Sequence[RunLog]) -> str:
    """A row for each run, or a column where rows would be too wide."""
    return table(HEAD, [_row(run) for run in runs])


def _row(run: RunLog) -> tuple[str, ...]:
    r = run.result
    infractions = ", ".join(f"{name} {count}" for name, count in sorted(r.infractions.items()))
    recovered = "–" if r.immobilizations == 0 else "never"
    if r.time_to_recover_s is not None:
        recovered = f"{r.time_to_recover_s:.1f}"
    return (
        f"{run.scenario}; {run.arm}",
        r.status,
        f"{r.route_completion_pct:.1f}",
        infractions or "none",
        f"{r.stopped_s:.1f}",
        recovered,
        str(r.decisions),
        str(r.plans_accepted),
    )
