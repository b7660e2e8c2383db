"""The trade-off of a sweep: the number of queries against the scores, for each setting."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping
from pathlib import Path

from stucksolver.atomic_files import write_text
from stucksolver.optional_dependencies import can_plot
from stucksolver_eval.metrics.columns import number
from stucksolver_eval.metrics.summary import Summary
from stucksolver_eval.report.plots import DPI
from stucksolver_eval.terminal_table import table

AXES: dict[str, Callable[[Summary], float | None]] = {
    "driving score": lambda s: s.driving_score,
    "success rate %": lambda s: s.success_rate,
    "efficiency": lambda s: s.efficiency,
    "time to recover, median s": lambda s: s.recovery.median_s,
}
HEAD = ("Setting", "Queries/km", "DS", "SR %", "Efficiency", "Median s", "p95 s", "False", "Harm")


def write_tradeoff(summaries: Mapping[str, Summary], folder: Path) -> str:
    """Write `tradeoff.csv`, and `tradeoff.png` if matplotlib is installed. Returns a table. Raises `OutputError`."""
    rows = [_row(label, summary) for label, summary in summaries.items()]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerows([HEAD, *rows])
    write_text(folder / "tradeoff.csv", text.getvalue())
    if can_plot():
        _plot(summaries, folder / "tradeoff.png")
    return table(HEAD, rows)


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
    """Draw a line for each value of the first settings, along which the last one varies."""
    from matplotlib.figure import Figure

    lines = _series(summaries)
    figure = Figure(figsize=(12, 3.6), layout="constrained")
    for axes, (name, value) in zip(figure.subplots(1, len(AXES)), AXES.items(), strict=True):
        for shared, series in lines.items():
            known = [(s.recovery.queries_per_km, value(s), last) for last, s in series.items()]
            points = [(x, y, last) for x, y, last in known if x is not None and y is not None]
            axes.plot([x for x, _, _ in points], [y for _, y, _ in points], "o-", markersize=4, lw=0.8, label=shared)
            for x, y, last in points:
                axes.annotate(last.partition("=")[2], (x, y), fontsize=6, xytext=(2, 2), textcoords="offset points")
        axes.set_xlabel("queries per km")
        axes.set_ylabel(name)
    if len(lines) > 1:
        figure.legend(*axes.get_legend_handles_labels(), loc="outside right upper", fontsize=7)
    varied = next(iter(summaries)).rpartition(",")[2].partition("=")[0]
    figure.suptitle(f"label of each point: {varied}", fontsize=8)
    figure.savefig(path, dpi=DPI)


def _series(summaries: Mapping[str, Summary]) -> dict[str, dict[str, Summary]]:
    """Group summaries by all settings but the last, and then by the last."""
    found: dict[str, dict[str, Summary]] = {}
    for label, summary in summaries.items():
        shared, _, last = label.rpartition(",")
        found.setdefault(shared, {})[last] = summary
    return found
