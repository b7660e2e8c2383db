"""Each excuse of the closed-loop oracle: a drive that it covers, and a drive alike that it must not cover.

The drives obey fixed orders, without a guard, until the first contact.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from grids import each_value
from lab.benchmarks.guard_oracle import causes
from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.campaign import proposal_of
from lab.benchmarks.guard_oracle.case import Case
from lab.benchmarks.guard_oracle.contact import contact_with
from lab.benchmarks.guard_oracle.counterfactual import stop_avoids
from lab.benchmarks.guard_oracle.drive import drive, judged
from lab.benchmarks.guard_oracle.others import AlongLane
from lab.benchmarks.guard_oracle.recording import Recording, copied
from lab.benchmarks.guard_oracle.road import Road, lanes_of
from lab.benchmarks.guard_oracle.scene import Setting, at_the_kerb, crossing, driving, number_of, standing
from lab.benchmarks.guard_oracle.vehicle import LENGTH_M, Manner
from lab.benchmarks.guard_oracle.world import DT, World
from stucksolver.plan import Execute
from stucksolver.plan.behaviors import KeepLane, Wait
from stucksolver.plan.directive import PathPoint
from stucksolver.scene import ObjectKind, ZoneKind

EGO_S = 60.0
STREET = Road("street", [(330.0, 0.0)], lanes_of("multi"))
RAILS = Road("rails", [(330.0, 0.0)], lanes_of("multi"), [(ZoneKind.LEVEL_CROSSING, EGO_S - 4.0, EGO_S + 4.0)])
STOP = Execute(behavior=Wait(duration_s=1.0), brake_mps2=3.0)
K = ObjectKind


def along(mps, offset=lambda s: 0.0):
    """An order to drive along the road at this speed, at an offset to the left that depends on the arc length."""
    points = tuple(PathPoint(x_m=s, y_m=offset(s), speed_mps=mps) for s in (EGO_S - 1.0 + 0.5 * k for k in range(300)))
    return Execute(behavior=KeepLane(distance_m=100.0, speed_mps=max(mps, 1.0)), path=points)


def case_of(setting, orders, manner=None, silent_from=math.inf, again=lambda _: True):
    """Drives until a contact. `orders`: (order, its duration in s), in turn."""
    world = World(setting, manner or Manner(keen=1.0, eager=1.0))
    recording = Recording(world, silent_from)
    for order, lasts_s in orders:
        for _ in range(round(lasts_s / DT)):
            recording.orders.append(order)
            world.step(order)
            hit = world.touched()
            if hit is not None:
                return Case(contact_with(world, hit, "Execute"), recording, again)
    raise AssertionError("no contact")


def crosses_slowly(reach_m, mps=8.0, pace=1.2, kind=K.CAR, meets_s=12.0, stops_at_s=25.0):
    """A slow ego is hit in its side by a steady vehicle from the left, which is visible within this distance."""
    car = crossing("car", STREET, EGO_S + LENGTH_M / 2 + 10.0, mps * meets_s, -math.pi / 2, mps, "crosses", kind)
    setting = Setting(STREET, [car], ego_s=EGO_S, ego_speed=pace, reach_m=reach_m)
    return case_of(setting, [(along(pace), stops_at_s), (STOP, 25.0)])


@pytest.mark.parametrize(
    ("mps", "kind", "pace"), each_value([5.0, 8.0, 13.0], [K.CAR, K.TRUCK, K.MOTORCYCLE], [0.9, 1.2])
)
def test_crosser_is_excused_only_if_first_visible_too_late(mps, pace, kind):
    """The nose is in its lane a few seconds before the contact: seen later, no stop avoids it."""
    late = crosses_slowly(mps * 1.5, mps, pace, kind)
    early = crosses_slowly(mps * 9.0, mps, pace, kind)
    assert causes.excused_by(late) and causes.hidden_crosser(late)
    assert causes.excused_by(early) is None
    assert late.contact == early.contact


@pytest.mark.integration
def test_crosser_is_excused_up_to_one_distance_and_no_further():
    """Let it be visible earlier and earlier: the verdict changes once."""
    verdicts = [causes.hidden_crosser(crosses_slowly(reach)) for reach in range(10, 95, 14)]
    assert verdicts[0] and not verdicts[-1]
    assert sorted(verdicts, reverse=True) == verdicts


def test_crosser_in_sight_when_the_plan_began_is_never_excused():
    """A stop at the start is always possible; that the vehicle is in its way from the start makes no difference."""
    case = crosses_slowly(500.0, mps=13.0)
    assert case.first_visible == 0 and causes.excused_by(case) is None


@pytest.mark.integration
def test_figures_report_visible_time_and_latest_stop():
    """The figures report how long the vehicle was visible and the latest stop that avoids it."""
    case = crosses_slowly(60.0, mps=6.0)
    figures = case.figures()
    assert figures["visible_s"] == pytest.approx(10.0, abs=1.5)
    assert 1.0 < figures["stop_s"] < figures["visible_s"]
    assert crosses_slowly(9.0, mps=6.0).figures()["stop_s"] is None


@pytest.mark.release
@pytest.mark.integration
@pytest.mark.slow
def test_stop_in_the_way_of_another_vehicle_does_not_count():
    """A second vehicle, on the other lane, hits the ego wherever it stops since the first is in sight."""
    case = crosses_slowly(60.0, mps=6.0)
    assert not causes.hidden_crosser(case)
    for k, lane_s in enumerate((-2.0, 1.0, 4.0, 7.0, 10.0, 13.0)):
        more = crossing(f"more{k}", STREET, EGO_S + lane_s, -6.0 * 13.0, math.pi / 2, 6.0, "crosses")
        case.recording.start.others.append(more)
    case = case_of(case.recording.start.setting, [(along(1.2), 25.0)])
    assert case.contact.name == "car" and causes.hidden_crosser(case)


def steps_out(reach_m, mps=4.0):
    """Somebody walks into the path of the ego's front."""
    walker = crossing("walker", STREET, EGO_S + 16.0, -4.0, math.pi / 2, 1.2, "walks", K.PEDESTRIAN)
    setting = Setting(STREET, [walker], ego_s=EGO_S, ego_speed=mps, reach_m=reach_m)
    return case_of(setting, [(along(mps), 8.0)])


