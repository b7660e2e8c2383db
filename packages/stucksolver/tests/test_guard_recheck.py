"""While a plan runs: what ends it before the commit point, and what may still end it afterwards."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from guard_cases import commit_s
from stucksolver.guard import Guard, RejectCode
from stucksolver.guard import guard as guard_module
from stucksolver.guard.abort_stops import braking_profile
from stucksolver.guard.collision_mitigation import FINISH, _drawn_against
from stucksolver.guard.context import CheckContext
from stucksolver.guard.prediction import gaps_at_heading, is_on_drift_side
from stucksolver.guard.verdict import OK, RejectReason, Verdict
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import AbortAction, BorrowOncomingLane, ChangeLane, KeepLane, Wait
from stucksolver.scene import ControlKind, LightState, LineKind, ObjectKind, TrafficControl
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from worlds import LANE_M, World, red_light, straight_road, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
pytestmark = pytest.mark.usefixtures("alike")
GUARD = Guard()
BORROW = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
LEFT = ChangeLane(side="left", distance_m=60.0, speed_mps=5.0)
RIGHT = ChangeLane(side="right", distance_m=25.0, speed_mps=5.0)
ONCOMING = thing("oncoming", 120.0, LANE_M, speed=-10.0)


def begin(behaviors, world):
    verdict, proven = GUARD.accept(behaviors, world.view(), guided=False)
    assert proven is not None, str(verdict)
    return proven


def borrowing():
    world = World(TWO_WAY, [thing("lead", 72.0)])
    return world, begin([BORROW], world)


def put(world, proven, s, speed=None):
    """The ego on its path at an arc length, as one comes there, and as quick as the path lets it be if not told."""
    body = proven.path.body(0.0, world.ego().limits.wheelbase_m)
    world.yaw = float(np.interp(s, proven.path.s, body))
    world.x, world.y = s, float(np.interp(s, proven.path.s, proven.path.d))
    world.speed = 3.0 if speed is None else speed
    return world


def stations(proven, start, end, step=1.0):
    """Arc lengths on the path between two of them."""
    return np.arange(max(start, proven.path.s[0]), min(end, proven.path.end_s - 1.0), step)


def test_while_nothing_changes_the_plan_stands_from_start_to_end():
    world, proven = borrowing()
    for s in stations(proven, 0.0, 1e9):
        assert GUARD.recheck(proven, put(world, proven, s).view()).accepted, s


def test_an_oncoming_car_before_the_commit_point_means_stop():
    world, proven = borrowing()
    world.objects.append(ONCOMING)
    for s in stations(proven, 0.0, commit_s(proven) - 0.01, 0.2):
        verdict = GUARD.recheck(proven, put(world, proven, s, 1.0).view())
        assert verdict.abort is AbortAction.STOP
        assert RejectCode.ONCOMING_GAP in {r.code for r in verdict.rejects}


@pytest.mark.integration
@pytest.mark.parametrize("others", [[ONCOMING], [thing("wreck", 78.0, LANE_M, kind=ObjectKind.BARRIER)]])
def test_recheck_after_commit_point_does_not_stop_in_oncoming_lane(others):
    """After the commit point, the ego does not stop in the oncoming lane."""
    world, proven = borrowing()
    world.objects += others
    world.controls = (red_light(60.0),)
    lane = proven.path.enters[0]
    aborts = set()
    for s in stations(proven, commit_s(proven), 1e9):
        view = put(world, proven, s).view()
        verdict = GUARD.recheck(proven, view)
        aborts.add(verdict.abort)
        reaches_in = view.ego_d + view.ego.width_m / 2 > lane.at(s)[0] + 0.2
        assert not (reaches_in and verdict.abort is AbortAction.STOP)
    assert aborts - {None, AbortAction.STOP}


def test_recheck_gap_behind_obstacle_allows_return_to_lane():
    """With a gap behind the obstacle, the ego returns to its lane."""
    world, proven = borrowing()
    world.objects.append(thing("oncoming", 150.0, LANE_M, speed=-12.0))
    beyond = 72.0 + 2.3 + 2.45 + 3.0
    verdict = GUARD.recheck(proven, put(world, proven, beyond, 4.0).view())
    if not verdict.accepted:
        assert verdict.abort in (AbortAction.RETURN_TO_LANE, AbortAction.FINISH)
    assert GUARD.way_back(world.view()) is not None


def test_beside_the_obstacle_there_is_no_way_back():
    world, proven = borrowing()
    assert GUARD.way_back(put(world, proven, 70.0).view()) is None


def test_commit_point_is_before_body_enters_other_lane():
    """The commit point comes before the body enters the other lane."""
    world, proven = borrowing()
    lane = proven.path.enters[0]
    first = next(
        s
        for s, d in zip(proven.path.s, proven.path.d, strict=True)
        if d + world.ego().width_m / 2 > lane.at(float(s))[0] + 0.05
    )
    assert world.x <= commit_s(proven) < first


def test_commit_point_of_double_lane_change_is_at_leaving():
    """A lane change there and back commits only when it leaves the lane."""
    world = World(MULTI, [thing("lead", 72.0)])
    proven = begin([LEFT, RIGHT], world)
    assert commit_s(proven) > world.x
    world.objects.append(thing("quick", 20.0, LANE_M, speed=13.0))
    verdict = GUARD.recheck(proven, put(world, proven, world.x, 0.5).view())
    assert verdict.abort is AbortAction.STOP
    assert {r.code for r in verdict.rejects} == {RejectCode.LANE_ENTRY}


def test_commit_point_is_none_within_own_lane():
    """A path that never leaves the lane has no commit point."""
    assert commit_s(begin([KeepLane(distance_m=30.0, speed_mps=5.0)], World(TWO_WAY))) is None


@pytest.mark.parametrize("committed", [False, True])
def test_a_light_that_turns_red_ahead_is_stopped_for(committed):
    world = World(MULTI, controls=(red_light(50.0, LightState.GREEN),))
    proven = begin([LEFT], world)
    at = proven.path.s[0] if not committed else commit_s(proven) + 20.0
    put(world, proven, at)
    world.controls = (red_light(30.0, LightState.GREEN),)
    assert GUARD.recheck(proven, world.view()).accepted
    world.controls = (red_light(20.0, LightState.YELLOW),)
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.STOP
    assert RejectCode.RED_LIGHT in {r.code for r in verdict.rejects}


def sign(distance):
    return TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=distance, applies=True)


@pytest.mark.parametrize("committed", [False, True])
@pytest.mark.parametrize("control", [sign, partial(red_light, state=LightState.OFF)])
def test_recheck_dark_light_or_new_stop_sign_stops(control, committed):
    """A light that goes dark or a sign that becomes visible is stopped at."""
    world = World(MULTI, controls=(red_light(50.0, LightState.GREEN),))
    proven = begin([LEFT], world)
    put(world, proven, proven.path.s[0] + 1.0 if not committed else commit_s(proven) + 20.0)
    world.controls = (control(20.0),)
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.STOP
    assert {r.code for r in verdict.rejects} == {RejectCode.STOP_LINE}


@pytest.mark.parametrize("control", [sign, partial(red_light, state=LightState.OFF)])
def test_a_line_that_was_stopped_at_is_crept_over(control):
    world = World(TWO_WAY, controls=(control(3.0),))
    proven = begin([KeepLane(distance_m=20.0, speed_mps=2.0)], world)
    for way in np.arange(0.0, 5.0, 0.25):
        world.controls = (control(3.0 - way),)
        assert GUARD.recheck(proven, put(world, proven, 50.0 + way, 1.5).view()).accepted, way


def test_a_light_too_near_to_stop_at_is_past_mending():
    world = World(TWO_WAY)
    proven = begin([KeepLane(distance_m=40.0, speed_mps=5.0)], world)
    put(world, proven, 60.0, speed=5.0)
    world.controls = (red_light(1.0, LightState.YELLOW),)
    assert GUARD.recheck(proven, world.view()).accepted
    world.controls = (red_light(6.0, LightState.YELLOW),)
    assert GUARD.recheck(proven, world.view()).abort is AbortAction.STOP


def test_old_news_before_the_commit_point_means_stop():
    world, proven = borrowing()
    world.age_s = 1.0
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.STOP
    assert [r.code for r in verdict.rejects] == [RejectCode.STALE]


def test_strayed_into_the_oncoming_lane_there_is_no_stop():
    world = World(TWO_WAY, y=0.0)
    proven = begin([KeepLane(distance_m=40.0, speed_mps=5.0)], world)
    world.x, world.y = 60.0, 2.5
    verdict = GUARD.recheck(proven, world.view())
    assert [r.code for r in verdict.rejects] == [RejectCode.DEVIATION]
    assert verdict.abort is AbortAction.RETURN_TO_LANE


def test_recheck_pedestrian_stepping_out_stops_path_in_lane():
    """A pedestrian who steps out stops a path in the ego's lane."""
    world = World(TWO_WAY)
    proven = begin([KeepLane(distance_m=40.0, speed_mps=5.0)], world)
    world.objects.append(thing("walker", 75.0, -3.0, kind=ObjectKind.PEDESTRIAN, sideways=1.0))
    verdict = GUARD.recheck(proven, put(world, proven, 60.0).view())
    assert verdict.abort is AbortAction.STOP
    assert verdict.rejects[0].object_id == "walker"


