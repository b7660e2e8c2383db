"""The passenger's page in left-hand traffic: every sentence of the car names the side that people see."""

from __future__ import annotations

import pytest
from sitting import Sitting

from left_hand_worlds import LeftHandWorld, left_hand
from worlds import straight_road, thing


def test_page_left_hand_names_true_sides():
    """The question, its line in the conversation, and the behavior in execution say "on the right"."""
    pytest.importorskip("onnxruntime")
    sitting = Sitting(LeftHandWorld(left_hand(straight_road()), [thing("parked", 75.0)]))
    asked = sitting.until(lambda now: now.question is not None)
    assert asked.question.text.startswith("May I go round it on the right")
    assert asked.question.text in sitting.car()
    sitting.answer(True)
    now = sitting.until(lambda now: "executing" in now.state)
    assert now.thought == "I am going round it on the right."


def test_page_left_hand_keeps_the_words_of_people():
    """What a passenger says stays, and is understood as said."""
    pytest.importorskip("onnxruntime")
    sitting = Sitting(LeftHandWorld(left_hand(straight_road()), [thing("ahead", 95.0, speed=3.0)], speed=3.0))
    sitting.drive(1.0)
    sitting.say("overtake on the right")
    now = sitting.until(lambda now: any(line.understood for line in now.lines))
    line = next(line for line in now.lines if line.understood)
    assert line.text == "overtake on the right"
    assert line.understood.startswith("overtake on the right")
    assert any(text.startswith("You want me to go past on the right") for text in sitting.car())
