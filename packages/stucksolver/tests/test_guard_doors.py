"""No door is met at more than walking pace, even if the vehicle drifts off its path as fast as a fault may move it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from stucksolver.guard import Guard, GuardPolicy, RejectCode
from stucksolver.plan.behaviors import BorrowOncomingLane, KeepLane, Nudge
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.scene.boxes import separation
from worlds import World, straight_road, thing

GUARD = Guard(GuardPolicy(solid_line="autonomous"))
ROAD = straight_road(left=LineKind.BROKEN, oncoming=None)
CREEP_MPS, DRIFT_MPS, REACH_M, LAG_S = 8 / 3.6, 0.25, 0.9, 0.3
HALF_M = 1.85 / 2


def door_gap_m(world, parked):
    """From the body to where an open door of the vehicle may reach."""
    ego = (world.x, world.y, world.yaw)
    half = (parked.length_m / 4, parked.width_m / 2 + REACH_M)
    return float(separation(ego, (4.9 / 2, HALF_M), (parked.x_m, parked.y_m, parked.yaw_rad), half))


def worst_mps(world, proven, parked, drifts_from_m, dt=0.1):
    """The highest speed within reach of the door, while the ego drifts towards it from a place on."""
    path, error, braking, ordered_s, worst = proven.path, 0.0, None, 0.0, 0.0
    side = np.sign(parked.y_m)
    for _ in range(250):
        if door_gap_m(world, parked) < 0.0:
            worst = max(worst, world.speed)
        if world.x >= path.end_s - 1.0 or (braking and world.speed <= 0.0):
            break
        if braking is None:
            verdict = GUARD.recheck(proven, world.view())
            if not verdict.accepted:
                braking = verdict.brake_mps2 or world.ego().limits.comfort_braking_mps2
        ordered_s += dt if braking else 0.0
        allowed = float(np.interp(world.x, path.s, path.speed))
        gain = -braking if braking and ordered_s > LAG_S else np.clip((allowed - world.speed) / dt, -3.0, 1.5)
        world.speed = max(world.speed + gain * dt, 0.0)
        error += side * DRIFT_MPS * dt * (world.x > drifts_from_m and world.speed > 0.0)
        world.x += world.speed * dt
        world.y = float(np.interp(world.x, path.s, path.d)) + error
        world.frame, world.time_s = world.frame + 1, world.time_s + dt
    return worst


@pytest.mark.integration
@given(
    gap_m=st.floats(0.85, 1.6),
    side=st.sampled_from([-1.0, 1.0]),
    at_m=st.floats(72.0, 95.0),
    from_m=st.floats(55.0, 95.0),
    speed=st.floats(2.0, 5.5),
    begins=st.sampled_from([0.0, 3.0]),
)
@settings(max_examples=12, deadline=None)
def test_drift_meets_no_door_quicker_than_walking_pace(gap_m, side, at_m, from_m, speed, begins):
    parked = thing("parked", at_m, side * (HALF_M + gap_m + 0.95))
    world = World(ROAD, [parked], speed=min(begins, speed))
    _, proven = GUARD.accept([KeepLane(distance_m=70.0, speed_mps=speed)], world.view(), False)
    assume(proven is not None)
    # A tick of 0.1 s of driving and drift belongs to no side.
    assert worst_mps(world, proven, parked, from_m) <= CREEP_MPS + 0.35


@pytest.mark.parametrize("gap_m", [0.95, 1.0, 1.05, 1.1])
@pytest.mark.parametrize("from_m", [60.0, 70.0, 76.0])
def test_drift_beside_a_parked_row_is_noticed_in_time(gap_m, from_m):
    parked = thing("parked", 80.0, -(HALF_M + gap_m + 0.95))
    world = World(ROAD, [parked])
    _, proven = GUARD.accept([KeepLane(distance_m=70.0, speed_mps=5.5)], world.view(), False)
    assert proven is not None, _
    assert worst_mps(world, proven, parked, from_m) <= CREEP_MPS + 0.35


@pytest.mark.parametrize(("gap_m", "quickest"), [(0.92, CREEP_MPS), (1.1, 4.1), (1.2, 5.5), (1.5, 5.5)])
def test_plan_slows_to_what_the_room_beside_a_door_allows(gap_m, quickest):
    parked = thing("parked", 80.0, -(HALF_M + gap_m + 0.95))
    world = World(ROAD, [parked])
    verdict, proven = GUARD.accept([KeepLane(distance_m=70.0, speed_mps=5.5)], world.view(), False)
    assert verdict.accepted
    beside = np.abs(proven.path.s - 80.0) < 1.0
    assert proven.path.speed[beside].max() == pytest.approx(quickest, abs=0.1)
    assert proven.path.speed[proven.path.s > 95.0].max() == pytest.approx(5.5)


@pytest.mark.parametrize("gap_m", [0.4, 0.8])
def test_within_reach_of_a_door_a_quicker_plan_is_refused(gap_m):
    parked = thing("parked", 80.0, -(HALF_M + gap_m + 0.95))
    found = GUARD.accept([KeepLane(distance_m=70.0, speed_mps=5.5)], World(ROAD, [parked]).view(), False)[0]
    assert RejectCode.DOOR in found.codes


@pytest.mark.parametrize("error_m", [0.0, 0.03, -0.3])
def test_recheck_small_or_outward_error_at_door_is_accepted(error_m):
    """A small tracking error, or one away from the door, does not end the plan."""
    parked = thing("parked", 80.0, -(HALF_M + 1.2 + 0.95))
    world = World(ROAD, [parked])
    _, proven = GUARD.accept([KeepLane(distance_m=70.0, speed_mps=5.5)], world.view(), False)
    world.x, world.y, world.speed = 72.0, -error_m, 5.5
    assert GUARD.recheck(proven, world.view()).accepted


def test_pass_of_parked_row_is_slowed_above_30_kmh():
    """A pass of a parked row is slowed only above 30 km/h.

    The pass is laid out with a margin for the drift; a fast one with a larger margin.
    """
    two_way = straight_road()
    row = [thing(f"p{k}", 62.0 + 7.0 * k, -0.9, hazard=True) for k in range(6)]
    for speed, beside_mps in ((5.5, 5.5), (8.0, 8.0), (11.0, 8.0)):
        plan = BorrowOncomingLane(past_object_id="p5", speed_mps=speed)
        verdict, proven = GUARD.accept([plan], World(two_way, row, sight_m=400.0).view(), False)
        assert verdict.accepted, verdict
        beside = np.abs(proven.path.s - 80.0) < 5.0
        assert proven.path.speed[beside].min() > 0.95 * beside_mps


def test_bicycles_and_moving_cars_have_no_doors_to_fear():
    rider = thing("bike", 80.0, -(HALF_M + 1.05 + 0.3), kind=ObjectKind.BICYCLE)
    _, proven = GUARD.accept([KeepLane(distance_m=70.0, speed_mps=5.5)], World(ROAD, [rider]).view(), False)
    assert proven is None or proven.path.speed.min() == pytest.approx(5.5)


def test_nudge_past_parked_car_keeps_walking_pace():
    """Within reach of the door of a parked car, a nudge keeps to walking pace."""
    parked = thing("parked", 66.0, -2.2)
    plan = Nudge(side="left", offset_m=0.7, distance_m=30.0, speed_mps=2.2)
    verdict, _ = GUARD.accept([plan], World(ROAD, [parked]).view(), False)
    assert RejectCode.DOOR not in verdict.codes
