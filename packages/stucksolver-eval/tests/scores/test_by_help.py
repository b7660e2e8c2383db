"""What words gained and cost, by the sort of help."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest
from outcomes import noted, outcome, spoken

from stucksolver_eval.metrics.guidance_effect import help_figures
from stucksolver_eval.result_pages.guided import GuidedPageError, main, pairs_of


@dataclass(frozen=True)
class Named:
    id: str


@dataclass(frozen=True)
class Row:
    """What the figures need of a row."""

    route: Named
    seed: int
    outcome: Any
    score: float
    success: bool


@dataclass(frozen=True)
class Rows:
    rows: tuple[Row, ...]


def rows(*drives: tuple[str, int, float, bool, tuple[Any, ...]], near: tuple[Any, ...] = ()) -> Any:
    made = [
        Row(Named(name), seed, outcome(route_id=name, seed=seed, guidance=said, near_misses=near), score, success)
        for name, seed, score, success, said in drives
    ]
    return Rows(tuple(made))


HELP, HARM = (spoken(5.0, "helpful", "pass quicker"),), (spoken(5.0, "dangerous", "into the flow"),)


def test_routes_are_paired_and_grouped_by_what_was_said_first() -> None:
    before = rows(
        ("1", 1, 40.0, False, ()), ("1", 2, 60.0, False, ()), ("2", 1, 100.0, True, ()), ("3", 1, 50.0, True, ())
    )
    after = rows(
        ("1", 1, 100.0, True, HELP), ("1", 2, 60.0, False, HELP), ("2", 1, 90.0, False, HARM), ("3", 1, 0.0, False, ())
    )
    helpful, pass_quicker, dangerous, flow = help_figures(before, after)
    assert (helpful.help, pass_quicker.help, dangerous.help, flow.help) == ("", "pass quicker", "", "into the flow")
    assert pass_quicker.score.difference.mean == pytest.approx(30.0)
    assert (pass_quicker.drives, pass_quicker.won, pass_quicker.lost) == (2, 1, 0)
    assert (flow.success.difference.mean, flow.lost) == (-100.0, 1)


def test_what_is_worse_is_told_as_harm() -> None:
    before = rows(("1", 1, 40.0, False, ()))
    after = rows(("1", 1, 40.0, False, HELP), near=(noted(3.0), noted(9.0)))
    assert [figure.harm for figure in help_figures(before, after)] == [2, 2]


@pytest.mark.parametrize("arguments", [[], ["dev"], ["dev=one"], ["=a,b"], ["dev=a,b,c"], ["dev=a,"]])
def test_wrong_arguments_are_told_how_they_look(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(GuidedPageError, match="SUITE=UNGUIDED,GUIDED"):
        pairs_of(arguments)
    assert main(arguments) == 2
    assert capsys.readouterr().err.startswith("error: ")
