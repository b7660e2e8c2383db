"""Where a pass comes back: as soon as its tail clears what it passed, into a gap, and at the end of the known road."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import affinity
from shapely.geometry import box

from stucksolver.guard import Guard
from stucksolver.plan.behaviors import BorrowOncomingLane
from stucksolver.scene import ObjectKind, PlanFailure
from worlds import World, straight_road, thing

GUARD = Guard()
ROAD = straight_road()


def proven(*objects, speed=5.0, road=ROAD):
    view = World(road, list(objects)).view()
    verdict, found = GUARD.accept([BorrowOncomingLane(past_object_id="lead", speed_mps=speed)], view, False)
    assert found is not None, verdict
    return found


def body(x, y, yaw):
    flat = box(-4.9 / 2, -1.85 / 2, 4.9 / 2, 1.85 / 2)
    return affinity.translate(affinity.rotate(flat, yaw, origin=(0, 0), use_radians=True), x, y)


@pytest.mark.parametrize("speed", [2.0, 5.0])
@pytest.mark.parametrize("across", [-0.8, 0.0, 0.5])
def test_pass_return_begins_early_and_keeps_gap(speed, across):
    """The return starts before the ego is past the object, and keeps clear of it."""
    path = proven(thing("lead", 65.0, across, hazard=True), speed=speed).path
    lead = box(65.0 - 2.3, across - 0.95, 65.0 + 2.3, across + 0.95)
    turns = np.flatnonzero(np.diff(path.d) < -1e-3)
    assert path.s[turns[0]] < 65.0 + 2.3 + 4.9 / 2 + 1.0
    heading = path.body(0.0, 2.9)
    gaps = [body(*at).distance(lead) for at in zip(path.s, path.d, heading, strict=True)]
    assert min(gaps[1:]) > 0.3


def test_a_pass_may_end_where_the_known_road_ends():
    count = 83
    lanes = tuple(
        lane.model_copy(update={name: getattr(lane, name)[:count] for name in ("offset_m", "width_m", "line")})
        for lane in ROAD.lanes
    )
    short = ROAD.model_copy(update={"key": "short", "reference": ROAD.reference[:count], "lanes": lanes})
    path = proven(thing("lead", 62.0), road=short).path
    assert path.end_s <= 82.0 and path.stops and abs(path.end_d) < 1e-6
    assert not proven(thing("lead", 62.0)).path.stops


def test_pass_known_road_too_short_to_return_is_rejected():
    """Where the known road is too short to return, there is no pass."""
    count = 70
    lanes = tuple(
        lane.model_copy(update={name: getattr(lane, name)[:count] for name in ("offset_m", "width_m", "line")})
        for lane in ROAD.lanes
    )
    short = ROAD.model_copy(update={"key": "too short", "reference": ROAD.reference[:count], "lanes": lanes})
    view = World(short, [thing("lead", 62.0)]).view()
    verdict, _ = GUARD.accept([BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)], view, False)
    assert verdict.failures == (PlanFailure.NO_ROOM_TO_COME_BACK,)


def test_pass_return_keeps_gap_to_adjacent_cones():
    """The return keeps clear of objects beside the passed one.

    Cones along the border of the lane, as beside a construction site, reach farther than the passed object.
    """
    cones = [thing(f"cone{k}", 64.0 + 2.0 * k, 1.45, kind=ObjectKind.CONE) for k in range(5)]
    path = proven(thing("lead", 70.0, hazard=True), *cones, speed=3.0).path
    bodies = [body(*at) for at in zip(path.s, path.d, path.body(0.0, 2.9), strict=True)]
    assert min(b.distance(box(c.x_m - 0.2, 1.25, c.x_m + 0.2, 1.65)) for b in bodies for c in cones) > 0.3
