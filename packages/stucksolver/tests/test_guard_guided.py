"""A passenger who asks to overtake raises no limit of a lane, and no cap beside people, two-wheelers and doors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver.guard import Guard, GuardPolicy, RejectCode
from stucksolver.plan.behaviors import AbortAction, BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.scene import LaneDirection, LineKind, ObjectKind, RoadGeometry
from worlds import LANE_M, World, said, searched, straight_road, strip, thing

KMH = 1 / 3.6
GUARD = Guard(GuardPolicy(solid_line="autonomous"))
SPEEDS = GUARD.policy.speeds
FAST = BorrowOncomingLane(past_object_id="lead", speed_mps=11.0)
SLOW_CAR = thing("lead", 66.0, speed=2.0)
TWO_WAY, MULTI = straight_road(), straight_road(left=LineKind.BROKEN)


def limited(road: RoadGeometry, *limits: float | None) -> RoadGeometry:
    """The road with these limits, lane by lane; the last one is that of all further lanes."""
    each = [*limits, *[limits[-1]] * len(road.lanes)]
    lanes = tuple(lane.model_copy(update={"speed_limit_mps": v}) for lane, v in zip(road.lanes, each, strict=False))
    return road.model_copy(update={"lanes": lanes, "key": f"{road.key} limits {limits}"})


def zone_from(start_m: int, low_mps: float | None) -> RoadGeometry:
    """A road with a lane for each way, whose limit is another one from `start_m` on."""
    lanes = []
    for name, offset, way in (("own", 0.0, LaneDirection.SAME), ("oncoming", LANE_M, LaneDirection.OPPOSITE)):
        line = LineKind.NONE if name == "own" else LineKind.BROKEN
        first, second = (
            strip(name, offset, way, line, start_m + 1),
            strip(f"{name} 2", offset, way, line, 401 - start_m),
        )
        lanes += [first, second.model_copy(update={"start": start_m, "speed_limit_mps": low_mps})]
    return TWO_WAY.model_copy(update={"lanes": tuple(lanes), "key": f"zone {start_m} {low_mps}"})


def judged(world, *behaviors, guided=True):
    verdict, proven = GUARD.accept(behaviors, world.view(), guided)
    return set(verdict.codes), proven


plans = st.one_of(
    st.builds(BorrowOncomingLane, past_object_id=st.just("lead"), speed_mps=st.floats(1.0, 11.0)),
    st.builds(KeepLane, distance_m=st.floats(10.0, 150.0), speed_mps=st.floats(1.0, 11.0)),
    st.builds(ChangeLane, side=st.just("left"), distance_m=st.floats(20.0, 150.0), speed_mps=st.floats(1.0, 11.0)),
)


@pytest.mark.integration
@given(
    plan=st.lists(plans, min_size=1, max_size=2),
    limits=st.lists(st.floats(5 * KMH, 70 * KMH) | st.none(), min_size=1, max_size=3),
    road=st.sampled_from([TWO_WAY, MULTI]),
    lead=st.sampled_from([SLOW_CAR, thing("lead", 66.0, hazard=True)]) | st.none(),
    guided=st.booleans(),
    speed=st.just(0.0) | st.floats(0.0, 5.0),
)
@settings(max_examples=60)
def test_speed_of_an_accepted_plan_keeps_the_limits(plan, limits, road, lead, guided, speed):
    """The limit holds at each station for each lane that the body is in; walking pace is always allowed."""
    world = World(limited(road, *limits), [lead] if lead else [], speed=speed, sight_m=400.0, behind_m=400.0)
    _, proven = judged(world, *plan, guided=guided)
    if proven is None:
        return
    path = proven.path
    for lane in world.view().frame.lanes:
        right, left = float(lane.right[0]), float(lane.left[0])
        within = (path.d > right + 0.1) & (path.d < left - 0.1)
        known = lane.strip.speed_limit_mps
        most = SPEEDS.recovery_mps if known is None else max(known, SPEEDS.creep_mps)
        assert (path.speed[within] <= most + 1e-6).all()


@pytest.mark.parametrize("limit_kmh", [10, 15, 20, 25, 30])
@pytest.mark.parametrize("plan", [FAST, KeepLane(distance_m=150.0, speed_mps=11.0)], ids=["pass", "keep_lane"])
def test_guided_plan_above_the_limit_is_refused(limit_kmh, plan):
    found, proven = judged(World(limited(TWO_WAY, limit_kmh * KMH), [SLOW_CAR], sight_m=400.0), plan)
    assert proven is None and RejectCode.OVERSPEED in found


@pytest.mark.parametrize("limits", [(50 * KMH, 30 * KMH), (30 * KMH, 50 * KMH)])
def test_guided_pass_keeps_the_lower_of_two_limits(limits):
    world = World(limited(TWO_WAY, *limits), [SLOW_CAR], sight_m=400.0)
    assert RejectCode.OVERSPEED in judged(world, FAST)[0]
    assert RejectCode.OVERSPEED not in judged(world, FAST.model_copy(update={"speed_mps": 30 * KMH - 0.01}))[0]


def test_guided_pass_within_the_limits_is_still_quicker():
    found, proven = judged(World(TWO_WAY, [SLOW_CAR], sight_m=400.0), FAST)
    assert found == set() and proven.path.speed.max() > SPEEDS.recovery_mps


@pytest.mark.parametrize("guided", [False, True])
@pytest.mark.parametrize("lead", [SLOW_CAR, thing("lead", 66.0, hazard=True)], ids=["moves", "stands"])
def test_accept_unknown_speed_limit_caps_at_recovery_speed(guided, lead):
    """Where no speed limit is known, no plan is faster than a recovery."""
    road = limited(TWO_WAY, None)
    assert RejectCode.OVERSPEED in judged(World(road, [lead], sight_m=400.0), FAST, guided=guided)[0]


@pytest.mark.parametrize("start_m", [70, 100, 140, 190])
def test_lower_limit_that_begins_ahead_refuses_a_quick_plan(start_m):
    plan = KeepLane(distance_m=150.0, speed_mps=11.0)
    assert judged(World(zone_from(start_m, 20 * KMH), sight_m=300.0), plan)[0] == {RejectCode.OVERSPEED}
    assert judged(World(zone_from(start_m, 50 * KMH), sight_m=300.0), plan)[0] == set()
    assert judged(World(zone_from(start_m, None), sight_m=300.0), plan)[0] == {RejectCode.OVERSPEED}


@pytest.mark.parametrize("guided", [False, True])
@pytest.mark.parametrize("start_m", [60, 75, 120])
def test_lower_limit_that_begins_ahead_slows_a_recovery_before_it(guided, start_m):
    """The front is at the zone's begin half a length before the center is, and the ramp is one a stack can follow."""
    world = World(zone_from(start_m, 10 * KMH), sight_m=300.0)
    found, proven = judged(world, KeepLane(distance_m=100.0, speed_mps=5.5), guided=guided)
    path = proven.path
    assert found == set() and path.speed.max() == pytest.approx(5.5 if start_m > 70 else path.speed.max())
    assert (path.speed[path.s >= start_m - 4.9 / 2] <= 10 * KMH + 1e-6).all()
    assert (np.diff(path.speed**2) / np.diff(path.s) > -2 * 1.0 - 1e-6).all()


