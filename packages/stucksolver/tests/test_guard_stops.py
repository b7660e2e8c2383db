"""Stops as a way out: where they end, whom they meet on the way, and who is let by, against motion in small steps."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from stucksolver.guard import GuardPolicy, RejectCode, RejectReason, abort_stops
from stucksolver.guard.context import CheckContext
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene import LaneDirection, LineKind, ObjectKind, Zone, ZoneKind
from worlds import LANE_M, World, straight_road, thing

C = RejectCode
POLICY = GuardPolicy()
HALF_LENGTH_M = 4.9 / 2
HALF_WIDTH_M = 1.85 / 2
A_LITTLE = 0.02
SURE_S = POLICY.prediction.sure_running_s
"""Who goes straight on may be so much earlier or later."""


def zone(kind, start, end):
    return Zone(kind=kind, start_m=start, end_m=end)


JUNCTION = (zone(ZoneKind.JUNCTION, 30.0, 120.0),)


def case_of(objects=(), *, zones=JUNCTION, speed=0.0, stations=60, path_mps=5.0, d=None, enters=(), **road):
    """Straight on along the lane, or with offsets `d`, half a meter from station to station."""
    world = World(straight_road(zones=zones, **road), list(objects), speed=speed)
    view = world.view()
    s = 50.0 + 0.5 * np.arange(stations)
    offsets = np.zeros(stations) if d is None else np.asarray(d, float)
    lanes = tuple(lane for lane in view.frame.lanes if lane.strip.id in enters)
    path = FrenetPath(s, offsets, np.full(stations, path_mps), lanes, yaw=np.zeros(stations))
    return CheckContext(view, path, POLICY, running=True)


def crosses(x, y, speed, name="it", **more):
    """A car across the road that goes towards +y."""
    return thing(name, x, y, speed=0.0, sideways=speed, yaw=math.pi / 2, **more)


def driven(t, v, braking, lag):
    """How far one gets by `t` who brakes from `v` after a lag, in steps of five milliseconds."""
    ticks = np.arange(0.0025, t, 0.005)
    return float(np.maximum(v - braking * np.maximum(ticks - lag, 0.0), 0.0).sum() * 0.005)


@pytest.mark.parametrize(("speed", "braking"), [(0.0, None), (2.0, None), (5.0, None), (5.0, 6.0)])
def test_braking_profile_follows_vehicle_until_3_s_after_stop(speed, braking):
    """The profile brakes as the vehicle does and lasts until the vehicle has been stopped for 3 s."""
    stations, t = abort_stops.braking_profile(case_of(speed=speed), braking)
    for at, place in list(zip(t, stations, strict=True))[:: max(len(t) // 8, 1)]:
        assert place - 50.0 == pytest.approx(driven(at, speed, braking or 3.0, 0.3), abs=0.02)
    assert stations[-1] - 50.0 == pytest.approx(driven(8.0, speed, braking or 3.0, 0.3), abs=0.02)
    until = 0.3 + speed / (braking or 3.0) + 3.0
    step = POLICY.prediction.step_s
    assert until - 1e-9 <= t[-1] <= until + step + 1e-9
    assert np.allclose(np.diff(t), step)


def test_who_reverses_stands_where_it_is():
    stations, _ = abort_stops.braking_profile(case_of(speed=-1.0))
    assert np.allclose(stations, 50.0)


# ---- stops before the commit point


def met_by_stopping(case, thing_x, thing_y, speed, free):
    """The least gap along the road while a stop is under way, while the other's side is abreast, by small steps."""
    least = math.inf
    for run in (case.quick, case.slow):
        for start in free[::6]:
            takes = run.v[start] / 3.0
            for t in np.arange(0.0, run.t[start] + takes, 0.02):
                place = float(np.interp(t, run.t, case.path.s))
                if t > run.t[start]:
                    since = t - run.t[start]
                    place = case.path.s[start] + run.v[start] * since - 1.5 * since**2
                along = abs(place - thing_x) - HALF_LENGTH_M - 0.95
                steady = abs(thing_y + speed * t) - HALF_WIDTH_M - 2.3 - speed * SURE_S
                brakes = abs(thing_y + driven(t, speed, POLICY.prediction.braking_mps2, 0.0)) - HALF_WIDTH_M - 2.3
                faster = min(t, (30 / 3.6 - speed) / 2.0)
                sets_off = abs(thing_y + speed * t + 2.0 * (faster * t - faster**2 / 2)) - HALF_WIDTH_M - 2.3
                slow = speed < POLICY.prediction.sets_off_mps
                least = min(least, max(along, min(steady, brakes, sets_off if slow else math.inf)))
    return least


