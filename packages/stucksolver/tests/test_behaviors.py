"""Each behavior, driven from its start to its end, given up, and timed out: where it leaves the vehicle."""

from __future__ import annotations

import pytest

from grids import each_value
from stucksolver.guard import Guard
from stucksolver.plan import Execute, RecoveryPlan, Replan, SafeStop
from stucksolver.plan.behaviors import (
    REGISTRY,
    BackUp,
    BorrowOncomingLane,
    ChangeLane,
    Creep,
    DriveOver,
    FollowVehicle,
    HazardLights,
    KeepLane,
    NoseOut,
    Nudge,
    PullOver,
    RejoinRoute,
    ReplanRoute,
    RequestAssistance,
    Wait,
)
from stucksolver.scene import LineKind, ObjectKind, PlanFailure, Zone, ZoneKind
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from stucksolver.solver.state_machine.minimal_risk import minimal_risk
from worlds import LANE_M, World, straight_road, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN)
GUARD = Guard()


def lead(**more):
    return World(TWO_WAY, [thing("lead", 65.0, **more)])


def bag():
    flat = thing("bag", 62.0, kind=ObjectKind.BAG, height=0.1, seen_for_s=2.0, kind_confidence=0.9)
    return World(TWO_WAY, [flat])


CASES = {
    "wait": (Wait(duration_s=3.0), World(TWO_WAY)),
    "keep_lane": (KeepLane(distance_m=30.0, speed_mps=5.0), World(TWO_WAY)),
    "follow_vehicle": (
        FollowVehicle(leader_id="lead", distance_m=30.0, speed_mps=5.0),
        World(TWO_WAY, [thing("lead", 65.0, speed=6.0)]),
    ),
    "change_lane": (ChangeLane(side="left", distance_m=30.0, speed_mps=5.0), World(MULTI)),
    "borrow_oncoming_lane": (BorrowOncomingLane(past_object_id="lead", speed_mps=5.0), lead()),
    "nudge": (Nudge(side="left", offset_m=0.6, distance_m=12.0), World(TWO_WAY)),
    "nose_out": (NoseOut(side="left"), World(MULTI)),
    "creep": (Creep(distance_m=5.0), World(TWO_WAY)),
    "back_up": (BackUp(distance_m=5.0), World(TWO_WAY)),
    "drive_over": (DriveOver(object_id="bag"), bag()),
    "pull_over": (PullOver(), World(TWO_WAY)),
    "rejoin_route": (RejoinRoute(), World(MULTI, y=LANE_M)),
    "replan": (ReplanRoute(), World(TWO_WAY)),
    "hazard_lights": (HazardLights(), World(TWO_WAY)),
    "request_assistance": (RequestAssistance(reason="blocked", duration_s=5.0), lead()),
}


def run(behaviors, world, seconds=60.0, every_tick=None):
    """Carries a plan through; returns the outcome and all that the stack was told."""
    execution = Execution(RecoveryPlan(behaviors=tuple(behaviors)), GUARD, guided=False)
    verdict = execution.start(world.view(), world.time_s)
    assert verdict.accepted, str(verdict)
    told = []
    while world.time_s < seconds:
        result = execution.tick(world.view(), world.time_s)
        if isinstance(result, ExecutionOutcome):
            return result, told
        told.append(result)
        world.drive(result)
        if every_tick is not None:
            every_tick(execution, world)
    raise AssertionError("it never ended")


def fresh(name):
    behavior, world = CASES[name]
    return behavior, World(world.road, list(world.objects), y=world.y, dt=0.1)


@pytest.mark.parametrize("behavior", [KeepLane(distance_m=1.0, speed_mps=1.5), Creep(distance_m=1.5)], ids=str)
def test_a_short_way_is_driven_and_not_over_at_once(behavior):
    world = World(TWO_WAY, dt=0.1)
    outcome, _ = run([behavior], world)
    assert outcome.finished and 0.5 * behavior.distance_m < world.x - 50.0 < behavior.distance_m + 0.2


def test_every_behavior_of_the_closed_list_is_driven_here():
    # A turn follows no road: test_turning.py drives it.
    assert list(CASES) == [name for name in REGISTRY if name != "turn_round"]


@pytest.mark.parametrize("name", CASES)
def test_it_is_done_within_its_time_and_touches_nothing(name):
    behavior, world = fresh(name)
    nearest = []
    outcome, told = run([behavior], world, every_tick=lambda _, w: nearest.append(w.clearance()))
    assert outcome.finished, outcome.text
    assert told
    assert name == "drive_over" or min(nearest, default=1.0) > 0.25


