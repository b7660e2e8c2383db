"""Every number that the guard judges by stands in its policy, once, with a unit and an origin."""

from __future__ import annotations

import ast
import math
from pathlib import Path

import pytest
from pydantic import ValidationError

import stucksolver.guard
from stucksolver.guard import Guard, GuardPolicy
from stucksolver.guard.policy import ClearancePolicy, DoorPolicy, RssPolicy
from stucksolver.plan.behaviors import KeepLane
from stucksolver.scene.base_model import FrozenModel
from worlds import World, straight_road, thing

ROOM = Path(stucksolver.guard.__file__).parent
JUDGES = sorted(ROOM.glob("*.py"))
POLICY_FILES = sorted((ROOM / "policy").glob("*.py"))
MEANING_NOTHING = {"EPSILON", "KMH_PER_MPS", "MOST", "MOST_STOPS", "NAMED", "SAMPLES"}
"""Arithmetic, bounds on the work of one look, and units for sentences."""
COUNTED = {0, 1, 2}
"""Indices, signs, halves and squares."""
UNITS = ("_m", "_s", "_mps", "_mps2", "_rad")
PARTS = {"part_of_length", "confidence", "confirmed_confidence", "sluggish_speed", "sluggish_acceleration"}
"""Numbers without a unit: parts of something, and probabilities."""
SUB_POLICIES = {
    name: field.annotation
    for name, field in GuardPolicy.model_fields.items()
    if isinstance(field.annotation, type) and issubclass(field.annotation, FrozenModel)
}
NUMBERS = [(part, name) for part, model in SUB_POLICIES.items() for name in model.model_fields]


def constants(tree):
    """(name, value node) of what is assigned at the level of a module."""
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            for name in ast.walk(target) if target is not None else ():
                if isinstance(name, ast.Name):
                    yield name.id, node.value


def numbers(node):
    return [
        n.value
        for n in ast.walk(node)
        if isinstance(n, ast.Constant) and isinstance(n.value, int | float) and not isinstance(n.value, bool)
    ]


def stray_constants(source):
    """Names of a module's numeric constants that say something about safety."""
    return [name for name, value in constants(ast.parse(source)) if numbers(value) and name not in MEANING_NOTHING]


def stray_literals(source):
    """Figures written into a module's functions and classes."""
    tree = ast.parse(source)
    body = [node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    return [value for node in body for value in numbers(node) if value not in COUNTED]


@pytest.mark.parametrize("file", JUDGES, ids=lambda file: file.name)
def test_no_number_with_a_meaning_stands_beside_the_policy(file):
    source = file.read_text(encoding="utf-8")
    assert stray_constants(source) == [], "give it a field of a sub-policy in guard/policy, with unit and origin"
    assert stray_literals(source) == [], "give it a field of a sub-policy in guard/policy, with unit and origin"


@pytest.mark.parametrize(
    "source", ["GAP_M = 0.3", "NEAR_M, FAR_M = 1.0, 2.0", "GAP_M: float = 3", "SPANS_S = (1.5, 2.5)", "MORE = 20 / 3.6"]
)
def test_a_constant_beside_the_policy_would_be_found(source):
    assert stray_constants(source)
    assert not stray_constants("NAMED = 3\nKINDS = frozenset()\nON = True")


def test_a_figure_in_a_function_would_be_found():
    assert stray_literals("def near(gap):\n    return gap < 0.4") == [0.4]
    assert stray_literals("def half(gap):\n    return gap / 2") == []


def test_each_number_has_a_unit_in_its_name():
    assert [number for number in NUMBERS if not number[1].endswith(UNITS) and number[1] not in PARTS] == []


def test_each_number_says_what_it_is_for():
    """A docstring under each field, or one for it and the field before it."""
    for file in POLICY_FILES:
        for model in (n for n in ast.parse(file.read_text(encoding="utf-8")).body if isinstance(n, ast.ClassDef)):
            body = model.body
            for field, after in zip(body, [*body[1:], None], strict=True):
                if isinstance(field, ast.AnnAssign) and numbers(field.value):
                    assert isinstance(after, ast.Expr), f"{file.name}: {model.name}.{field.target.id}"


def test_each_number_is_read_by_the_guard():
    trees = [ast.parse(file.read_text(encoding="utf-8")) for file in JUDGES]
    read = {node.attr for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    assert [number for number in NUMBERS if not set(number) <= read] == [], "nobody reads it: leave it out"


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_a_number_that_cannot_be_is_refused(value):
    with pytest.raises(ValidationError, match="standing_gap_m"):
        ClearancePolicy(standing_gap_m=value)


def test_policy_zero_divisor_or_misspelled_number_is_rejected():
    """A divisor must not be zero, and a misspelled number is rejected with its name."""
    with pytest.raises(ValidationError, match="response_braking_mps2"):
        RssPolicy(response_braking_mps2=0.0)
    with pytest.raises(ValidationError, match="standing_gap"):
        GuardPolicy(clearance={"standing_gap": 0.3})


def test_a_policy_survives_json():
    own = GuardPolicy(clearance=ClearancePolicy(standing_gap_m=0.4), solid_line="forbid")
    assert GuardPolicy.model_validate_json(own.model_dump_json()) == own != GuardPolicy()


def test_guard_uses_its_own_policy():
    """The guard uses its own policy and not the default.

    Doors that reach 0.9 m are in the way of a fast plan past a parked car 0.7 m beside the ego; short ones are not.
    """
    world, plan = World(straight_road(), [thing("parked", 75.0, -2.6)]), [KeepLane(distance_m=40.0, speed_mps=5.0)]
    assert not Guard().accept(plan, world.view(), False)[0].accepted
    assert Guard(GuardPolicy(doors=DoorPolicy(reach_m=0.2))).accept(plan, world.view(), False)[0].accepted
