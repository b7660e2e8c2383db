"""Bar plots as PNG, for papers; needs matplotlib (the extra [report] of the README)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stucksolver_eval.metrics.columns import run_name
from stucksolver_eval.metrics.multi_ability import ABILITIES
from stucksolver_eval.metrics.summary import Summary
from stucksolver_eval.report.tables import per_scenario

DPI = 200
"""Resolution of the plots (dots per inch)."""


def write_plots(summaries: Sequence[Summary], folder: Path) -> list[Path]:
    """Write `abilities.png` and `scenarios.png`, which compare the runs. Returns the files. Raises `OSError`."""
    names = [run_name(s) for s in summaries]
    folder.mkdir(parents=True, exist_ok=True)
    abilities = [[s.abilities[name] or 0.0 for name in ABILITIES] for s in summaries]
    groups = [per_scenario(s) for s in summaries]
    types = sorted(set().union(*groups))
    scores = [[g[t]["driving_score"] if t in g else 0.0 for t in types] for g in groups]
    return [
        _grouped(
            folder / "abilities.png", [n.replace("_", " ") for n in ABILITIES], names, abilities, "success rate %"
        ),
        _grouped(folder / "scenarios.png", types, names, scores, "driving score"),
    ]


def _grouped(path: Path, labels: list[str], names: list[str], values: list[list[float]], unit: str) -> Path:
    """Draw horizontal bars, grouped by label. Returns the file."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 1.2 + 0.13 * len(labels) * (len(names) + 1)), layout="constrained")
    axes = figure.subplots()
    height = 0.8 / len(names)
    for k, (name, row) in enumerate(zip(names, values, strict=True)):
        axes.barh([i + k * height for i in range(len(labels))], row, height, label=name)
    axes.set_yticks([i + 0.4 - height / 2 for i in range(len(labels))], labels, fontsize=7)
    axes.invert_yaxis()
    axes.set_xlim(0, 100)
    axes.set_xlabel(unit)
    axes.legend(fontsize=7)
    figure.savefig(path, dpi=DPI)
    return path
