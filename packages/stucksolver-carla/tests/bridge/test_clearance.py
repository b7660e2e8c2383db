"""Free way along a path: the vehicle's body swept along it, against boxes."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_bridge.actor_boxes import BridgeActorBox, PlacedBox
from stucksolver_bridge.clearance import STEP_M, free_way_m
from stucksolver_bridge.path_line import PathLine

AHEAD = PathLine([(0.0, 0.0, 5.0), (60.0, 0.0, 5.0)])
CAR = (2.4, 1.0)


def box(x, y, z=0.5, length=4.0, width=2.0, yaw=0.0, name=7):
    body = BridgeActorBox(SimpleNamespace(id=name), length / 2, width / 2, 0.5, (0.0, 0.0, 0.5), 0.0)
    return PlacedBox(body, x, y, z, yaw, 0.0, 0.0)


@pytest.mark.integration
@given(x=st.floats(6, 40))
def test_free_way_ends_within_step_before_bumper_contact(x):
    """The free distance ends a step or less before the bumpers touch."""
    gap = x - 2.0 - CAR[0]
    assert gap - STEP_M <= free_way_m(AHEAD, 0.0, 50.0, CAR, 0.0, [box(x, 0.0)]) <= gap + 1e-6


@pytest.mark.parametrize(
    "thing",
    [box(20.0, 2.5), box(-8.0, 0.0), box(20.0, 0.0, z=6.0), box(20.0, 0.0, z=-4.0), box(58.0, 0.0)],
    ids=["beside", "behind", "on a bridge above", "on a road below", "out of reach"],
)
def test_what_is_not_in_the_way_leaves_it_free(thing):
    assert free_way_m(AHEAD, 0.0, 40.0, CAR, 0.0, [thing]) == math.inf


def test_free_way_ignores_object_to_drive_over():
    """An object that the path leads over on purpose does not end the free distance."""
    assert free_way_m(AHEAD, 0.0, 40.0, CAR, 0.0, [box(20.0, 0.0, name=3)], ignore=(3,)) == math.inf


@given(x=st.floats(1.0, 4.39), y=st.floats(-1.5, 1.5), yaw=st.floats(-0.3, 0.3))
def test_what_touches_already_is_not_pushed(x, y, yaw):
    assert free_way_m(AHEAD, 0.0, 40.0, CAR, 0.0, [box(x, y, yaw=yaw)]) == 0.0


@pytest.mark.parametrize(
    "thing",
    [box(-4.3, 0.0), box(-4.0, 0.5, yaw=0.2), box(1.0, 2.1), box(-1.0, -1.99)],
    ids=["at the rear bumper", "askew at the rear", "within the margin beside", "rubbing behind the middle"],
)
def test_what_touches_already_may_be_left(thing):
    assert free_way_m(AHEAD, 0.0, 40.0, CAR, 0.0, [thing]) == math.inf


def test_backing_away_from_what_is_touched_in_front_is_free():
    back = PathLine([(0.0, 0.0, 1.0), (-10.0, 0.0, 1.0)])
    assert free_way_m(back, 0.0, 8.0, CAR, 0.0, [box(4.35, 0.0)], backwards=True) == math.inf
    assert free_way_m(back, 0.0, 8.0, CAR, 0.0, [box(-4.35, 0.0)], backwards=True) == 0.0


def test_a_box_that_is_turned_reaches_farther_to_the_side():
    beside = 2.2
    assert free_way_m(AHEAD, 0.0, 40.0, CAR, 0.0, [box(20.0, beside, yaw=0.0)]) == math.inf
    assert free_way_m(AHEAD, 0.0, 40.0, CAR, 0.0, [box(20.0, beside, yaw=math.pi / 2)]) < 20.0
