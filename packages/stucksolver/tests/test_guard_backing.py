"""Backing up by a vehicle that stands in a junction: within it or out of it, and no worse than where it stands."""

from __future__ import annotations

import math

import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import BackUp
from stucksolver.scene import ObjectKind, Zone, ZoneKind
from stucksolver.solver import EventKind
from worlds import World, drive, straight_road, thing

C, K = RejectCode, ObjectKind
BACK = BackUp(distance_m=5.0, speed_mps=2.0)


def zones(*spans, **road):
    return straight_road(**road, zones=tuple(Zone(kind=kind, start_m=a, end_m=b) for kind, a, b in spans))


def codes(world, behavior=BACK):
    return {r.code for r in Guard().accept([behavior], world.view(), False)[0].rejects}


IN_IT = zones((ZoneKind.JUNCTION, 30.0, 60.0))
"""The ego is at 50 m, its body from 47.5 to 52.5 m."""


@pytest.mark.parametrize("start_m", [30.0, 48.0], ids=["within it", "out of it"])
def test_who_stands_in_a_junction_may_back_up(start_m):
    assert codes(World(zones((ZoneKind.JUNCTION, start_m, 60.0)))) == set()


def test_back_up_into_junction_is_rejected():
    """An ego that has stopped outside a junction does not back into it."""
    assert codes(World(zones((ZoneKind.JUNCTION, 30.0, 43.0)))) == {C.STOPPING_PLACE}


def test_from_one_junction_nobody_backs_into_another():
    two = zones((ZoneKind.JUNCTION, 30.0, 44.0), (ZoneKind.JUNCTION, 46.0, 60.0))
    assert codes(World(two)) == {C.STOPPING_PLACE}


def test_nobody_backs_onto_rails_even_out_of_a_junction():
    rails = zones((ZoneKind.LEVEL_CROSSING, 40.0, 45.0), (ZoneKind.JUNCTION, 46.0, 60.0))
    assert C.STOPPING_PLACE in codes(World(rails))


@pytest.mark.parametrize(
    ("kind", "x", "y", "refused"),
    [
        (K.PEDESTRIAN, 43.0, -4.0, True),
        (K.PEDESTRIAN, 38.5, 5.0, True),
        (K.BICYCLE, 43.0, 5.0, True),
        (K.PEDESTRIAN, 43.0, -20.0, False),
        (K.PEDESTRIAN, 30.0, -4.0, False),
    ],
)
def test_a_crosswalk_is_backed_onto_only_with_nobody_near_it(kind, x, y, refused):
    road = zones((ZoneKind.CROSSWALK, 41.0, 45.0), (ZoneKind.JUNCTION, 46.0, 60.0))
    assert codes(World(road)) == set()
    assert (C.STOPPING_PLACE in codes(World(road, [thing("one", x, y, kind=kind)]))) is refused


def test_back_up_in_junction_with_traffic_behind_is_rejected():
    """In a junction, too, a vehicle or occluded space behind the ego rejects backing up."""
    assert C.COLLISION in codes(World(IN_IT, [thing("behind", 41.0)]))
    assert codes(World(IN_IT, [thing("behind", 20.0, speed=4.0)]), BackUp(distance_m=5.0)) & {C.COLLISION, C.GAP}
    assert codes(World(IN_IT, behind_m=8.0)) == {C.PATH_NOT_VISIBLE}


def crossing(x, away_m):
    return thing("car", x, -away_m, sideways=6.0, yaw=math.pi / 2)


def test_back_up_end_in_conflict_path_is_rejected():
    """Backing up does not end in the path of a vehicle that crosses behind.

    The ego arrives after some 5 s, at 45 m; the car is there 3 s after that.
    """
    assert C.GAP in codes(World(IN_IT, [crossing(45.0, 48.0)]))
    assert codes(World(IN_IT, [crossing(25.0, 48.0)])) == set()


def test_back_up_out_of_conflict_path_is_accepted():
    """The ego may clear the path of a vehicle that would hit it where it has stopped."""
    assert codes(World(IN_IT, [crossing(54.0, 80.0)])) == set()


@pytest.mark.integration
def test_two_nose_to_nose_in_a_junction_part():
    one_lane = zones((ZoneKind.JUNCTION, 30.0, 60.0), oncoming=None)
    world = World(one_lane, [thing("other", 58.0, yaw=math.pi, stationary_s=40.0)])
    reached = []
    seen = drive(world, 30.0, every_tick=lambda w: reached.append(w.x))
    assert "back_up, wait" in seen.texts(EventKind.STARTED)
    assert min(reached) < 44.0
