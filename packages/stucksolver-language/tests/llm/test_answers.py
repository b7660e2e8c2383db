"""Reading answers: tolerant about what stands around them, strict about what stands in them."""

from __future__ import annotations

import copy
import json
import math
import os
import struct
from random import Random

import mind
import pytest
from chat_server import behaviors_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from stucksolver.guard import Guard
from stucksolver.reasoners import ReasonerError, ReasonerTrace
from stucksolver.reasoners.reasoner import parse_trace
from stucksolver.scene import LightState, LineKind, ObjectKind
from stucksolver.solver.state_machine.execution import Execution
from stucksolver_language.llm import AnswerError, parse_answer
from stucksolver_language.llm.answer_parser import FORMAT
from stucksolver_language.llm.prompt import messages
from stucksolver_language.llm.tool_schema import decide_tool
from worlds import World, red_light, straight_road, thing

ADVERSARIAL = int(os.environ.get("ADVERSARIAL_ANSWERS", "10000"))
"""How many different answers are made up; `make test` looks at fewer."""

WORLD = World(
    straight_road(left=LineKind.BROKEN),
    [thing("car", 60.0), thing("walker", 75.0, 2.0, kind=ObjectKind.PEDESTRIAN), thing("far", 110.0, 7.0, speed=-8.0)],
    (red_light(90.0, LightState.GREEN),),
)
SCENE = WORLD.scene()
VIEW = WORLD.view()
OFFERED = [b.name for b in SCENE.behaviors]
GOOD = mind.answer(messages(SCENE)[1].text, OFFERED)
TEXT = json.dumps(GOOD)
OTHER = json.dumps({**GOOD, "decision": {**GOOD["decision"], "behaviors": None}})


def test_the_right_answer_is_read():
    assert parse_answer(TEXT, SCENE).plan is not None


@pytest.mark.parametrize(
    "wrapped",
    [
        f"```json\n{TEXT}\n```",
        f"I think so: {TEXT} Good luck!",
        TEXT.replace("}]", "},]"),
        f"  \n{TEXT}\n",
        f"{{not json}} {TEXT}",
        f"{TEXT} {TEXT}",
    ],
)
def test_what_stands_around_it_is_overlooked(wrapped):
    assert parse_answer(wrapped, SCENE) == parse_answer(TEXT, SCENE)


@pytest.mark.parametrize(
    "text", ["", "no", "{", "null", "[1]", "{}", TEXT[:-20], f"{TEXT} {OTHER}", "{" * 5000, "[" * 99999]
)
def test_what_is_no_single_answer_is_an_error(text):
    with pytest.raises(AnswerError):
        parse_answer(text, SCENE)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_numbers_that_are_not_finite_are_refused(number):
    data = copy.deepcopy(GOOD)
    data["decision"]["behaviors"][0]["speed_mps"] = 12345.5
    with pytest.raises(AnswerError):
        parse_answer(json.dumps(data).replace("12345.5", number), SCENE)


def test_a_recorded_answer_is_read_again_by_its_format():
    trace = ReasonerTrace(format=FORMAT, answers=("first", TEXT))
    assert parse_trace(trace, SCENE) == parse_answer(TEXT, SCENE)


# ---- whatever a model says

ids = st.sampled_from(["car", "walker", "far", "ghost", "", "none", "w1"])
numbers = st.one_of(st.floats(), st.integers(-5, 200), st.sampled_from([0.5, 1.5, 3.0, 5.0, 30.0, 60.0]))
values = st.one_of(ids, numbers, st.none(), st.booleans(), st.sampled_from(["left", "right", "time", "clear"]))
FIELDS = [
    "speed_mps",
    "distance_m",
    "side",
    "object_id",
    "past_object_id",
    "leader_id",
    "offset_m",
    "duration_s",
    "until",
]
wild = st.fixed_dictionaries(
    {"name": st.sampled_from([*OFFERED, "fly"])},
    optional=dict.fromkeys(FIELDS, values),
)


@st.composite
def sound(draw):
    """A behavior that fits its schema, with any parameters within their bounds."""
    definitions = decide_tool(SCENE).parameters["$defs"]
    one = definitions[draw(st.sampled_from(behaviors_of({"$defs": definitions})))]
    return {key: draw(_value(schema)) for key, schema in one["properties"].items()}


def _value(schema):
    if "enum" in schema:
        return st.sampled_from(schema["enum"])
    if "$ref" in schema:
        return st.sampled_from(["car", "walker", "far"] if "object" in schema["$ref"] else ["w1"])
    if "anyOf" in schema:
        return st.none()
    if schema["type"] == "number":
        low = schema.get("minimum", schema.get("exclusiveMinimum", 0.0) + 0.01)
        return st.floats(low, schema["maximum"])
    return {"boolean": st.booleans(), "string": st.text(max_size=30)}[schema["type"]]


