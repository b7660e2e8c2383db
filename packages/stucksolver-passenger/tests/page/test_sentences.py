"""Whatever code the solver comes up with, there is a plain sentence for it."""

from __future__ import annotations

import re

import pytest

from stucksolver.guard import RULES, RejectReason, Verdict
from stucksolver.plan import CauseCode, WaitReason
from stucksolver.plan.behaviors import REGISTRY, BorrowOncomingLane, ChangeLane
from stucksolver.plan.decision import RecoveryPlan
from stucksolver.scene import Claim, GuidanceIntent, Interpretation, ObjectKind, PlanFailure, RejectCode
from stucksolver.solver import EventKind, Question, QuestionKind, StandstillReason
from stucksolver.solver.notices import IMMOVABLE, NOT_KNOWN
from stucksolver.solver.state_machine.state import StateName
from stucksolver_passenger.conversation import _HANDLERS, SILENT
from stucksolver_passenger.sentences import (
    acknowledged,
    blocked_by,
    future_phrase,
    needed,
    nouns,
    question_text,
    rejection_sentence,
    standstill_sentence,
    waiting,
)
from stucksolver_passenger.sentences.acknowledgements import CLAIMS, INTENTS
from stucksolver_passenger.sentences.nouns import THINGS
from stucksolver_passenger.sentences.questions import NEEDS
from stucksolver_passenger.sentences.reasons import CAUSES, WAITS
from stucksolver_passenger.sentences.rejections import FAILURES, REFUSALS
from stucksolver_passenger.status_summary import STATES
from worlds import World, straight_road, thing

TABLES = {
    "states": (STATES, StateName),
    "waits": (WAITS, WaitReason),
    "causes": (CAUSES, CauseCode),
    "refusals": (REFUSALS, RejectCode),
    "failures": (FAILURES, PlanFailure),
    "things": (THINGS, ObjectKind),
    "intents": (INTENTS, GuidanceIntent),
    "claims": (CLAIMS, Claim),
}
LEFT = BorrowOncomingLane(past_object_id="7", speed_mps=5.0)


@pytest.mark.parametrize("name", TABLES)
def test_sentence_tables_match_codes_exactly(name):
    """Every code has a sentence, and every sentence belongs to a code."""
    table, codes = TABLES[name]
    assert set(table) == set(codes)


def test_every_behavior_and_every_rule_has_its_words():
    assert all(behavior.phrase.future and behavior.phrase.present for behavior in REGISTRY.values())
    assert set(NEEDS) == set(RULES)
    assert needed(tuple(REGISTRY)) == ("I would use the lane of the oncoming traffic.",)
    assert len(needed((*RULES, *REGISTRY))) == len(NEEDS) + 1


def test_event_kinds_are_either_handled_or_silent():
    """Every kind of event has either a handler or an entry among those that a passenger does not need."""
    assert set(_HANDLERS) | SILENT == set(EventKind)
    assert not set(_HANDLERS) & SILENT


def test_sentence_unknown_need_raises_error():
    """A requirement without a sentence raises an error and is not skipped."""
    with pytest.raises(KeyError, match="Add it to NEEDS"):
        needed(("a_new_rule",))


def scene_with(kind):
    return World(straight_road(), [thing("7", 75.0, kind=kind)]).scene()


def sentences():
    scene = scene_with(ObjectKind.TRUCK)
    yield from (
        rejection_sentence(Verdict(rejects=(RejectReason(code=code, detail="x_y", object_id="7"),)), scene)
        for code in RejectCode
    )
    for failure in PlanFailure:
        yield rejection_sentence(
            Verdict(rejects=(RejectReason(code=RejectCode.NO_PATH, detail="x_y", failure=failure),)), scene
        )
    for reason in WaitReason:
        yield from waiting(reason, scene)
    yield from (blocked_by(cause, scene) for cause in CauseCode)
    for wait in WaitReason:
        yield standstill_sentence(StandstillReason(text="x_y", wait=wait), scene)
    for cause in CauseCode:
        yield standstill_sentence(StandstillReason(text="x_y", cause=cause), scene)
    for reject in RejectCode:
        found = RejectReason(code=reject, detail="x_y", object_id="7")
        yield standstill_sentence(StandstillReason(text="x_y", reject=found), scene)
    yield from (standstill_sentence(reason, scene) for reason in (IMMOVABLE, NOT_KNOWN))
    for intent in GuidanceIntent:
        yield acknowledged(Interpretation(intent=intent, likely=intent, confidence=1.0, reader="r"))


