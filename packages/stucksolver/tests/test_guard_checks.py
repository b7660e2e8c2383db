"""The guard's single checks at their bounds: gaps, doors, edges of the road, lines and lights."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from shapely import affinity
from shapely.geometry import box

from guard_cases import (
    GUARD,
    LENGTH_M,
    MULTI,
    POLICY,
    WIDTH_M,
    C,
    case_on,
)
from stucksolver.guard import path_checks
from stucksolver.guard.context import CheckContext
from stucksolver.guard.prediction import is_on_drift_side
from stucksolver.plan.behaviors import KeepLane
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene import (
    ControlKind,
    LightState,
    ObjectKind,
    TrafficControl,
)
from worlds import LANE_M, World, red_light, straight_road, thing

# ---- how near is too near, and how slow is creeping


def drifted(error_m, error_rad=0.0, *, gap=(0.05, 0.5), y=2.0, speed=4.0):
    """An object at offset `y`, at gaps now and then, and an ego so far beside its path."""
    case = case_on([0.0] * 4, [0.0] * 4, [thing("it", 60.0, y)], speed=speed)
    case = replace(case, running=True, error_m=error_m, error_rad=error_rad)
    gaps = np.array(gap)[:, None]
    return path_checks._too_near(case, np.array([0]), gaps, np.full((2, 1), 0.0), np.array([0.0, 3.0]))


def test_recheck_drift_within_15_cm_of_object_ends_plan():
    """A tracking error that has brought the ego within 15 cm of an object ends the plan at once."""
    (found,) = drifted(0.2)
    assert found.time_s == 0.0 and found.gap_m == pytest.approx(0.05)
    assert drifted(-0.2, y=-2.0) and not drifted(-0.2) and not drifted(0.2, y=-2.0)
    assert drifted(0.2, y=0.5), "right ahead on that side"
    assert not drifted(0.04), "on its path, as far as localisation can tell"
    assert drifted(0.2, gap=(0.15 - 0.01, 0.5)) and not drifted(0.2, gap=(0.15 + 0.01, 0.5))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_what_a_stop_still_adds_to_an_error_counts(sign):
    """At 4 m/s a stop takes 1.2 m and 2.67 m; turned by 0.05 rad that is 0.19 m more."""
    more = math.sin(0.05) * (4.0 * 0.3 + 16.0 / 6.0)
    for over, ends in ((-0.01, True), (0.01, False)):
        gap = (0.15 + more + over, 0.5)
        assert bool(drifted(sign * 0.2, sign * 0.05, gap=gap, y=sign * 2.0)) is ends
        assert not drifted(sign * 0.2, -sign * 0.05, gap=gap, y=sign * 2.0), "it comes back"


@pytest.mark.parametrize("number", range(60))
def test_recheck_stop_within_15_cm_of_object_ends_plan(number):
    """A plan ends if a straight stop would come within 15 cm of an object.

    The body is moved along its heading, in centimeters, over a stop with 0.3 s until the brakes act.
    """
    draw = random.Random(number)
    speed, turn = draw.uniform(0.3, 2.2), -draw.uniform(0.05, 0.25)
    it = thing(
        "it", 50.0 + draw.uniform(4.6, 6.2), -draw.uniform(1.6, 2.6), yaw=draw.uniform(-0.1, 0.1), stationary_s=40.0
    )
    case = case_on([0.0] * 20, [turn] * 20, [it], speed=speed, yaw=turn)
    case = replace(case, running=True, error_m=-0.2)
    stands = affinity.translate(
        affinity.rotate(box(-2.3, -0.95, 2.3, 0.95), it.yaw_rad, use_radians=True), it.x_m, it.y_m
    )
    body = affinity.rotate(box(-LENGTH_M / 2, -WIDTH_M / 2, LENGTH_M / 2, WIDTH_M / 2), turn, (0, 0), use_radians=True)
    way = speed * 0.3 + speed**2 / 6.0
    gaps = [
        affinity.translate(body, 50.0 + on * math.cos(turn), on * math.sin(turn)).distance(stands)
        for on in np.linspace(0.0, way, 1 + int(way / 0.01))
    ]
    found = bool(path_checks._stops_against(case, np.array([0]), np.array([gaps[0]]))[0])
    if abs(min(gaps) - 0.15) > 0.02 and gaps[0] > POLICY.clearance.nearer_m:
        assert found is (min(gaps) < 0.15 and min(gaps) < gaps[0] - POLICY.clearance.nearer_m)


def test_stops_against_counts_only_on_drift_side():
    """A straight stop counts only with a tracking error, and only on the side of that error."""
    it = thing("it", 55.2, -2.0, stationary_s=40.0)
    case = case_on([0.0] * 20, [-0.15] * 20, [it], speed=1.5, yaw=-0.15)
    wide, none = np.full((20, 1), 0.5), np.zeros((20, 1))
    for error, ends in ((-0.2, True), (0.2, False), (-0.04, False)):
        now = replace(case, running=True, error_m=error)
        assert bool(path_checks._too_near(now, np.array([0]), wide, none, np.arange(20.0))) is ends
        later = wide.copy()
        later[1:] = -1.0  # what is foretold of later on says nothing about the stop
        assert bool(path_checks._too_near(now, np.array([0]), later, none - 2.0, np.arange(20.0))) is ends
    gone = path_checks._stops_against(replace(case, error_m=-0.2), np.array([0]), np.array([-1.0]))
    assert not gone.any(), "it comes no nearer than it is"


def test_stops_against_uses_each_object_and_body_heading():
    """A straight stop is checked for each object separately and along the heading of the body.

    Turned by 0.9 rad at 2 m/s, a stop covers 1.27 m, 0.79 m of it along the road.
    """
    turn, way = -0.9, 2.0 * 0.3 + 4.0 / 6.0
    x, y = 50.0 + (way + LENGTH_M / 2) * math.cos(turn), (way + LENGTH_M / 2) * math.sin(turn)
    near, far = (
        thing(name, x + ahead, y, length=0.4, width=0.4, kind=ObjectKind.CONE)
        for name, ahead in (("a", 0.4), ("b", 1.0))
    )
    case = replace(case_on([0.0] * 20, [turn] * 20, [near, far], speed=2.0, yaw=turn), running=True, error_m=-0.2)
    assert path_checks._stops_against(case, np.array([0, 1]), np.array([1.0, 1.0])).tolist() == [True, False]


def test_walking_pace_is_8_kmh_and_not_a_hair_less():
    creeps = KeepLane(distance_m=40.0, speed_mps=8 / 3.6)
    for kind, code in ((ObjectKind.CAR, C.DOOR), (ObjectKind.BARRIER, C.GAP)):
        beside = World(MULTI, [thing("it", 75.0, WIDTH_M / 2 + 0.95 + 0.36, kind=kind)])
        assert code not in {r.code for r in GUARD.accept([creeps], beside.view(), False)[0].rejects}
    meets = World(MULTI, [thing("it", 90.0, WIDTH_M / 2 + 0.95 + 0.36, speed=-2.0)])
    assert C.GAP not in {r.code for r in GUARD.accept([creeps], meets.view(), False)[0].rejects}


@pytest.mark.parametrize(("distance_m", "until"), [(2.0, 2.0), (0.0, 0.0), (-0.7, 0.0)])
def test_creeps_over_line_until_front_is_past(distance_m, until):
    past_m = POLICY.controls.creeps_past_m
    s = 50.0 + 0.1 * np.arange(120)
    view = World(MULTI).view()
    for fast_from, creeps in ((until + past_m - 0.05, False), (until + past_m + 0.05, True)):
        speed = np.where(s - 50.0 > fast_from, 4.0, 8 / 3.6)
        case = CheckContext(view, FrenetPath(s, np.zeros(120), speed), POLICY)
        assert path_checks._creeps_over(case, distance_m) is creeps


def test_off_road_rejection_reports_distance_of_body():
    """A rejection reports how far the body is off the driving lanes or off the road."""
    d = np.zeros(20)
    d[8] = -3.2
    view = World(MULTI).view()
    case = CheckContext(view, FrenetPath(50.0 + 0.5 * np.arange(20), d, np.full(20, 2.0), yaw=np.zeros(20)), POLICY)
    for check, code, what in (
        (path_checks.drivable_area, C.OFF_LANES, "the driving lanes"),
        (path_checks.roadside, C.OFF_ROAD, "the road"),
    ):
        (found,) = check(case)
        assert found.code is code
        assert found.detail.startswith(f"{-found.gap_m:.2f} m off {what} 4 m ahead, allowed ")


def margins(*objects, speed=5.0, **world):
    case = case_on([0.0] * 4, [0.0] * 4, objects, **world)
    return path_checks._margins(case, np.arange(len(objects)), np.array([speed]))[0].tolist()


def test_margins_crossing_vehicle_needs_no_drift_margin():
    """A vehicle that crosses or turns in is predicted to go on and needs no larger gap for that."""
    keeps = thing("keeps", 70.0, LANE_M, speed=6.0, sideways=0.29)
    drifts = thing("drifts", 70.0, LANE_M, speed=6.0, sideways=0.5)
    crosses = thing("crosses", 70.0, -9.0, sideways=0.25, yaw=math.pi / 2)
    assert case_on([0.0] * 4, [0.0] * 4, [crosses]).view.elsewhere[0]
    drawn = 0.05 + 0.25 * (0.3 + 5.0 / 3.0)
    assert margins(keeps, drifts, crosses) == pytest.approx([0.5 + 0.29 + 0.29**2 / 2, drawn, drawn], abs=1e-6)


def test_one_on_foot_makes_nobody_else_need_more_room():
    walker = thing("walker", 70.0, -4.0, kind=ObjectKind.PEDESTRIAN)
    barrier = thing("barrier", 70.0, 4.0, kind=ObjectKind.BARRIER)
    alone, beside = margins(barrier), margins(walker, barrier)
    assert beside[1] == alone[0] and beside[0] > 1.0


def test_nearer_means_nearer_than_at_the_start():
    case = case_on([0.0] * 4, [0.0] * 4, [thing("it", 60.0, 2.0)])
    found = path_checks._too_near(
        case, np.array([0]), np.array([[0.5], [0.2], [0.19]]), np.full((3, 1), 0.3), np.arange(3.0)
    )
    assert [r.time_s for r in found] == [1.0]


def against(d, *, x, y, running=False):
    """Reasons against a path whose ego stands beside a car of its own length at (x, y)."""
    case = replace(case_on(d, [0.0] * len(d), [thing("it", x, y, length=LENGTH_M, width=WIDTH_M)]), running=running)
    return [item for item in path_checks.collision(case) if "scrape" in item.detail]


@pytest.mark.parametrize("gap_m", [0.0, 0.09])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_what_the_ego_stands_against_is_not_scraped_along(gap_m, side):
    beside = side * (WIDTH_M + gap_m)
    (found,) = against([0.0] * 20, x=50.0, y=beside)
    assert found.object_id == "it" and found.gap_m == pytest.approx(gap_m, abs=1e-6)
    assert not against([0.0] * 20, x=50.0, y=side * (WIDTH_M + 0.11)), "not a contact"
    assert not against([0.0] * 20, x=50.0, y=beside, running=True), "it parts while it runs"
    away = -side * np.minimum(0.3 * np.arange(20), 1.5)
    assert not against(away, x=50.0, y=beside), "it parts within half a metre"
    returns = -side * np.concatenate([np.minimum(0.3 * np.arange(8), 1.0), np.maximum(1.0 - 0.3 * np.arange(8), 0.0)])
    assert against(returns, x=52.0, y=beside), "it parts and then touches again"


def test_collision_back_up_from_contact_ahead_is_accepted():
    """An ego that has stopped with its front against a car may back up."""
    ahead = 50.0 + LENGTH_M + 0.02
    case = case_on([0.0] * 8, [0.0] * 8, [thing("it", ahead, 0.0, length=LENGTH_M, width=WIDTH_M)])
    back = replace(case, path=replace(case.path, s=50.0 - 0.5 * np.arange(8)))
    assert not [item for item in path_checks.collision(back) if "scrape" in item.detail]


def test_drift_side_is_relative_to_ego():
    """The side of a tracking error is that of the ego and not of the lane."""
    case = replace(case_on([0.0] * 4, [0.0] * 4, [thing("it", 60.0, 1.0)], y=2.0), running=True, error_m=0.2)
    assert is_on_drift_side(case, np.array([0])).tolist() == [False]
    assert is_on_drift_side(replace(case, error_m=-0.2), np.array([0])).tolist() == [True]


@pytest.mark.parametrize(("askew", "share"), [(0.1, math.sin(0.1)), (1.4, math.sin(1.4)), (2.0, 1.0), (-0.1, 0.0)])
def test_still_to_drift_grows_with_sine_of_heading_error(askew, share):
    """A body that points aside drifts on by the sine of its heading error times its stopping distance."""
    case = replace(case_on([0.0] * 4, [0.0] * 4, speed=4.0), error_m=0.2, error_rad=askew)
    assert path_checks._still_to_drift(case) == pytest.approx(share * (4.0 * 0.3 + 16.0 / 6.0))


def doors(*cars, x=50.0):
    found = GUARD.accept([KeepLane(distance_m=40.0, speed_mps=5.0)], World(MULTI, list(cars), x=x).view(), False)[0]
    return [r.object_id for r in found.rejects if r.code is C.DOOR]


def test_doors_rejection_names_car_with_reachable_door():
    """Of several parked cars, the rejection names the car whose door reaches the ego's path."""
    near, far = (thing(name, x, WIDTH_M / 2 + 0.95 + gap) for name, x, gap in (("near", 75.0, 0.7), ("far", 65.0, 2.0)))
    barrier = thing("barrier", 70.0, WIDTH_M / 2 + 0.95 + 0.7, kind=ObjectKind.BARRIER)
    assert doors(far, near) == ["near"] == doors(near, far)
    assert doors(barrier, near) == ["near"] == doors(near, barrier)


