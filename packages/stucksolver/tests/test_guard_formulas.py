"""The guard's figures beside the same reckoned by hand: distances, sight, harm, zones, places to stand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from guard_cases import CAR_M, GUARD, LENGTH_M, MULTI, POLICY, WIDTH_M, C, case_of, case_on, on_way
from stucksolver.guard import (
    NOBODY,
    adjacent_traffic,
    collision_mitigation,
    leaving,
    marking,
    sight_distance,
    traffic_rules,
)
from stucksolver.guard.context import CheckContext
from stucksolver.guard.path_tracking import swing_out_motion, tracked_path
from stucksolver.guard.policy import RssPolicy
from stucksolver.guard.rss import rss_distance, rss_lateral
from stucksolver.plan.behaviors import BackUp, ChangeLane, Creep, KeepLane, NoPathError, RequestAssistance
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene import LaneKind, LineKind, ObjectKind, Zone, ZoneKind
from stucksolver.scene.failed_attempts import PlanFailure
from worlds import LANE_M, World, straight_road, thing

K = ObjectKind
TWO_WAY = straight_road()
FRONT_M = LENGTH_M / 2
HALF_CAR_M = CAR_M / 2


def zones(kind, start_m, end_m):
    return straight_road(left=LineKind.BROKEN, zones=(Zone(kind=kind, start_m=start_m, end_m=end_m),))


# ---- responsibility-sensitive safety


@pytest.mark.parametrize(
    ("rear", "front", "running", "meters"),
    [
        (10.0, 6.0, False, 8.0 + 100.0 / 7.0 - 36.0 / 16.0),
        (10.0, 6.0, True, 8.0 + 100.0 / 9.0 - 36.0 / 16.0),
        (5.0, 0.0, False, 4.0 + 25.0 / 7.0),
        (3.0, 12.0, False, 0.0),
    ],
)
def test_rss_distance_follower_reacts_and_lead_brakes_hardest(rear, front, running, meters):
    """The follower reacts and then brakes; the lead brakes as hard as possible."""
    policy = RssPolicy(reaction_s=0.8)
    assert rss_distance(rear, front, policy, running=running) == pytest.approx(meters)
    if not running:
        assert rss_distance(rear, front, policy) == pytest.approx(meters)


def test_rss_lateral_gap_grows_with_reaction_and_braking():
    """The gap to an object that drifts aside grows with its reaction and its braking."""
    policy = RssPolicy(reaction_s=0.5, lateral_braking_mps2=2.0)
    found = rss_lateral(np.array([0.0, 1.0, 2.0]), 0.3, policy)
    assert found == pytest.approx([0.3, 0.3 + 0.5 + 0.25, 0.3 + 1.0 + 1.0])


# ---- who is ahead of us, and is followed


def coming_in(lead, *, speed=5.0, now_s=2.0, running=False):
    """We change into the left lane at 60 m, at that speed; is somebody there ahead of us by then?"""
    d = [0.0] * 20 + [LANE_M] * 60
    case = replace(case_on(d, [0.0] * 80, [lead], speed=speed), running=running)
    t = np.array([0.0, now_s])
    station = np.array([[50.0, 50.0 + speed * now_s]])
    return bool(adjacent_traffic._is_ahead_of_ego(case, station, 0, t)[0])


@pytest.mark.parametrize("theirs", [2.0, 4.5, 6.0])
@pytest.mark.parametrize("more_m", [-0.02, 0.02])
def test_entry_gap_to_lead_covers_slowing_down(theirs, more_m):
    """Behind a vehicle, there must be a gap to slow down to its speed.

    Half a second and half a meter, and what braking from 5 m/s to its speed takes more, with 3 m/s².
    """
    needed = 0.5 * 5.0 + 0.5 + max(25.0 - theirs**2, 0.0) / 6.0
    rear = 60.0 + FRONT_M + needed + more_m
    lead = thing("lead", rear + HALF_CAR_M - 2.0 * theirs, LANE_M, speed=theirs)
    assert coming_in(lead) is (more_m > 0)


@pytest.mark.parametrize(("more_m", "followed"), [(0.02, True), (-0.02, False)])
def test_lead_in_path_is_followed_if_ego_can_fall_back(more_m, followed):
    """A vehicle in the ego's path counts as followed if the ego can fall back behind it.

    From 5 m/s to 2: (25 - 4) / (2 * 3) m of braking, and 0.3 s before it at a speed 3 m/s higher than the lead's.
    """
    lead = thing("lead", 50.0 + FRONT_M + HALF_CAR_M + 3.5 + 0.9 + more_m, 0.0, speed=2.0)
    assert coming_in(lead) is followed


@pytest.mark.parametrize(("more_m", "followed"), [(0.02, True), (-0.02, False)])
def test_recheck_lead_in_path_is_followed_if_ahead(more_m, followed):
    """While a plan runs, a vehicle in the path counts as followed if it is only ahead."""
    lead = thing("lead", 50.0 + FRONT_M + HALF_CAR_M + more_m, 0.0, speed=2.0)
    assert coming_in(lead, running=True) is followed


@pytest.mark.parametrize(("more_m", "meets"), [(0.02, False), (-0.02, True)])
def test_in_path_vehicle_within_30_cm_beside_body_counts(more_m, meets):
    """A vehicle within 30 cm beside the body is in the ego's path.

    A vehicle alongside is not ahead. Only a vehicle that the ego never comes near counts as followed.
    """
    beside = thing("beside", 50.0, -(WIDTH_M / 2 + 0.3 + 0.95 + more_m), speed=5.0)
    assert coming_in(beside) is not meets


def test_that_one_is_followed_makes_nobody_else_a_leader():
    d = [0.0] * 20 + [LANE_M] * 60
    others = [thing("ahead", 90.0, 0.0, speed=4.0), thing("level", 52.0, LANE_M, speed=5.0)]
    case = case_on(d, [0.0] * 80, others, speed=5.0)
    t = np.linspace(0.0, 4.0, 21)
    station = 50.0 + 5.0 * t[None]
    found = adjacent_traffic.is_followed_lead(case, station, np.array([0, 1]), t)
    assert found[0, :, 0].all() and not found[0, :, 1].any()


def test_in_the_oncoming_lane_nobody_is_followed():
    world = World(TWO_WAY, [thing("ahead", 90.0, speed=4.0)], x=50.0)
    case = case_of(world, KeepLane(distance_m=30.0, speed_mps=5.0))
    opposite = next(lane for lane in case.view.frame.lanes if lane.strip.id == "oncoming")
    path = replace(case.path, d=np.where(case.path.s > 60.0, LANE_M, 0.0), enters=(opposite,))
    case = replace(case, path=path)
    station = np.array([[50.0, 55.0, 65.0, 75.0]])
    found = adjacent_traffic.is_followed_lead(case, station, np.array([0]), np.array([0.0, 1.0, 3.0, 5.0]))
    assert found[0, :, 0].tolist() == [True, True, False, False]


def test_adjacent_traffic_bicycle_needs_larger_gap_than_car():
    """A bicycle beside the ego needs a larger gap than a car.

    It comes up from behind at 8 m/s: 0.5 m beside a bicycle, 0.3 m beside a car of the same width.
    """
    reach = 0.8 + WIDTH_M / 2
    for room, kind, stopped in ((0.4, K.BICYCLE, True), (0.4, K.CAR, False), (0.2, K.CAR, True)):
        d = np.linspace(0.0, 0.8, 40)
        beside = thing("it", 40.0, reach + room + 0.4, kind=kind, speed=8.0, width=0.8, length=2.0)
        case = case_on(list(d), [0.0] * 40, [beside], speed=2.0)
        assert bool(adjacent_traffic.from_behind(case)) is stopped, (room, kind)


# ---- sight


@pytest.mark.parametrize("speed", [1.5, 5.5])
@pytest.mark.parametrize("more_m", [-0.01, 0.0, 0.01])
def test_ahead_is_seen_as_far_as_a_stop_takes(speed, more_m):
    """From our front: half a second and a stop by 3 m/s², and a meter."""
    needed = LENGTH_M / 2 + speed**2 / 6.0 + 0.5 * speed + 1.0
    case = case_of(World(MULTI, sight_m=needed + more_m, speed=speed), KeepLane(distance_m=60.0, speed_mps=speed))
    found = sight_distance._ahead(case, case.start_lane)
    assert bool(found) is (more_m < 0)
    assert all(r.gap_m == pytest.approx(more_m) for r in found)


@pytest.mark.parametrize("more_m", [-0.01, 0.01])
def test_no_further_than_the_way_goes(more_m):
    case = case_of(World(MULTI, sight_m=LENGTH_M / 2 + 1.0 + more_m), Creep(distance_m=1.0))
    assert bool(sight_distance._ahead(case, case.start_lane)) is (more_m < 0)


@pytest.mark.parametrize("comes_mps", [4.0, 7.0])
@pytest.mark.parametrize("more_m", [-0.01, 0.01])
def test_behind_is_seen_as_far_as_who_comes_needs(comes_mps, more_m):
    case = case_of(World(MULTI, speed=3.0), ChangeLane(side="left", distance_m=40.0, speed_mps=3.0))
    lane = next(lane for lane in case.view.frame.lanes if lane.strip.id == "left")
    when, own = min(float(case.slow.t[10]), 1.0), float(case.slow.v[10])
    braked = comes_mps * 1.0 + comes_mps**2 / (2 * 4.5) - own**2 / (2 * 8.0)
    needed = LENGTH_M / 2 + comes_mps * when + braked
    seen = replace(case, view=World(MULTI, speed=3.0, behind_m=needed + more_m).view())
    found = sight_distance._behind(seen, lane, 10, comes_mps)
    assert bool(found) is (more_m < 0)
    assert all(r.gap_m == pytest.approx(more_m) for r in found)


@pytest.mark.parametrize("way", [-1, 1])
def test_sight_ends_at_near_end_of_vehicle_in_lane(way):
    """A sight ends at the near end of the vehicle in that lane.

    A truck of 16 m; the reported sight is accurate to 4 m.
    """
    case = case_of(World(MULTI, [thing("lorry", 50.0 + way * 60.0, LANE_M, length=16.0)]), Creep(distance_m=3.0))
    lane = next(lane for lane in case.view.frame.lanes if lane.strip.id == "left")
    near = 50.0 + way * 52.0
    for off, ends in ((0.0, True), (3.9, True), (-3.9, True), (4.1, False), (-4.1, False)):
        assert sight_distance._ends(case, lane, near + off, way) is ends
    assert not sight_distance._ends(case, case.start_lane, near, way), "they are in another lane"


def test_a_lane_that_ends_is_seen_to_its_end():
    case = case_of(World(MULTI), Creep(distance_m=3.0))
    lane = case.start_lane
    assert sight_distance._ends(case, lane, lane.end_m - 3.0, 1) and not sight_distance._ends(
        case, lane, lane.end_m - 5.0, 1
    )
    assert not sight_distance._ends(case, lane, lane.end_m, -1), "backwards it begins there"


# ---- rails


@pytest.mark.parametrize(("x", "on_them"), [(52.5, False), (52.6, True), (72.4, True), (72.5, False)])
def test_on_rails_covers_present_place_and_stop(x, on_them):
    """The ego is on rails if its body is there now or would be after a stop."""
    case = case_of(World(zones(ZoneKind.LEVEL_CROSSING, 55.0, 70.0), x=x), Creep(distance_m=2.0))
    assert case.on_rails(200.0) is on_them
    assert case.on_rails(60.0)


# ---- the rules of the road


@pytest.mark.parametrize(
    ("x", "end_m", "leaves"),
    [
        (52.0, 80.0, False),  # its front is not there yet
        (53.0, 80.0, True),
        (71.0, 80.0, True),
        (72.5, 80.0, False),  # its rear has left it
        (60.0, 72.4, False),  # it would end with its rear on it
        (60.0, 72.6, True),
    ],
)
def test_leaves_crossing_only_with_body_on_it_and_end_beyond(x, end_m, leaves):
    """A path leaves a level crossing if the ego is on it and the path ends beyond it."""
    world = World(zones(ZoneKind.LEVEL_CROSSING, 55.0, 70.0), x=x)
    s = np.linspace(x, end_m, 40)
    case = CheckContext(world.view(), FrenetPath(s, np.zeros(40), np.full(40, 5.0)), POLICY)
    assert leaving.leaves(case, world.road.zones[0]) is leaves


@pytest.mark.parametrize(("aside_m", "free"), [(0.12, False), (0.08, True)])
def test_moves_over_object_reaching_into_lane_blocks(aside_m, free):
    """A vehicle that reaches into the lane does not leave its full width to the ego.

    The ego passes in the left lane; the vehicle is in the right lane and reaches over the line by that much.
    """
    truck = thing("truck", 75.0, LANE_M / 2 - 0.95 + aside_m, kind=K.EMERGENCY)
    case = case_on([LANE_M] * 120, [0.0] * 120, [truck], y=LANE_M)
    assert traffic_rules._moves_over(case, 0) is free


def test_moves_over_lasts_from_before_until_after_object():
    """The ego must have moved over before it reaches the vehicle and until it has passed."""
    truck = thing("truck", 75.0, 0.0, kind=K.EMERGENCY, length=8.0)
    for over, back, free in ((70.0, 80.0, True), (71.5, 80.0, False), (70.0, 78.5, False)):
        s = 50.0 + 0.5 * np.arange(120)
        case = case_on(list(np.where((s >= over) & (s < back), LANE_M, 0.0)), [0.0] * 120, [truck])
        assert traffic_rules._moves_over(case, 0) is free


def test_moves_over_without_known_lane_is_false():
    """Passing an emergency scene where no lane is known is not moving over."""
    truck = thing("truck", 75.0, 0.0, kind=K.EMERGENCY)
    assert traffic_rules._moves_over(case_on([LANE_M] * 120, [0.0] * 120, [truck], y=LANE_M), 0)
    assert not traffic_rules._moves_over(case_on([40.0] * 120, [0.0] * 120, [truck], y=40.0), 0)


@pytest.mark.parametrize(("d", "off"), [(LANE_M, True), (LANE_M / 2 - 0.1, False), (LANE_M / 2 + 0.1, True)])
def test_off_route_adjacent_lane_above_limits_is_rejected(d, off):
    """A path beside the route for more than 200 m or 60 s is rejected."""
    slow = case_on([0.0, *([d] * 200)], [0.0] * 201)
    path = replace(slow.path, speed=np.full(201, 1.0))
    (found,) = traffic_rules.off_route(replace(slow, path=path)) or (None,)
    assert (found is not None) is off
    if found is not None:
        assert found.code is C.OFF_ROUTE
        assert found.time_s > 60.0 and found.gap_m == pytest.approx(100.0, abs=1.0)


def test_off_route_without_lane_starts_at_2_m():
    """Where the route has no lane, a place more than 2 m beside it is off the route."""
    for d, off in ((1.9, False), (2.1, True)):
        case = case_on([d] * 200, [0.0] * 200)
        path = replace(case.path, s=case.path.s + 1000.0, speed=np.full(200, 1.0))
        far = replace(case, path=path)
        assert far.view.frame.lane_at(float(path.s[0]), 0.0) is None
        assert bool(traffic_rules.off_route(far)) is off


# ---- where one may stand


def test_help_is_not_called_for_in_a_junction():
    call = RequestAssistance(reason="stuck")
    inside = World(zones(ZoneKind.JUNCTION, 45.0, 60.0))
    (found,) = GUARD.allows_standing(call, inside.view()).rejects
    assert found.code is C.STOPPING_PLACE
    assert "requires a stop outside junctions" in found.detail
    assert GUARD.allows_standing(call, World(MULTI).view()).accepted


@pytest.mark.parametrize(("more_m", "may"), [(-0.02, True), (0.02, False)])
def test_may_stand_over_line_to_oncoming_lane_by_30_cm(more_m, may):
    """The ego may stop up to 30 cm over the line to the oncoming lane."""
    y = LANE_M / 2 - WIDTH_M / 2 + 0.3 + more_m
    assert GUARD.may_stand(World(TWO_WAY, y=y).view()) is may


def test_too_fast_is_told_with_both_figures():
    world = World(MULTI, speed=3.0)
    proven = GUARD.accept([KeepLane(distance_m=60.0, speed_mps=3.0)], world.view(), False)[1]
    world.speed = 4.5
    (found,) = GUARD.recheck(proven, world.view()).rejects
    assert found.code is C.OVERSPEED and "4.5 m/s" in found.detail and "4.0 m/s" in found.detail


# ---- painted lines


@pytest.mark.parametrize("side", ["left", "right"])
def test_legal_lane_in_same_direction_is_found_on_both_sides(side):
    """A lane in the ego's direction is looked for on both sides."""
    road = straight_road(left=LineKind.BROKEN, oncoming=None)
    if side == "right":
        lanes = tuple(
            lane if lane.id == "own" else lane.model_copy(update={"offset_m": tuple(-o for o in lane.offset_m)})
            for lane in road.lanes
        )
        road = road.model_copy(update={"key": "right", "lanes": lanes})
    case = case_of(World(road), Creep(distance_m=3.0))
    assert marking._legal_way(case, 60.0)
    assert not marking._legal_way(case_of(World(TWO_WAY), Creep(distance_m=3.0)), 60.0)