def nosing_in(gap_m, speed, reaches_m=0.3, giving_way=False, own_mps=1.5, sd_m=None):
    """A slow change of lanes whose nose is in the next lane, and somebody in it so far behind the nose."""
    world = World(MULTI)
    proven = begin([ChangeLane(side="left", distance_m=60.0, speed_mps=1.5)], world)
    s = float(proven.path.s[int(np.argmax(proven.path.d > reaches_m))]) + 0.05
    put(world, proven, s, own_mps)
    behind = thing("behind", s + 2.45 - gap_m - 2.3, LANE_M, speed=speed)
    world.objects.append(behind.model_copy(update={"position_sd_m": sd_m}))
    assert proven.committed(s)
    return GUARD.recheck(proven, world.view(), giving_way)


def test_recheck_follower_not_yielding_is_let_pass_with_gap():
    """A follower that does not yield is let pass while a gap is left beside the ego's front."""
    assert nosing_in(12.0, 10.0).abort is AbortAction.YIELD
    assert nosing_in(12.0, 10.0, reaches_m=1.2).abort is not AbortAction.YIELD, "no room is left: the way is finished"


def test_who_can_still_stop_behind_us_is_not_waited_for():
    assert nosing_in(45.0, 10.0).accepted
    assert nosing_in(12.0, 1.0).accepted


