"""A queue is told from what is there now, however long it has stood and whether or not we saw it move."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard, GuardPolicy, RejectCode
from stucksolver.plan.behaviors import BorrowOncomingLane
from stucksolver.scene import LineKind, ObjectKind
from worlds import World, straight_road, thing

GUARD = Guard()
LAST = BorrowOncomingLane(past_object_id="last", speed_mps=5.0)
ROAD = straight_road()


def why(*objects, guided=False, road=ROAD, guard=GUARD):
    return {r.code for r in guard.accept([LAST], World(road, list(objects)).view(), guided)[0].rejects}


def last(**more):
    return thing("last", 62.0, **more)


@pytest.mark.parametrize("stood_s", [12.0, 65.0, 600.0])
@pytest.mark.parametrize("moved_s_ago", [None, 90.0])
@pytest.mark.parametrize("guided", [False, True])
def test_one_that_stood_before_we_came_is_not_passed(stood_s, moved_s_ago, guided):
    stands = {"stationary_s": stood_s, "moved_s_ago": moved_s_ago}
    assert RejectCode.WAIT_FIRST in why(last(**stands), thing("next", 70.0, **stands), guided=guided)


def test_the_next_one_moves_at_this_very_moment():
    parked = last(stationary_s=65.0)
    assert RejectCode.WAIT_FIRST in why(parked, thing("next", 75.0, 0.6, speed=0.05, moved_s_ago=0.0))


@pytest.mark.parametrize(
    "more",
    [
        {"hazard": True},
        {"kind": ObjectKind.EMERGENCY, "emergency_lights": True},
        {"y": 0.6},
        {"x": 90.0},
        {"kind": ObjectKind.CONE},
    ],
    ids=str,
)
def test_what_says_that_it_does_not_wait_makes_no_queue(more):
    where = {"x": 70.0, "y": 0.0} | more
    found = why(last(stationary_s=65.0), thing("next", where.pop("x"), where.pop("y"), **where))
    assert RejectCode.WAIT_FIRST not in found


def test_no_solid_line_is_crossed_past_a_queue():
    road = straight_road(oncoming=LineKind.SOLID)
    guard = Guard(GuardPolicy(solid_line="autonomous"))
    found = why(last(stationary_s=65.0), thing("next", 70.0, stationary_s=65.0), road=road, guard=guard)
    assert RejectCode.SOLID_LINE in found
