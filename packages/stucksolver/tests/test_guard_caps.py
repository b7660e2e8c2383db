"""How quick a pass may be: 40 km/h or the limit past what stands, 20 km/h beside people, doors, and solid lines."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard, GuardPolicy, RejectCode
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.scene import LineKind, ObjectKind
from worlds import World, searched, straight_road, thing

KMH = 1 / 3.6
ROAD = straight_road()
GUARD = Guard(GuardPolicy(solid_line="autonomous"))
ROW = tuple(thing(name, 62.0 + 7.0 * k, -0.9, hazard=True) for k, name in enumerate(("a", "b", "c", "d", "e", "lead")))


def codes(speed, *more, road=ROAD, row=ROW, behavior=None, **world):
    behavior = behavior or BorrowOncomingLane(past_object_id="lead", speed_mps=speed)
    verdict, proven = GUARD.accept([behavior], World(road, [*row, *more], sight_m=400.0, **world).view(), False)
    return set(verdict.codes), proven


def limited(limit_mps):
    lanes = tuple(lane.model_copy(update={"speed_limit_mps": limit_mps}) for lane in ROAD.lanes)
    return ROAD.model_copy(update={"lanes": lanes, "key": f"caps {limit_mps}"})


def test_pass_of_stopped_object_may_exceed_20_kmh():
    found, proven = codes(9.0)
    assert found == set() and proven.path.speed.max() > 20 * KMH


@pytest.mark.parametrize(("limit_mps", "speed", "refused"), [(8.0, 8.1, True), (8.0, 7.9, False), (4.0, 5.5, False)])
def test_pass_above_speed_limit_is_rejected(limit_mps, speed, refused):
    """A pass is no faster than the speed limit, but the speed of a recovery (20 km/h) is always allowed."""
    found, _ = codes(speed, road=limited(limit_mps))
    assert (RejectCode.OVERSPEED in found) is refused


@pytest.mark.parametrize(
    "behavior", [KeepLane(distance_m=30.0, speed_mps=6.0), ChangeLane(side="left", distance_m=40.0, speed_mps=6.0)]
)
def test_nothing_but_a_pass_is_quicker_than_20_kmh(behavior):
    found, _ = codes(6.0, road=straight_road(left=LineKind.BROKEN), row=(), behavior=behavior)
    assert found == {RejectCode.OVERSPEED}


@pytest.mark.parametrize(("kind", "y"), [(ObjectKind.PEDESTRIAN, -1.9), (ObjectKind.BICYCLE, -1.9)])
def test_beside_people_it_is_no_quicker_than_20_kmh(kind, y):
    row = (*ROW[:3], thing("lead", 97.0, -0.9, hazard=True))
    walker = thing("walker", 90.0, y, kind=kind)
    assert RejectCode.OVERSPEED in codes(9.0, walker, row=row)[0]
    assert RejectCode.OVERSPEED not in codes(5.5, walker, row=row)[0]


def test_cap_pedestrian_at_slow_part_keeps_other_speeds():
    """A pedestrian beside the part where the ego is still slow does not slow the rest."""
    walker = thing("walker", 53.0, -4.5, kind=ObjectKind.PEDESTRIAN)
    assert RejectCode.OVERSPEED not in codes(9.0, walker)[0]


def test_a_door_in_reach_holds_it_to_20_kmh():
    """The road leaves 1 m beside cars that stand at the left of their lane."""
    row = tuple(o.model_copy(update={"y_m": 1.25}) for o in ROW)
    quick, _ = codes(9.0, row=row)
    assert RejectCode.OVERSPEED in quick
    assert RejectCode.OVERSPEED not in codes(5.5, row=row)[0]


def test_pass_over_solid_line_is_capped_at_20_kmh():
    """A pass over a solid line is nowhere faster than 20 km/h."""
    solid = straight_road(oncoming=LineKind.SOLID)
    assert codes(5.5, road=solid)[0] == set()
    assert codes(9.0, road=solid)[0] == {RejectCode.SOLID_LINE}


def test_pass_of_moving_vehicle_above_20_kmh_needs_guidance():
    """A moving vehicle is passed at up to 20 km/h, unless a passenger asks for more."""
    slow = thing("lead", 66.0, speed=2.0)
    view = World(ROAD, [slow], sight_m=400.0).view()
    plan = [BorrowOncomingLane(past_object_id="lead", speed_mps=9.0)]
    assert RejectCode.OVERSPEED in GUARD.accept(plan, view, False)[0].codes
    assert RejectCode.OVERSPEED not in GUARD.accept(plan, view, True)[0].codes


def proposed_mps(sight_m, *objects, road=ROAD):
    """The speed of the pass that the search proposes behind a row of disabled cars; None if it finds none."""
    world = World(road, list(objects), sight_m=sight_m)
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": 30.0})
    plan = searched(world, scene.model_copy(update={"ego": ego})).plan
    return None if plan is None else plan.behaviors[-1].speed_mps


def test_search_passes_faster_where_sight_is_short():
    """A faster pass needs less sight, and is proposed only where a slower one does not do."""
    assert proposed_mps(110.0, *ROW) is None
    assert proposed_mps(250.0, *ROW) > 5.5
    assert proposed_mps(400.0, *ROW) == 5.5