def test_from_beside_a_parked_car_one_may_drive_off():
    assert doors(thing("beside", 50.0, WIDTH_M / 2 + 0.95 + 0.7), x=50.0) == []
    assert doors(thing("beside", 50.0, WIDTH_M / 2 + 0.95 + 0.7), x=40.0) == ["beside"]


def off(d, **world):
    view = World(straight_road(oncoming=None), **world).view()
    path = FrenetPath(50.0 + 0.5 * np.arange(len(d)), np.asarray(d, float), np.full(len(d), 2.0), yaw=np.zeros(len(d)))
    return path_checks.drivable_area(CheckContext(view, path, POLICY))


def test_drivable_area_return_from_beyond_edge_is_accepted():
    """An ego over the edge may come back and must end on the road.

    The body is over the edge of the lane by 0.825 m less than its offset.
    """
    edge = LANE_M / 2 - WIDTH_M / 2
    for side in (-1.0, 1.0):
        over = np.array([0.3, 0.2, 0.1, 0.0, 0.0, 0.0]) + edge
        assert not off(side * over)
        again = over.copy()
        again[-1] = edge + 0.3
        (found,) = off(side * again)
        assert "m off the driving lanes 2 m ahead" in found.detail and found.gap_m == pytest.approx(-0.3)
        further = over.copy()
        further[2] = edge + 0.3 + 0.06
        assert off(side * further) and not off(side * np.minimum(further, edge + 0.3 + 0.04))


