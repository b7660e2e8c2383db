"""The table and the picture of a sweep, from result files."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from stores import ROUTES, begun, keep, outcome, record

from stucksolver_eval.metrics.summary import summarize
from stucksolver_eval.report.tradeoff import write_tradeoff

HALF = {"v_min=2,dt=1": 50.0, "v_min=2,dt=3": 60.0, "v_min=5,dt=1": 70.0, "v_min=5,dt=3": 80.0}


def swept(folder: Path, completions: dict[str, float]) -> str:
    summaries = {}
    for label, completion in completions.items():
        store = begun(folder / label, recovery="search")
        for of in ROUTES:
            keep(store, of, 1, record(of, completion))
            store.write_outcome(of, outcome(of, track=((0.0, 0.0), (10.0, completion))))
        summaries[label] = summarize(store)
    return write_tradeoff(summaries, folder)


@pytest.mark.integration
def test_every_setting_is_a_row_for_people_and_for_scripts(tmp_path: Path) -> None:
    told = swept(tmp_path, HALF)
    rows = list(csv.DictReader((tmp_path / "tradeoff.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["Setting"]: float(row["DS"]) for row in rows} == HALF
    assert all(label in told for label in HALF)


@pytest.mark.parametrize("completions", [HALF, {"dt=1": 50.0, "dt=3": 60.0}])
def test_tradeoff_plot_has_line_per_first_setting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, completions: dict[str, float]
) -> None:
    """The plot has one line for each value of the first setting."""
    figure = pytest.importorskip("matplotlib.figure", reason="needs matplotlib (the extra `report`)").Figure
    drawn = []
    monkeypatch.setattr(figure, "savefig", lambda self, path, **_: drawn.append((self, Path(path))))
    swept(tmp_path, completions)
    ((picture, path),) = drawn
    assert path == tmp_path / "tradeoff.png"
    scores = picture.axes[0]
    lines = scores.get_lines()
    assert [y for line in lines for y in line.get_ydata()] == list(completions.values())
    assert len(lines) == len({label.rpartition(",")[0] for label in completions})
    assert [text.get_text() for text in scores.texts] == [label.rpartition("=")[2] for label in completions]