@pytest.mark.parametrize(("name", "when_s"), each_value(CASES, [0.3, 2.0, 5.0]))
def test_given_up_it_leaves_the_vehicle_where_it_may_be(name, when_s):
    """At rest where one may stand, or, once committed, with the behavior finished."""
    behavior, world = fresh(name)

    def give_up(execution, world):
        if world.time_s >= when_s:
            execution.withdraw()

    outcome, _ = run([behavior], world, every_tick=give_up)
    assert GUARD.may_stand(world.view()) or outcome.finished
    if not outcome.finished:
        assert abs(world.speed) < 0.2


@pytest.mark.integration
@pytest.mark.parametrize("name", [n for n in CASES if not CASES[n][0].stands_still])
def test_a_vehicle_that_does_not_move_times_out_standing_safely(name):
    behavior, world = fresh(name)

    def stuck(execution, w):
        w.x, w.y, w.speed, w.yaw = 50.0, world_y, 0.0, 0.0

    world_y = world.y
    outcome, _ = run([behavior], world, 300.0, every_tick=stuck)
    if name == "follow_vehicle":
        assert outcome.finished  # the leader has left
        return
    assert not outcome.finished
    assert "timeout" in outcome.text or "refused" in outcome.text or outcome.text
    assert GUARD.may_stand(world.view())


@pytest.mark.parametrize("name", ["nudge", "creep", "back_up", "pull_over"])
def test_what_ends_at_rest_has_gone_as_far_as_asked(name):
    behavior, world = fresh(name)
    run([behavior], world)
    assert abs(world.speed) < 0.2
    way = -behavior.distance_m if name == "back_up" else behavior.distance_m
    assert world.x - 50.0 == pytest.approx(way, abs=2.0)


def test_back_up_directives_reverse_along_path_behind():
    """Backing up sends directives in reverse with a path that ends behind the ego."""
    behavior, world = fresh("back_up")
    _, told = run([behavior], world)
    assert all(isinstance(x, Execute) and x.reverse for x in told)
    assert told[0].path[-1].x_m == pytest.approx(45.0, abs=0.3)


def test_driving_over_tells_the_stack_what_not_to_brake_for():
    behavior, world = fresh("drive_over")
    _, told = run([behavior], world)
    assert all(x.ignore == ("bag",) for x in told)
    assert max(p.speed_mps for x in told for p in x.path) <= 8 / 3.6


@pytest.mark.integration
def test_plan_back_up_then_pass_is_driven():
    """Backing up and a pass are proven one after the other."""
    world = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 2.3 + 2.0)])
    outcome, told = run([BackUp(distance_m=6.0), CASES["borrow_oncoming_lane"][0]], world)
    assert outcome.finished, outcome.text
    assert [x.reverse for x in told if isinstance(x, Execute)].count(False) > 20
    assert world.x > 65.0


@pytest.mark.parametrize(("until", "ends_s"), [("time", 8.0), ("clear", 3.0), ("oncoming", 3.0)])
def test_a_wait_ends_when_what_it_waits_for_has_come(until, ends_s):
    world = World(TWO_WAY, [thing("lead", 60.0), thing("car", 120.0, LANE_M, speed=-5.0)])

    def clear_after_three_seconds(_, world):
        if world.time_s >= 3.0:
            world.objects = []

    run([Wait(duration_s=8.0, until=until)], world, every_tick=clear_after_three_seconds)
    assert world.time_s == pytest.approx(ends_s, abs=0.2)


def test_execution_replan_and_assistance_have_own_directives():
    """A replan is sent once as `Replan`. A request for assistance is sent as `SafeStop` with its reason."""
    _, told = run([ReplanRoute(route_start="own+40"), Wait(duration_s=1.0)], World(TWO_WAY))
    assert told[0] == Replan(route_start="own+40")
    assert sum(isinstance(x, Replan) for x in told) == 1
    _, told = run([RequestAssistance(reason="no way", duration_s=5.0)], lead())
    assert set(map(type, told)) == {SafeStop}
    assert told[0].reason == "no way"


def test_a_call_for_help_ends_when_the_way_is_free():
    world = lead()

    def towed(_, world):
        if world.time_s >= 3.0:
            world.objects = []

    outcome, _ = run([RequestAssistance(reason="blocked", duration_s=60.0)], world, every_tick=towed)
    assert outcome.finished
    assert world.time_s < 4.0


