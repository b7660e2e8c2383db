"""What is not seen counts as not free, in our own direction too."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import ChangeLane, Creep, KeepLane, RejoinRoute
from test_guard_abreast import LEFT, MULTI, OVER, SHOULDER
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
FAR = KeepLane(distance_m=150.0, speed_mps=5.5)


def codes(behavior, world):
    return {r.code for r in GUARD.accept([behavior], world.view(), False)[0].rejects}


@pytest.mark.parametrize(
    ("behavior", "road"),
    [(FAR, MULTI), (LEFT, MULTI), (OVER, SHOULDER), (Creep(distance_m=10.0), MULTI)],
    ids=["keep_lane", "change_lane", "pull_over", "creep"],
)
def test_without_any_sight_ahead_nothing_is_begun(behavior, road):
    assert RejectCode.PATH_NOT_VISIBLE in codes(behavior, World(road, sight_m=0.0))
    assert codes(behavior, World(road, sight_m=30.0)) == set()


@pytest.mark.parametrize(
    ("behavior", "road", "y"),
    [(LEFT, MULTI, 0.0), (OVER, SHOULDER, 0.0), (RejoinRoute(), MULTI, LANE_M)],
    ids=["change_lane", "pull_over", "rejoin_route"],
)
def test_without_sight_behind_no_lane_is_entered(behavior, road, y):
    assert RejectCode.PATH_NOT_VISIBLE in codes(behavior, World(road, behind_m=0.0, y=y))
    assert codes(behavior, World(road, behind_m=56.0, y=y)) == set()


def test_who_drives_straight_on_need_not_see_behind():
    assert codes(FAR, World(MULTI, behind_m=0.0)) == set()


@pytest.mark.parametrize("sight_m", [4.0, 8.0])
def test_what_is_seen_ahead_must_do_for_a_stop(sight_m):
    assert RejectCode.PATH_NOT_VISIBLE in codes(FAR, World(MULTI, sight_m=sight_m))


def test_sight_ending_at_lead_vehicle_is_enough():
    """A sight that ends at a known vehicle is as good as that vehicle.

    A truck ahead hides the road: the ego follows it, and its path does not reach beyond it yet.
    """
    lorry = thing("lorry", 65.0, speed=4.0, height=3.0)
    near_m = 65.0 - 2.3 - 50.0
    world = World(straight_road(), [lorry], sight_m=near_m - 2.0)
    assert codes(KeepLane(distance_m=40.0, speed_mps=5.5), world) == set()


def test_a_plan_ends_where_its_sight_does():
    world = World(MULTI)
    proven = GUARD.accept([FAR], world.view(), False)[1]
    world.x, world.speed, world.sight_m = 60.0, 5.0, 6.0
    verdict = GUARD.recheck(proven, world.view())
    assert {r.code for r in verdict.rejects} == {RejectCode.PATH_NOT_VISIBLE}


def test_behind_who_is_known_nobody_unseen_is_feared():
    lorry = thing("lorry", 20.0, LANE_M, speed=1.0, height=3.0)
    change = ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)
    assert codes(change, World(MULTI, [lorry], behind_m=26.0)) == set()


@pytest.mark.parametrize("x", [47.0, 49.0, 51.0, 53.0])
def test_sight_behind_ends_at_truck_passing_alongside(x):
    """A truck that passes alongside ends the sight behind, wherever it is.

    Its front is ahead of the ego already, its rear behind: a sight that ends at the ego's middle ends at the truck.
    """
    lorry = thing("lorry", x, LANE_M, speed=9.0, length=9.0, height=3.0)
    change = ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)
    assert RejectCode.PATH_NOT_VISIBLE not in codes(change, World(MULTI, [lorry], behind_m=0.0))
    gone = thing("lorry", x + 15.0, LANE_M, speed=9.0, length=9.0, height=3.0)
    assert RejectCode.PATH_NOT_VISIBLE in codes(change, World(MULTI, [gone], behind_m=0.0))