@pytest.mark.integration
def test_going_on_takes_a_longer_gap_than_giving_way():
    gaps = np.arange(10.0, 110.0, 2.0)
    ends = []
    for giving_way in (False, True):
        verdicts = [nosing_in(gap, 10.0, 0.6, giving_way, own_mps=0.0) for gap in gaps]
        waits = [verdict.abort is AbortAction.YIELD for verdict in verdicts]
        ends.append(gaps[int(np.argmin(waits))])
        assert not any(waits[int(np.argmin(waits)) :])
    assert 20.0 < ends[0] < ends[1] < 100.0


def test_recheck_yielding_front_goes_on_up_to_conflict_path():
    """With distance left before the follower's path, the ego goes on up to it."""
    assert nosing_in(12.0, 10.0, 0.1, giving_way=True, own_mps=0.0).accepted
    assert nosing_in(12.0, 10.0, 0.6, giving_way=True, own_mps=0.0).abort is AbortAction.YIELD


def test_recheck_sensor_mode_yields_until_named_vehicle_has_passed():
    """In sensor mode, the ego yields until the named vehicle has passed.

    Before, a tick without a rejection let the ego go on, 20 m before a car at 12 m/s whose tracked position varied.
    """
    named, other = frozenset({"behind"}), frozenset({"other"})
    seen = [nosing_in(20.0, 12.0, 0.1, to, own_mps=0.0, sd_m=0.05) for to in (named, other, False)]
    assert [verdict.abort is AbortAction.YIELD for verdict in seen] == [True, False, False]
    assert nosing_in(90.0, 12.0, 0.1, named, own_mps=0.0, sd_m=0.05).accepted
    assert nosing_in(20.0, 12.0, 0.1, named, own_mps=0.0).accepted, "exact sight decides later"