def test_drivable_area_path_beyond_known_road_is_rejected():
    (found,) = off(np.zeros(800))
    assert found.code is C.OFF_ROAD and found.detail == "the path runs beyond the known road"


@pytest.mark.parametrize(("way_m", "refused"), [(2.0, True), (12.0, False)])
def test_accept_path_too_short_to_slow_down_is_rejected(way_m, refused):
    """A path that is too short to slow down to the speed of its plan is rejected.

    Braking from 5.3 m/s to 2 m/s takes 4 m.
    """
    world = World(MULTI, speed=5.3)
    found = GUARD.accept([KeepLane(distance_m=way_m, speed_mps=2.0)], world.view(), False)[0].rejects
    assert (C.OVERSPEED in {r.code for r in found}) is refused


def test_what_stands_counts_whoever_else_moves():
    wall = thing("wall", 70.0, kind=ObjectKind.BARRIER)
    harmless = thing("harmless", 75.0, LANE_M, speed=-2.0)
    plan = [KeepLane(distance_m=40.0, speed_mps=5.0)]
    for objects in ([wall, harmless], [harmless, wall]):
        found = GUARD.accept(plan, World(MULTI, objects).view(), False)[0].rejects
        assert "wall" in {r.object_id for r in found if r.code is C.COLLISION}


