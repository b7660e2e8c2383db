"""Geometry and motion of the guard against another way to the same figure: polygons, small steps, formulas by hand."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from shapely import affinity
from shapely.geometry import Polygon, box

from guard_cases import (
    BOTH,
    CAR_M,
    LENGTH_M,
    MULTI,
    NUMBERS,
    PAST_LEAD,
    POLICY,
    WIDTH_M,
    C,
    case_of,
    case_on,
)
from stucksolver.guard import lane_entry, oncoming_lane
from stucksolver.guard.context import CheckContext
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.plan.speed_profile import SpeedProfile
from stucksolver.scene import (
    LaneDirection,
    LineKind,
    ObjectKind,
    Zone,
    ZoneKind,
)
from worlds import LANE_M, World, straight_road, strip, thing

# ---- where the body's tail is, while it crosses a border


def rearmost(s, d, turn, border, from_right):
    """Of the part of the body beyond a border, None where no part is."""
    body = affinity.rotate(box(-LENGTH_M / 2, -WIDTH_M / 2, LENGTH_M / 2, WIDTH_M / 2), turn, (0, 0), use_radians=True)
    body = affinity.translate(body, s, d)
    beyond = box(-1e3, border, 1e3, 1e3) if from_right else box(-1e3, -1e3, 1e3, border)
    part = body.intersection(beyond)
    return part.bounds[0] if isinstance(part, Polygon) and not part.is_empty else None


@pytest.mark.parametrize("from_right", [True, False])
@pytest.mark.parametrize("number", NUMBERS)
def test_tail_inside_border_matches_polygon_of_body(number, from_right):
    """The tail of the body beyond a border is that of the polygon."""
    draw = random.Random(number)
    sign = 1.0 if from_right else -1.0
    turn = np.full(60, draw.uniform(0.05, 0.6)) * sign
    d = sign * (np.arange(60) * 0.5 * math.tan(abs(turn[0])) - draw.uniform(1.0, 3.0))
    case = case_on(d, turn)
    k = draw.randrange(0, 6)
    border = sign * draw.uniform(-0.5, 1.0)
    tail = lane_entry.tail_inside_border_s(case, k, np.full(60 - k, border), from_right)
    stations = range(k, k + len(tail))
    expected = [rearmost(case.path.s[j], d[j], turn[j], border, from_right) for j in stations]
    met = [(item, other) for item, other in zip(tail, expected, strict=True) if other is not None]
    assert met and all(item == pytest.approx(other, abs=1e-6) for item, other in met)
    last = k + len(tail) - 1
    rear_edge = sign * d[last] - LENGTH_M / 2 * math.sin(abs(turn[0])) + WIDTH_M / 2 * math.cos(turn[0])
    assert rear_edge >= sign * border - 1e-6, "all of its leading side is beyond the border at the end ..."
    if len(tail) > 1:
        before = sign * d[last - 1] - LENGTH_M / 2 * math.sin(abs(turn[0])) + WIDTH_M / 2 * math.cos(turn[0])
        assert before < sign * border + 1e-6, "... and was not before"


def test_tail_inside_border_straight_body_is_whole_or_none():
    """A body that moves straight along a border is beyond it as a whole or not at all."""
    for d, tail_m in ((0.0, LENGTH_M / 2), (2.0, -LENGTH_M / 2)):
        case = case_on([d] * 10, [0.0] * 10)
        tail = lane_entry.tail_inside_border_s(case, 0, np.full(10, 1.5), True)
        assert tail[0] - case.path.s[0] == pytest.approx(tail_m)
        assert len(tail) == (10 if d == 0.0 else 1)


@pytest.mark.parametrize("y", [0.0, LANE_M])
def test_lane_entry_tail_uses_border_on_ego_side(y):
    """A lane is entered across the border on the ego's side."""
    side = "left" if y == 0.0 else "right"
    case = case_of(World(MULTI, y=y), ChangeLane(side=side, distance_m=30.0, speed_mps=5.0))
    (lane,) = case.path.enters
    k = int(np.flatnonzero(case.inside(lane))[0])
    tail = lane_entry._tail(case, lane, k)
    for j, item in zip(range(k, k + len(tail)), tail, strict=True):
        expected = rearmost(case.path.s[j], case.path.d[j], case.heading[j], LANE_M / 2, side == "left")
        assert expected is None or item == pytest.approx(expected, abs=1e-6)
    assert 1 < len(tail) < len(case.path.s) - k


