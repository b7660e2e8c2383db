"""Results as text, JSON and CSV, for people and for scripts."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from statistics import median
from typing import Any

from stucksolver.commands.terminal_text import filled
from stucksolver.reasoners.factory import unanswered_banner
from stucksolver_eval.metrics.columns import (
    ABILITY_HEAD,
    HEAD,
    RECOVERY_HEAD,
    ability_row,
    corrected_row,
    main_row,
    recovery_row,
    run_name,
)
from stucksolver_eval.metrics.right_reaction import TypeRow, type_rows
from stucksolver_eval.metrics.summary import RouteRow, Summary
from stucksolver_eval.results.checkpoint import status_text
from stucksolver_eval.terminal_table import table

CSV_HEAD = (
    "route_id",
    "scenario",
    "town",
    "seed",
    "status",
    "driving_score",
    "success",
    "route_completion",
    "penalty",
    "infractions",
    "near_misses",
    "smoothness",
    "smoothness_corrected",
    "duration_game_s",
    "wall_s",
    "spells",
    "interventions",
    "queries",
    "expected",
    "asked_s",
    "reason",
)


MEANING = (
    "RC: route completion, %. IS: infraction score, 1 without infractions. DS: driving score, the mean of RC x IS. "
    "SR: success rate, the routes completed without an infraction; driving slowly does not count as one."
)


def summary_text(summaries: list[Summary]) -> str:
    """Return all tables for a terminal."""
    main = [row for s in summaries for row in (main_row(s), corrected_row(s))]
    parts = [
        table(HEAD, main),
        filled(MEANING),
        table(ABILITY_HEAD, [ability_row(s) for s in summaries]),
        table(RECOVERY_HEAD, [recovery_row(s) for s in summaries]),
        *(reaction_text(s) for s in summaries),
        "\n".join(filled(f"{run_name(s)}: {_statuses(s)}") for s in summaries),
    ]
    warned = [banner for s in summaries for banner in banners(s)]
    words = [f"guidance to {run_name(s)}: {guidance_text(s)}" for s in summaries if s.recovery.said]
    return "\n\n".join(part for part in (*parts, *map(filled, words), *map(filled, warned)) if part)


def reaction_text(summary: Summary) -> str:
    """Return a line for each situation whose reaction has a time limit: right or wrong, and why. Empty without any."""
    rows = reactions(summary)
    right, drives = sum(row.right for row in rows), sum(row.drives for row in rows)
    times_s = [row.called_s for row in rows if row.called_s is not None]
    called = f"; operator called after {median(times_s):.0f} s, median of {len(times_s)} situations" if times_s else ""
    total = f"{run_name(summary)}: {right} of {drives} reactions right{called}"
    return "\n".join(map(filled, (total, *(row.text for row in rows)))) if rows else ""


def reactions(summary: Summary) -> list[TypeRow]:
    """Return the judgments of the situations whose reaction has a time limit."""
    return type_rows(row.outcome for row in summary.rows if row.outcome is not None)


def banners(summary: Summary) -> list[str]:
    """Return a warning for each model that gave no usable answer to most questions."""
    f = summary.recovery
    why = "; ".join(text for text, _ in f.whys.most_common(1) if text)
    found = [unanswered_banner(f.asked[name], f.unanswered[name], name, why) for name in f.asked]
    return [text for text in found if text is not None]


def guidance_text(summary: Summary) -> str:
    """Return the guidance of a run by kind, and the number of followed lines; empty without guidance."""
    f = summary.recovery
    return ", ".join(f"{kind} {count} said, {f.followed[kind]} followed" for kind, count in f.said.most_common())


def _statuses(summary: Summary) -> str:
    return ", ".join(f"{count} {status_text(status)}" for status, count in summary.statuses.most_common())


def summary_json(summary: Summary) -> str:
    """Return the content of `summary.json`: all figures except those of single routes."""
    return json.dumps(summary_data(summary), indent=1) + "\n"


def summary_data(summary: Summary) -> dict[str, Any]:
    """Return all figures except those of single routes, as JSON-compatible values."""
    # `asdict` would turn a counter's items into counters.
    recovery: dict[str, Any] = {f.name: getattr(summary.recovery, f.name) for f in dataclasses.fields(summary.recovery)}
    recovery |= {"median_s": summary.recovery.median_s, "p95_s": summary.recovery.p95_s}
    return {
        "manifest": summary.manifest.model_dump(mode="json"),
        "routes": len(summary.rows),
        "driving_score": summary.driving_score,
        "success_rate": summary.success_rate,
        "route_completion": summary.route_completion,
        "infraction_score": summary.infraction_score,
        "efficiency": summary.efficiency,
        "efficiency_corrected": summary.efficiency_corrected,
        "comfort": summary.comfort,
        "comfort_corrected": summary.comfort_corrected,
        "abilities": summary.abilities,
        "recovery": recovery,
        "statuses": dict(summary.statuses.most_common()),
        "per_scenario": per_scenario(summary),
        "reactions": [dataclasses.asdict(row) for row in reactions(summary)],
    }


def per_scenario(summary: Summary) -> dict[str, dict[str, float]]:
    """Return routes, driving score and success rate (%) by scenario type."""
    groups: dict[str, list[RouteRow]] = {}
    for row in summary.rows:
        groups.setdefault(row.scenario, []).append(row)
    return {
        name: {
            "routes": len(rows),
            "driving_score": sum(row.score for row in rows) / len(rows),
            "success_rate": 100.0 * sum(row.success for row in rows) / len(rows),
        }
        for name, rows in sorted(groups.items())
    }


def routes_csv(summary: Summary) -> str:
    """Return the content of `routes.csv`: a line for each route and seed."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(CSV_HEAD)
    writer.writerows(_csv_row(row) for row in summary.rows)
    return text.getvalue()


def _csv_row(row: RouteRow) -> list[Any]:
    record, outcome = row.record, row.outcome
    status = record.status if record is not None else "missing" if outcome is None else outcome.state
    return [
        row.route.id,
        row.scenario,
        row.route.town,
        row.seed,
        status,
        row.score,
        int(row.success),
        "" if record is None else record.scores.score_route,
        "" if record is None else record.scores.score_penalty,
        "" if record is None else infraction_text(row),
        "" if outcome is None else len(outcome.near_misses),
        _blank(row.smooth),
        _blank(row.smooth_corrected),
        "" if record is None else record.meta.duration_game,
        "" if outcome is None else outcome.wall_s,
        "" if outcome is None else len(outcome.spells),
        "" if outcome is None else len(outcome.interventions),
        "" if outcome is None else len(outcome.queries),
        "" if outcome is None else outcome.expected or "",
        "" if outcome is None else _blank(outcome.asked_s),
        "" if outcome is None else (outcome.reason.splitlines() or [""])[-1],
    ]


def infraction_text(row: RouteRow) -> str:
    """Return kinds and counts of a record's infractions, without those of minimum speed."""
    if row.record is None:
        return ""
    counts = {k: len(v) for k, v in row.record.infractions.items() if v and k != "min_speed_infractions"}
    return " ".join(f"{kind}:{count}" for kind, count in counts.items())


def _blank(value: float | None) -> Any:
    return "" if value is None else round(value, 4)
