"""Orders that cannot be performed are told apart from those that can, before any of them is performed."""

from __future__ import annotations

import copy
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.plan import Execute, PathPoint, SafeStop
from stucksolver.plan.behaviors import KeepLane, Wait
from stucksolver.plan.directive import directive_adapter
from stucksolver_bridge.directive_validation import MOST_POINTS, malformed_reason

POINTS = tuple(PathPoint(x_m=float(x), y_m=0.5, speed_mps=4.0, no_stop=x > 10) for x in range(30))
DRIVE = Execute(behavior=KeepLane(distance_m=30.0, speed_mps=4.0), path=POINTS, ignore=("17",))
FOLLOW = {"path": [[p.x_m, -p.y_m, p.speed_mps] for p in POINTS], "reverse": False, "ignore": [17]}


def form(directive):
    return directive_adapter.dump_python(directive, mode="json")


GOOD = [
    {},
    {"directive": form(DRIVE), "orders": [["follow", FOLLOW]]},
    {"directive": form(Execute(behavior=Wait(duration_s=1.0), brake_mps2=6.0)), "orders": [["hold", 6.0]]},
    {"directive": form(SafeStop(reason="blocked")), "orders": [["lights", 48], ["hold", None]]},
    {"directive": {"kind": "replan", "route_start": "own+20"}, "orders": [["release", None], ["route", []]]},
    {"orders": [["route", [[11, -1, 3.5, "lane_follow"], [11, -1, 4.5, "left"]]]]},
    {"events": [{"kind": "started", "time_s": 3.0, "text": "", "verdict": None}]},
]


@pytest.mark.parametrize("answer", GOOD)
def test_what_the_solver_says_can_be_performed(answer):
    assert malformed_reason(json.loads(json.dumps(answer))) is None


def spoilt():
    """Each a sound answer with one thing wrong."""
    drive = GOOD[1]
    ends = [
        (("orders", 0, 1, "path", 3, 0), [math.nan, math.inf, "3", None, 1e9, 10**400, [], True]),
        (("orders", 0, 1, "path", 3, 2), [-1.0, math.nan, 1e5, "fast"]),
        (("orders", 0, 1, "path", 3), [[1.0, 2.0], {}, "here", 7, [1.0, 2.0, 3.0, 4.0]]),
        (("orders", 0, 1, "path"), [[], None, "ahead", [[0.0, 0.0, 1.0]], [[0.0, 0.0, 1.0]] * 9, FOLLOW["path"] * 999]),
        (("orders", 0, 1, "reverse"), [None, 1, "no"]),
        (("orders", 0, 1, "ignore"), [None, [None], ["17"], [1.5], [2**40], list(range(5000))]),
        (("orders", 0, 1), [None, [], 3, "path", {}]),
        (("orders", 0, 0), ["fly", None, 7, [], {}]),
        (("orders", 0), [None, {}, "follow", ["follow"], []]),
        (("orders",), [None, {}, "follow", [["hold", None]] * 1000]),
        (("directive",), [None, [], "continue", {}, {"kind": "drive"}, {"kind": ["execute"]}]),
        (("directive", "path"), [None, "ahead", [3], [{}], form(DRIVE)["path"] * 1000]),
        (("directive", "path", 2, "x_m"), [math.nan, None, "3"]),
        (("directive", "path", 2, "no_stop"), [None, 1, "yes"]),
        (("directive", "expires_ticks"), [None, 0, 1e9, math.inf, 2.5, "soon", True]),
        (("directive", "brake_mps2"), [0.0, -3.0, math.nan, "hard"]),
        (("events",), [None, {}, [7], [None], [{}] * 100_000]),
    ]
    for where, values in ends:
        for value in values:
            answer = copy.deepcopy({**drive, "events": []})
            inner = answer
            for step in where[:-1]:
                inner = inner[step]
            inner[where[-1]] = value
            yield pytest.param(answer, id=f"{'.'.join(map(str, where))}={str(value)[:20]}")


@pytest.mark.parametrize("answer", list(spoilt()))
def test_one_thing_that_is_wrong_is_named(answer):
    assert malformed_reason(answer)


@pytest.mark.parametrize("name", ["follow", "hold", "release"])
def test_what_the_driver_does_must_come_with_its_directive(name):
    assert "directive" in malformed_reason({"orders": [[name, FOLLOW if name == "follow" else None]]})


@pytest.mark.parametrize(
    "order",
    [
        *(["route", [spot]] for spot in ([11, -1, 3.5], ["a", -1, 3.5, "left"], [11, -1, math.nan, "left"])),
        *(["lights", state] for state in (-1, 1.5, None, 2**40)),
        *(["hold", brake] for brake in ("hard", -1)),
    ],
)
def test_other_orders_are_looked_at_as_well(order):
    assert malformed_reason({"directive": {"kind": "continue"}, "orders": [order]})


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=6),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4),
    max_leaves=12,
)


@given(ANYTHING)
def test_nothing_is_raised_whatever_is_said(answer):
    for item in (answer, {"directive": answer}, {"orders": [["follow", answer]]}, {"orders": answer}):
        assert malformed_reason(item) is None or isinstance(malformed_reason(item), str)


def test_a_huge_list_is_refused_without_being_looked_through():
    huge = [object()] * (MOST_POINTS + 1)
    assert "entries" in malformed_reason({"directive": {"kind": "execute", "path": huge}})