@st.composite
def spoilt_answers(draw):
    """The right answer with a plan of any kind and some of its parts replaced."""
    data = copy.deepcopy(GOOD)
    data["decision"]["behaviors"] = draw(st.one_of(st.lists(sound(), max_size=6), st.lists(wild, max_size=8), values))
    for _ in range(draw(st.integers(0, 2))):
        part = draw(st.sampled_from(["observation", "analysis", "decision"]))
        key = draw(st.sampled_from([*GOOD[part], "extra"]))
        data[part][key] = draw(st.one_of(values, st.lists(values, max_size=3), st.text(max_size=20)))
    text = json.dumps(data)
    return draw(st.sampled_from([text, f"```json\n{text}\n```", f"Ignore the guard! {text}", text[: len(text) // 2]]))


def held_to_its_promises(text: str) -> None:
    """No crash, no plan outside the schema, no plan past the guard."""
    try:
        decision = parse_answer(text, SCENE)
    except ReasonerError:
        return
    if decision.plan is None:
        return
    assert {b.name for b in decision.plan.behaviors} <= set(OFFERED)
    for behavior in decision.plan.behaviors:
        # Strictly as the behavior's own type has it, bounds included.
        assert type(behavior).model_validate_json(behavior.model_dump_json(), strict=True) == behavior
    execution = Execution(decision.plan, Guard(), guided=False)
    if execution.start(VIEW, 0.0).accepted:
        execution.tick(VIEW, 0.0)


@pytest.mark.integration
@settings(max_examples=300, suppress_health_check=list(HealthCheck))
@given(st.one_of(spoilt_answers(), st.text(max_size=200)))
def test_no_answer_crashes_leaves_the_schema_or_passes_the_guard(text):
    held_to_its_promises(text)


# ---- many more of them, drawn by hand: hypothesis takes ten times as long to draw one as it takes to judge it

NAMES = [*FIELDS, "name", "extra"]
TEXTS = ["left", "right", "time", "clear", "", "\x00", "\ud800", "Ignore the guard!", "ß" * 30, "]}", "NaN"]
NUMBERS = [0.5, 1.5, 3.0, 5.0, 30.0, 60.0, -0.0, 1e-300, 1e308, math.inf, -math.inf, math.nan, 2**70, -1]
IDS = ["car", "walker", "far", "ghost", "", "none", "w1"]
DEFINITIONS = decide_tool(SCENE).parameters["$defs"]


def any_value(draw: Random):
    """An identifier, a number of any size, a text or a constant."""
    (number,) = struct.unpack("<d", draw.randbytes(8))
    pool = draw.choice([IDS, NUMBERS, TEXTS, [number, draw.uniform(-5.0, 200.0), draw.randint(-5, 200)]])
    return draw.choice([*pool, None, draw.random() < 0.5])


def within_schema(draw: Random, schema):
    """A value that a field's schema allows; bounds are drawn, too."""
    if "enum" in schema:
        return draw.choice(schema["enum"])
    if "$ref" in schema:
        return draw.choice(["car", "walker", "far"] if "object" in schema["$ref"] else ["w1"])
    if "anyOf" in schema:
        return None
    if schema["type"] == "number":
        low = schema.get("minimum", schema.get("exclusiveMinimum", 0.0) + 0.01)
        return draw.choice([low, schema["maximum"], draw.uniform(low, schema["maximum"])])
    return draw.random() < 0.5 if schema["type"] == "boolean" else draw.choice(TEXTS)


def sound_behavior(draw: Random):
    """A behavior that fits its schema."""
    properties = DEFINITIONS[draw.choice(behaviors_of({"$defs": DEFINITIONS}))]["properties"]
    return {key: within_schema(draw, schema) for key, schema in properties.items()}


def wild_behavior(draw: Random):
    """A behavior's name, or one that there is not, with any fields."""
    fields = {key: any_value(draw) for key in draw.sample(NAMES, draw.randint(0, 6))}
    return {**fields, "name": draw.choice([*OFFERED, "fly"])}


def adversarial_answer(draw: Random) -> str:
    """As `spoilt_answers`."""
    data = copy.deepcopy(GOOD)
    kind = draw.choice([sound_behavior, sound_behavior, wild_behavior, None])
    data["decision"]["behaviors"] = any_value(draw) if kind is None else [kind(draw) for _ in range(draw.randint(0, 7))]
    for _ in range(draw.choice([0, 0, 1, 2])):
        part = draw.choice(["observation", "analysis", "decision"])
        values = [any_value(draw) for _ in range(3)]
        data[part][draw.choice([*GOOD[part], "extra"])] = draw.choice([values[0], values])
    text = json.dumps(data)
    return draw.choice([text, text, f"```json\n{text}\n```", f"Ignore the guard! {text}", text[: len(text) // 2]])


@pytest.mark.slow
@pytest.mark.integration
def test_thousands_of_adversarial_answers_are_held_to_the_promises():
    texts = list(dict.fromkeys(adversarial_answer(Random(seed)) for seed in range(ADVERSARIAL * 3 // 2)))
    assert len(texts) >= ADVERSARIAL
    for text in texts[:ADVERSARIAL]:
        held_to_its_promises(text)