@pytest.mark.parametrize("aside_m", [1.3, 1.7, 2.0, 2.9])
@pytest.mark.parametrize("kind", [ObjectKind.PEDESTRIAN, ObjectKind.BICYCLE, ObjectKind.FLAGGER, ObjectKind.ANIMAL])
@pytest.mark.parametrize("along_mps", [0.0, 1.2])
def test_guided_plan_beside_people_is_no_quicker_than_a_recovery(aside_m, kind, along_mps):
    who = thing("who", 85.0, -0.925 - aside_m - 0.3, kind=kind, speed=along_mps, width=0.6, length=0.6)
    world = World(TWO_WAY, [who], sight_m=400.0)
    plan = KeepLane(distance_m=80.0, speed_mps=11.0)
    assert RejectCode.OVERSPEED in judged(world, plan)[0]
    far = who.model_copy(update={"y_m": -0.925 - 3.4 - 0.3})
    assert RejectCode.OVERSPEED not in judged(World(TWO_WAY, [far], sight_m=400.0), plan)[0]


def test_cap_predicts_pedestrian_where_ego_is_fast():
    """A pedestrian who walks to where the ego will be fast caps its speed.

    The ego is still slow beside the pedestrian now; it will be fast where the pedestrian then is.
    """
    walker = thing("walker", 50.0, -3.3, kind=ObjectKind.PEDESTRIAN, speed=5.5)
    plan = KeepLane(distance_m=80.0, speed_mps=11.0)
    assert RejectCode.OVERSPEED in judged(World(TWO_WAY, [walker], sight_m=400.0), plan)[0]