def test_doors_next_parked_car_counts_beside_another():
    """Beside one parked car, the door of the next one counts."""
    beside, ahead = (thing(name, x, WIDTH_M / 2 + 0.95 + 0.7) for name, x in (("beside", 50.0), ("ahead", 70.0)))
    assert doors(beside, ahead) == ["ahead"] == doors(ahead, beside)


def test_doors_car_just_ahead_counts():
    """The door of a car just ahead counts like one farther on."""
    car = thing("it", 50.0 + LENGTH_M / 2 + 4.6 / 4 + 0.1, WIDTH_M / 2 + 0.95 + 0.7)
    view = World(MULTI, [car], speed=5.0).view()
    found = GUARD.accept([KeepLane(distance_m=40.0, speed_mps=5.0)], view, False)[0].rejects
    assert C.DOOR in {r.code for r in found}


def test_off_road_rejection_distance_starts_at_ego():
    """The distance to the place where the path leaves the road is counted from the ego."""
    d = np.zeros(20)
    d[10] = -3.2
    (found,) = off(d)
    assert " m off the driving lanes 5 m ahead" in found.detail


def light(distance_m, state=LightState.RED, *, running, speed):
    world = World(MULTI, controls=(red_light(distance_m, state),), speed=speed)
    s = 50.0 + 0.5 * np.arange(60)
    case = CheckContext(world.view(), FrenetPath(s, np.zeros(60), np.full(60, 5.0)), POLICY, running=running)
    return path_checks.stop_line(case)