def test_minimal_risk_plan_pulls_over_with_hazard_lights():
    """The minimal risk maneuver ends at the roadside with hazard lights on."""
    world = World(TWO_WAY)
    plan = minimal_risk(GUARD, world.view(), "nothing more can be done")
    assert [b.name for b in plan.behaviors] == ["hazard_lights", "pull_over", "request_assistance"]
    run(plan.behaviors[:2], world)
    assert world.hazard_lights
    assert world.y < -0.5


@pytest.mark.parametrize("blocked_by", ["a car right ahead", "a junction"])
def test_minimal_risk_pull_over_unsafe_stops_in_place(blocked_by):
    """Where pulling over is not safe, the ego stops where it is."""
    zones = (Zone(kind=ZoneKind.JUNCTION, start_m=53.0, end_m=90.0),)
    world = World(TWO_WAY, [thing("lead", 57.5)]) if "car" in blocked_by else World(straight_road(zones=zones))
    plan = minimal_risk(GUARD, world.view(), "nothing more can be done")
    assert [b.name for b in plan.behaviors] == ["hazard_lights", "request_assistance"]


def test_execution_withdrawn_in_junction_does_not_stop_there():
    """A plan that is withdrawn in a junction is finished, or ends where the ego may stop."""
    zones = (Zone(kind=ZoneKind.JUNCTION, start_m=40.0, end_m=60.0),)
    world = World(straight_road(zones=zones), speed=3.0)
    outcome, _ = run(
        [KeepLane(distance_m=30.0, speed_mps=5.0)], world, every_tick=lambda execution, _: execution.withdraw()
    )
    assert outcome.finished or world.x > 60.0 or GUARD.may_stand(world.view())


@pytest.mark.parametrize("room_m", [16.0, 18.0, 20.0, 22.0])
def test_a_pass_ends_behind_what_stands_beyond(room_m):
    """At rest in the own lane, instead of going on into it."""
    behavior, world = fresh("borrow_oncoming_lane")
    near = world.objects[0].x_m + world.objects[0].length_m / 2 + room_m
    world.objects.append(thing("queue", near + 2.3))
    nearest = []
    outcome, _ = run([behavior], world, every_tick=lambda _, w: nearest.append(w.clearance()))
    assert outcome.finished, outcome.text
    assert min(nearest) > 0.25
    assert abs(world.speed) < 0.4 and abs(world.y) < 0.2
    assert 1.0 < near - (world.x + 2.45) < 4.0


def test_pass_with_long_gap_ahead_ends_moving():
    """A pass does not end at rest if the gap ahead is long enough."""
    behavior, world = fresh("borrow_oncoming_lane")
    world.objects.append(thing("queue", 130.0))
    outcome, _ = run([behavior], world)
    assert outcome.finished, outcome.text
    assert world.speed > 4.0


def test_where_it_cannot_come_back_it_is_not_begun():
    behavior, world = fresh("borrow_oncoming_lane")
    world.objects.append(thing("queue", world.objects[0].x_m + 4.6 + 11.0))
    verdict = Execution(RecoveryPlan(behaviors=(behavior,)), GUARD, guided=False).start(world.view(), 0.0)
    assert verdict.failures == (PlanFailure.NO_ROOM_TO_COME_BACK,)


@pytest.mark.parametrize("then", [Wait(duration_s=1.0), Creep(distance_m=5.0), BackUp(distance_m=2.0)])
def test_execution_behavior_before_next_ends_at_rest(then):
    """A behavior before another one ends at rest, within the proven path.

    4.7 m at 3.8 m/s, 1.5 m before a stopped vehicle: braking that began at the end would lead into it.
    """
    world = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 2.3 + 6.2)])
    execution = Execution(RecoveryPlan(behaviors=(KeepLane(distance_m=4.7, speed_mps=3.8), then)), GUARD, guided=False)
    assert execution.start(world.view(), world.time_s).accepted
    furthest = world.x
    for _ in range(600):
        result = execution.tick(world.view(), world.time_s)
        if isinstance(result, ExecutionOutcome):
            break
        world.drive(result)
        furthest = max(furthest, world.x)
        assert world.clearance() > 0.3
    assert furthest < 50.0 + 4.7 + 0.6 or isinstance(then, Creep)