@pytest.mark.parametrize(("at_m", "refused"), [(51.9, False), (52.1, True), (72.9, True), (73.1, False)])
def test_solid_line_crossing_near_junction_is_rejected(at_m, refused):
    """No solid line is crossed within 3 m of a junction."""
    road = zones(ZoneKind.JUNCTION, 55.0, 70.0)
    policy = POLICY.model_copy(update={"solid_line": "autonomous"})
    case = replace(case_on([0.0] * 100, [0.0] * 100, [thing("it", 85.0)]), policy=policy)
    view = World(road, [thing("it", 85.0)]).view()
    s = np.linspace(at_m, at_m + 40.0, 100)
    case = replace(case, view=view, path=replace(case.path, s=s))
    lane = next(lane for lane in view.frame.lanes if lane.strip.id == "oncoming")
    why = marking._against_solid(case, lane, 0)
    assert ("junction" in (why or "")) is refused


# ---- what a path is looked at for


def entering(left_at_m, shoulder_at_m, **world):
    """A path that enters the left lane at one place and the shoulder at another."""
    view = World(WITH_SHOULDER, x=50.0, speed=3.0, **world).view()
    s = 50.0 + 0.5 * np.arange(120)
    d = np.where(s >= left_at_m, LANE_M, np.where(s >= shoulder_at_m, -2.75, 0.0))
    case = case_on([0.0] * 120, [0.0] * 120, speed=3.0)
    lanes = {lane.strip.id: lane for lane in view.frame.lanes}
    path = replace(case.path, d=d, enters=(lanes["own"], lanes["shoulder"], lanes["left"]))
    return replace(case, view=view, path=path)