@pytest.mark.parametrize(("sd_m", "second"), [(0.05, {"a", "b"}), (None, {"b"})])
def test_recheck_sensor_mode_keeps_named_vehicles_while_yielding(monkeypatch, sd_m, second):
    """In sensor mode, a vehicle that was named once stays named while the ego yields."""
    world, asked = World(MULTI), []
    running = Execution(RecoveryPlan(behaviors=(LEFT,)), GUARD, guided=False)

    def view():
        seen = world.surroundings()
        ego = seen.ego.model_copy(update={"position_sd_m": sd_m})
        return FrenetScene(seen.model_copy(update={"ego": ego}))

    def names(_, proven, seen, giving_way=False):
        asked.append(giving_way)
        who = ("a", "b", None)[len(asked) - 1]
        rejects = (RejectReason(code=RejectCode.LANE_ENTRY, detail="it presses", object_id=who),)
        return OK if who is None else Verdict(rejects=rejects, abort=AbortAction.YIELD)

    assert running.start(view(), 0.0).accepted
    monkeypatch.setattr(Guard, "recheck", names)
    for k in range(3):
        running.tick(view(), 0.1 * (k + 1))
    assert asked == [False, {"a"}, second]


@pytest.mark.integration
def test_recheck_slightly_faster_follower_ends_no_plan():
    """A follower that speeds up a little does not end a plan that was accepted.

    At the start, gentle braking of the follower must be enough; later, it may brake a bit harder.
    """
    world = World(MULTI)
    gaps = np.arange(5.0, 80.0, 0.5)
    begun = begin([LEFT], world)
    least = []
    for judge in (
        lambda view: GUARD.accept([LEFT], view, guided=False)[0],
        lambda view: GUARD.recheck(begun, view),
    ):
        refused = [
            gap
            for gap in gaps
            if not judge(World(MULTI, [thing("behind", 48.05 - gap - 2.3, LANE_M, speed=10.0)], x=50.5).view()).accepted
        ]
        least.append(max(refused))
    assert least[0] - least[1] > 3.0


@pytest.mark.integration
@pytest.mark.parametrize("appears_at", [50.0, 51.0, 51.5, 52.0])
@pytest.mark.parametrize("gap_m", [15.0, 20.0, 25.0, 30.0])
def test_execution_follower_never_yielding_passes_without_contact(appears_at, gap_m):
    """A follower that never yields passes the ego's front without contact."""
    world = World(MULTI)
    execution = Execution(
        RecoveryPlan(behaviors=(ChangeLane(side="left", distance_m=30.0, speed_mps=1.5),)), GUARD, False
    )
    assert execution.start(world.view(), 0.0).accepted
    told, nearest = None, []
    while not isinstance(told, ExecutionOutcome) and world.time_s < 40.0:
        told = execution.tick(world.view(), world.time_s)
        if not world.objects and world.x >= appears_at:
            world.objects.append(thing("behind", world.x + 2.45 - gap_m - 2.3, LANE_M, speed=10.0))
        if not isinstance(told, ExecutionOutcome):
            world.drive(told)
        nearest.append(world.clearance())
    # Before the commit point it stops and is done with it.
    assert isinstance(told, ExecutionOutcome) and (told.finished or appears_at < 51.5), told
    assert min(nearest) > 0.2


def strayed():
    """A plan in the own lane that strayed into the oncoming one, on its way back, and its world."""
    world = World(TWO_WAY, y=0.0)
    execution = Execution(RecoveryPlan(behaviors=(KeepLane(distance_m=40.0, speed_mps=5.0),)), GUARD, guided=False)
    assert execution.start(world.view(), 0.0).accepted
    world.x, world.y, world.speed = 60.0, 2.5, 4.0
    order = execution.tick(world.view(), 1.0)
    assert execution.last_verdict.abort is AbortAction.RETURN_TO_LANE
    assert isinstance(order, Execute) and order.path
    return world, execution, order


def test_a_free_way_back_is_driven_on():
    world, execution, order = strayed()
    world.x, world.y = 61.0, 2.4
    assert execution.tick(world.view(), 1.1) == order


