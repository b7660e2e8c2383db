"""A slow ego yields while the path of predicted traffic is still free of its body."""

from __future__ import annotations

import math

import pytest

from grids import each_value
from stucksolver.guard import Guard
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import AbortAction, BorrowOncomingLane, Creep, KeepLane
from stucksolver.scene import ObjectKind, Zone, ZoneKind
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
START_M = 60.0
JUNCTION = straight_road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=START_M, end_m=85.0),))
HALF_M = 4.9 / 2
NOSE_M = 0.7
"""How far the nose is inside the junction when the other vehicle comes into sight (m)."""


def crosser(away_m: float, speed_mps: float, side: int, at_m: float, **more: object):
    """A road user on a road that crosses ours at `at_m`, `away_m` from our lane; `side` 1: from the left."""
    return thing("crosser", at_m, side * away_m, sideways=-side * speed_mps, yaw=-side * math.pi / 2, **more)


def through(behavior, other, *, road=JUNCTION, x_m=52.0, seconds=45.0, dt=0.1):
    """Drive a plan into the junction; `other` comes into sight once the nose is inside. Return world and outcome."""
    world = World(road, x=x_m, dt=dt)
    execution = Execution(RecoveryPlan(behaviors=(behavior,)), GUARD, False)
    assert execution.start(world.view(), 0.0).accepted
    nearest_m, outcome = math.inf, None
    while world.time_s < seconds and outcome is None:
        if not world.objects and world.x + HALF_M > START_M + NOSE_M:
            world.objects.append(other)
        step = execution.tick(FrenetScene(world.surroundings()), world.time_s)
        outcome = step if isinstance(step, ExecutionOutcome) else None
        if outcome is None:
            world.drive(step)
            nearest_m = min(nearest_m, world.clearance())
    return world, outcome, nearest_m


CROSSINGS = [
    (0.6, 50.0, 6.0, 64.0),
    (0.6, 84.0, 9.0, 64.0),
    (1.0, 50.0, 9.0, 64.0),
    (1.0, 84.0, 6.0, 70.0),
    (1.5, 50.0, 9.0, 66.0),
    (1.5, 84.0, 9.0, 72.0),
    (2.2, 70.0, 12.0, 68.0),
]
"""(Speed of the ego in m/s, distance of the car in m, its speed in m/s, where the ego's path is crossed in m)."""


@pytest.mark.integration
@pytest.mark.parametrize(("crossing", "side"), each_value(CROSSINGS, [-1, 1]))
def test_slow_plan_crossing_car_comes_into_sight_is_not_hit(crossing, side):
    """A steady car that comes into sight 50 to 84 m away passes before the slow ego lies across its path."""
    speed_mps, away_m, theirs_mps, at_m = crossing
    plan = KeepLane(distance_m=38.0, speed_mps=speed_mps)
    _, _, nearest_m = through(plan, crosser(away_m, theirs_mps, side, at_m))
    assert nearest_m > 0.0


@pytest.mark.parametrize("away_m", [50.0, 70.0])
def test_creep_at_default_speed_crossing_car_is_not_hit(away_m):
    """The same for `creep` in a small junction, 3 m wide, so that it ends beyond it."""
    road = straight_road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=START_M, end_m=START_M + 3.0),))
    plan = Creep(distance_m=14.0)
    _, _, nearest_m = through(plan, crosser(away_m, 8.0, 1, START_M + 1.9), road=road, x_m=55.0)
    assert nearest_m > 0.0


@pytest.mark.integration
@pytest.mark.parametrize("kind", [ObjectKind.MOTORCYCLE, ObjectKind.BICYCLE, ObjectKind.PEDESTRIAN, ObjectKind.TRUCK])
def test_slow_plan_any_road_user_crosses_is_not_hit(kind):
    """The rule knows no classes: whatever is predicted to cross is let by."""
    theirs_mps = 1.4 if kind is ObjectKind.PEDESTRIAN else 6.0
    other = crosser(7.0 * theirs_mps, theirs_mps, 1, 65.0, kind=kind)
    _, _, nearest_m = through(KeepLane(distance_m=38.0, speed_mps=1.0), other)
    assert nearest_m > 0.0


@pytest.mark.integration
def test_yield_path_is_free_again_plan_goes_on():
    """The plan gives way with its nose in the junction, and is finished after the other has passed."""
    world, outcome, nearest_m = through(KeepLane(distance_m=38.0, speed_mps=1.5), crosser(50.0, 9.0, 1, 66.0))
    assert outcome is not None and outcome.finished
    assert nearest_m > 0.3 and world.x > 85.0


