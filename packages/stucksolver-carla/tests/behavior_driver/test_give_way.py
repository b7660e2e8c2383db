"""When the ego waits for others at a junction, and when it goes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.conflicting_traffic import TurnStatistics, vehicles_on_path, with_flow_speed
from stucksolver_carla.drivers.behavior.ego_rollout import LeadVehicle
from stucksolver_carla.drivers.behavior.junction_yield import (
    PATIENCE_S,
    SETTLED_S,
    START_LAG_S,
    EgoSpeeds,
    JunctionYield,
)
from stucksolver_carla.drivers.behavior.lane_speed_prior import MEMORY_S, NEW_TRACK_S, PACE_S, LaneSpeedPrior
from stucksolver_carla.drivers.behavior.nearby_objects import FIRST_FAR_ID, NearbyObjects
from stucksolver_carla.drivers.behavior.path import make_path
from stucksolver_carla.drivers.behavior.profiles import PROFILES
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_perception.far_tracking import FIRST_ID

CAR = VehicleModel(half_length=2.45, half_width=0.95, wheelbase=2.9, wheel_lock=1.2)
S = np.arange(0.0, 200.0)
LINE = make_path(S, np.zeros(200), np.full(200, 8.0))
WAIT_S = 90.0
MEET_S = 100.0
AT_THE_LINE = WAIT_S - CAR.half_length - 1.0
TOP_MPS = 13.0
DT_S = 0.05


class Light:
    def __init__(self, state):
        self.state = state


def way(joins=False, goes_first=True, lights=()):
    """Comes from y = -90 to the route at x = 100; crosses it, or turns into it."""
    along = np.arange(0.0, 180.0)
    inside = np.minimum(along, 90.0)
    x = MEET_S + (along - inside if joins else np.zeros(180))
    y = -90.0 + (inside if joins else along)
    return ConflictPath(
        x=x,
        y=y,
        yaw=np.where(along < 90.0, np.pi / 2.0, 0.0 if joins else np.pi / 2.0),
        s=along,
        bend_mps=100.0,
        inside_s=82.0,
        meets_s=88.0,
        parts_s=92.0,
        route_meets_s=MEET_S - 2.0,
        route_parts_s=MEET_S + (8.0 if joins else 2.0),
        straight=True,
        joins=joins,
        approach=(1, 0, -1),
        goes_first=goes_first,
        lights=tuple(lights),
    )


def comers(*places):
    """(meters before the meeting, m/s) of cars on the other way."""
    away, speed = np.array(places, dtype=float).reshape(-1, 2).T
    zeros = np.zeros(len(away))
    return NearbyObjects(
        actor_id=tuple(range(len(away))),
        is_walker=np.zeros(len(away), dtype=bool),
        x=zeros + MEET_S,
        y=-2.0 - away,
        yaw=zeros + np.pi / 2.0,
        half_length=zeros + 2.4,
        half_width=zeros + 0.95,
        bottom=zeros,
        top=zeros + 1.5,
        vx=zeros,
        vy=speed,
    )


def look(around, s=AT_THE_LINE, speed=0.0, one=None, watch=None):
    watch = watch or JunctionYield([JunctionConflicts(WAIT_S, (one or way(),))], PROFILES["normal"], CAR)
    return watch.decide(LINE, s, EgoSpeeds(speed, TOP_MPS), around, DT_S)


def test_with_nobody_about_it_goes():
    assert look(comers()).wait_m is None


def test_yield_waits_at_line_for_conflicting_vehicle():
    """The ego waits at the line for a vehicle that it would meet."""
    assert look(comers((25.0, 8.0))).wait_m == pytest.approx(WAIT_S - AT_THE_LINE - CAR.half_length)


@pytest.mark.parametrize("around", [comers((85.0, 8.0)), comers((4.0, 12.0)), comers((25.0, 0.0))])
def test_yield_far_passed_or_stopped_vehicle_does_not_wait(around):
    """The ego goes before a far vehicle, behind one that is about to pass, and past a stopped one."""
    assert look(around).wait_m is None


def test_one_whom_it_passes_behind_is_no_reason_to_brake():
    assert look(comers((4.0, 12.0))).passing == {0}


def test_yield_without_right_of_way_waits_only_if_needed():
    """A vehicle that must yield is not waited for unless it cannot stop."""
    minor = way(goes_first=False)
    assert look(comers((16.0, 5.0)), one=minor).wait_m is None
    assert look(comers((28.0, 14.0)), s=WAIT_S - 10.0, speed=8.0, one=minor).wait_m is not None


def test_a_red_light_holds_those_who_can_still_stop():
    carla = pytest.importorskip("carla")
    red = [Light(carla.TrafficLightState.Red)]
    assert look(comers((16.0, 5.0)), one=way(lights=red)).wait_m is None
    assert look(comers((16.0, 5.0)), one=way(lights=[Light(carla.TrafficLightState.Green)])).wait_m is not None


def test_yield_after_long_wait_accepts_shorter_gap():
    """After a wait, the ego accepts a gap that was too short at first."""
    watch = JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR)
    gaps = [away for away in np.arange(20.0, 80.0, 0.5) if look(comers((away, 8.0)), watch=watch).wait_m is None]
    watch = JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR)
    for _ in range(round(PATIENCE_S / DT_S)):
        look(comers((25.0, 8.0)), watch=watch)
    smaller = [away for away in np.arange(20.0, 80.0, 0.5) if look(comers((away, 8.0)), watch=watch).wait_m is None]
    assert min(smaller) < min(gaps) - 1.0


def test_it_is_never_told_to_stop_where_the_ways_meet():
    for s in np.arange(AT_THE_LINE, MEET_S + 6.0, 0.5):
        wait_m = look(comers((20.0, 8.0)), s=float(s), speed=5.0).wait_m
        assert wait_m is None or s + CAR.half_length + wait_m <= MEET_S - 2.0


def test_yield_past_line_brakes_before_conflicting_merge():
    """Past the line, the ego still brakes before it would merge into a vehicle."""
    late = look(comers((16.0, 14.0)), s=93.0, speed=4.0, one=way(joins=True))
    assert late.wait_m == pytest.approx(MEET_S - 2.0 - 93.0 - CAR.half_length)


def test_yield_merge_follows_lead_but_not_before_faster_vehicle():
    """The ego joins a flow behind the vehicle that is then ahead, and not before a faster one."""
    joining = way(joins=True)
    verdict = look(comers((5.0, 10.0)), one=joining)
    assert verdict.wait_m is None and isinstance(verdict.leader, LeadVehicle) and verdict.leader.speed == 10.0
    assert look(comers((45.0, 14.0)), one=joining).wait_m is not None


def test_turn_statistics_unused_path_is_not_expected_far_away():
    """A path that no vehicle has taken so far is not expected of far vehicles."""
    one, other, habits = way(), way(joins=True), TurnStatistics()
    far, near = (vehicles_on_path(one, comers((away, 8.0)))[0] for away in (40.0, 12.0))
    assert habits.may_take(one, far)
    for actor in vehicles_on_path(other, comers((-1.0, 8.0), (-1.0, 8.0))):
        habits.observe([(other, actor)])
    assert not habits.may_take(one, far) and habits.may_take(one, near) and habits.may_take(other, far)


def test_yield_before_turn_slows_down_to_look():
    """Before a turn where others have priority, the ego slows down to look."""
    bend = make_path(S, np.zeros(200), np.where(np.abs(S - MEET_S) < 10.0, 5.5, 13.0))
    watch = JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR)
    verdict = watch.decide(bend, 50.0, EgoSpeeds(10.0, TOP_MPS), comers(), DT_S)
    assert verdict.look_m == pytest.approx(WAIT_S - 50.0 - CAR.half_length)
    fast = make_path(S, np.zeros(200), np.full(200, 13.0))
    watch = JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR)
    assert watch.decide(fast, 50.0, EgoSpeeds(10.0, TOP_MPS), comers(), DT_S).look_m is None


def sensed():
    return JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR, sensor_mode=True)


def test_flow_speed_averages_noise_but_keeps_other_speeds():
    """The noise of the speeds in a flow is averaged out; a vehicle with another speed keeps it."""
    one = way()
    seen = [
        (one, other) for other in vehicles_on_path(one, comers((10.0, 9.2), (30.0, 10.0), (50.0, 10.9), (70.0, 4.0)))
    ]
    assert [other.speed for _, other in with_flow_speed(seen)] == pytest.approx([9.6, 9.6, 9.6, 4.0])
    pair = seen[:2]
    assert with_flow_speed(pair) == pair


@pytest.mark.parametrize("past_m", [0.1, 0.5, 0.9])
def test_yield_sensor_mode_waits_after_creeping_past_line(past_m):
    """In sensor mode, an ego that crept past the place to wait still waits."""
    s = MEET_S - 2.0 - CAR.half_length + past_m
    coming = comers((10.0, 8.0))
    assert look(coming, watch=sensed(), s=s, speed=0.2).wait_m == 0.0
    assert look(coming, watch=sensed(), s=s, speed=3.0).wait_m is None, "too late"
    assert look(coming, s=s, speed=0.2).wait_m is None, "with ground truth it knows that it is in the way"


def test_yield_sensor_mode_goes_after_several_free_ticks():
    """In sensor mode, the ego sets off when the path has been free for several ticks."""
    watch = sensed()
    waits = [look(comers(), watch=watch).wait_m is not None for _ in range(10)]
    assert waits[0] and not waits[-1]
    assert sum(waits) == round(SETTLED_S / DT_S) - 1
    watch = sensed()
    flickering = [look(comers((20.0, 8.0)) if k % 3 == 0 else comers(), watch=watch).wait_m for k in range(40)]
    assert all(wait_m is not None for wait_m in flickering)


def test_lane_speed_prior_raises_speed_of_new_vehicle():
    """A new vehicle counts as no slower than those before it until its speed is measured."""
    one, paces = way(), LaneSpeedPrior()

    def seen(speed, actor_id):
        return [(one, other._replace(actor_id=actor_id)) for other in vehicles_on_path(one, comers((60.0, speed)))]

    for k in range(20):
        assert paces.with_prior_speed(seen(9.0, 1), DT_S * k)[0][1].speed == 9.0
        paces.with_prior_speed(seen(9.0, 1) + seen(36.0, FIRST_FAR_ID), DT_S * k)
    now_s = DT_S * 20
    assert paces.with_prior_speed(seen(5.0, 2), now_s)[0][1].speed == 9.0
    assert paces.with_prior_speed(seen(12.0, 3), now_s + DT_S)[0][1].speed == 12.0
    paces.with_prior_speed(seen(5.0, 4), now_s)
    assert paces.with_prior_speed(seen(5.0, 4), now_s + NEW_TRACK_S)[0][1].speed == 5.0, "by now it is measured"
    assert paces.with_prior_speed(seen(4.0, 5), now_s + NEW_TRACK_S + PACE_S)[0][1].speed == 4.0, "that was long ago"


@pytest.mark.parametrize(("others", "speed"), [(1, 36.0), (2, 11.0)], ids=["one drove there", "two did"])
def test_lane_speed_prior_caps_speed_of_camera_tracks(others, speed):
    """A vehicle that only the camera tracks counts as little faster than those that drove there.

    The camera's speed is an upper bound.
    """
    one, paces = way(), LaneSpeedPrior()

    def seen(speed, *ids):
        return [
            (one, other._replace(actor_id=k)) for k in ids for other in vehicles_on_path(one, comers((60.0, speed)))
        ]

    for k in range(20):
        paces.with_prior_speed(seen(9.0, *range(others)), DT_S * k)
    now_s = DT_S * 20
    assert paces.with_prior_speed(seen(36.0, FIRST_FAR_ID), now_s)[0][1].speed == speed
    assert paces.with_prior_speed(seen(36.0, FIRST_FAR_ID), now_s + MEMORY_S)[0][1].speed == 36.0, "that was long ago"


@pytest.mark.parametrize(("next_m", "goes_on"), [(90.0, True), (20.0, False)], ids=["a gap behind it", "another one"])
def test_yield_sensor_mode_going_ego_lets_passing_vehicle_pass(next_m, goes_on):
    """In sensor mode, an ego that has set off lets a passing vehicle pass and goes on."""
    watch = JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR, sensor_mode=True)
    while watch.decide(LINE, AT_THE_LINE, EgoSpeeds(0.0, TOP_MPS), comers(), DT_S).wait_m is not None:
        pass
    here = MEET_S - 2.0 - CAR.half_length - 1.2
    for _ in range(round(SETTLED_S / DT_S) + 1):
        found = watch.decide(LINE, here, EgoSpeeds(2.0, TOP_MPS), comers((2.0, 6.0), (next_m, 9.0)), DT_S)
    assert found.wait_m is not None
    assert watch.has_started is goes_on


@pytest.mark.parametrize(("first_id", "gives_up"), [(1, True), (FIRST_FAR_ID, False)], ids=["LiDAR", "camera only"])
def test_yield_sensor_mode_going_ego_stops_only_for_lidar_tracks(first_id, gives_up):
    """In sensor mode, an ego that has set off stops only for vehicles that the LiDAR measures."""
    watch = JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR, sensor_mode=True)
    while watch.decide(LINE, AT_THE_LINE, EgoSpeeds(0.0, TOP_MPS), comers(), DT_S).wait_m is not None:
        pass
    comes = replace(comers((20.0, 8.0)), actor_id=(first_id,))
    for _ in range(round(SETTLED_S / DT_S) + 1):
        found = watch.decide(LINE, AT_THE_LINE, EgoSpeeds(0.5, TOP_MPS), comes, DT_S)
    assert (found.wait_m is not None) is gives_up


def test_turn_statistics_ignore_camera_only_tracks():
    """The position of a vehicle that only the camera tracks says nothing about its path."""
    turning = way(joins=True)
    for first_id, taken in ((1, True), (FIRST_FAR_ID, False)):
        watch = JunctionYield([JunctionConflicts(WAIT_S, (way(), turning))], PROFILES["normal"], CAR, sensor_mode=True)
        for k in range(3):
            bodies = comers((-1.0, 8.0))
            look(replace(bodies, actor_id=(first_id + k,)), watch=watch, s=AT_THE_LINE - 5.0, speed=5.0)
        assert bool(watch._turn_statistics._observed_turns) is taken
    assert FIRST_FAR_ID == FIRST_ID


def least_lead_m(sensed):
    """How far off a car must be for an ego to set off before it, seven seconds before their ways join."""
    ramp = make_path(S, np.zeros(200), np.full(200, 4.0))
    for away_m in np.arange(90.0, 40.0, -1.0):
        watch = JunctionYield(
            [JunctionConflicts(WAIT_S - 30.0, (way(joins=True),))], PROFILES["normal"], CAR, sensor_mode=sensed
        )
        s = WAIT_S - 30.5 - CAR.half_length
        if watch.decide(ramp, s, EgoSpeeds(4.0, TOP_MPS), comers((away_m, 7.0)), DT_S).wait_m is not None:
            return away_m + 1.0
    raise AssertionError("it never waits")


def test_yield_sensor_mode_checks_gap_until_merged():
    """In sensor mode, a gap is checked until the ego has merged, even at the end of a long ramp."""
    assert least_lead_m(sensed=True) > least_lead_m(sensed=False) + 5.0


@pytest.mark.parametrize(
    "past_m, speed, stays", [(0.1, 1.2, True), (0.8, 0.0, True), (0.8, 3.0, False), (1.2, 0.5, False)]
)
def test_yield_sensor_mode_aborted_start_stays_near_line(past_m, speed, stays):
    """In sensor mode, an ego that aborts its start just past the line stays there."""
    s = WAIT_S - CAR.half_length + past_m
    to_the_way_m = MEET_S - 2.0 - WAIT_S - past_m
    coming = comers((25.0, 8.0))
    assert look(coming, watch=sensed(), s=s, speed=speed).wait_m == pytest.approx(0.0 if stays else to_the_way_m)
    assert look(coming, s=s, speed=speed).wait_m == pytest.approx(to_the_way_m), (
        "with ground truth it goes up to the way"
    )


def test_yield_sensor_mode_follower_on_common_path_is_no_lead():
    """In sensor mode, a follower on the common path is not a lead vehicle.

    The ego has joined before a car, and would brake to get behind it.
    """
    here = comers((0.0, 0.0))
    follower = replace(here, x=here.x + 3.0, y=np.zeros(1), yaw=np.zeros(1), vx=np.full(1, 10.0), vy=np.zeros(1))
    joining, s = JunctionConflicts(WAIT_S, (way(joins=True),)), MEET_S + 9.5
    told = [
        look(follower, s=s, speed=9.0, watch=JunctionYield([joining], PROFILES["normal"], CAR, sensor_mode=item))
        for item in (True, False)
    ]
    assert told[0].leader is None and told[0].wait_m is None
    assert told[1].leader is not None and told[1].leader.gap_m < -2.0 * CAR.half_length, "with ground truth it is one"


def test_yield_sensor_mode_noisy_tick_does_not_stop_going():
    """In sensor mode, an ego that has set off does not stop for one noisy tick."""
    noisy_s = SETTLED_S - DT_S
    for watch, looks in (
        (sensed(), round(noisy_s / DT_S)),
        (JunctionYield([JunctionConflicts(WAIT_S, (way(),))], PROFILES["normal"], CAR), 0),
    ):
        look(comers(), watch=watch, speed=2.0)
        assert watch.has_started
        goes = [look(comers((21.0, 8.0)), watch=watch, speed=2.0).wait_m is None for _ in range(10)]
        assert goes == [True] * looks + [False] * (10 - looks)


def test_yield_sensor_mode_new_vehicle_needs_measured_speed():
    """In sensor mode, the ego stops for a new vehicle only when its speed is measured."""
    for going in (False, True):
        watch = sensed()
        for k in range(20):
            passing = replace(comers((40.0 - 20.0 * DT_S * k, 20.0)), actor_id=(50,))
            look(passing, watch=watch, s=AT_THE_LINE - 20.0, speed=8.0)
        if going:
            look(comers(), watch=watch, speed=2.0)
        assert watch.has_started is going
        new = replace(comers((60.0, 8.0)), actor_id=(51,))
        waits = [look(new, watch=watch, speed=2.0).wait_m is not None for _ in range(5)]
        assert waits == [not going] * 5


@pytest.mark.integration
def test_yield_sensor_mode_goes_on_into_accepted_gap():
    """In sensor mode, the ego goes on into the gap that it accepted after a long wait.

    It needs some tenths of a second to set off: once, not again at each tick.
    """
    watch = sensed()
    for _ in range(round(PATIENCE_S / DT_S)):
        assert look(comers((25.0, 8.0)), watch=watch).wait_m is not None
    away_m = min(item for item in np.arange(20.0, 80.0, 0.25) if _settles(watch, item))
    told, s, speed = [], AT_THE_LINE, 0.0
    for k in range(60):
        told.append(look(comers((away_m - 8.0 * DT_S * k, 8.0)), watch=watch, s=s, speed=speed).wait_m)
        speed += 3.3 * DT_S if k * DT_S > START_LAG_S else 0.0
        s += speed * DT_S
    assert told == [None] * 60


def test_yield_sensor_mode_early_ego_keeps_its_gap():
    """In sensor mode, an ego that is early lets one vehicle pass and keeps its gap."""
    watch, near = sensed(), MEET_S - 2.0 - CAR.half_length - 1.0
    for _ in range(5):
        look(comers((70.0, 10.0)), watch=watch, s=near)
    for _ in range(5):
        assert look(comers((4.5, 10.0), (60.0, 10.0)), watch=watch, s=near, speed=0.3).wait_m == pytest.approx(1.0)
        assert watch.has_started
    for _ in range(5):
        look(comers((4.5, 10.0), (20.0, 10.0)), watch=watch, s=near, speed=0.3)
    assert not watch.has_started, "before the second one the gap is too short"


def _settles(watch, away_m):
    """True if a standing ego sets off before one that comes from there; if it does not, it has not moved."""
    waits = [look(comers((away_m, 8.0)), watch=watch).wait_m for _ in range(4)]
    return waits[-1] is None