def test_way_back_pedestrian_is_braked_for_until_gone():
    """On the way back, the ego brakes for a pedestrian who steps into its path, and then goes on."""
    world, execution, order = strayed()
    world.x, world.y = 61.0, 2.4
    world.objects.append(thing("walker", 68.0, 1.2, kind=ObjectKind.PEDESTRIAN))
    braked = execution.tick(world.view(), 1.1)
    assert isinstance(braked, Execute) and isinstance(braked.behavior, Wait)
    world.objects.clear()
    assert execution.tick(world.view(), 1.2) == order


def test_way_back_stopped_before_pedestrian_hands_back():
    """An ego that has stopped before a pedestrian on the way back ends the plan."""
    world, execution, _ = strayed()
    world.x, world.y, world.speed = 61.0, 2.4, 0.0
    world.objects.append(thing("walker", 65.0, 1.2, kind=ObjectKind.PEDESTRIAN))
    ended = execution.tick(world.view(), 1.1)
    assert isinstance(ended, ExecutionOutcome) and not ended.finished


def drawn_path():
    return begin([KeepLane(distance_m=40.0, speed_mps=5.0)], World(TWO_WAY)).path


@pytest.mark.parametrize(
    ("error_m", "error_rad", "way_m", "touched"),
    [(-0.3, -0.2, 4.0, True), (-0.3, -0.2, 1.0, False), (-0.3, 0.2, 4.0, False), (0.3, 0.2, 4.0, False)],
    ids=["grows towards it", "stops short of it", "is worked off", "on the other side"],
)
def test_an_error_that_grows_is_taken_to_lead_straight_on(error_m, error_rad, way_m, touched):
    # The front corner on its side: 2.45 cos 0.2 - 0.95 sin 0.2 = 2.2 m ahead and 1.4 m aside, 2 m before its rear.
    world = World(TWO_WAY, [thing("lead", 50.0 + 2.2 + 2.0 + 2.3, -1.9)], speed=2.0)
    world.yaw = -0.2
    case = CheckContext(world.view(), drawn_path(), GUARD.policy)
    case = replace(case, running=True, error_m=error_m, error_rad=error_rad)
    met = _drawn_against(case, way_m, 0.0)
    assert (met is not None) == touched
    if met is not None:
        # Braking at 0.5 m/s2 begins after 0.3 s, 0.6 m: 1.3 m are left of the 2 m less 0.1 m that count as contact.
        assert met.speed_mps == 2.0
        braked = _drawn_against(case, way_m, 0.5, 0.3)
        assert braked is not None and braked.speed_mps == pytest.approx(np.sqrt(4.0 - 2 * 0.5 * 1.3), abs=0.06)


def drawn(lead, *, way_m=6.0, braking=0.0, lag_s=0.3, error_rad=0.2, speed=3.0, more=()):
    """What an ego meets that is drawn to the left, its body along the lane."""
    world = World(TWO_WAY, [lead, *more], speed=speed)
    case = replace(
        CheckContext(world.view(), drawn_path(), GUARD.policy), running=True, error_m=0.3, error_rad=error_rad
    )
    return _drawn_against(case, way_m, braking, lag_s)


FRONT_M = 50.0 + 2.45
STANDS_LEFT = thing("lead", FRONT_M + 2.1 + 2.3, 1.0)
"""Its rear is 2.1 m ahead of our front: 2 m until what counts as contact."""


def test_drift_contact_braking_counts_from_brake_lag():
    """Braking for an object that the ego drifts to counts from when the brakes act."""
    met = [drawn(STANDS_LEFT, braking=b, lag_s=lag) for b, lag in ((0.0, 0.3), (1.0, 0.3), (1.0, 0.0), (1.0, 5.0))]
    # 3 m/s: of 2 m, 0.9 m are gone before the brakes bite. v^2 = 9 - 2 b s.
    wanted = [3.0, np.sqrt(9.0 - 2 * 1.1), np.sqrt(9.0 - 2 * 2.0), 3.0]
    assert [item.speed_mps for item in met] == pytest.approx(wanted, abs=0.04)
    assert drawn(STANDS_LEFT, braking=9.0).speed_mps == 0.0