WITH_SHOULDER = MULTI.model_copy(
    update={
        "key": "with shoulder",
        "lanes": (
            *MULTI.lanes,
            MULTI.lanes[0].model_copy(
                update={
                    "id": "shoulder",
                    "kind": LaneKind.SHOULDER,
                    "offset_m": (-2.75,) * 401,
                    "width_m": (2.0,) * 401,
                }
            ),
        ),
    }
)


@pytest.mark.parametrize("behind_m", [0.0, 56.0])
def test_sight_distance_behind_is_checked_for_each_entered_lane(behind_m):
    """The sight behind is checked for each entered lane, and one reason is reported."""
    for left, shoulder in ((52.0, 1e3), (1e3, 52.0)):
        found = sight_distance.check_sight_distance(entering(left, shoulder, behind_m=behind_m))
        assert [r.code for r in found] == ([C.PATH_NOT_VISIBLE] if behind_m == 0.0 else [])


def test_sight_distance_behind_depends_on_fastest_road_user():
    """On the shoulder, the sight behind is that for cyclists; in a lane, for its fastest traffic.

    A cyclist needs 14 m behind, a car at the limit 50 m.
    """
    for behind_m, seen in ((30.0, True), (5.0, False)):
        assert bool(sight_distance.check_sight_distance(entering(1e3, 52.0, behind_m=behind_m))) is not seen
    assert sight_distance.check_sight_distance(entering(52.0, 1e3, behind_m=30.0))


