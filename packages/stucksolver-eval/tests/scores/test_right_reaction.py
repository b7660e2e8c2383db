"""Whether a reaction was right, from outcomes that were made up: each reaction right, late, missing and harmful."""

from __future__ import annotations

import pytest
from outcomes import noted, outcome, plan

from stucksolver_eval.metrics.recovery import recovery_figures, responded_correctly
from stucksolver_eval.metrics.right_reaction import called_after_s, fault_of, told_after_s, type_rows
from stucksolver_eval.results.outcome import NoticeRecord

MET_S = 20.0
STANDS = tuple((float(t), min(float(t), 60.0)) for t in range(201))
"""A track that ends 60 m after the start of a route of 200 m."""


def case(expected, within_s, *, passed=None, left=None, free=None, met=MET_S, **changes):
    times = {"met": met, "passed": passed, "left": left, "free": free}
    marks = {mark: time_s for mark, time_s in times.items() if time_s is not None}
    return outcome(expected=expected, within_s=within_s, marks=marks, **changes)


RIGHT = {
    "recovered in time": case("recover", 60.0, passed=79.0),
    "recovered with a near miss before the arrival": case("recover", 60.0, passed=79.0, infractions=(noted(5.0),)),
    "recovered slowly, which is no harm": case(
        "recover", 60.0, passed=79.0, infractions=(noted(50.0, "min_speed_infractions"),)
    ),
    "asked in time": case("ask", 30.0, asked_s=49.0, track=STANDS),
    "asked in time after a plan that moved": case("ask", 30.0, asked_s=49.0, interventions=(plan(25.0, 30.0),)),
    "left in time": case("leave", 20.0, left=35.0),
    "arrived another way in time": case("reroute", 160.0),
    "waited and went on": case("wait", 30.0, free=60.0, passed=80.0),
    "waited, asked and went on": case("wait", 30.0, free=60.0, passed=80.0, asked_s=40.0),
    "waited, then went on by a plan": case("wait", 30.0, free=60.0, passed=80.0, interventions=(plan(62.0, 80.0),)),
    "waited with a plan that stands": case(
        "wait", 30.0, free=60.0, passed=80.0, interventions=(plan(30.0, 50.0, moves=False),)
    ),
    "moved before the arrival": case("wait", 30.0, free=60.0, passed=80.0, interventions=(plan(10.0, 15.0),)),
}
WRONG = {
    "never arrived": (case("recover", 60.0, met=None), "never arrived"),
    "never passed": (case("recover", 60.0), "never passed"),
    "passed late": (case("recover", 60.0, passed=81.0), "passed after 61 s"),
    "touched a vehicle": (
        case("recover", 60.0, passed=50.0, infractions=(noted(40.0),)),
        "collisions_vehicle after 20 s",
    ),
    "never asked": (case("ask", 30.0), "never told an operator"),
    "asked late": (case("ask", 30.0, asked_s=51.0), "told an operator after 31 s"),
    "asked and passed": (case("ask", 30.0, asked_s=40.0, passed=90.0), "passed after 70 s"),
    "never left": (case("leave", 20.0), "never left"),
    "left late": (case("leave", 20.0, left=41.0), "left after 21 s"),
    "left over a red light": (
        case("leave", 20.0, left=25.0, infractions=(noted(24.0, "red_light"),)),
        "red_light after 4 s",
    ),
    "did not find another way": (case("reroute", 160.0, track=STANDS), "never at the destination"),
    "arrived late": (case("reroute", 100.0), "at the destination after 155 s"),
    "did not wait": (case("wait", 30.0, free=60.0, passed=50.0), "passed after 30 s"),
    "moved by a plan": (
        case("wait", 30.0, free=60.0, passed=70.0, interventions=(plan(40.0, 45.0),)),
        "moved after 20 s",
    ),
    "did not go on": (case("wait", 30.0, free=60.0), "never passed once it was free"),
    "went on late": (case("wait", 30.0, free=60.0, passed=95.0), "passed once it was free after 35 s"),
}


@pytest.mark.parametrize("name", RIGHT)
def test_right_reaction_has_no_fault(name):
    assert fault_of(RIGHT[name]) == ""
    assert responded_correctly(RIGHT[name])


@pytest.mark.parametrize("name", WRONG)
def test_wrong_reaction_is_named_with_its_time(name):
    drive, fault = WRONG[name]
    assert fault_of(drive) == fault
    assert not responded_correctly(drive)


def test_operator_is_called_after_the_arrival():
    """A call before the arrival counts as one at the arrival; without a call there is no time."""
    assert called_after_s(case("ask", 30.0, asked_s=45.0)) == 25.0
    assert called_after_s(case("ask", 30.0, asked_s=10.0)) == 0.0
    assert called_after_s(case("ask", 30.0)) is None
    assert called_after_s(case("ask", 30.0, met=None, asked_s=45.0)) is None


def notices(to, *times_s):
    return tuple(NoticeRecord(time_s=time_s, to=to) for time_s in times_s)


def test_operator_is_told_by_a_notice_or_by_a_call():
    told = notices("operator", 50.0)
    assert called_after_s(case("ask", 30.0, notices=told)) == 30.0
    assert called_after_s(case("ask", 30.0, notices=told, asked_s=45.0)) == 25.0
    assert fault_of(case("ask", 30.0, notices=told)) == ""
    assert fault_of(case("ask", 30.0, notices=notices("passenger", 50.0))) == "never told an operator"


def test_passenger_is_told_with_the_first_notice():
    """What was told before the arrival counts as told at the arrival."""
    told = notices("passenger", 25.0, 28.0)
    assert told_after_s(case("ask", 30.0, notices=told)) == 5.0
    assert told_after_s(case("ask", 30.0, notices=notices("passenger", 3.0))) == 0.0
    assert told_after_s(case("ask", 30.0, notices=notices("operator", 25.0))) is None
    assert told_after_s(case("ask", 30.0, met=None, notices=told)) is None


def test_rows_count_right_drives_by_situation():
    drives = [
        case("ask", 30.0, asked_s=40.0, scenario="Gate", notices=notices("passenger", 25.0)),
        case("ask", 30.0, asked_s=60.0, scenario="Gate", seed=2),
        case("ask", 30.0, asked_s=41.0, scenario="Gate", state="crashed"),
        outcome(expected="wait"),
        case("recover", 60.0, passed=70.0, scenario="Bin"),
    ]
    bin_row, gate_row = type_rows(drives)
    assert bin_row.cells == ("Bin", "recover within 60 s", "1/1", "–", "–", "–")
    assert gate_row.cells == ("Gate", "ask within 30 s", "1/2", "5", "30", "told an operator after 40 s")
    assert gate_row.text.startswith("1/2 Gate (ask within 30 s): passenger told after 5 s, operator told after 30 s")


def test_plan_after_the_wait_is_no_false_intervention():
    """Where waiting is right until a time, a plan is false before it, and not after it."""
    early = case("wait", 30.0, free=60.0, passed=70.0, interventions=(plan(40.0, 45.0),))
    late = case("wait", 30.0, free=60.0, passed=80.0, interventions=(plan(62.0, 80.0),))
    assert recovery_figures([early]).false == 1
    assert recovery_figures([late]).false == 0


def test_situation_without_a_time_limit_is_judged_as_before():
    assert responded_correctly(outcome(expected="ask", asked_s=190.0))
    assert not responded_correctly(outcome(expected="wait", interventions=(plan(10.0, 20.0),)))
