"""A passenger and the car: what is asked, said and done, with the real solver, guard and reader of words."""

from __future__ import annotations

import pytest
from sitting import Sitting, parked

from stucksolver.interpreter import NoInterpreter
from stucksolver.plan import Execute
from stucksolver.scene import LineKind, ObjectKind
from worlds import World, ladder, straight_road, thing

pytest.importorskip("onnxruntime")


def moves(sitting):
    return any(isinstance(directive, Execute) and directive.path for directive in sitting.directives)


def test_conversation_parked_car_is_reported_before_asking_to_pass():
    """The car names the blocker and asks for approval before it passes."""
    sitting = Sitting(parked())
    now = sitting.until(lambda now: now.question is not None)
    assert now.thought == "A parked car blocks my lane."
    assert now.question.text.startswith("May I go round it on the left when the oncoming lane is free?")
    assert [answer.label for answer in now.answers] == ["Yes", "No"]
    assert not moves(sitting)


def test_a_yes_is_done_and_told():
    sitting = Sitting(parked())
    sitting.until(lambda now: now.question is not None)
    assert sitting.answer(True).taken
    sitting.until(lambda now: "Done. I drive on." in [line.text for line in now.lines])
    assert sitting.world.x > 85.0
    assert "I am going round it on the left." in sitting.car()


def test_a_no_keeps_the_car_where_it_is():
    sitting = Sitting(parked())
    sitting.until(lambda now: now.question is not None)
    assert sitting.answer(False).taken
    sitting.drive(5.0)
    assert "All right, I will leave it." in sitting.car()
    assert not moves(sitting)


def test_conversation_requested_plan_needs_no_further_approval():
    """An utterance that requests the plan counts as its approval: the car does not ask again."""
    sitting = Sitting(parked())
    sitting.drive(5.0)
    sitting.say("please go round it on the left")
    sitting.until(lambda now: "executing" in now.state)
    assert not any(line.startswith("May I") for line in sitting.car())


def test_a_yes_in_words_is_a_yes():
    sitting = Sitting(parked())
    sitting.until(lambda now: now.question is not None)
    sitting.say("yes please")
    sitting.until(lambda now: "executing" in now.state)


def test_conversation_unclear_reply_asks_for_yes_or_no():
    """After an unclear reply, the car asks for yes or no, and the question stays open."""
    sitting = Sitting(parked())
    sitting.until(lambda now: now.question is not None)
    sitting.say("hrmpf grmbl")
    sitting.drive(1.0)
    assert sitting.car()[-1] == "I did not understand that. Please answer with yes or no."
    assert sitting.now.question is not None


def test_words_are_no_yes_to_crossing_a_solid_line():
    world = World(straight_road(oncoming=LineKind.SOLID), [thing("parked", 75.0)])
    sitting = Sitting(world, policy=ladder())
    sitting.say("please go round it on the left")
    now = sitting.until(lambda now: now.question is not None)
    assert "I would cross a solid line." in now.question.text
    sitting.drive(3.0)
    assert not moves(sitting)


def test_what_cannot_be_done_is_refused_with_its_reason():
    oncoming = thing("truck", 105.0, y=3.5, kind=ObjectKind.TRUCK, speed=-8.0)
    sitting = Sitting(parked())
    sitting.world.objects.append(oncoming)
    sitting.say("please go round it")
    sitting.drive(2.0)
    assert any(line.startswith("I can't") for line in sitting.car()), sitting.car()
    assert not moves(sitting)


def going_round(seconds):
    """A ride on which the plan has been driven for so long, from 20 m before the parked car."""
    sitting = Sitting(parked(x=50.0, cruise_mps=0.0))
    sitting.until(lambda now: now.question is not None)
    sitting.answer(True)
    sitting.until(lambda now: "executing" in now.state)
    sitting.drive(seconds)
    assert sitting.press("stop").taken
    return sitting


def test_the_button_stop_ends_the_plan_under_way():
    sitting = going_round(1.0)
    sitting.until(lambda now: "executing" not in now.state, limit_s=3.0)
    assert "I have ended that, as you asked." in sitting.car()
    sitting.drive(10.0)
    assert sitting.world.x < 55.0
    assert sitting.now.intention == "I am waiting, as you asked. Tell me when I should try again."


@pytest.mark.integration
def test_conversation_stop_beyond_commit_point_finishes_plan_and_reports():
    """Where a stop would not be safe, the plan is finished, and the car says so."""
    sitting = going_round(4.0)
    sitting.until(lambda now: "executing" not in now.state)
    assert "I could not stop safely half-way, so I have finished it." in sitting.car()
    assert "I have ended that, as you asked." not in sitting.car()


@pytest.mark.integration
def test_the_same_refusal_is_told_once():
    sitting = Sitting(parked(sight_m=40.0))
    sitting.say("please go round it")
    sitting.drive(20.0)
    told = [line for line in sitting.car() if line.startswith("I can't")]
    assert told and len(told) == len(set(told))


def test_unclear_words_are_asked_back_once():
    sitting = Sitting(parked())
    for words in ("blub", "hrmpf grmbl"):
        sitting.say(words)
        sitting.drive(1.0)
    assert [line for line in sitting.car() if "understand" in line] == [
        "I did not understand that. Shall I wait, drive on, go round it, or take another way?",
        "I still do not understand, so I will carry on as before. The buttons show what I can do.",
    ]


def test_words_show_what_they_were_understood_as():
    sitting = Sitting(parked())
    sitting.say("please wait")
    sitting.drive(1.0)
    (said,) = [line for line in sitting.now.lines if line.text == "please wait"]
    assert said.understood is not None and said.understood.startswith("wait")


def test_a_stop_while_the_car_just_drives_is_not_promised():
    sitting = Sitting(parked())
    sitting.world.objects.clear()
    sitting.drive(4.0)
    sitting.press("stop")
    sitting.drive(1.0)
    assert "I will keep to our route" in sitting.car()[-1]


def test_without_a_reader_of_words_the_car_says_so():
    sitting = Sitting(parked(), reader=NoInterpreter())
    sitting.say("please go round it")
    sitting.drive(1.0)
    assert sitting.car()[-1].startswith("I could not read your words.")


def test_conversation_after_end_of_ride_ignores_utterances():
    """The end of the ride is reported, and later utterances are not accepted."""
    sitting = Sitting(parked())
    sitting.drive(1.0)
    sitting.seat.end()
    assert sitting.now.ended and sitting.now.thought == "The ride is over."
    assert not sitting.say("hello").taken


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        ("he's unloading, that takes an hour", "Then I will look for a way past"),
        ("the driver is just coming back", "I will wait for them"),
        ("the road is clear", "I will still look for myself"),
        ("what a lovely day", "asks nothing of my driving"),
    ],
)
def test_conversation_claim_is_answered_with_its_effect(words, answer):
    """A statement about the world is answered with what it changes."""
    sitting = Sitting(parked())
    sitting.say(words)
    sitting.drive(0.5)
    assert any(answer in text for text in sitting.car())


def test_conversation_no_question_while_waiting_for_returning_driver():
    """The car asks no question while it waits for a driver who is coming back."""
    sitting = Sitting(parked())
    sitting.say("the driver is just coming back")
    sitting.drive(25.0)
    assert "All right, I will wait for them for a while." in sitting.car()
    assert sitting.now.question is None
    assert not moves(sitting)