def test_sight_distance_of_late_entry_is_checked_when_due():
    """While a plan runs, a lane that is entered late is checked when the entry is due."""
    for at_m, due in ((105.0, False), (53.0, True)):
        assert (
            bool(sight_distance.check_sight_distance(replace(entering(at_m, 1e3, behind_m=0.0), running=True))) is due
        )


@pytest.mark.parametrize("way", [-1, 1])
def test_behind_a_long_lorry_nobody_unseen_is_feared(way):
    """The sight ends at its near end, 5 m from our bumper; its middle is 13 m from there."""
    lorry = thing("lorry", 50.0 + way * (FRONT_M + 3.0 + 8.0), LANE_M if way < 0 else 0.0, speed=3.0, length=16.0)
    change, ahead = ChangeLane(side="left", distance_m=40.0, speed_mps=3.0), KeepLane(distance_m=40.0, speed_mps=5.0)
    sees = {"behind_m": FRONT_M + 3.0} if way < 0 else {"sight_m": FRONT_M + 3.0}
    case = case_of(World(MULTI, [lorry], speed=3.0, **sees), change if way < 0 else ahead)
    lane = next(lane for lane in case.view.frame.lanes if lane.strip.id == ("left" if way < 0 else "own"))
    assert (sight_distance._behind(case, lane, 5, 13.0) if way < 0 else sight_distance._ahead(case, lane)) == []