def test_recheck_red_light_within_braking_distance_is_exempt():
    """Only a running plan is exempt from a red light that is nearer than comfortable braking reaches."""
    at_m = 25.0 / 6.0 - POLICY.controls.over_line_m
    assert light(at_m + 0.05, running=True, speed=5.0) and not light(at_m - 0.05, running=True, speed=5.0)
    assert light(at_m - 0.05, running=False, speed=5.0) and light(0.5, running=False, speed=5.0)


def test_a_light_of_unknown_state_is_told_so():
    (found,) = light(10.0, None, running=False, speed=0.0)
    assert found.code is C.RED_LIGHT and found.detail == "unknown light 10 m ahead"
    (found,) = light(10.0, LightState.YELLOW, running=False, speed=0.0)
    assert found.detail == "yellow light 10 m ahead"


def test_only_signs_and_dark_lights_close_ahead_are_stopped_at():
    def line(distance_m, kind=ControlKind.STOP_SIGN, state=None):
        return TrafficControl(kind=kind, distance_m=distance_m, applies=True, state=state)

    near = POLICY.controls.at_line_m - 0.1
    controls = (line(near), line(20.0), line(near, ControlKind.TRAFFIC_LIGHT, LightState.RED))
    dark = line(near, ControlKind.TRAFFIC_LIGHT, LightState.OFF)
    view = World(MULTI, controls=(*controls, dark)).view()
    place = 50.0 + LENGTH_M / 2 + near
    assert path_checks.stopped_at(view, POLICY) == pytest.approx((place, place))
    assert path_checks.stopped_at(World(MULTI, controls=controls, speed=2.0).view(), POLICY) == ()
