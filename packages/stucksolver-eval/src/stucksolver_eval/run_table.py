"""Runs as a table for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from stucksolver.commands.terminal_text import filled
from stucksolver_eval.results.checkpoint import status_text
from stucksolver_eval.results.outcome import QueryOutcome
from stucksolver_eval.results.run_log import DecisionMoment, RunLog, RunResult
from stucksolver_eval.terminal_table import table

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

_LISTED_KINDS = ("guidance", "outcome", "abort", "directive", "infraction")


def runs_table(runs: Sequence[RunLog]) -> str:
    """Return a row for each run, or a column if rows would be too wide."""
    return table(HEAD, [_row(run) for run in runs])


def conversation(run: RunLog) -> str:
    """Return the utterances, their interpretations, the reasons to wait and the results, one line each."""
    guidance_s = next((event.time_s for event in run.events if event.kind == "guidance"), None)
    if guidance_s is None:
        return ""
    lines = [
        (event.time_s, event.kind == "guidance", event.text) for event in run.events if event.kind in _LISTED_KINDS
    ]
    lines += [(moment.time_s, False, _decided(moment)) for moment in run.decisions]
    text_lines = [f"{run.scenario}:"]
    last = ""
    for time_s, spoken, text in sorted((line for line in lines if line[0] >= guidance_s), key=lambda line: line[0]):
        about = text.split(",")[0]
        if spoken or about != last:
            text_lines.append(filled(f"{time_s:5.1f} s  {'passenger' if spoken else 'car'}: {text}"))
        last = about
    return "\n".join(text_lines)


def _decided(moment: DecisionMoment) -> str:
    rationale = str(moment.decision.get("rationale", ""))
    return f"{rationale}: {moment.verdict}" if moment.outcome is QueryOutcome.REFUSED else rationale


def recovered_text(result: RunResult) -> str:
    """Return the seconds from onset to recovery, `never`, or a dash without an immobilization.

    After several immobilizations this is the median, with the number of recoveries: `8.0 (1 of 2)`.
    """
    if result.time_to_recover_s is None:
        return "never" if result.immobilizations else "–"
    several = f" ({result.recoveries} of {result.immobilizations})" if result.immobilizations > 1 else ""
    return f"{result.time_to_recover_s:.1f}{several}"


def stopped_text(result: RunResult) -> str:
    """Return the stopped time (s), or a dash if it was not measured."""
    return "–" if result.stopped_s is None else f"{result.stopped_s:.1f}"


def _row(run: RunLog) -> tuple[str, ...]:
    r = run.result
    infractions = ", ".join(f"{name} {count}" for name, count in sorted(r.infractions.items()))
    return (
        f"{run.scenario}; {run.arm}",
        status_text(r.status),
        f"{r.route_completion_pct:.1f}",
        infractions or "none",
        stopped_text(r),
        recovered_text(r),
        str(r.decisions),
        str(r.plans_accepted),
    )
