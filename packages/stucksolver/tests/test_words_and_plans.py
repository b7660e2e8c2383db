"""What a passenger's words may move: only what our own reader understood, whatever a reasoner makes of them."""

from __future__ import annotations

import pytest

from stucksolver.interpreter import NoInterpreter
from stucksolver.plan import Execute, RecoveryPlan, intent_authorizes, plan_matches_intent
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane, ChangeLane, KeepLane, PullOver
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import GuidanceIntent, LineKind, ObjectKind
from stucksolver.solver import EventKind
from worlds import READER, World, drive, ladder, noticed, said, straight_road, stubborn, thing

TWO_WAY = straight_road()
OVERTAKE = RecoveryPlan(behaviors=(BorrowOncomingLane(past_object_id="far", speed_mps=11.0),))


class Untrusted:
    """Proposes the same plan whatever is said."""

    name = "untrusted"

    def __init__(self, plan):
        self._plan = plan
        self.asked = 0

    def decide(self, request):
        self.asked += 1
        decision = noticed(request.scene)
        analysis = decision.analysis.model_copy(update={"guidance_intent": GuidanceIntent.OVERTAKE})
        return ReasonerAnswer(decision.model_copy(update={"plan": self._plan, "analysis": analysis}), self.name)


def cyclists():
    riders = [thing(name, x, kind=ObjectKind.BICYCLE, speed=4.0) for name, x in (("near", 75.0), ("far", 81.0))]
    return World(TWO_WAY, riders, x=40.0, sight_m=400.0)


@pytest.mark.integration
@pytest.mark.parametrize(
    "words",
    [
        "please do NOT overtake, just wait",
        "all right",
        "Pass me the water bottle, Tom",
        "I wouldn't pass him here",
        "do  not   pass",
        "stop!",
        "back up a little",
        "what a lovely day",
    ],
)
def test_a_reasoner_cannot_use_words_that_ask_for_something_else(words):
    seen = drive(cyclists(), 20.0, words={5.0: words}, reasoner=Untrusted(OVERTAKE))
    assert not [d for d in seen.directives if isinstance(d, Execute) and d.path]


@pytest.mark.integration
def test_plan_requested_by_passenger_is_driven():
    """The same plan is driven when the passenger asks for it."""
    seen = drive(cyclists(), 40.0, words={5.0: "please overtake them"}, reasoner=Untrusted(OVERTAKE))
    assert EventKind.STARTED in seen.kinds()
    assert seen.nearest_m > 0.5


def test_stop_does_not_let_a_reasoner_go_quicker():
    fast = RecoveryPlan(behaviors=(KeepLane(distance_m=60.0, speed_mps=11.0),))
    seen = drive(World(TWO_WAY, x=40.0), 15.0, words={5.0: "stop!"}, reasoner=Untrusted(fast))
    assert EventKind.STARTED not in seen.kinds()


def reading(text):
    return said(text).reading


@pytest.mark.parametrize(
    ("words", "plan", "released", "asked"),
    [
        ("overtake them", OVERTAKE, True, True),
        ("overtake them on the left", OVERTAKE, True, True),
        ("overtake them on the right", OVERTAKE, False, False),
        ("pull over please", RecoveryPlan(behaviors=(PullOver(),)), False, True),
        ("reverse a bit", RecoveryPlan(behaviors=(BackUp(distance_m=3.0),)), False, True),
        ("reverse a bit", OVERTAKE, False, False),
        ("drive on", OVERTAKE, False, False),
        ("drive on", RecoveryPlan(behaviors=(KeepLane(distance_m=20.0, speed_mps=3.0),)), False, True),
        ("drive on", RecoveryPlan(behaviors=(ChangeLane(side="left", distance_m=30.0, speed_mps=3.0),)), False, False),
        ("wait", OVERTAKE, False, False),
    ],
)
def test_what_words_release_and_what_they_ask_for(words, plan, released, asked):
    assert intent_authorizes(reading(words), plan) is released
    assert plan_matches_intent(reading(words), plan) is asked