def test_lay_out_reversal_needs_stop_and_plan_needs_behavior():
    """Between forward and reverse the ego must be stopped, and an empty plan is rejected."""
    view = World(MULTI).view()
    for behaviors, failure in (
        ((Creep(distance_m=3.0), BackUp(distance_m=3.0)), PlanFailure.MUST_BE_STOPPED),
        ((), PlanFailure.EMPTY),
    ):
        with pytest.raises(NoPathError) as raised:
            GUARD.lay_out(behaviors, view, False, NOBODY)
        assert raised.value.failure is failure


def test_lay_out_behavior_starts_at_speed_of_previous_end():
    """A behavior begins at the speed at which the previous one ends."""
    view = World(MULTI, speed=3.0).view()
    keep = [KeepLane(distance_m=20.0, speed_mps=v) for v in (3.0, 5.0)]
    path = GUARD.lay_out(keep, view, False, NOBODY).path
    assert float(path.speed[5]) == pytest.approx(3.0) and float(path.speed[-5]) == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("kind", "rule"),
    [(K.CROSSING_GATE, "level crossing"), (K.FLAGGER, "flagger"), (K.SCHOOL_BUS, "school bus")],
)
def test_whose_scene_it_is_stands_in_the_reason(kind, rule):
    case = case_on([0.0] * 80, [0.0] * 80, [thing("it", 60.0, 3.0, kind=kind)])
    (found,) = traffic_rules.authority(case)
    assert found.code is C.AUTHORITY and found.detail.startswith(rule)