def test_pedestrian_is_excused_only_if_hidden_within_a_stopping_distance():
    assert causes.steps_out(steps_out(4.0)) and causes.excused_by(steps_out(4.0))
    assert causes.excused_by(steps_out(12.0)) is None
    assert causes.excused_by(steps_out(100.0)) is None


@pytest.mark.integration
def test_through_body_is_void_only_if_no_stop_avoids():
    """A contact with a vehicle that drove through another body is void only if no stop avoids it."""

    def case(reach_m):
        late = crosses_slowly(reach_m)
        setting = late.recording.start.setting
        setting.others.append(standing("pillar", STREET, setting.others[0].body.x, 30.0, K.CONE))
        return case_of(setting, [(along(1.2), 25.0)])

    assert causes.through(case(9.0))
    assert not causes.through(case(80.0)) and causes.excused_by(case(80.0)) is None


def behind_a_leader(path, follows=False, gap=14.0, brakes_at=2.0, mps=5.0):
    """The ego runs into a leader that brakes."""
    lead = driving("lead", STREET, EGO_S + LENGTH_M / 2 + 2.3 + gap, 0.0, mps, "leads", brakes_at=brakes_at)
    setting = Setting(STREET, [lead], ego_s=EGO_S, ego_speed=mps)
    return case_of(setting, [(path, 20.0)], Manner(follows=follows))


def test_leader_is_excused_only_if_a_following_stack_avoids_it():
    assert causes.leads(behind_a_leader(along(5.0)))
    assert causes.excused_by(behind_a_leader(along(5.0), gap=0.4, brakes_at=0.0)) is None


def test_leader_in_the_lane_that_the_plan_enters_is_followed():
    """Only the path in force counts: it leads into the leader's lane, and stays there."""
    into = along(5.0, lambda s: 3.5 * min(max((s - EGO_S - 4.0) / 14.0, 0.0), 1.0))
    lead = driving("lead", STREET, EGO_S + 20.0, 3.5, 4.0, "goes beside us", brakes_at=1.0)
    setting = Setting(STREET, [lead], ego_s=EGO_S, ego_speed=4.0)
    case = case_of(setting, [(along(4.0), 0.5), (into, 20.0)])
    assert case.contact.their_part == "rear" and causes.leads(case)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("back", [False, True])