# ---- one from behind who could not stop


def reaches(now, when, limit, alongside=0.0):
    """Front of one who speeds up by 2 m/s² to the limit, and its speed at the end, in steps of a millisecond."""
    speed, way = now, 0.0
    for _ in range(round(when * 1000)):
        after = max(now, min(speed + 0.002, limit))
        way += (speed + after) / 2 * 0.001
        speed = after
    return way + alongside, speed


@pytest.mark.parametrize("reaction_s", [0.5, 1.0])
@pytest.mark.parametrize("number", NUMBERS)
def test_could_not_stop_follower_accelerates_reacts_and_brakes(number, reaction_s):
    """A follower speeds up, reacts and brakes with 4.5 m/s²."""
    draw = random.Random(number)
    now, when, ours = draw.uniform(1.0, 13.0), draw.uniform(0.3, 3.0), draw.uniform(0.3, 5.0)
    way, speed = reaches(now, when, 13.4)
    braking = POLICY.rss.running_braking_mps2
    needed = max(speed * 1.0 + speed**2 / (2 * braking) - ours**2 / (2 * 8.0), 0.0) - (1.0 - reaction_s) * speed
    tail = np.array([160.0, 161.0])
    run = SpeedProfile(np.array([0.0, when, when + 0.2, when + 0.4]), np.full(4, ours))
    for more, refused in ((-0.05, True), (0.05, False)):
        x = 160.0 - needed - way - CAR_M / 2 - more
        case = case_on([0.0] * 4, [0.0] * 4, [thing("behind", x, LANE_M, speed=now)], start_s=160.0)
        found = lane_entry._could_not_stop(case, run, 1, 0, tail, reaction_s)
        assert (found is not None) is refused
        if found is not None:
            assert found.time_s == when and found.gap_m == pytest.approx(needed - 0.05, abs=0.01)
            assert found.detail.startswith(f"car behind behind: gap {found.gap_m:.1f} m, required ")


@pytest.mark.parametrize(("beyond_m", "past"), [(0.05, True), (-0.05, False)])
def test_could_not_stop_vehicle_past_ego_front_is_ignored(beyond_m, past):
    """A vehicle whose rear is past the ego's front at the entry is past the ego.

    At the limit already: 13.4 m/s for a second.
    """
    x = 50.5 + LENGTH_M / 2 + CAR_M / 2 - 13.4 + beyond_m
    case = case_on([0.0] * 4, [0.0] * 4, [thing("by", x, LANE_M, speed=13.4)])
    run = SpeedProfile(np.array([0.0, 1.0, 1.2, 1.4]), np.full(4, 2.0))
    found = lane_entry._could_not_stop(case, run, 1, 0, np.array([48.0, 48.5]), 1.0)
    assert (found is None) is past


def test_could_not_stop_unknown_limit_assumes_50_kmh():
    """Without a lane of known limit, a follower may speed up to the limit of towns.

    Far off the road: from 13 m/s, two seconds, to 50 km/h.
    """
    nowhere = thing("behind", 10.0, 40.0, speed=13.0)
    case = case_on([0.0] * 4, [0.0] * 4, [nowhere])
    assert case.view.lane_of[0] is None
    run = SpeedProfile(np.array([0.0, 2.0, 2.2, 2.4]), np.full(4, 2.0))
    found = lane_entry._could_not_stop(case, run, 1, 0, np.array([50.0, 51.0]), 1.0)
    assert found is not None
    assert found.gap_m == pytest.approx(50.0 - (10.0 + CAR_M / 2 + reaches(13.0, 2.0, 50 / 3.6)[0]), abs=0.01)


# ---- gaps ahead and behind on entering a lane


@pytest.mark.parametrize(
    ("own", "front", "needed"),
    [(5.0, 0.0, 2.5 + 25 / 6), (5.0, 4.0, 2.5 + 25 / 6 - 1.0), (2.0, 1.0, 1.0 + 4 / 6 - 1 / 16), (2.0, 10.0, 0.0)],
)
def test_entry_gap_to_lead_is_difference_of_stopping_distances(own, front, needed):
    """Behind a lead vehicle, the ego keeps its stopping distance less that of the lead."""
    case = case_on([0.0] * 4, [0.0] * 4)
    assert lane_entry._follow_distance_m(case, own, front) == pytest.approx(needed)