@pytest.mark.parametrize("number", range(40))
def test_stops_with_contact_before_standstill_are_not_safe(number):
    """A stop that hits an object before it is over is not a safe way out."""
    draw = random.Random(number)
    x, y, speed = draw.uniform(60.0, 75.0), draw.uniform(-25.0, -8.0), draw.uniform(2.0, 6.0)
    case = case_of([crosses(x, y, speed)], zones=(), stations=48, speed=draw.uniform(0.0, 4.0))
    no_stop = np.zeros(48, bool)
    no_stop[draw.randrange(10, 47) :] = True
    least = met_by_stopping(case, x, y, speed, np.flatnonzero(~no_stop))
    found = abort_stops.are_stops_safe(case, no_stop)
    if abs(least) > 0.5:  # between their instants, a tenth of a second apart, both move on by as much
        assert bool(found) is bool(least < 0.0)
    if found:
        assert found[0].code is C.NO_ABORT and found[0].object_id == "it"
        assert found[0].detail == f"car it: contact at {found[0].time_s:.1f} s after an abort"
        if speed >= POLICY.prediction.sets_off_mps:
            assert abs(y + speed * found[0].time_s) < HALF_WIDTH_M + 2.3 + speed * SURE_S + 0.1


MEETS = {"x": 62.0, "y": -12.0, "speed": 3.0}
ALL_FREE = np.zeros(48, bool)