def test_leader_that_the_plan_swings_round_is_not_excused(side, back):
    """The path leads past it, with or without a return, but too late."""

    def swings(s):
        out = min(max((s - EGO_S - 24.0) / 12.0, 0.0), 1.0)
        return side * 3.5 * (out - min(max((s - EGO_S - 60.0) / 12.0, 0.0), 1.0) * back)

    case = behind_a_leader(along(5.0, swings))
    assert case.contact.their_part == "rear"
    assert not causes.leads(case) and causes.excused_by(case) is None


def passed_by_a_bike(room, drift):
    """A motorcycle filters past on the left while the ego drifts that way."""
    d = 1.85 / 2 + 0.4 + room
    bike = driving("bike", STREET, EGO_S - 20.0, d, 9.0, "filters past us", K.MOTORCYCLE, answers="never")
    setting = Setting(STREET, [bike], ego_s=EGO_S, ego_speed=4.0)
    return case_of(setting, [(along(4.0), 10.0)], Manner(drift=drift, drift_rate=0.25, drifts_from=2.2))


def test_filtering_vehicle_is_excused_only_with_narrow_gap():
    """A vehicle that filters past is excused only if its gap is narrower than assumed."""
    assert causes.filters(passed_by_a_bike(0.1, 0.4))
    wide = passed_by_a_bike(0.2, 0.8)
    assert not causes.filters(wide) and causes.excused_by(wide) is None


def test_filtering_vehicle_is_not_excused_if_stop_avoids(monkeypatch):
    """A vehicle that filters past is not excused if a stop avoids it."""
    case = passed_by_a_bike(0.1, 0.4)
    monkeypatch.setattr(type(case), "no_stop_avoids", lambda *_: False)
    assert not causes.filters(case)


def sets_off(lead_s, cruise=4.0, ahead_m=10.0):
    """A vehicle that stands at the side sets off into the ego's path, this long before the ego is there."""
    meets_s = (ahead_m - LENGTH_M / 2) / 3.0
    more = {"sets_off_at": max(meets_s - lead_s, 0.1), "cruise": cruise}
    car = crossing("car", STREET, EGO_S + ahead_m, -4.0, math.pi / 2, 0.0, "crosses", **more)
    setting = Setting(STREET, [car], ego_s=EGO_S, ego_speed=3.0)
    return case_of(setting, [(along(3.0), 12.0)])


def test_vehicle_setting_off_is_excused_only_if_alongside():
    """A vehicle that sets off is excused only if the ego was alongside.

    It was visible, at rest, all the time: the stop counts from when it moves.
    """
    late, early = sets_off(-0.3), sets_off(5.0, cruise=0.35, ahead_m=20.0)
    assert late.first_visible == early.first_visible == 0
    assert causes.sets_off(late) and causes.excused_by(late)
    assert causes.excused_by(early) is None


def test_setting_off_pedestrian_or_short_stop_is_not_excused():
    """Setting off is no excuse for a pedestrian or for a vehicle that had hardly stopped.

    A pedestrian steps off at any time (A5), and a vehicle that hardly stops has not stopped for a road user.
    """
    on_foot, hardly = sets_off(-0.3), sets_off(-0.3)
    on_foot.contact.kind = "pedestrian"
    assert not causes.sets_off(on_foot)
    hardly.recording.start.others[0].stood = -hardly.contact.t
    assert not causes.sets_off(hardly)


def test_crosser_is_not_excused_if_own_stop_caused_contact():
    """A crossing vehicle is not excused if the ego stopped in its path without need.

    No stop avoided the contact any more when it became visible, but going on would have: the guard's own stop was the
    fault.
    """
    goes_on, stops = crosses_slowly(25.0, pace=1.2), crosses_slowly(25.0, pace=2.5, meets_s=8.5, stops_at_s=5.5)
    assert causes.hidden_crosser(goes_on)
    assert stops.stops.latest(stops.first_visible or 0) is None
    assert not causes.hidden_crosser(stops)


