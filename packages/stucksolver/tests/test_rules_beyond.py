"""Who only waits beyond an obstruction is no part of what is to be passed."""

from __future__ import annotations

import pytest

from stucksolver.reasoners.rules.pass_target import group_of
from stucksolver.scene import FailedAttempt, ObjectKind, PlanFailure
from worlds import World, straight_road, thing

K = ObjectKind


def group(*beyond, failed=(), **lead):
    """Ids of what is passed together with a lead that ends at 64.6 m."""
    first = thing("lead", 62.3, **{"hazard": True, **lead})
    scene = World(straight_road(), [first, *beyond]).scene()
    attempts = tuple(FailedAttempt(time_s=0.0, behaviors=("x",), failures=(item,), outcome="") for item in failed)
    scene = scene.model_copy(update={"attempts": attempts})
    return [o.id for o in group_of(scene, next(o for o in scene.objects if o.id == "lead")).objects]


def after(gap_m, **more):
    return thing("beyond", 64.6 + gap_m + 2.3, **more)


@pytest.mark.parametrize("gap_m", [11.0, 12.5, 14.0, 17.0])
def test_group_excludes_car_waiting_beyond_accident(gap_m):
    """A car that waits beyond an accident is not passed together with it."""
    no_room = (PlanFailure.NO_ROOM_TO_COME_BACK,)
    assert group(after(gap_m)) == group(after(gap_m), failed=no_room) == ["lead"]


@pytest.mark.parametrize("lead", [{}, {"kind": K.CONE, "hazard": None}, {"hazard": False, "y": -0.8}], ids=str)
def test_whatever_says_of_itself_that_it_is_an_obstruction(lead):
    assert group(after(12.0), **lead) == ["lead"]


@pytest.mark.parametrize(
    "more", [{"hazard": True}, {"kind": K.BARRIER}, {"y": -0.8}, {"emergency_lights": True}], ids=str
)
def test_what_is_an_obstruction_itself_joins_it(more):
    assert group(after(12.0, **more)) == ["lead", "beyond"]


def test_group_without_gap_to_return_includes_next_car():
    """Without a gap to return before it, the next car is passed too."""
    assert group(after(8.0)) == ["lead", "beyond"]


def test_behind_a_lead_that_may_be_a_queue_nothing_changes():
    assert group(after(12.0), hazard=False) == ["lead", "beyond"]
