"""The columns of comparisons, and published rows for reference."""

from __future__ import annotations

from typing import NamedTuple

from stucksolver_eval.metrics.multi_ability import ABILITIES
from stucksolver_eval.metrics.summary import Summary
from stucksolver_eval.terminal_table import Row

HEAD = ("Run", "Scheme", "Modality", "Clock", "RC", "IS", "DS", "SR %", "Efficiency", "Comfort")
NOT_COMPARABLE = "reported on CARLA, not comparable"
SOURCE = "the StuckSolver paper; README of Bench2Drive 0.0.4, github.com/Thinklab-SJTU/Bench2Drive"


class PublishedRow(NamedTuple):
    """Numbers of `SOURCE`: driving score, success rate, efficiency, comfort; and the abilities with their mean."""

    name: str
    scores: tuple[float, float, float | None, float | None]
    abilities: tuple[float, float, float, float, float, float] | None


PUBLISHED = (
    PublishedRow("Behavior Agent (StuckSolver paper)", (48.70, 18.21, None, None), None),
    PublishedRow("  with StuckSolver", (65.23, 36.32, None, None), None),
    PublishedRow("  with StuckSolver and guidance", (70.89, 50.01, None, None), None),
    PublishedRow("LEAD", (95.59, 87.28, 201.55, 20.56), (89.86, 73.44, 98.25, 50.00, 97.67, 81.84)),
    PublishedRow("SimLingo", (86.55, 70.45, 251.72, 35.47), (63.77, 60.94, 91.23, 50.00, 90.70, 71.34)),
    PublishedRow("Drive-π0", (69.71, 45.91, 178.07, 10.80), (24.64, 39.06, 73.68, 33.33, 66.86, 47.52)),
    PublishedRow("DriveTransformer", (60.20, 35.91, 168.87, 17.22), (30.43, 39.06, 49.12, 0.00, 61.63, 36.05)),
    PublishedRow("DriveAdapter", (54.96, 30.45, 91.82, 20.63), (26.09, 21.88, 64.90, 33.33, 69.18, 43.08)),
    PublishedRow("ThinkTwice", (52.84, 27.73, 90.73, 19.76), (20.29, 20.31, 59.64, 33.33, 66.86, 40.09)),
    PublishedRow("TCP", (51.44, 26.36, 75.67, 30.16), (14.49, 14.06, 59.64, 33.33, 63.95, 37.10)),
    PublishedRow("UniAD", (38.69, 19.09, 120.16, 64.09), (11.59, 10.94, 40.35, 33.33, 8.14, 20.87)),
    PublishedRow("VAD", (38.65, 17.27, 163.74, 67.34), (13.04, 17.19, 29.82, 16.67, 19.77, 19.30)),
    PublishedRow("ADMLP", (35.39, 0.00, 64.92, 20.95), (0.00, 0.00, 0.00, 0.00, 45.35, 9.07)),
)


def number(value: float | None, digits: int = 2) -> str:
    """Format a number for a table; a dash for None."""
    return "–" if value is None else f"{value:.{digits}f}"


def run_name(summary: Summary) -> str:
    """Return a run's name in tables: driver, recovery, guidance and any special setting."""
    m = summary.manifest
    helped = {"none": "driver alone", "timers": "driver + timers"}.get(m.recovery, f"driver + {m.recovery}")
    helped += f" + {m.reasoner}" if m.reasoner else ""
    marks = (m.guidance and " + guidance", m.heedless and ", heedless", not m.guarded and ", unguarded")
    return helped + "".join(mark for mark in marks if mark)


def main_row(summary: Summary) -> Row:
    """Return a run's scores in the order of `HEAD`."""
    m = summary.manifest
    return (
        run_name(summary),
        m.driver,
        f"perception:{m.perception}",
        m.clock,
        number(summary.route_completion),
        number(summary.infraction_score, 3),
        number(summary.driving_score),
        number(summary.success_rate),
        number(summary.efficiency),
        number(summary.comfort),
    )


def corrected_row(summary: Summary) -> Row:
    """Return efficiency and comfort without the benchmark's known errors."""
    blanks = ("",) * (len(HEAD) - 3)
    return ("  corrected", *blanks, number(summary.efficiency_corrected), number(summary.comfort_corrected))


ABILITY_HEAD = ("Run", *(name.replace("_", " ") for name in ABILITIES), "Mean")


def ability_row(summary: Summary) -> Row:
    """Return a run's multi-ability scores as a row of their table."""
    return (run_name(summary), *(number(summary.abilities[name], 1) for name in (*ABILITIES, "mean")))


def published_ability_rows() -> list[Row]:
    """Return the rows of the publications that contain abilities."""
    return [(row.name, *(number(value, 1) for value in row.abilities)) for row in PUBLISHED if row.abilities]


RECOVERY_HEAD = (
    "Run",
    "Episodes",
    "Resolved",
    "Median s",
    "p95 s",
    "Plans",
    "Recovered",
    "By rung",
    "False",
    "Missed",
    "Harm (alone)",
    "Infractions (alone)",
    "Right",
    "Queries/route",
    "Dropped",
    "Failed",
    "Refused",
    "Queries/km",
    "Tokens",
    "Tokens/query",
    "USD/query",
    "Latency s",
    "Lost s",
)


def recovery_row(summary: Summary) -> Row:
    """Return the effect and the cost of a run's recovery, in the order of `RECOVERY_HEAD`."""
    f = summary.recovery
    latency = sum(f.latencies_s) / len(f.latencies_s) if f.latencies_s else None
    rungs = ", ".join(f"{name} {count}" for name, count in f.by_rung.most_common()) or "–"
    return (
        run_name(summary),
        str(f.met),
        str(f.left),
        number(f.median_s, 1),
        number(f.p95_s, 1),
        str(f.interventions),
        str(f.recovered),
        rungs,
        str(f.false),
        str(f.missed),
        _with_alone(f.harm, f.harm_alone),
        _with_alone(f.infractions, f.infractions_alone),
        f"{f.right}/{f.judged}" if f.judged else "–",
        number(f.counted_queries / f.routes if f.routes else None),
        str(f.dropped),
        str(f.failed),
        str(f.refused),
        number(f.queries_per_km),
        str(f.tokens),
        number(f.tokens / f.counted_queries if f.counted_queries else None, 0),
        number(f.usd / f.counted_queries if f.counted_queries and f.usd else None, 5),
        number(latency, 3),
        number(f.lost_s, 1),
    )


def _with_alone(count: int, alone: int | None) -> str:
    return str(count) if alone is None else f"{count} ({alone})"
