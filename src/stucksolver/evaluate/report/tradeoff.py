"""The trade-off of a sweep: what each setting costs in questions, and what it brings."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping
from pathlib import Path

from stucksolver.evaluate.files import write_text
from stucksolver.evaluate.report.plots import DPI
from stucksolver.evaluate.scores.columns import aligned, number
from stucksolver.evaluate.scores.summary import Summary
from stucksolver.plotting import can_plot

AXES: dict[str, Callable[[Summary], float | None]] = {
    "driving score": lambda s: s.driving_score,
    "success rate %": lambda s: s.success_rate,
    "efficiency": lambda s: s.efficiency,
    "time to recover, median s": lambda s: s.recovery.median_s,
}
HEAD = ("Setting", "Queries/km", "DS", "SR %", "Efficiency", "Median s", "p95 s", "False", "Harm")


def write_tradeoff(summaries: Mapping[str, Summary], folder: Path) -> str:
    """`tradeoff.csv`, and `tradeoff.png` where matplotlib is installed; the table as text. Raises `OutputError`."""
    rows = [_row(label, summary) for label, summary in summaries.items()]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows([HEAD, *rows])
    write_text(folder / "tradeoff.csv", text.getvalue())
    if can_plot():
        _plot(summaries, folder / "tradeoff.png")
    return aligned(HEAD, rows)


def _row(label: str, summary: Summary) -> tuple[str, ...]:
    f = summary.recovery
    return (
        label,
        number(f.queries_per_km),
        number(summary.driving_score),
        number(summary.success_rate),
        number(summary.efficiency),
        number(f.median_s, 1),
        number(f.p95_s, 1),
        str(f.false),
        str(f.harm),
    )


def _plot(summaries: Mapping[str, Summary], path: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 3.2), layout="constrained")
    for axes, (name, value) in zip(figure.subplots(1, len(AXES)), AXES.items(), strict=True):
        for label, summary in summaries.items():
            x, y = summary.recovery.queries_per_km, value(summary)
            if x is None or y is None:
                continue
            axes.plot(x, y, "o", markersize=4)
            axes.annotate(label, (x, y), fontsize=5, xytext=(2, 2), textcoords="offset points")
        axes.set_xlabel("queries per km")
        axes.set_ylabel(name)
    figure.savefig(path, dpi=DPI)
