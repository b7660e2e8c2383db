"""Scores and recovery metrics with their definitions: one row per metric, one column per run."""

from __future__ import annotations

from collections.abc import Mapping

from stucksolver_eval.metrics.columns import (
    ABILITY_HEAD,
    NOT_COMPARABLE,
    PUBLISHED,
    RECOVERY_HEAD,
    SOURCE,
    number,
    published_ability_rows,
    recovery_row,
)
from stucksolver_eval.metrics.summary import Summary
from stucksolver_eval.report import markup
from stucksolver_eval.terminal_table import PART

MEANINGS = {
    "Driving score (DS)": "Mean over all routes of route completion times infraction score; 0 to 100.",
    "Success rate (SR), %": "Routes completed without an infraction; driving slowly does not count as one.",
    "Route completion (RC), %": "Completed share of the route, mean over all routes.",
    "Infraction score (IS)": "1 without infractions; each collision, red light, stop sign or time-out multiplies it by "
    "a factor below 1.",
    "Efficiency": "Speed relative to the surrounding traffic, %; above 100: faster than the others.",
    "Efficiency, corrected": "The same, including the stretch on which a route got stuck, which the benchmark omits.",
    "Comfort": "Share of the time in which acceleration, jerk and yaw rate stay within bounds, %.",
    "Comfort, corrected": "The same with bounds in the intended units; the benchmark mixes them up.",
}
RECOVERY_MEANINGS = {
    "Episodes": "Number of times that the vehicle was stopped or crept for 10 s or more, or that a plan was started.",
    "Resolved": "Number of episodes that were followed by 15 m of progress, by any means.",
    "Median s": "From the onset of immobilization to 15 m of progress.",
    "p95 s": "The same, 95th percentile.",
    "Plans": "Recovery plans that were executed.",
    "Recovered": "Plans with 15 m of progress within 60 s and no infraction from then on.",
    "By rung": "Rung of the escalation ladder that the plans came from.",
    "False": "Plans that moved the vehicle although waiting was right.",
    "Missed": "Immobilizations that never ended, without a plan that moves, although recovering was right.",
    "Harm (alone)": "Infractions and near misses from a plan's start to 10 s after its end; in brackets, those of the "
    "driver alone in the same time.",
    "Infractions (alone)": "On whole routes; in brackets, those of the driver alone.",
    "Right": "Routes with the right action (recover, wait, ask, reroute), of those whose scenario states it.",
    "Queries/route": "Questions to the language model; without one, to any reasoner.",
    "Dropped": "Questions whose answer was no longer needed, because the situation had cleared.",
    "Failed": "Questions without a usable answer.",
    "Refused": "Plans that the guard, or a rule of the ladder, rejected.",
    "Queries/km": "Questions per kilometer driven.",
    "Tokens": "Tokens of all questions and answers.",
    "Tokens/query": "Tokens of the language model per question to it.",
    "USD/query": "Price per question, if the model's price is known.",
    "Latency s": "Wall time per answer, mean.",
    "Lost s": "Simulated time between questions and answers.",
}


def scores_table(runs: Mapping[str, Summary]) -> str:
    """Return the table of the benchmark's scores, one column per run, with definitions."""
    rows = [
        [markup.text(name), *(markup.cell(values[k]) for values in map(_scores, runs.values())), _meaning(meaning)]
        for k, (name, meaning) in enumerate(MEANINGS.items())
    ]
    return markup.raw_table("Scores", ("Figure", *runs, "What it is"), rows)


def recovery_table(runs: Mapping[str, Summary]) -> str:
    """Return the table of recovery metrics with definitions. Metrics that no run has are omitted."""
    columns = [recovery_row(run) for run in runs.values()]
    rows = [
        [markup.text(name), *(markup.cell(column[k]) for column in columns), _meaning(RECOVERY_MEANINGS[name])]
        for k, name in enumerate(RECOVERY_HEAD)
        if k and any(column[k] != "–" for column in columns)
    ]
    return markup.raw_table("Recovery", ("Figure", *runs, "What it is"), rows)


def published_table() -> str:
    """Return published metrics in a separate section, because they come from another simulator."""
    head = ("Published", "DS", "SR %", "Efficiency", "Comfort")
    rows = [(_whole_name(k), *(number(value) for value in item.scores)) for k, item in enumerate(PUBLISHED)]
    about = markup.note(f"Source: {SOURCE}.")
    scores = markup.table("Published scores", head, rows)
    abilities = markup.table("Published success rates by ability", ABILITY_HEAD, published_ability_rows())
    return f"<details><summary>Published figures, {NOT_COMPARABLE}</summary>{about}{scores}{abilities}</details>"


def _whole_name(k: int) -> str:
    """Return a row's full name. A row that belongs to the previous one includes that one's name."""
    name = PUBLISHED[k].name
    if not name.startswith(PART):
        return name
    leads = next(item.name for item in reversed(PUBLISHED[:k]) if not item.name.startswith(PART))
    return f"{leads.partition(' (')[0]} {name.strip()}"


def _scores(summary: Summary) -> tuple[str, ...]:
    """Return a run's scores in the order of `MEANINGS`."""
    return (
        number(summary.driving_score),
        number(summary.success_rate),
        number(summary.route_completion),
        number(summary.infraction_score, 3),
        number(summary.efficiency),
        number(summary.efficiency_corrected),
        number(summary.comfort),
        number(summary.comfort_corrected),
    )


def _meaning(words: str) -> str:
    return f'<td class="long">{markup.text(words)}</td>'