@pytest.mark.parametrize("running", [False, True])
@pytest.mark.parametrize("where", ["ahead", "behind"])
def test_entry_gap_is_taken_at_entry_of_slow_ego(running, where):
    """The gap to a vehicle ahead or behind is that at the entry of the slow ego."""

    def entering(x):
        change = ChangeLane(side="left", distance_m=30.0, speed_mps=5.0)
        case = case_of(World(MULTI, [thing("it", x, LANE_M, speed=4.0)]), change, running=running)
        k = int(np.flatnonzero(case.inside(case.path.enters[0]))[0])
        tail = lane_entry._tail(case, case.path.enters[0], k)
        return case, k, tail, float(case.slow.t[k]) + (0.0 if running else 0.3)

    case, k, tail, when = entering(100.0)
    nose = float(case.path.s[k]) + LENGTH_M / 2
    x = (nose + 1.0 + CAR_M / 2 if where == "ahead" else tail.min() - 2.0 - CAR_M / 2) - 4.0 * when
    case, k, tail, when = entering(float(x))
    found = lane_entry.check_entry_gap(case, k, 0, tail)
    assert found is not None and f" {where}: " in found.detail and found.time_s == when
    if where == "ahead":
        assert found.gap_m == pytest.approx(1.0)
        return
    braking = POLICY.rss.running_braking_mps2 if running else POLICY.rss.response_braking_mps2
    needs = np.maximum(4.0 + 16.0 / (2 * braking) - np.square(case.slow.v[k : k + len(tail)]) / 16.0, 0.0)
    room = tail - tail.min() + 2.0 - needs
    assert found.gap_m == pytest.approx(float(tail[room.argmin()] - tail.min() + 2.0))


def test_entry_gap_vehicle_between_fast_and_slow_ego_rejects():
    """A vehicle behind the fast ego and ahead of the slow one is alongside an ego in between.

    It is far enough from both of them, and the entry is still rejected.
    """
    plan = (KeepLane(distance_m=100.0, speed_mps=5.0), ChangeLane(side="left", distance_m=30.0, speed_mps=5.0))
    straddles = 0
    for x in np.arange(-60.0, 60.0, 1.0):
        case = case_of(World(MULTI, [thing("it", float(x), LANE_M, speed=9.0)], x=100.0), *plan)
        lane = case.path.enters[0]
        k = int(np.flatnonzero(case.inside(lane))[0])
        tail = lane_entry._tail(case, lane, k)
        found = lane_entry.check_entry_gap(case, k, 0, tail)
        sluggish_m = x + 9.0 * (float(case.slow.t[k]) + 0.3) - CAR_M / 2 - case.path.s[k] - LENGTH_M / 2
        quick_m = tail.min() - x - 9.0 * float(case.quick.t[k]) - CAR_M / 2
        if sluggish_m > 8.0 and quick_m > 0.0:
            straddles += 1
            assert found is not None
    assert straddles > 3
    assert found is None, "the last one is far ahead of both"


def entry(case, lane):
    return lane_entry._entry(case, lane, int(np.flatnonzero(case.inside(lane))[0]))


@pytest.mark.parametrize("edge", [-1.0, 1.0])
@pytest.mark.parametrize(("inwards_m", "counts"), [(0.1 + 0.01, True), (0.1 - 0.01, False)])
def test_lane_entry_vehicle_over_border_line_is_in_lane(edge, inwards_m, counts):
    """A vehicle that reaches over the border of a lane by more than its line is in that lane."""
    y = LANE_M + edge * (LANE_M / 2 + 0.95 - inwards_m)
    first = thing("aside", 45.0, -8.0, speed=4.0)
    lanes = ChangeLane(side="left", distance_m=30.0, speed_mps=5.0)
    case = case_of(World(MULTI, [first, thing("it", 50.0, y, speed=4.0)]), lanes)
    (lane,) = case.path.enters
    assert bool(entry(case, lane)) is counts


