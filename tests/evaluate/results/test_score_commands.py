"""`stucksolver score` and `stucksolver compare`, on files alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from stores import ROUTES, begun, keep, record

from stucksolver.cli import main


def evaluation(folder: Path, recovery: str, completion: float) -> Path:
    store = begun(folder, recovery=recovery)
    for of in ROUTES:
        keep(store, of, 1, record(of, completion))
    return folder


def test_score_prints_every_table_and_pairs_with_the_driver_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    alone, helped = evaluation(tmp_path / "a", "none", 50.0), evaluation(tmp_path / "b", "rules", 100.0)
    assert main(["score", str(alone), str(helped)]) == 0
    told = capsys.readouterr().out
    assert "driver alone" in told and "driver + rules" in told
    assert "perception:privileged" in told and "Overtaking" in told and "Harm" in told
    assert "with the driver alone" in (helped / "report.html").read_text()


def test_compare_gives_the_difference_with_its_interval(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    first, second = evaluation(tmp_path / "a", "none", 50.0), evaluation(tmp_path / "b", "rules", 100.0)
    assert main(["compare", str(first), str(second)]) == 0
    told = capsys.readouterr().out
    assert "50.00 [50.00, 50.00]" in told
    assert "won by B: 1 Accident, 2 T_Junction" in told


def test_a_crashed_route_shows_in_the_exit_code(tmp_path: Path) -> None:
    from stores import outcome

    store = begun(tmp_path / "a")
    store.write_outcome(ROUTES[0], outcome(ROUTES[0], state="crashed", reason="x"))
    assert main(["score", str(store.folder)]) == 1


@pytest.mark.parametrize("command", [["score", "{}"], ["compare", "{}", "{}"]])
def test_what_is_no_evaluation_is_named(tmp_path: Path, command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([part.format(tmp_path) for part in command]) == 2
    assert "is no result of `stucksolver evaluate`" in capsys.readouterr().err