@pytest.mark.parametrize(
    ("x", "y", "counts"),
    [
        (50.0 - FRONT_M - HALF_CAR_M - 0.1, 3.0, False),  # behind us
        (50.0 - FRONT_M - HALF_CAR_M + 0.1, 3.0, True),
        (89.5 + FRONT_M + HALF_CAR_M + 0.1, 3.0, False),  # beyond the end
        (89.5 + FRONT_M + HALF_CAR_M - 0.1, 3.0, True),
        (70.0, 8.0 + 0.95 - 0.1, True),  # 8 m beside the route
        (70.0, 8.0 + 0.95 + 0.1, False),
    ],
)
def test_authority_scene_counts_from_near_end_to_far_end(x, y, counts):
    """A scene counts from its near end to its far end, and up to 8 m beside the route."""
    case = case_on([0.0] * 80, [0.0] * 80, [thing("it", x, y, kind=K.SCHOOL_BUS, length=CAR_M, width=1.9)])
    assert bool(traffic_rules.authority(case)) is counts


@pytest.mark.parametrize(("start_m", "end_m", "counts"), [(92.2, 99.0, True), (92.3, 99.0, False), (30.0, 47.6, True)])
def test_authority_level_crossing_counts_up_to_final_front(start_m, end_m, counts):
    """A level crossing counts up to where the ego's front may end.

    The rear is at 47.55 m, the front at 91.95 m at the stop, or 0.3 m farther. A crossing that the ego is on, and
    leaves, does not count.
    """
    view = World(zones(ZoneKind.LEVEL_CROSSING, start_m, end_m)).view()
    case = replace(case_on([0.0] * 80, [0.0] * 80), view=view)
    assert bool(traffic_rules.authority(case)) is (counts and start_m > 50.0)