def test_lane_entry_passed_object_counts_only_in_same_direction():
    """The passed object is no traffic in the borrowed lane, but is in a lane of the ego's direction."""
    creeps = thing("lead", 62.0, 1.2, speed=0.6)
    case = case_of(World(straight_road(), [creeps]), BorrowOncomingLane(past_object_id="lead", speed_mps=5.0))
    (lane,) = case.path.enters
    assert lane.strip.direction is LaneDirection.OPPOSITE and case.path.passes == ("lead",)
    nearer = World(straight_road(), [creeps.model_copy(update={"x_m": 56.0})]).view()
    assert not entry(replace(case, view=nearer), lane)
    assert entry(replace(case, view=nearer, path=replace(case.path, passes=())), lane)
    change = ChangeLane(side="left", distance_m=30.0, speed_mps=5.0)
    case = case_of(World(MULTI, [thing("it", 50.0, LANE_M, speed=4.0)]), change)
    (lane,) = case.path.enters
    assert entry(replace(case, path=replace(case.path, passes=("it",))), lane)


def test_lane_entry_without_start_lane_rejects_nothing():
    """From a place beside every lane, there is no lane to return to."""
    d = np.linspace(20.0, 0.0, 60)
    view = World(straight_road(), [thing("it", 60.0, speed=2.0)], y=20.0).view()
    path = FrenetPath(50.0 + 0.5 * np.arange(60), d, np.full(60, 2.0))
    case = CheckContext(view, path, POLICY)
    assert case.start_lane is None
    assert lane_entry.lane_entry(case) == []


def test_lane_entry_return_to_own_lane_checks_traffic():
    """On the return to the ego's lane, a vehicle there may be too near as well."""

    def codes(*others):
        world = World(straight_road(), [thing("lead", 62.0), *others])
        return {r.object_id for r in lane_entry.lane_entry(case_of(world, PAST_LEAD))}

    assert codes() == set()
    alone = case_of(World(straight_road(), [thing("lead", 62.0)]), PAST_LEAD)
    k = int(alone.entries(alone.start_lane)[-1])
    rear = float(alone.path.s[k]) - LENGTH_M / 2 - 5.0 * (float(alone.slow.t[k]) + 0.3) - CAR_M / 2
    assert codes(thing("comes up", rear - 1.0, speed=5.0)) == {"comes up"}
    assert codes(thing("far behind", rear - 20.0, speed=5.0)) == set()
    comes_by = thing("comes by", 48.0, LANE_M, speed=6.0)
    assert codes(comes_by) == {"comes by"}
    assert codes(comes_by, thing("comes up", rear - 1.0, speed=5.0)) == {"comes by", "comes up"}


# ---- the oncoming lane


def borrowed(zones=(), **world):
    road = straight_road(zones=zones)
    case = case_of(World(road, [thing("lead", 65.0)], **world), PAST_LEAD)
    inside = np.flatnonzero(case.inside(case.path.enters[0]))
    return case, float(case.path.s[inside[0]]), float(case.path.s[inside[-1] + 1])


@pytest.mark.parametrize(("aside_m", "in_it"), [(0.05, False), (-0.05, True)])
def test_oncoming_zone_within_3_m_of_body_rejects(aside_m, in_it):
    """A zone counts within 3 m of the body in the oncoming lane."""
    _, first, last = borrowed()
    for start, end in (
        (20.0, first - LENGTH_M / 2 - 3.0 - aside_m),
        (last + LENGTH_M / 2 + 3.0 + aside_m, 200.0),
    ):
        case, _, _ = borrowed((Zone(kind=ZoneKind.LEVEL_CROSSING, start_m=start, end_m=end),))
        zone = [r for r in oncoming_lane.oncoming(case) if r.code is C.ZONE]
        assert bool(zone) is in_it
        assert not zone or zone[0].detail == "oncoming lane used within 3.0 m of a level crossing"


def test_the_first_of_two_zones_does_not_hide_the_second():
    _, _, last = borrowed()
    zones = (
        Zone(kind=ZoneKind.JUNCTION, start_m=300.0, end_m=310.0),
        Zone(kind=ZoneKind.CROSSWALK, start_m=last, end_m=last + 3.0),
    )
    for order in (zones, zones[::-1]):
        case, _, _ = borrowed(order)
        assert {r.code for r in oncoming_lane.oncoming(case)} == {C.ZONE}


