"""Things in the oncoming lane that never come: the guard does not wait for them as for oncoming traffic."""

from __future__ import annotations

import math

import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.scene import LineKind, ObjectKind
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
C, K = RejectCode, ObjectKind
LEAD = thing("lead", 66.0, stationary_s=40.0)
PAST = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
GUTTER_M = LANE_M + 1.5
FACING = {"yaw": math.pi, "stationary_s": 300.0}


def codes(behavior, *objects, road=None):
    world = World(road or straight_road(), [LEAD, *objects], sight_m=300.0)
    return set(GUARD.accept([behavior], world.view(), False)[0].codes)


def drifting(obj, speed_mps):
    """The same object as a tracker may report it: its place is right, its velocity is not zero."""
    return obj.model_copy(update={"vx_mps": speed_mps, "stationary_s": 0.0})


UNMOVING = [
    thing("bin", 66.0, GUTTER_M, kind=K.PROP, length=0.6, width=0.6),
    thing("bin of unknown kind", 66.0, GUTTER_M, kind=K.UNKNOWN, length=0.6, width=0.6),
    thing("bin further on", 80.0, GUTTER_M, kind=K.PROP, length=0.6, width=0.6),
    thing("hose", 85.0, LANE_M, kind=K.DEBRIS, length=0.3, width=3.4, height=0.08),
    thing("barrier", 85.0, LANE_M, kind=K.BARRIER, length=0.6, width=1.8),
    thing("van with hazard lights", 85.0, LANE_M, kind=K.VAN, hazard=True, length=5.6, width=2.1, **FACING),
    thing("parked car", 80.0, LANE_M + 0.6, **FACING),
    thing("car that has just stopped", 90.0, LANE_M, yaw=math.pi, stationary_s=1.0, moved_s_ago=1.0),
]


@pytest.mark.parametrize("obj", UNMOVING, ids=lambda o: o.id)
def test_stationary_object_in_oncoming_lane_is_not_yielded_to(obj):
    assert codes(PAST, obj) == set()


@pytest.mark.parametrize("speed_mps", [-0.7, -2.0, 0.7])
@pytest.mark.parametrize("kind", [K.BARRIER, K.CONE, K.PROP, K.DEBRIS, K.BAG])
def test_static_object_with_velocity_is_no_oncoming_traffic(kind, speed_mps):
    """Whatever velocity a tracker reports for a barrier or a bin, it is no traffic that must pass first."""
    obj = drifting(thing("still", 110.0, GUTTER_M, kind=kind, length=0.6, width=0.6), speed_mps)
    assert codes(PAST, obj) == set()


def test_vehicle_with_velocity_is_oncoming_traffic():
    van = thing("van", 110.0, LANE_M, kind=K.VAN, hazard=True, yaw=math.pi)
    assert C.ONCOMING_GAP in codes(PAST, drifting(van, -5.0))


def test_static_object_with_velocity_is_no_traffic_from_behind():
    """Beside the ego and behind it: a barrier in the next lane is not a vehicle that must be able to brake."""
    multi = straight_road(left=LineKind.BROKEN, oncoming=None)
    change = ChangeLane(side="left", distance_m=30.0, speed_mps=5.0)
    barrier = thing("barrier", 40.0, LANE_M, kind=K.BARRIER, length=0.6, width=1.8)
    assert codes(change, drifting(barrier, 0.8), road=multi) == set()
    assert C.LANE_ENTRY in codes(change, thing("car", 40.0, LANE_M, speed=8.0), road=multi)


def test_static_object_with_velocity_is_no_leader_to_follow():
    """A barrier that seems to roll ahead is hit, not followed; a car is."""
    barrier = thing("barrier", 70.0, kind=K.BARRIER, length=0.6, width=1.8)
    keep = KeepLane(distance_m=40.0, speed_mps=5.0)
    for obj, found in ((drifting(barrier, 2.0), {C.COLLISION}), (thing("car", 66.0, speed=4.0), set())):
        world = World(straight_road(), [obj], speed=0.0)
        assert set(GUARD.accept([keep], world.view(), False)[0].codes) == found, obj.id


def test_static_object_above_walking_pace_is_traffic():
    """A barrier that comes at 10 m/s is a vehicle of the wrong class."""
    assert C.ONCOMING_GAP in codes(PAST, drifting(thing("barrier", 150.0, LANE_M, kind=K.BARRIER), -10.0))
