"""Scores and recovery figures as rows that say what each of them is: one row a figure, one column a run."""

from __future__ import annotations

from collections.abc import Mapping

from stucksolver_eval.report import markup
from stucksolver_eval.scores.columns import (
    ABILITY_HEAD,
    NOT_COMPARABLE,
    PUBLISHED,
    RECOVERY_HEAD,
    SOURCE,
    number,
    published_ability_rows,
    recovery_row,
)
from stucksolver_eval.scores.summary import Summary
from stucksolver_eval.terminal import PART

MEANINGS = {
    "Driving score (DS)": "Mean over all routes of route completion times infraction score; 0 to 100.",
    "Success rate (SR), %": "Routes driven to their end without an infraction; driving slowly is not counted as one.",
    "Route completion (RC), %": "How much of its route the vehicle drove, mean over all routes.",
    "Infraction score (IS)": "1 without infractions; each collision, red light, stop sign or time-out multiplies it by "
    "a factor below 1.",
    "Efficiency": "Speed beside that of the traffic around, %; above 100: faster than the others.",
    "Efficiency, corrected": "The same, with the stretch on which a route got stuck, which the benchmark omits.",
    "Comfort": "Share of the time in which acceleration, jerk and yaw rate stay within bounds, %.",
    "Comfort, corrected": "The same with bounds in the units they are meant for; the benchmark mixes them up.",
}
RECOVERY_MEANINGS = {
    "Met": "Times that the vehicle stood or crept for 10 s or more, or that a plan was begun.",
    "Left": "Of those, after how many 15 m of progress followed, by whatever means.",
    "Median s": "From the onset of immobilization to 15 m of progress.",
    "p95 s": "The same, 95th percentile.",
    "Plans": "Recovery plans that were carried out.",
    "Recovered": "Plans with 15 m of progress within 60 s and no infraction from then on.",
    "By rung": "Which rung of the escalation ladder the plans came from.",
    "False": "Plans that moved the vehicle where waiting was right.",
    "Missed": "Immobilizations that were never left, with no plan that moves, though recovering was right.",
    "Harm (alone)": "Infractions and near misses from a plan's start to 10 s after its end; in brackets those of the "
    "driver alone in the same time.",
    "Infractions (alone)": "On whole routes; in brackets those of the driver alone.",
    "Right": "Routes on which the right thing was done (recover, wait, ask, reroute), of those that state it.",
    "Queries/route": "Questions put to a reasoner.",
    "Dropped": "Questions whose answer nobody waited for any more: the situation had cleared.",
    "Failed": "Questions without a usable answer.",
    "Refused": "Plans that the guard, or a rule of the ladder, refused.",
    "Queries/km": "Questions per kilometre driven.",
    "Tokens": "Tokens of all questions and answers.",
    "Tokens/query": "Tokens per question.",
    "USD/query": "Price per question, where the model's price is known.",
    "Latency s": "Wall time per answer, mean.",
    "Lost s": "Simulated time between questions and answers.",
}


def scores_table(runs: Mapping[str, Summary]) -> str:
    """The benchmark's scores of runs, by the names of their columns, with what they mean."""
    rows = [
        [markup.text(name), *(markup.cell(values[k]) for values in map(_scores, runs.values())), _meaning(meaning)]
        for k, (name, meaning) in enumerate(MEANINGS.items())
    ]
    return markup.raw_table("Scores", ("Figure", *runs, "What it is"), rows)


def recovery_table(runs: Mapping[str, Summary]) -> str:
    """What recovery did and cost, with what the figures mean; those that no run has are left out."""
    columns = [recovery_row(one) for one in runs.values()]
    rows = [
        [markup.text(name), *(markup.cell(column[k]) for column in columns), _meaning(RECOVERY_MEANINGS[name])]
        for k, name in enumerate(RECOVERY_HEAD)
        if k and any(column[k] != "–" for column in columns)
    ]
    return markup.raw_table("Recovery", ("Figure", *runs, "What it is"), rows)


def published_table() -> str:
    """Figures that others published, apart from ours: they are of another simulator."""
    head = ("Published", "DS", "SR %", "Efficiency", "Comfort")
    rows = [(_whole_name(k), *(number(value) for value in one.scores)) for k, one in enumerate(PUBLISHED)]
    about = markup.note(f"Source: {SOURCE}.")
    scores = markup.table("Published scores", head, rows)
    abilities = markup.table("Published success rates by ability", ABILITY_HEAD, published_ability_rows())
    return f"<details open><summary>Published figures, {NOT_COMPARABLE}</summary>{about}{scores}{abilities}</details>"


def _whole_name(k: int) -> str:
    """A row that belongs to the one before it is named after that one, too."""
    name = PUBLISHED[k].name
    if not name.startswith(PART):
        return name
    leads = next(one.name for one in reversed(PUBLISHED[:k]) if not one.name.startswith(PART))
    return f"{leads.partition(' (')[0]} {name.strip()}"


def _scores(summary: Summary) -> tuple[str, ...]:
    """In the order of `MEANINGS`."""
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
