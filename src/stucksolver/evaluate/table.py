"""Runs as a table for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from stucksolver.evaluate.runlog import RunLog

HEAD = (
    "scenario",
    "arm",
    "ended",
    "completion %",
    "infractions",
    "stopped s",
    "recovered after s",
    "decisions",
    "plans",
)


def table(runs: Sequence[RunLog]) -> str:
    """One line for each run, columns aligned."""
    rows = [HEAD, *(_row(run) for run in runs)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEAD))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join([lines[0], "-" * len(lines[0]), *lines[1:]])


def _row(run: RunLog) -> tuple[str, ...]:
    r = run.result
    infractions = ", ".join(f"{name} {count}" for name, count in sorted(r.infractions.items()))
    recovered = "–" if r.immobilizations == 0 else "never"
    if r.time_to_recover_s is not None:
        recovered = f"{r.time_to_recover_s:.1f}"
    return (
        run.scenario,
        run.arm,
        r.status,
        f"{r.route_completion_pct:.1f}",
        infractions or "none",
        f"{r.stopped_s:.1f}",
        recovered,
        str(r.decisions),
        str(r.plans_accepted),
    )