@pytest.mark.parametrize(("more_m", "free"), [(0.02, True), (-0.02, False)])
def test_oncoming_gap_is_1_5_s_to_ego_front(more_m, free):
    """An oncoming vehicle is 1.5 s from the ego's front when the ego is back."""
    case, _, last = borrowed()
    back_s = float(case.slow.t[round((last - case.path.s[0]) / 0.5)])
    x = last + LENGTH_M / 2 + CAR_M / 2 + 11.0 * (back_s + 1.5) + more_m
    lead = thing("lead", 65.0)
    case = case_of(
        World(straight_road(), [lead, thing("comes", x, LANE_M, speed=-10.0)], sight_m=500.0),
        PAST_LEAD,
    )
    found = [r for r in oncoming_lane.oncoming(case) if r.code is C.ONCOMING_GAP]
    assert (found == []) is free
    assert free or found[0].gap_m == pytest.approx(more_m, abs=1e-6)


def test_oncoming_sight_covers_path_ending_in_oncoming_lane():
    """A path that ends in the oncoming lane is checked to its end."""
    case, _, _ = borrowed(sight_m=10.0)
    ends = int(np.flatnonzero(case.inside(case.path.enters[0]))[-1])
    for k in (ends, ends - 1):
        path = case.path
        cut = FrenetPath(path.s[: k + 1], path.d[: k + 1], path.speed[: k + 1], path.enters, path.passes)
        (found,) = (
            r for r in oncoming_lane.oncoming(CheckContext(case.view, cut, POLICY)) if r.code is C.ONCOMING_SIGHT
        )
        own_m = float(cut.s[-1]) - 50.0
        slow = CheckContext(case.view, cut, POLICY).slow.t[-1]
        assert found.gap_m == pytest.approx(10.0 - (own_m + 13.4 * slow + 10.0))


def test_oncoming_lane_is_checked_behind_lanes_of_own_direction():
    """Lanes of the ego's direction before it do not hide an oncoming lane."""
    road = straight_road(left=LineKind.BROKEN)
    view = World(road, sight_m=10.0).view()
    lanes = {lane.strip.id: lane for lane in view.frame.lanes}
    d = np.concatenate([np.linspace(0.0, 2 * LANE_M, 41), np.full(20, 2 * LANE_M)])
    s = 50.0 + 0.5 * np.arange(len(d))
    for enters in ((lanes["left"], lanes["oncoming"]), (lanes["oncoming"], lanes["left"])):
        case = CheckContext(view, FrenetPath(s, d, np.full(len(d), 5.0), enters), POLICY)
        assert {r.code for r in oncoming_lane.oncoming(case)} == {C.ONCOMING_SIGHT}
    second = strip("oncoming 2", 3 * LANE_M, LaneDirection.OPPOSITE, LineKind.BROKEN, 401)
    wide = World(road.model_copy(update={"key": "two", "lanes": (*road.lanes, second)}), sight_m=10.0).view()
    lanes = {lane.strip.id: lane for lane in wide.frame.lanes}
    for enters in ((lanes["oncoming 2"], lanes["oncoming"]), (lanes["oncoming"], lanes["oncoming 2"])):
        reached = CheckContext(wide, FrenetPath(s, d, np.full(len(d), 5.0), enters), POLICY)
        assert {r.code for r in oncoming_lane.oncoming(reached)} == {C.ONCOMING_SIGHT}
    lanes = {lane.strip.id: lane for lane in view.frame.lanes}
    never = FrenetPath(s, np.zeros(len(s)), np.full(len(s), 5.0), (lanes["oncoming"],))
    assert oncoming_lane.oncoming(CheckContext(view, never, POLICY)) == []


# ---- those who do not let us in