def test_between_two_lanes_the_outer_one_owns_the_line():
    lanes = {lane.strip.id: lane for lane in World(WITH_SHOULDER).view().frame.lanes}
    own, left, shoulder = lanes["own"], lanes["left"], lanes["shoulder"]
    assert marking._outer(left, own, 60.0) is left and marking._outer(own, left, 60.0) is left
    assert marking._outer(shoulder, own, 60.0) is shoulder and marking._outer(own, shoulder, 60.0) is shoulder
    assert marking._outer(own, None, 60.0) is own


@pytest.mark.parametrize("giving_way", [False, True])
def test_who_gives_way_goes_on_giving_it_for_longer(giving_way):
    """At 2 m/s a walker is met in 4.5 s: later than a stop and 2.5 s, but within 6 s."""
    case = on_way(
        thing("it", 65.0 + FRONT_M + 0.25 + 9.0, -4.5, kind=K.PEDESTRIAN, sideways=1.0, yaw=math.pi / 2), speed=2.0
    )
    path = replace(case.path, speed=np.full(80, 2.0))
    assert (
        bool(
            collision_mitigation.least_harmful_option(replace(case, path=path), giving_way)
            != collision_mitigation.FINISH
        )
        is giving_way
    )


def test_mitigation_impact_speed_includes_own_lateral_motion():
    """The impact speed of a turned body includes its own lateral motion.

    Turned by 0.5 rad at 5 m/s, hit from the side at 3 m/s against that lateral motion.
    """
    case = case_on(
        [0.0] * 80, [0.5] * 80, [thing("it", 72.5, 4.5, sideways=-3.0, yaw=-math.pi / 2)], start_s=65.0, speed=5.0
    )
    t = np.linspace(0.0, 3.0, 31)
    found = collision_mitigation._with_moving(replace(case, running=True), 65.0 + 5.0 * t[None], t)
    across = 5.0 * math.sin(0.5) + 3.0
    assert found.speed_mps == pytest.approx(math.hypot(5.0 * math.cos(0.5), across), abs=0.15)


def test_back_up_body_straightens_over_3_m():
    """In reverse, the body straightens over about 3 m and never swings out farther."""
    view = World(MULTI, yaw=0.3).view()
    path = GUARD.lay_out([BackUp(distance_m=6.0)], view, False, NOBODY).path
    yaw = tracked_path(path, view.backwards, POLICY.tracking, reverse=True).yaw
    assert yaw[0] == pytest.approx(view.backwards.ego_yaw)
    assert abs(yaw[6]) == pytest.approx(0.3 * math.exp(-1.0), abs=0.01)
    askew = swing_out_motion(path, view.backwards, POLICY.tracking, 0.3)
    assert np.allclose(askew.yaw, view.backwards.ego_yaw)