def between(late_m=24.0, again=lambda _: True):
    """The ego stops for somebody in the far lane who comes into sight late, in the path of somebody in the near one."""
    far = crossing("far", STREET, EGO_S + LENGTH_M / 2 + 14.0, -66.0, math.pi / 2, 6.0, "crosses")
    near = crossing("near", STREET, EGO_S + LENGTH_M / 2 + 9.5, 60.0, -math.pi / 2, 4.0, "crosses")
    setting = Setting(STREET, [far, near], ego_s=EGO_S, ego_speed=1.2, reach_m=150.0)
    corner = Body(EGO_S + 10.0, -late_m - 10.0, 0.0, 20.0, 20.0)
    setting.walls.append((corner, 9.0))
    return case_of(setting, [(along(1.2), 9.6), (STOP, 12.0)], again=again)


def test_caught_between_is_excused_only_without_late_vehicle():
    """A yielding vehicle is excused only if the run without the late vehicle has no contact."""
    asked = []
    case = between(again=lambda names: asked.append(names) or True)
    assert case.contact.name == "near" and case.came_into_sight.keys() == {"far"}
    assert causes.caught_between(case) and asked == [frozenset({"far"})]
    assert not causes.caught_between(between(again=lambda _: False))


@pytest.mark.parametrize(("room_m", "avoids"), [(0.3, True), (0.05, False)])
def test_stop_that_leaves_no_room_to_who_crosses_avoids_nothing(room_m, avoids):
    car = crossing("car", STREET, EGO_S + LENGTH_M / 2 + 0.95 + room_m, 30.0, -math.pi / 2, 8.0, "crosses")
    world = World(Setting(STREET, [car], ego_s=EGO_S), Manner())
    assert stop_avoids(world, "car", 3.0, 4.0) is avoids


def silent_case(orders, silent_from, awake=True, reach_m=200.0):
    """A slow ego is hit by a crossing vehicle, with a solver that falls silent."""
    case = crosses_slowly(reach_m)
    return case_of(copied(case.recording.start).setting, orders, None, silent_from, lambda _: awake)


@pytest.mark.integration
def test_silence_is_excused_only_after_commit_point_of_good_plan():
    """Silence is an excuse only past the commit point, and only if the plan is good."""
    path = along(1.2)
    assert causes.silent(silent_case([(path, 25.0)], 2.0))
    assert not causes.silent(silent_case([(path, 25.0)], 2.0, awake=False))
    assert not causes.silent(silent_case([(path, 25.0)], math.inf))
    stands = silent_case([(path, 10.5), (STOP, 15.0)], 10.0)
    assert not causes.silent(stands)


def test_silence_is_no_excuse_within_the_lease_or_without_sight():
    path = along(1.2)
    contact_s = silent_case([(path, 25.0)], 2.0).contact.t
    assert not causes.silent(silent_case([(path, 25.0)], contact_s - 0.3))
    assert not causes.silent(silent_case([(path, 25.0)], 2.0, reach_m=9.0))


def runs_into_us(stands_s, role="follows us", mps=5.0):
    """Somebody from behind, who never brakes, hits an ego that has stood for about this long."""
    away = LENGTH_M / 2 + 2.3 + 3.0 + mps * stands_s
    more = {"answers": "never"}
    car = driving("car", STREET, EGO_S - away, 0.0, mps, role, **more)
    setting = Setting(STREET, [car], ego_s=EGO_S, ego_speed=1.0)
    return case_of(setting, [(STOP, 20.0)])


def test_rear_end_contact_is_excused_only_if_avoidable():
    """A vehicle that hits the stopped ego is excused only if that vehicle was able to stop."""
    assert causes.runs_into_us(runs_into_us(4.0))
    assert causes.excused_by(runs_into_us(0.6)) is None
    assert causes.excused_by(runs_into_us(4.0, role="comes up in the lane entered")) is None


@pytest.mark.integration
@pytest.mark.parametrize(("reach_m", "excused"), [(38.0, True), (90.0, False)])
def test_crosser_hitting_stopped_ego_is_excused_only_if_late(reach_m, excused):
    """A crossing vehicle that hits the stopped ego is excused only if it was visible late.

    The ego stops in its lane for 4 s. With sight from afar, it could have stopped short of the lane.
    """
    car = crossing("car", STREET, EGO_S + 11.0, 8.0 * 12.5, -math.pi / 2, 8.0, "crosses")
    setting = Setting(STREET, [car], ego_s=EGO_S, ego_speed=1.2, reach_m=reach_m)
    case = case_of(setting, [(along(1.2), 7.5), (STOP, 12.0)])
    assert (case.last - case.stands_since) * DT >= 3.0 and case.contact.ego_speed == 0.0
    assert (causes.excused_by(case) is not None) is excused


