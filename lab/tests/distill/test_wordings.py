"""From a passenger's sentence to the student's plan: what counts as the kind that was asked for."""

from __future__ import annotations

import json

import pytest

from lab.language.student.guidance_following import (
    PlanSample,
    matches_request,
    sentences_in,
    wording_scores,
    wording_table,
)
from stucksolver.interpreter import NoInterpreter, ScriptedInterpreter
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane, PullOver
from stucksolver.scene import GuidanceIntent, Interpretation
from stucksolver_language.student import DistilledReasoner
from worlds import World, straight_road, thing

AROUND = RecoveryPlan(behaviors=(BorrowOncomingLane(past_object_id="lead", speed_mps=5.5),))
BACK = RecoveryPlan(behaviors=(BackUp(distance_m=3.0),))


def meant(intent):
    return Interpretation(intent=GuidanceIntent(intent), likely=GuidanceIntent(intent), confidence=1.0, reader="author")


@pytest.fixture
def said(tmp_path):
    lines = [("a", "back_up"), ("b", "overtake"), ("c", "drive_over")]
    told = [{"text": t, "situation": "Standing.", "intent": i, "side": None} for t, i in lines]
    (tmp_path / "said.jsonl").write_text("\n".join(map(json.dumps, told)), encoding="utf-8")
    return sentences_in([tmp_path / "said.jsonl"])


@pytest.fixture(scope="module")
def place():
    return PlanSample(World(straight_road(), [thing("lead", 75.0)], x=66.0).scene(), (AROUND, BACK))


def ends(said, place, readings):
    return wording_scores(said, [place], DistilledReasoner(), ScriptedInterpreter(readings))


def test_what_is_understood_leads_to_a_plan_of_that_kind(said, place):
    found = ends(said, place, {"a": meant("back_up"), "b": meant("overtake")})
    assert found["back_up"]["read"] == found["back_up"]["meant"] == 1
    assert found["overtake"]["read"] == found["overtake"]["meant"] == 1


def test_misinterpreted_wording_counts_as_error_of_interpreter(said, place):
    """A wording that is misinterpreted leads to another plan and counts against the interpreter, not the student."""
    count = ends(said, place, {"a": meant("pull_over"), "b": meant("overtake")})["back_up"]
    assert (count["read"], count["meant"]) == (0, 1)
    assert count["other"] + count["none"] == 1


def test_what_is_not_understood_is_asked_back(said, place):
    found = wording_scores(said, [place], DistilledReasoner(), NoInterpreter())
    assert {count["asked_back"] for count in found.values()} == {1}


def test_a_kind_that_the_guard_accepts_nowhere_is_not_tried(said, place):
    assert "drive_over" not in ends(said, place, {})


def test_going_on_may_be_going_round_but_not_backing_up():
    assert matches_request(meant("go"), AROUND)
    assert not matches_request(meant("go"), BACK)
    assert not matches_request(meant("overtake"), RecoveryPlan(behaviors=(PullOver(),)))


def test_wording_table_has_row_per_behavior_and_total(said, place):
    """The table has one row for each behavior and one for all."""
    rows = wording_table(ends(said, place, {"a": meant("back_up"), "b": meant("overtake")})).splitlines()
    assert [row.split(" | ")[0] for row in rows[2:]] == ["| back_up", "| overtake", "| all"]
    assert "| 2 | 2 | 100.0 % | 100.0 % | 0 | 0 | 0 |" in rows[-1]


def test_a_line_that_is_no_sentence_is_named(tmp_path):
    (tmp_path / "x.jsonl").write_text('{"text": "go"}\n', encoding="utf-8")
    with pytest.raises(ValueError, match=r"x\.jsonl:1: no sentence"):
        sentences_in([tmp_path / "x.jsonl"])