@pytest.mark.parametrize("text", list(sentences()))
def test_a_sentence_is_one_that_people_say(text):
    assert re.fullmatch(r"[A-Z][^_{}]*[.?]", text), text


def test_rejection_sentence_names_road_user_and_next_try():
    """The sentence for a rejection names the road user in the way and when the plan will be tried again."""
    verdict = Verdict(rejects=(RejectReason(code=RejectCode.ONCOMING_GAP, detail="", object_id="7"),))
    assert rejection_sentence(verdict, scene_with(ObjectKind.TRUCK)) == (
        "I can't: a truck is coming. I will try when it has passed."
    )


def test_standstill_sentence_says_how_much_sight_is_missing():
    reject = RejectReason(code=RejectCode.ONCOMING_SIGHT, detail="", needed_m=151.8, seen_m=24.0)
    assert standstill_sentence(StandstillReason(text="", reject=reject), None) == (
        "I cannot go on: I cannot see far enough ahead to use the other lane, 128 m are missing. "
        "I will look again in a moment."
    )


def test_wait_at_gate_is_not_told_as_red_light():
    assert waiting(WaitReason.LIGHT, scene_with(ObjectKind.CROSSING_GATE))[0] == "I am waiting at a closed gate."


def test_who_is_not_in_the_scene_is_somebody():
    verdict = Verdict(rejects=(RejectReason(code=RejectCode.ONCOMING_GAP, detail="", object_id="8"),))
    assert rejection_sentence(verdict, None).startswith("I can't: somebody is coming.")


def test_a_verdict_that_rejects_nothing_is_no_reason():
    with pytest.raises(ValueError, match="contains no rejection"):
        rejection_sentence(Verdict(), None)


def test_what_blocks_the_lane_is_named():
    assert blocked_by(CauseCode.PARKED_VEHICLE, scene_with(ObjectKind.VAN)) == "A parked van blocks my lane."


def test_a_thing_without_a_usual_name_still_blocks_the_lane():
    assert blocked_by(CauseCode.PARKED_VEHICLE, None) == "A parked vehicle blocks my lane."


@pytest.mark.parametrize(
    ("kinds", "told"),
    [
        ([], "something"),
        ([ObjectKind.CAR], "a car"),
        ([ObjectKind.BICYCLE] * 2, "two cyclists"),
        ([ObjectKind.CAR] * 7, "7 cars"),
        ([ObjectKind.LITTER] * 2, "some litter"),
        ([ObjectKind.CAR, ObjectKind.VAN], "a car"),
    ],
)
def test_several_things_are_counted_as_people_do(kinds, told):
    assert nouns(kinds) == told


def test_a_plan_is_told_part_by_part():
    right = ChangeLane(side="right", distance_m=30.0, speed_mps=5.0)
    plan = RecoveryPlan(behaviors=(LEFT, right))
    assert future_phrase(plan) == (
        "go round it on the left when the oncoming lane is free, then go round it in the lane on the right"
    )


def test_a_question_for_a_yes_says_what_it_would_release():
    plan = RecoveryPlan(behaviors=(LEFT,))
    question = Question(
        id="q1",
        time_s=0.0,
        kind=QuestionKind.APPROVAL,
        to="passenger",
        text="code",
        plan=plan,
        needs=("borrow_oncoming_lane", "solid_line"),
    )
    assert question_text(question) == (
        "May I go round it on the left when the oncoming lane is free? "
        "I would use the lane of the oncoming traffic. I would cross a solid line."
    )