def test_a_steady_error_leads_nowhere():
    assert drawn(STANDS_LEFT, error_rad=0.0) is None


def test_drift_contact_nearest_object_is_first_and_cyclist_is_person():
    """Of the objects that the ego drifts to, the nearest is hit first. A cyclist counts as a person."""
    cyclist = thing("cyclist", FRONT_M + 1.1 + 0.9, 1.0, kind=ObjectKind.BICYCLE)
    one, two = drawn(cyclist, braking=1.0, lag_s=0.0), drawn(STANDS_LEFT, braking=1.0, lag_s=0.0, more=[cyclist])
    assert one.person and two.person and not drawn(STANDS_LEFT).person
    assert two.speed_mps == one.speed_mps == pytest.approx(np.sqrt(9.0 - 2 * 1.0), abs=0.04)


def test_drift_contact_near_object_without_approach_is_none():
    """An object that is near from the start and comes no nearer is not hit."""
    beside = thing("beside", 50.0, 0.95 + 0.95 + 0.05)
    assert drawn(beside) is None


def test_drift_side_counts_from_error_of_5_cm():
    """The side to which the ego drifts is that of its error, from 5 cm on."""
    case = CheckContext(
        World(TWO_WAY, [thing("left", 60.0, 1.0), thing("level", 70.0, 0.0)]).view(), drawn_path(), GUARD.policy
    )
    both = np.array([0, 1])
    assert is_on_drift_side(replace(case, error_m=0.05), both).tolist() == [True, False]
    assert is_on_drift_side(replace(case, error_m=0.049), both).tolist() == [False, False]


def test_gaps_at_heading_steps_are_within_contact_distance():
    """A straight path is checked in steps no longer than the distance that counts as contact."""
    case = CheckContext(World(TWO_WAY, [thing("lead", 90.0)]).view(), drawn_path(), GUARD.policy)
    gaps = gaps_at_heading(case, np.array([0]), 20.0)[:, 0]
    assert -np.diff(gaps).min() <= GUARD.policy.harm.touch_m + 1e-9
    assert gaps[0] - gaps[-1] == pytest.approx(20.0)


def test_braking_profile_without_lag_is_shorter_by_lag_distance():
    """A stop whose brakes already act is shorter by the distance of the lag."""
    case = CheckContext(World(TWO_WAY, speed=4.0).view(), drawn_path(), GUARD.policy)
    ends = [braking_profile(case, 2.0, lag_s)[0][-1] - case.path.s[0] for lag_s in (None, 0.3, 0.0)]
    assert ends == pytest.approx([4.0 + 1.2, 4.0 + 1.2, 4.0])


def test_recheck_way_back_reports_object_that_is_braked_for():
    """The way back is checked like a running plan, and the verdict names the object to brake for."""
    world, _, _ = strayed()
    path = GUARD.way_back(world.view())
    world.x, world.y, world.yaw = 61.0, 2.4, -0.1
    walker = thing("walker", 67.0, 1.2, kind=ObjectKind.PEDESTRIAN)
    world.objects.append(walker)
    verdict = GUARD.recheck_way_back(path, world.view())
    assert verdict.abort is AbortAction.YIELD and verdict.brake_mps2 == world.ego().limits.max_braking_mps2
    assert [r.object_id for r in verdict.rejects] == ["walker"]


def test_recheck_way_back_passes_growing_error_to_mitigation(monkeypatch):
    """On the way back, too, the ego brakes for an error that grows."""
    seen = []
    monkeypatch.setattr(
        guard_module, "least_harmful_option", lambda case, giving: seen.append((case, giving)) or FINISH
    )
    world, _, _ = strayed()
    path = GUARD.way_back(world.view())
    world.x, world.y, world.yaw = 61.0, 2.9, 0.05
    world.objects.append(thing("walker", 68.0, 1.5, kind=ObjectKind.PEDESTRIAN))
    GUARD.recheck_way_back(path, world.view(), True)
    ((case, giving),) = seen
    assert giving is True and case.running is True
    assert case.error_m == pytest.approx(2.9 - float(np.interp(61.0, path.s, path.d)))
    assert case.error_rad == pytest.approx(0.05 - float(np.interp(61.0, path.s, path.heading())))
