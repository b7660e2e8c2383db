"""The figures on a drive's page: those of its summary, and no recovery where the ego never recovered."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from outcomes import outcome, plan, spell

from stucksolver_eval.metrics.recovery import recovery_figures
from stucksolver_eval.metrics.run_result import immobilizations, run_result
from stucksolver_eval.results.checkpoint import make_record
from stucksolver_eval.results.run_log import RunResult
from stucksolver_eval.run_table import recovered_text, stopped_text

START = spell(0.0, 5.1, place_m=0.0)
"""The ego speeds up from the start: slow for more than a second, then 15 m of progress."""


def result(**changes: Any) -> RunResult:
    driven = outcome(**changes)
    record = make_record(
        route_id="1",
        scenario="Accident",
        town="t",
        length_m=200.0,
        game_s=90.0,
        wall_s=1.0,
        completion_pct=30.0,
        failure="Agent got blocked",
        infractions=(),
    )
    return run_result(record, driven, 0)


def test_result_of_a_drive_that_never_recovered_has_no_recovery():
    """The start is no immobilization. A page said "recovered in 5.1 s" here."""
    found = result(spells=(START, spell(20.0, 90.0, recovered=False)))
    assert (found.immobilizations, found.recoveries, found.time_to_recover_s) == (1, 0, None)
    assert recovered_text(found) == "never"


@pytest.mark.parametrize(
    ("spells", "text"),
    [
        ((START,), "–"),
        ((START, spell(20.0, 34.5)), "14.5"),
        ((spell(20.0, 34.5), spell(50.0, 90.0, recovered=False)), "14.5 (1 of 2)"),
        ((spell(20.0, 30.0), spell(50.0, 70.0)), "15.0 (2 of 2)"),
        ((spell(20.0, 30.0, recovered=False), spell(50.0, 70.0, recovered=False)), "never"),
    ],
)
def test_recovered_text_counts_recoveries_of_several_immobilizations(spells, text):
    assert recovered_text(result(spells=spells)) == text


@pytest.mark.parametrize(("stopped_s", "text"), [(None, "–"), (0.0, "0.0"), (6.4, "6.4")])
def test_stopped_text_is_measured_or_a_dash(stopped_s, text):
    assert stopped_text(result(spells=(spell(20.0, 34.5),), stopped_s=stopped_s)) == text


times = st.floats(0.0, 300.0, allow_nan=False)
spells_made = st.lists(st.tuples(times, st.floats(1.0, 90.0), st.booleans()), max_size=5)
plans_made = st.lists(st.tuples(times, st.booleans()), max_size=4)


@pytest.mark.integration
@given(spells_made, plans_made)
def test_result_has_the_figures_of_the_summary(spells, plans):
    changes = {
        "spells": tuple(spell(onset, onset + lasts, recovered) for onset, lasts, recovered in spells),
        "interventions": tuple(plan(start, start + 5.0, moves=moves) for start, moves in plans),
    }
    found, figures = result(**changes), recovery_figures([outcome(**changes)])
    assert (found.immobilizations, found.recoveries) == (figures.met, figures.left)
    assert found.time_to_recover_s == figures.median_s
    assert len(immobilizations(outcome(**changes))) == figures.met