def test_nothing_is_released_by_words_that_nobody_read():
    assert not intent_authorizes(None, OVERTAKE)
    assert not plan_matches_intent(None, OVERTAKE)


def test_guidance_refusal_lasts_for_whole_intervention():
    """A refusal lasts for the intervention and not only for half a minute."""
    world = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("lead", 75.0)])
    seen = drive(world, 80.0, ladder=stubborn(), words={6.0: "please don't overtake it"})
    assert EventKind.STARTED not in seen.kinds()


@pytest.mark.integration
def test_other_words_end_a_refusal():
    world = World(straight_road(left=LineKind.BROKEN, oncoming=None), [thing("lead", 75.0)])
    seen = drive(world, 80.0, ladder=stubborn(), words={6.0: "please don't overtake it", 50.0: "ok, now overtake it"})
    started = [e.time_s for e in seen.events if e.kind is EventKind.STARTED]
    assert started and started[0] >= 50.0


@pytest.mark.integration
@pytest.mark.parametrize("words", ["cancel", "abort", "no, don't"])
def test_to_cancel_ends_a_running_plan_by_its_safe_abort(words):
    def world():
        return World(TWO_WAY, [thing("lead", 100.0)], x=60.0)

    started = next(e.time_s for e in drive(world(), 30.0).events if e.kind is EventKind.STARTED)
    seen = drive(world(), started + 10.0, words={round(started + 0.1, 2): words})
    assert seen.texts(EventKind.ABORTED)[0] == "withdrawn"


def test_unclear_words_are_asked_back_once_and_move_nothing():
    seen = drive(cyclists(), 25.0, words={5.0: "do the thing with the", 9.0: "the other, you know"})
    assert seen.kinds().count(EventKind.ASKED_BACK) == 1
    assert not [d for d in seen.directives if isinstance(d, Execute)]


def test_guidance_without_interpreter_asks_back_and_moves_nothing():
    """Without the interpreter, no intent is guessed, and the missing package is named."""
    seen = drive(cyclists(), 15.0, words={5.0: "please overtake them"}, reader=NoInterpreter())
    assert "[language]" in seen.texts(EventKind.ASKED_BACK)[0]
    assert not [d for d in seen.directives if isinstance(d, Execute)]


def test_a_reader_that_fails_is_told_of_and_moves_nothing():
    class Broken:
        name = "broken"

        def read(self, text, situation):
            raise RuntimeError("no weights")

    seen = drive(cyclists(), 15.0, words={5.0: "please overtake them"}, reader=Broken())
    assert "no weights" in seen.texts(EventKind.FAULT)[0]
    assert not [d for d in seen.directives if isinstance(d, Execute)]


@pytest.mark.integration
@pytest.mark.parametrize(("words", "starts"), [("yes please", True), ("no, leave it", False)])
def test_yes_and_no_in_words_answer_the_open_question(words, starts):
    def world():
        return World(straight_road(oncoming=LineKind.SOLID), [thing("lead", 75.0, hazard=True)], sight_m=400.0)

    asked = next(e for e in drive(world(), 40.0, ladder=ladder()).events if e.kind is EventKind.ASKED)
    seen = drive(world(), asked.time_s + 8.0, ladder=ladder(), words={round(asked.time_s + 1.0, 2): words})
    assert any(e.kind is EventKind.ANSWERED for e in seen.events)
    assert (EventKind.STARTED in seen.kinds()) is starts


def test_the_event_carries_the_reading():
    seen = drive(cyclists(), 8.0, words={5.0: "please overtake them"})
    event = next(e for e in seen.events if e.kind is EventKind.GUIDANCE)
    assert event.reading is not None
    assert event.reading.reader == READER.name
    assert event.reading.confidence > 0.7