def pressed(x, y, speed, d_end, *, own_mps=1.0, kind=ObjectKind.CAR, giving_way=False, first=(), within_m=1.0):
    """A body that goes aside by `d_end` within a meter without turning, and one beside it from behind."""
    s = 50.0 + 0.5 * np.arange(41)
    d = d_end * np.clip((s - 50.0) / within_m, 0.0, 1.0)
    path = FrenetPath(s, d, np.full(41, own_mps), yaw=np.zeros(41))
    world = World(BOTH, [*first, thing("it", x, y, speed=speed, kind=kind)])
    world.speed = own_mps
    return lane_entry.check_rear_traffic_can_stop(CheckContext(world.view(), path, POLICY, running=True), giving_way)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_rear_traffic_close_beside_ego_rejects_lateral_move(side):
    """On either side, a vehicle that comes up close beside the ego rejects a move into its path."""
    beside = side * (0.925 + 0.95 + 0.35)
    assert pressed(40.0, beside, 8.0, side * 1.0)
    assert not pressed(40.0, beside, 8.0, 0.0), "we stay out of their way"
    assert not pressed(40.0, -beside, 8.0, side * 1.0), "we leave it to them"
    assert not pressed(-40.0, beside, 8.0, side * 1.0), "they can stop"
    assert not pressed(40.0, side * (0.925 + 0.95 - 0.4), 8.0, side * 1.0), "we are in it already"
    other = thing("other side", 40.0, -beside, speed=8.0)
    stands = thing("stands", 40.0, beside, speed=0.0)
    assert pressed(40.0, beside, 8.0, side * 1.0, first=(other, stands)), "others do not hide them"
    later = thing("later", 40.0, side * (0.925 + 0.95 + 0.9), speed=8.0)
    assert pressed(40.0, side * (0.925 + 0.95 + 0.31), 8.0, side * 1.0, first=(later,), within_m=10.0)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_rear_traffic_needing_gap_must_stop_behind_ego_tail(side):
    """Traffic that needs the gap beside the ego must be able to stop behind its tail.

    The ego is in its path a meter on, after 1.1 s at 0.85 m/s. The vehicle is at 10.2 m/s then, reacts in half a
    second, and brakes with 4.5 m/s², to stop behind the ego's tail 2.45 m behind.
    """
    y = side * (0.925 + 0.95 + 0.3 + 0.2)
    refused = [x for x in np.arange(5.0, 40.0, 0.25) if pressed(float(x), y, 8.0, side * 0.3)]
    way, speed = reaches(8.0, 1.12, 13.4)
    stops_m = way + speed * 0.5 + speed**2 / 9.0
    assert refused[0] == pytest.approx(51.0 - LENGTH_M / 2 - stops_m - CAR_M / 2, abs=0.7)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("room_m", "meets"), [(0.3 + 0.3 - 0.02, True), (0.3 + 0.3 + 0.05, False)])
def test_they_need_30_cm_beside_us(side, room_m, meets):
    """The path goes 0.3 m aside."""
    assert bool(pressed(45.0, side * (0.925 + 0.95 + room_m), 8.0, side * 0.3)) is meets


def test_whose_rear_is_before_our_front_is_not_behind_us():
    y = 0.925 + 0.95 + 0.35
    front = 50.0 + LENGTH_M / 2
    assert pressed(front + CAR_M / 2 - 0.5, y, 0.5, 1.0)
    assert not pressed(front + CAR_M / 2 + 0.1, y, 0.5, 1.0)


def test_rear_traffic_conflict_beyond_stop_is_checked_later():
    """A conflict that is farther away than a stop takes is checked later.

    At 1 m/s, and 1.15 m/s a tick later: 0.12 m until then, 0.22 m of braking, 0.5 s and 0.5 m, in all 1.41 m before
    the body comes within 0.3 m of the other vehicle's path.
    """

    def comes_in(at_m):
        s = 50.0 + 0.05 * np.arange(401)
        d = np.clip((s - 50.0 - at_m) / 0.5, 0.0, 1.0)
        world = World(straight_road(left=LineKind.BROKEN), [thing("it", 42.0, 0.925 + 0.95 + 0.31, speed=8.0)])
        world.speed = 1.0
        path = FrenetPath(s, d, np.full(401, 1.0), yaw=np.zeros(401))
        return lane_entry.check_rear_traffic_can_stop(CheckContext(world.view(), path, POLICY, running=True), False)

    nose_m = next(at for at in np.arange(0.0, 3.0, 0.05) if not comes_in(float(at)))
    assert nose_m == pytest.approx(0.115 + 1.15**2 / 6 + 0.5 * 1.15 + 0.5, abs=0.06)