def in_junction(x_m: float, speed_mps: float, *others):
    world = World(JUNCTION, x=52.0)
    proven = GUARD.accept([KeepLane(distance_m=38.0, speed_mps=max(speed_mps, 0.6))], world.view(), False)[1]
    assert proven is not None and proven.committed(x_m)
    world.x, world.speed = x_m, speed_mps
    world.objects.extend(others)
    return world, proven


def test_recheck_path_begins_far_ahead_does_not_yield_yet():
    """Traffic may turn off before, so an ego inside the junction yields only at the last stop before its path."""
    world, proven = in_junction(62.0, 1.0, crosser(90.0, 6.0, 1, 77.0))
    assert GUARD.recheck(proven, world.view()).abort in (None, AbortAction.FINISH)


def test_recheck_nose_still_before_the_nearest_lane_yields_at_once():
    """Somebody may come along that lane while it waits further inside for the one whom it sees."""
    world, proven = in_junction(59.0, 1.0, crosser(90.0, 6.0, 1, 75.0))
    assert GUARD.recheck(proven, world.view()).abort is AbortAction.YIELD


def test_recheck_last_stop_before_path_yields_long_before_contact():
    """At 1 m/s the last stop before the path is due although the other arrives only after 10 s."""
    nose_m = 65.0 - 1.9 / 2 - 0.6
    world, proven = in_junction(nose_m - HALF_M - 0.45, 1.0, crosser(60.0, 6.0, 1, 65.0))
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.YIELD
    assert min(r.time_s for r in verdict.rejects) > 8.0


def test_recheck_ego_lies_in_path_does_not_stop_there():
    """In the other's path a stop helps nobody: the ego finishes, since that leaves the path soonest."""
    world, proven = in_junction(65.0, 1.0, crosser(60.0, 6.0, 1, 65.0))
    assert GUARD.recheck(proven, world.view()).abort in (None, AbortAction.FINISH)


@pytest.mark.parametrize("kind", [ZoneKind.CROSSWALK, ZoneKind.LEVEL_CROSSING])
def test_recheck_yield_on_rails_does_not_stop(kind):
    """A stop on a crosswalk lets others pass; a stop on rails is not made.

    Mitigation decides on rails, which rank low as a place to stop.
    """
    nose_m = 65.0 - 1.9 / 2 - 0.6
    world, proven = in_junction(nose_m - HALF_M - 0.45, 1.0, crosser(60.0, 6.0, 1, 65.0))
    world.road = straight_road(zones=(*JUNCTION.zones, Zone(kind=kind, start_m=62.0, end_m=63.5)))
    yields = GUARD.recheck(proven, world.view()).abort is AbortAction.YIELD
    assert yields is (kind is ZoneKind.CROSSWALK)


def test_recheck_stopped_for_far_traffic_stays_until_it_has_passed():
    """While giving way, the ego does not creep on towards a path that it would still lie in."""
    stop_m = 65.0 - 1.9 / 2 - 0.5 - 1.0 - HALF_M
    world, proven = in_junction(stop_m, 0.0, crosser(60.0, 6.0, 1, 65.0))
    assert GUARD.recheck(proven, world.view(), frozenset({"crosser"})).abort is AbortAction.YIELD


@pytest.mark.integration
@pytest.mark.parametrize("speed_mps", [1.5, 2.2])
def test_slow_pass_oncoming_car_passes_before_ego_enters_lane(speed_mps):
    """A late oncoming car passes while the ego stays in its own lane.

    Past the commit point but still in its own lane, the ego does not enter the lane of a car that it would meet.
    """
    world = World(straight_road(), [thing("parked", 75.0, stationary_s=60.0, hazard=True)], x=64.0, dt=0.1)
    plan = BorrowOncomingLane(past_object_id="parked", speed_mps=speed_mps)
    execution = Execution(RecoveryPlan(behaviors=(plan,)), GUARD, False)
    assert execution.start(world.view(), 0.0).accepted
    while not execution._committed(world.view()):
        world.drive(execution.tick(world.view(), world.time_s))
    world.objects.append(thing("late", world.x + 8.0 * 12.0, LANE_M, speed=-8.0, yaw=math.pi))
    furthest_m = []
    while world.time_s < 60.0 and any(o.id == "late" and o.x_m > world.x for o in world.objects):
        step = execution.tick(world.view(), world.time_s)
        if isinstance(step, ExecutionOutcome):
            break
        world.drive(step)
        furthest_m.append(world.y)
        assert world.clearance() > 0.0
    assert max(furthest_m) < LANE_M / 2