def train_hits(leader_gap, leader_mps):
    """A train hits an ego that began on the rails behind a leader."""
    rear = EGO_S + LENGTH_M / 2 + leader_gap
    lead = driving("lead", RAILS, rear + 2.3, 0.0, leader_mps, "leads")
    size = (40.0, 2.7, 3.6)
    train = crossing("train", RAILS, EGO_S, 20.0 + 10.0 * 5.0, -math.pi / 2, 10.0, "train", K.UNKNOWN, size)
    setting = Setting(RAILS, [lead, train], ego_s=EGO_S, ego_speed=0.3)
    return case_of(setting, [(along(0.3), 20.0)], Manner(follows=True))


@pytest.mark.integration
def test_train_is_excused_only_if_lead_leaves_no_gap():
    """A train is excused only behind a lead vehicle that leaves no gap."""
    assert causes.trapped(train_hits(1.5, 0.3))
    assert not causes.trapped(train_hits(3.0, 4.0)) and causes.excused_by(train_hits(3.0, 4.0)) is None


def kerb(trigger, stops_after=math.inf, mps=5.0, d=-2.0):
    """Somebody steps off the kerb when the front is this far away (m)."""
    walker = at_the_kerb("walker", EGO_S + 15.0, d, trigger)
    setting = Setting(STREET, [walker], ego_s=EGO_S, ego_speed=mps)
    return case_of(setting, [(along(mps), min(stops_after, 10.0)), (STOP, 10.0)])


def test_step_off_into_side_is_excused_and_front_is_not():
    """A pedestrian who steps into the ego's side is excused; one hit by the front is not."""
    assert causes.into_our_side(kerb(0.3))
    front = kerb(4.0)
    assert front.contact.part == "front" and causes.excused_by(front) is None


def test_step_off_into_a_front_that_stands_is_excused():
    """It comes to rest before the pedestrian reaches it."""
    case = kerb(1.75, stops_after=3.1, mps=3.4, d=-3.5)
    assert case.contact.ego_speed == 0.0 and case.contact.part == "front"
    assert causes.excused_by(case) is not None
    case.frames[-2:] = [replace(frame, ego_speed=0.5) for frame in case.frames[-2:]]
    assert not causes.into_our_front(case)


def test_ego_moving_side_into_step_off_is_not_excused():
    """An ego that pushes its side into a pedestrian who steps off is not excused.

    The ego's own lateral move closes the gap.
    """
    case = kerb(0.3)
    before = case.frames[-2]
    case.frames[-1] = replace(case.frames[-1], other=replace(before.other, x=before.other.x - 0.2))
    case.frames[-1].ego.y -= 0.07
    assert not causes.into_our_side(case)


def test_every_excuse_names_what_it_represents():
    assert len(causes.EXCUSES) == 12
    assert all("Represents" in (holds.__doc__ or "") for holds in causes.EXCUSES.values())


@pytest.mark.integration
@pytest.mark.parametrize(
    "name", [pytest.param("slow in a junction", marks=pytest.mark.release), "waits at a junction, then moves off"]
)
def test_recording_driven_again_ends_in_the_same_contact(name):
    """The first contact of the class, excused or not."""
    for number, k in itertools.product(range(80), range(1, 6)):
        proposal = proposal_of(77, number_of(name, number), k)
        execution, verdict = judged(proposal.world, proposal.plan, proposal.guided)
        ended = drive(proposal.world, execution, proposal.silent) if verdict.accepted else None
        if ended is not None and ended.recording is not None:
            break
    else:
        pytest.fail("no contact in 400 proposals")
    before = [replace(other.body) for other in ended.recording.start.others]
    *_, world = ended.recording.worlds()
    assert contact_with(world, world.touched(), ended.contact.order) == ended.contact
    assert [other.body for other in ended.recording.start.others] == before


def test_stop_of_a_copy_leaves_the_world_as_it_is():
    case = crosses_slowly(60.0)
    before = copied(case.recording.start)
    assert case.no_stop_avoids(0) is False
    start = case.recording.start
    assert (start.ego.x, start.ego.speed, start.t) == (before.ego.x, before.ego.speed, before.t)
    assert [o.body for o in start.others] == [o.body for o in before.others]
    assert not any(isinstance(o, AlongLane) for o in start.others)