@pytest.mark.parametrize(("stations", "first", "tried"), [(48, 0, 8), (96, 0, 16), (150, 0, 15), (150, 100, 9)])
def test_stops_are_tried_every_3_m_and_at_most_16(monkeypatch, stations, first, tried):
    """Stops are tried every 3 m along a path, and no more than 16 of them.

    Each is driven as planned, and braked from its own place on; then it is over.
    """
    looked = []
    plain = abort_stops.moving_gaps

    def moving_gaps(case, places, which, t):
        looked.append((places, t))
        return plain(case, places, which, t)

    monkeypatch.setattr(abort_stops, "moving_gaps", moving_gaps)
    case = case_of([crosses(58.0, -300.0, 60.0)], zones=(), stations=stations, speed=2.0)
    no_stop = np.zeros(stations, bool)
    no_stop[:first] = True
    abort_stops.are_stops_safe(case, no_stop)
    assert [len(places) for places, _ in looked] == [tried, tried]
    stride = max(6, -(-(stations - first) // 16))
    for run, (places, t) in zip((case.quick, case.slow), looked, strict=True):
        for k, start in enumerate(range(first, stations, stride)):
            for when, place in list(zip(t, places[k], strict=True))[::7]:
                since = min(max(when - run.t[start], 0.0), run.v[start] / 3.0)
                braked = case.path.s[start] + run.v[start] * since - 1.5 * since**2
                expected = braked if when >= run.t[start] else np.interp(when, run.t, case.path.s)
                assert place == pytest.approx(expected, abs=1e-9)


def test_stops_with_contact_on_the_way_are_not_safe():
    """An object that would be hit on the way to a stop rejects it as well."""
    no_stop = np.ones(48, bool)
    no_stop[44:] = False
    assert abort_stops.are_stops_safe(case_of([crosses(55.0, -8.0, 3.0)], zones=(), stations=48), no_stop)


def test_stops_ignore_stopped_objects_and_paths_without_stop():
    """A stopped object does not matter, and no object matters where no stop is left."""
    case = case_of([crosses(**MEETS)], zones=(), stations=48)
    assert abort_stops.are_stops_safe(case, ALL_FREE)
    assert not abort_stops.are_stops_safe(case, ~ALL_FREE)
    stands = crosses(62.0, 1.0, 0.0)
    assert not abort_stops.are_stops_safe(case_of([stands], zones=(), stations=48), ALL_FREE)
    other = crosses(**MEETS, name="other")
    assert abort_stops.are_stops_safe(case_of([stands, other], zones=(), stations=48), ALL_FREE)[0].object_id == "other"


def test_stops_ignore_lead_vehicle_in_same_direction():
    """A lead vehicle in the ego's direction is followed, and no stop is rejected for it."""
    ahead = thing("ahead", 56.0, speed=1.0)
    assert not abort_stops.are_stops_safe(case_of([ahead], zones=(), stations=48, speed=5.0), ALL_FREE)
    assert abort_stops.are_stops_safe(case_of([ahead, crosses(**MEETS)], zones=(), stations=48), ALL_FREE)
    # Who comes towards us in our own lane is not.
    comes = thing("comes", 70.0, speed=-3.0)
    assert abort_stops.are_stops_safe(case_of([comes], zones=(), stations=48, speed=5.0), ALL_FREE)


def test_stops_in_contact_count_only_approach():
    """An object in contact already counts as hit only if it comes nearer."""
    beside = thing("beside", 50.0, HALF_WIDTH_M + 0.95 - 0.05, speed=-0.3)
    assert not abort_stops.are_stops_safe(case_of([beside], zones=(), stations=4, path_mps=0.5), np.zeros(4, bool))


# ---- who crosses is let by


def against(time_s=1.0, name="it"):
    return [RejectReason(code=C.COLLISION, detail="", object_id=name, time_s=time_s)]


FAR_AHEAD = {"x": 75.0, "y": -15.0, "speed": 5.0}


@pytest.mark.parametrize("speed", [0.0, 3.0])
@pytest.mark.parametrize(("giving_way", "within_s"), [(False, 2.5), (True, 6.0)])
def test_junction_stop_yields_to_contacts_soon_after_stop(giving_way, within_s, speed):
    """The ego yields to traffic that would be hit soon after the stop."""
    case = case_of([crosses(**FAR_AHEAD)], speed=speed)
    assert case.view.elsewhere[0]
    latest = 0.3 + speed / 3.0 + within_s
    assert abort_stops.is_junction_stop_clear(case, against(latest - A_LITTLE), giving_way)
    assert not abort_stops.is_junction_stop_clear(case, against(latest + A_LITTLE), giving_way)
    assert not abort_stops.is_junction_stop_clear(case, against(1.0, "somebody else"), giving_way)
    timeless = [RejectReason(code=C.COLLISION, detail="", object_id="it")]
    assert not abort_stops.is_junction_stop_clear(case, timeless, giving_way)
    assert (
        abort_stops.is_junction_stop_clear(case, [*against(99.0), *against(latest - A_LITTLE)][::-1], giving_way)
        is False
    ), "each is named once, the last word counts"


def before_the_nose(gap_m, speed):
    """One who crosses in front of where a stop ends, and has not come there before."""
    stop_m = driven(8.0, speed, 3.0, 0.3)
    return crosses(50.0 + stop_m + HALF_LENGTH_M + 0.95 + gap_m, -14.0, 4.0)


@pytest.mark.parametrize("speed", [0.0, 2.0, 4.0])
@pytest.mark.parametrize(("gap_m", "lets"), [(0.5 + A_LITTLE, True), (0.5 - A_LITTLE, False)])
def test_a_stop_that_lets_by_leaves_half_a_meter(speed, gap_m, lets):
    assert (
        abort_stops.is_junction_stop_clear(case_of([before_the_nose(gap_m, speed)], speed=speed), against(), False)
        is lets
    )


def test_junction_stop_already_stopped_stays_without_contact():
    """An ego that has stopped to yield stays stopped as long as no vehicle hits it."""
    for gap_m, lets in ((A_LITTLE, True), (-A_LITTLE, False)):
        assert abort_stops.is_junction_stop_clear(case_of([before_the_nose(gap_m, 0.0)]), against(), True) is lets
    assert not abort_stops.is_junction_stop_clear(case_of([before_the_nose(0.3, 0.0)]), against(), False)
    for gap_m, lets in ((0.1 + A_LITTLE, True), (0.1 - A_LITTLE, False)):
        braking = case_of([before_the_nose(gap_m, 1.0)], speed=1.0)
        assert abort_stops.is_junction_stop_clear(braking, against(), True) is lets


def test_junction_stop_checks_all_traffic_until_its_end():
    """All traffic counts until the end of the stop, not only the named vehicle."""
    named = crosses(**FAR_AHEAD)
    case = case_of([named, before_the_nose(0.2, 3.0).model_copy(update={"id": "other"})], speed=3.0)
    assert not abort_stops.is_junction_stop_clear(case, against(), False)
    late = crosses(50.0 + 0.2 + HALF_LENGTH_M + 0.95, -2.3 - 0.925 - 3.05 * 4.0, 4.0, name="late")
    assert not abort_stops.is_junction_stop_clear(case_of([named, late]), against(), False), "within 3.3 s"
    races = crosses(50.0 + 0.2 + HALF_LENGTH_M + 0.95, -2.3 - 0.925 - 3.1 * 20.0, 20.0, name="races")
    assert not abort_stops.is_junction_stop_clear(case_of([named, races], stations=2), against(), False), (
        "from far away, on a short way"
    )


def test_who_leaves_us_is_let_go_however_near():
    gone = crosses(50.0 + HALF_LENGTH_M + 0.95 + 0.3, 0.5, 4.0)
    assert abort_stops.is_junction_stop_clear(case_of([gone]), against(), False)


@pytest.mark.parametrize(
    ("zones", "lets"),
    [
        (JUNCTION, True),
        ((zone(ZoneKind.CROSSWALK, 45.0, 56.0),), True),
        ((), False),
        ((zone(ZoneKind.JUNCTION, 50.0 + HALF_LENGTH_M + 0.1, 90.0),), False),
        ((zone(ZoneKind.LEVEL_CROSSING, 45.0, 60.0),), False),
        ((*JUNCTION, zone(ZoneKind.LEVEL_CROSSING, 53.0, 60.0)), False),
        ((*JUNCTION, zone(ZoneKind.LEVEL_CROSSING, 40.0, 45.0)), True),
    ],
)
def test_junction_stop_is_allowed_on_crosswalks_but_not_rails(zones, lets):
    """The ego yields in junctions and on their crosswalks, and never on rails.

    From 4 m/s the stop ends 3.9 m on.
    """
    assert (
        abort_stops.is_junction_stop_clear(case_of([crosses(**FAR_AHEAD)], zones=zones, speed=4.0), against(), False)
        is lets
    )


@pytest.mark.parametrize(("enters_at_m", "lets"), [(0.0, False), (4.0, False), (6.5, True)])
def test_way_is_not_given_in_an_oncoming_lane(enters_at_m, lets):
    """The stop ends 3.9 m on, and is looked at half a meter further."""
    s = 0.5 * np.arange(60)
    case = case_of([crosses(**FAR_AHEAD)], speed=4.0, d=np.where(s >= enters_at_m, 1.2, 0.0))
    assert abort_stops.is_junction_stop_clear(case, against(), False) is lets


# ---- who does not let us in


def comes_by(room_m, name="it", **more):
    return thing(name, 40.0, HALF_WIDTH_M + 0.95 + room_m, speed=8.0, **more)


MULTI = {"left": LineKind.BROKEN, "oncoming": None}


@pytest.mark.parametrize("speed", [0.0, 2.0])
def test_stops_beside_passing_traffic_leaves_30_cm(speed):
    """A stop beside passing traffic leaves it a gap of 30 cm."""
    for room_m, lets in ((0.3 + A_LITTLE, True), (0.3 - A_LITTLE, False)):
        assert abort_stops.stops_beside(case_of([comes_by(room_m)], speed=speed, **MULTI), against(), False) is lets
    least_m = 0.1 if speed else 0.0
    for room_m, lets in ((least_m + A_LITTLE, True), (least_m - A_LITTLE, False)):
        assert abort_stops.stops_beside(case_of([comes_by(room_m)], speed=speed, **MULTI), against(), True) is lets
    assert not abort_stops.stops_beside(case_of([comes_by(-A_LITTLE)], speed=speed, **MULTI), against(), True)


def test_only_those_who_are_named_and_move_are_stopped_for():
    stands = thing("it", 40.0, LANE_M, speed=0.0)
    assert not abort_stops.stops_beside(case_of([stands], **MULTI), against(), False)
    assert not abort_stops.stops_beside(case_of([comes_by(1.0)], **MULTI), against(name="other"), False)
    both = [comes_by(1.0, "first"), comes_by(0.1)]
    assert not abort_stops.stops_beside(case_of(both, **MULTI), against(), False)
    assert abort_stops.stops_beside(case_of(both, **MULTI), against(name="first"), False)


def test_stops_beside_on_rails_or_in_oncoming_lane_is_false():
    """The ego does not stop to yield on rails or with its body in an oncoming lane."""
    rails = (zone(ZoneKind.LEVEL_CROSSING, 55.5, 60.0),)
    assert not abort_stops.stops_beside(case_of([comes_by(1.0)], zones=rails, speed=4.0, **MULTI), against(), False)
    assert abort_stops.stops_beside(case_of([comes_by(1.0)], zones=rails, speed=1.0, **MULTI), against(), False)
    d = np.full(60, 1.0)
    world = case_of([comes_by(2.5)], d=d)
    assert world.in_oncoming_lane
    assert not abort_stops.stops_beside(world, against(), False)


# ---- where there is no stop


def no_stop(**more):
    return abort_stops.commit_mask(case_of(**more))


@pytest.mark.parametrize("path_mps", [2.0, 5.0])
def test_commit_mask_stop_ending_in_junction_is_marked(path_mps):
    """A stop that would end in a junction is not a stop.

    The body is in it from 2.45 m before its border on.
    """
    zones = (zone(ZoneKind.JUNCTION, 62.0, 66.0),)
    bad = no_stop(zones=zones, path_mps=path_mps, speed=path_mps)
    s = 50.0 + 0.5 * np.arange(60)
    way = path_mps**2 / 6.0
    for station, marked in zip(s, bad, strict=True):
        if not (62.0 - HALF_LENGTH_M - way - 0.5 <= station <= 62.0 - HALF_LENGTH_M - way):
            inside = station + way > 62.0 - HALF_LENGTH_M and station < 66.0 + HALF_LENGTH_M
            assert bool(marked) is bool(inside), station
    assert not no_stop(zones=(), path_mps=path_mps).any()


def test_every_zone_counts_and_so_does_where_we_are():
    zones = (zone(ZoneKind.JUNCTION, 56.0, 58.0), zone(ZoneKind.CROSSWALK, 70.0, 72.0))
    for order in (zones, zones[::-1]):
        bad = no_stop(zones=order, path_mps=1.0)
        assert bad[14] and bad[42] and not bad[24]
    here = no_stop(zones=(zone(ZoneKind.JUNCTION, 40.0, 50.0 - HALF_LENGTH_M + 0.1),), path_mps=0.5)
    assert here[0] and not here[1:].any()


def test_a_zone_beside_a_lane_that_is_entered_counts_too():
    d = np.concatenate([np.zeros(20), np.linspace(0.0, LANE_M, 20), np.full(20, LANE_M)])
    bad = no_stop(zones=(zone(ZoneKind.JUNCTION, 76.0, 78.0),), d=d, enters=("own", "left"), path_mps=1.0, **MULTI)
    assert bad[54] and bad[30] and not bad[45]


def test_commit_mask_marks_lane_borders_and_not_own_lanes():
    """No stop is at the border of a lane; a stop in the middle of a lane of the ego's direction is."""
    d = np.concatenate([np.zeros(20), np.linspace(0.0, LANE_M, 20), np.full(20, LANE_M)])
    bad = no_stop(zones=(), d=d, enters=("left",), path_mps=1.0, **MULTI)
    over = (d + HALF_WIDTH_M > LANE_M / 2 + 0.05) & (d - HALF_WIDTH_M < LANE_M / 2 - 0.1)
    assert bad[over].all()
    assert not bad[np.flatnonzero(over)[-1] + 1 :].any() and not bad[: np.flatnonzero(over)[0] - 2].any()
    in_oncoming = no_stop(zones=(), d=d, enters=("oncoming",), path_mps=1.0)
    assert in_oncoming[np.flatnonzero(over)[0] :].all()
    assert case_of(d=d, enters=("oncoming",)).path.enters[0].strip.direction is LaneDirection.OPPOSITE


def test_people_are_let_by_as_vehicles_are():
    walker = thing("it", 50.0 + HALF_LENGTH_M + 0.25 + 0.6, -5.0, kind=ObjectKind.PEDESTRIAN, sideways=1.4)
    found = abort_stops.is_junction_stop_clear(case_of([walker]), against(), False)
    assert found is bool(case_of([walker]).view.elsewhere[0])
