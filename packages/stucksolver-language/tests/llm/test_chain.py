"""What is concluded has to follow from the questions of the chain."""

from __future__ import annotations

import itertools
import json

import mind
import pytest
from chat_server import available_in

from stucksolver.plan import GuidanceIntent, WaitReason
from stucksolver.reasoners import ReasonerTrace
from stucksolver.reasoners.reasoner import parse_trace
from stucksolver.scene import Guidance, LineKind
from stucksolver_language.llm import AnswerError, parse_answer
from stucksolver_language.llm.chain_consistency import wrong_chain
from stucksolver_language.llm.prompt import messages
from worlds import World, straight_road, thing

SCENE = World(straight_road(left=LineKind.BROKEN), [thing("car", 60.0)]).scene()
GUIDED = SCENE.model_copy(update={"guidance": Guidance(text="please overtake", time_s=0.0)})


def good(sc):
    return mind.answer(messages(sc)[1].text, available_in(messages(sc)[1].text))


def changed(sc, *changes):
    """An answer with `(path, value)` put into it."""
    data = good(sc)
    for path, value in changes:
        *way, last = path.split("/")
        part = data
        for key in way:
            part = part[key]
        part[last] = value
    return json.dumps(data)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ([("analysis/steps/S2.2/answer", True)], "S2.2 is yes"),
        ([("analysis/steps/S2.3/answer", True)], "S2.3 is yes"),
        ([("analysis/steps/S2.4/answer", True), ("analysis/wait", "light")], "S2.4 is yes"),
        ([("analysis/steps/S2.4/answer", True)], "must say what holds the vehicle"),
        ([("analysis/wait", "queue")], "wait is queue, but S2.4"),
        ([("analysis/wait", "at_destination")], "but S2.2"),
        ([("analysis/steps/S2.5/answer", False)], "S2.5 is not yes"),
        ([("analysis/steps/S2.5/answer", None)], "S2.5 is not yes"),
        ([("analysis/immobilized", False), ("decision/behaviors", None)], "S2.5 is yes"),
    ],
)
def test_a_conclusion_against_its_own_answers_is_named(changes, told):
    with pytest.raises(AnswerError, match=told):
        parse_answer(changed(SCENE, *changes), SCENE)


@pytest.mark.parametrize(
    "changes",
    [
        [("analysis/steps/S2.1/answer", False), ("analysis/immobilized", False)],
        [("analysis/steps/S2.1/answer", None), ("analysis/immobilized", False)],
        [("analysis/guidance_intent", "unclear"), ("analysis/immobilized", False)],
    ],
)
def test_nobody_sets_off_on_words_that_were_not_understood(changes):
    with pytest.raises(AnswerError, match="behaviors must be null"):
        parse_answer(changed(GUIDED, *changes), GUIDED)


def test_being_held_without_a_plan_is_in_order():
    text = changed(
        SCENE,
        ("analysis/steps/S2.4/answer", True),
        ("analysis/wait", "no_safe_way"),
        ("analysis/steps/S2.5/answer", False),
        ("analysis/immobilized", False),
        ("decision/behaviors", None),
    )
    assert parse_answer(text, SCENE).plan is None


def test_chain_accepted_answers_never_contradict_conclusion():
    """No accepted chain concludes immobilized against its other answers, or moves while the ego is held."""
    answers = (True, False, None)
    for told in itertools.product(answers, repeat=4):
        for immobilized, wait, moves in itertools.product((True, False), (None, *WaitReason), (True, False)):
            chain = dict(zip(("S2.2", "S2.3", "S2.4", "S2.5"), told, strict=True))
            if wrong_chain(chain, immobilized=immobilized, wait=wait, intent=None, moves=moves):
                continue
            assert immobilized is (told[3] is True)
            assert not (immobilized and True in told[:3])
            assert not (moves and told[2] is True)


def test_with_words_only_what_can_be_done_is_done():
    for can, intent in itertools.product((True, False, None), GuidanceIntent):
        wrong = wrong_chain({"S2.1": can}, immobilized=False, wait=None, intent=intent, moves=True)
        assert bool(wrong) is (can is not True or intent is GuidanceIntent.UNCLEAR)


def test_answers_recorded_before_this_was_checked_can_be_read_again():
    text = changed(SCENE, ("analysis/steps/S2.5/answer", None))
    assert parse_trace(ReasonerTrace(format="llm-decide-1", answers=(text,)), SCENE).plan is not None
    with pytest.raises(AnswerError):
        parse_trace(ReasonerTrace(format="llm-decide-2", answers=(text,)), SCENE)