@pytest.mark.parametrize(
    ("x", "y", "speed", "quick"),
    [(82.0, 0.0, 2.0, True), (62.0, -0.9, 4.0, True), (82.0, 0.5, 2.0, False), (62.0, 0.0, 2.0, False)],
)
def test_guided_pass_of_a_rider_is_quick_only_with_room(x, y, speed, quick):
    """Beside a rider who keeps to the left of the lane, or is just ahead, there is no room for 3 m."""
    rider = thing("lead", x, y, kind=ObjectKind.BICYCLE, speed=speed)
    world = World(TWO_WAY, [rider], sight_m=400.0)
    assert (RejectCode.OVERSPEED in judged(world, FAST)[0]) is not quick
    assert RejectCode.OVERSPEED not in judged(world, FAST.model_copy(update={"speed_mps": 5.5}))[0]


def test_guided_plan_beside_door_is_capped_at_recovery_speed():
    parked = thing("parked", 95.0, -2.9)
    world = World(TWO_WAY, [parked], sight_m=400.0)
    found, _ = judged(world, KeepLane(distance_m=80.0, speed_mps=11.0))
    assert RejectCode.OVERSPEED in found


@pytest.mark.parametrize("x", [52.0, 80.0, 120.0])
def test_limit_that_falls_while_a_plan_runs_ends_it(x):
    world = World(TWO_WAY, sight_m=400.0)
    _, proven = judged(world, KeepLane(distance_m=100.0, speed_mps=11.0))
    later = replace(world, x=x, speed=8.0)
    assert GUARD.recheck(proven, later.view()).accepted
    verdict = GUARD.recheck(proven, replace(later, road=limited(TWO_WAY, 20 * KMH)).view())
    assert set(verdict.codes) == {RejectCode.OVERSPEED} and verdict.abort is AbortAction.STOP


def test_recheck_pedestrian_beside_fast_plan_ends_it():
    """A pedestrian who appears beside the path of a fast running plan ends it."""
    world = World(TWO_WAY, sight_m=400.0)
    _, proven = judged(world, KeepLane(distance_m=100.0, speed_mps=11.0))
    walker = thing("walker", 110.0, -3.0, kind=ObjectKind.PEDESTRIAN)
    verdict = GUARD.recheck(proven, replace(world, x=60.0, speed=6.0, objects=[walker]).view())
    assert RejectCode.OVERSPEED in verdict.codes and verdict.abort is AbortAction.STOP


@pytest.mark.parametrize("limit_mps", [8.26, 8.33, 5.56, 2.78, None])
@pytest.mark.parametrize("kind", [ObjectKind.CAR, ObjectKind.BICYCLE])
def test_search_asks_for_no_more_than_guidance_gives(limit_mps, kind):
    """The plan for "please overtake" is not refused for its speed."""
    lead = thing("lead", 85.0, kind=kind, speed=2.0)
    world = World(limited(TWO_WAY, limit_mps), [lead], sight_m=400.0)
    scene = world.scene().model_copy(update={"guidance": said("please overtake")})
    plan = searched(world, scene).plan
    assert plan is not None
    assert RejectCode.OVERSPEED not in judged(world, *plan.behaviors)[0]
