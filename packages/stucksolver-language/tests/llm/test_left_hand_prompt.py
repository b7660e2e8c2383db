"""A language model in left-hand traffic gets the scene as it is in the image, and its sides are swapped back."""

from __future__ import annotations

import json

import mind
import pytest

from left_hand_worlds import LeftHandWorld, left_hand
from stucksolver.plan.behaviors import ChangeLane
from stucksolver.reasoners.reasoner import ReasonerTrace, parse_trace
from stucksolver.scene import LaneRelation, LineKind
from stucksolver.scene.scene_builder import build_scene
from stucksolver_language.llm import parse_answer
from stucksolver_language.llm.answer_parser import FORMAT, parse_plan
from stucksolver_language.llm.prompt import LEFT_HAND, messages, system_text, user_text
from worlds import World, straight_road, thing

ROAD = straight_road(left=LineKind.BROKEN)


@pytest.fixture
def scene():
    """Two lanes in the ego's direction; the free one is on the right in the image, on the left for the solver."""
    return LeftHandWorld(left_hand(ROAD), [thing("car", 60.0, 0.3), thing("other", 90.0, -3.5, speed=5.0)]).scene()


def test_prompt_left_hand_shows_true_sides(scene):
    """The text is that of the scene that the stack sees: free lane and moving car are on the right."""
    assert scene.mirrored
    own = World(left_hand(ROAD), [thing("car", 60.0, 0.3), thing("other", 90.0, -3.5, speed=5.0)])
    assert user_text(scene) == user_text(build_scene(own.view(), own.status(), scene.behaviors))


def test_system_text_left_hand_swaps_sides(scene):
    """The meanings of behaviors name the sides that the model sees."""
    usual, swapped = system_text(World(ROAD).scene()), system_text(scene)
    assert LEFT_HAND in swapped and LEFT_HAND not in usual
    assert "through the oncoming lane on the left" in usual
    assert "through the oncoming lane on the right" in swapped and "lane on the left" not in swapped


def test_answer_left_hand_is_mirrored_for_the_solver(scene):
    """A change to the right lane of the image is a change to the left for the solver, also in a recorded answer."""
    answer = mind.answer(messages(scene)[1].text, [b.name for b in scene.behaviors])
    change = {"name": "change_lane", "side": "right", "distance_m": 30.0, "speed_mps": 5.0}
    answer["decision"]["behaviors"] = [change]
    answer["decision"]["rationale"] = "the lane on the right is free"
    answer["observation"]["participants"] = [
        {"object_id": "other", "kind": "car", "lane": "right", "intent": "unknown"}
    ]
    text = json.dumps(answer)
    decision = parse_answer(text, scene)
    first = decision.plan.behaviors[0]
    assert isinstance(first, ChangeLane) and first.side == "left"
    assert decision.rationale == "the lane on the left is free"
    assert decision.observation.participants[0].lane is LaneRelation.LEFT
    assert parse_trace(ReasonerTrace(format=FORMAT, answers=(text,)), scene) == decision
    assert parse_plan(json.dumps({"behaviors": [change]}), scene).behaviors[0].side == "left"
