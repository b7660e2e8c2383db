"""The oncoming lane: how far it must be seen, and who in it is given how much, by the formulas of docs/SAFETY.md."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stucksolver.guard import NOBODY, Guard, GuardPolicy, RejectCode, oncoming_lane
from stucksolver.guard.context import CheckContext
from stucksolver.guard.policy import OncomingPolicy
from stucksolver.plan.behaviors import BorrowOncomingLane
from stucksolver.scene import LaneDirection
from worlds import LANE_M, World, straight_road, thing

C = RejectCode
pytestmark = pytest.mark.usefixtures("alike")
GUARD = Guard()
ROAD = straight_road()
BORROW = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
LEAD = thing("lead", 65.0)
HALF_CAR_M = 4.6 / 2
HALF_EGO_M = 4.9 / 2
A_LITTLE = 0.01


def limited(limit_mps):
    lanes = tuple(lane.model_copy(update={"speed_limit_mps": limit_mps}) for lane in ROAD.lanes)
    return ROAD.model_copy(update={"lanes": lanes, "key": f"limit {limit_mps}"})


def found(code, *others, road=ROAD, guard=GUARD, **world):
    view = World(road, [LEAD, *others], **world).view()
    return [r for r in guard.accept([BORROW], view, False)[0].rejects if r.code is code]


def needed_m(road, guard=GUARD):
    """The sight that is asked for, as a verdict on less tells."""
    (reject,) = found(C.ONCOMING_SIGHT, road=road, guard=guard, sight_m=10.0)
    assert reject.detail.startswith("oncoming lane: sight distance 10.0 m, required ")
    return 10.0 - reject.gap_m, reject.time_s


def test_oncoming_sight_is_own_path_and_limit_distance_and_margin():
    """The required sight is the ego's path, the speed limit times the time, and 10 m."""
    slow_m, time_s = needed_m(limited(10.0))
    quick_m, again_s = needed_m(limited(20.0))
    assert time_s == again_s
    assert quick_m - slow_m == pytest.approx(10.0 * time_s)
    own_m = slow_m - 10.0 * time_s - 10.0
    _, proven = GUARD.accept([BORROW], World(ROAD, [LEAD]).view(), False)
    inside = [s for s, d in zip(proven.path.s, proven.path.d, strict=True) if d + 1.85 / 2 > LANE_M / 2]
    assert own_m == pytest.approx(inside[-1] - 50.0, abs=2.5)


def test_oncoming_sight_without_limit_assumes_50_kmh():
    """A lane without a known limit is taken to have that of towns, 50 km/h."""
    assert needed_m(limited(None))[0] == pytest.approx(needed_m(limited(50 / 3.6))[0])


def test_the_margin_is_the_policys():
    wide = Guard(GuardPolicy(oncoming=OncomingPolicy(sight_margin_m=30.0)))
    assert needed_m(ROAD, wide)[0] - needed_m(ROAD)[0] == pytest.approx(20.0)


def test_oncoming_sight_is_accepted_from_required_distance():
    """A little more sight than required is enough, and a little less is not."""
    asked_m, _ = needed_m(ROAD)
    assert not found(C.ONCOMING_SIGHT, sight_m=asked_m + A_LITTLE)
    assert found(C.ONCOMING_SIGHT, sight_m=asked_m - A_LITTLE)


def car(x, speed=-10.0, y=LANE_M):
    return thing("car", x, y, speed=speed)


def met(x, speed=-10.0, y=LANE_M, **world):
    return bool(found(C.ONCOMING_GAP, car(x, speed, y), **world))


def free_from(speed):
    """Where a car must be at least so that it is not met."""
    (reject,) = found(C.ONCOMING_GAP, car(80.0, speed))
    assert reject.object_id == "car" and reject.detail.startswith(
        f"car car 30 m ahead: approaches at {-speed:.1f} m/s, "
    )
    return 80.0 - reject.gap_m, reject.time_s


@pytest.mark.parametrize("speed", [-3.0, -10.0])
def test_oncoming_gap_assumes_1_mps_faster_and_1_5_s(speed):
    """An oncoming vehicle is assumed 1 m/s faster and must still be 1.5 s away."""
    x, back_s = free_from(speed)
    assert met(x - A_LITTLE, speed) and not met(x + A_LITTLE, speed)
    other, _ = free_from(speed - 2.0)
    assert other - x == pytest.approx(2.0 * (back_s + 1.5))
    front_m = x - HALF_CAR_M - (1.0 - speed) * (back_s + 1.5)
    _, proven = GUARD.accept([BORROW], World(ROAD, [LEAD]).view(), False)
    inside = [s for s, d in zip(proven.path.s, proven.path.d, strict=True) if d + 1.85 / 2 > LANE_M / 2]
    assert front_m == pytest.approx(inside[-1] + HALF_EGO_M, abs=3.0)


@pytest.mark.parametrize(("speed", "comes"), [(-0.5, True), (-0.5 + A_LITTLE, False), (0.0, False), (4.0, False)])
def test_who_comes_at_half_a_metre_a_second_is_oncoming(speed, comes):
    assert met(70.0, speed) is comes


@pytest.mark.parametrize(("x", "comes"), [(50.0 - HALF_CAR_M - A_LITTLE, False), (50.0 - HALF_CAR_M + A_LITTLE, True)])
def test_who_is_past_our_middle_is_past(x, comes):
    assert met(x) is comes


@pytest.mark.parametrize("edge", [LANE_M / 2 - 0.95, 3 * LANE_M / 2 + 0.95])
def test_who_reaches_into_the_lane_at_all_is_in_it(edge):
    inwards = 1.0 if edge < LANE_M else -1.0
    assert met(90.0, y=edge + inwards * A_LITTLE)
    assert not met(90.0, y=edge - inwards * A_LITTLE)


def test_oncoming_gap_finds_conflict_behind_other_vehicles():
    """A conflicting vehicle is found behind one without a conflict."""
    past = thing("past", 20.0, LANE_M, speed=-10.0)
    assert found(C.ONCOMING_GAP, past, car(80.0)) and found(C.ONCOMING_GAP, car(80.0), past)
    aside = thing("aside", 80.0, -6.0, speed=-10.0)
    assert found(C.ONCOMING_GAP, aside, car(80.0))


def test_the_oncoming_lane_must_go_on_beside_the_whole_way():
    short = ROAD.lanes[1].model_copy(
        update={
            "start": 0,
            "offset_m": ROAD.lanes[1].offset_m[:70],
            "width_m": ROAD.lanes[1].width_m[:70],
            "line": ROAD.lanes[1].line[:70],
        }
    )
    road = ROAD.model_copy(update={"lanes": (ROAD.lanes[0], short), "key": "short"})
    view = World(road, [LEAD]).view()
    assert {r.code for r in GUARD.accept([BORROW], view, False)[0].rejects} & {C.OFF_ROAD, C.NO_PATH}
    lane = next(lane for lane in view.frame.lanes if lane.strip.direction is LaneDirection.OPPOSITE)
    whole = World(ROAD, [LEAD]).view()
    path = GUARD.lay_out([BORROW], whole, False, NOBODY).path
    (found,) = oncoming_lane.oncoming(CheckContext(view, replace(path, enters=(lane,)), GUARD.policy))
    assert found.code is C.OFF_ROAD and found.detail == "the oncoming lane ends before the path does"
