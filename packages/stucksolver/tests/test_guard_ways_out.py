"""After the commit point: which way out is taken when going on would meet somebody."""

from __future__ import annotations

import math

import numpy as np
import pytest

from grids import each_value
from guard_cases import CAR_M, LENGTH_M, on_way
from stucksolver.guard import Guard, collision_mitigation
from stucksolver.guard.collision_mitigation import PredictedContact
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import AbortAction, BorrowOncomingLane, KeepLane
from stucksolver.scene import LineKind, ObjectKind, Zone, ZoneKind
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from worlds import LANE_M, World, straight_road, thing

K = ObjectKind
GUARD = Guard()
FRONT_M = LENGTH_M / 2
HALF_CAR_M = CAR_M / 2
ON = KeepLane(distance_m=60.0, speed_mps=5.0)


def zone(kind=ZoneKind.JUNCTION, start_m=55.0, end_m=95.0):
    return straight_road(left=LineKind.BROKEN, zones=(Zone(kind=kind, start_m=start_m, end_m=end_m),))


def closed_loop(world, behaviors, appears_at, what, seconds=15.0):
    """Drives a plan on; from `appears_at` on, something is there. Returns the least gap and what the speed was then."""
    execution = Execution(RecoveryPlan(behaviors=tuple(behaviors)), GUARD, False)
    verdict = execution.start(world.view(), 0.0)
    assert verdict.accepted, str(verdict)
    told, nearest, world.dt = None, [], 0.1
    while not isinstance(told, ExecutionOutcome) and world.time_s < seconds:
        if world.x >= appears_at and what is not None:
            world.objects.append(what)
            what = None
        told = execution.tick(world.view(), world.time_s)
        if not isinstance(told, ExecutionOutcome):
            world.drive(told)
        nearest.append((world.clearance(), world.speed))
    return min(nearest), told


@pytest.mark.integration
@pytest.mark.parametrize(
    ("ahead_m", "what", "kind"),
    each_value([10.0, 12.0, 20.0], [K.PEDESTRIAN, K.BICYCLE, K.CAR], [ZoneKind.JUNCTION, ZoneKind.CROSSWALK]),
)
def test_recheck_committed_stopped_object_ahead_is_not_hit(kind, what, ahead_m):
    """After the commit point, the ego does not hit an object that has stopped ahead."""
    world = World(zone(kind), speed=5.0)
    (gap, _), _ = closed_loop(world, [ON], 62.0, thing("x", 62.0 + 2.45 + ahead_m, kind=what))
    assert gap > 0.0


@pytest.mark.parametrize("ahead_m", [0.6, 1.5, 3.0, 6.0, 12.0])
def test_from_rest_it_never_sets_off_into_a_predicted_collision(ahead_m):
    world = World(zone(), speed=5.0)
    proven = GUARD.accept([ON], world.view(), False)[1]
    world.x, world.speed = 65.0, 0.0
    world.objects.append(thing("walker", 65.0 + 2.45 + ahead_m, kind=K.PEDESTRIAN))
    assert proven.committed(65.0)
    assert GUARD.recheck(proven, world.view()).abort is AbortAction.YIELD


@pytest.mark.parametrize("speed", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_recheck_committed_drift_within_touch_of_object_yields(speed, side):
    """A tracking error that has come within touching distance of an object stops the ego.

    The approach per tick is below what a recheck detects: the oracle found a car that a nose-out crept into for a
    second.
    """
    world = World(zone(), speed=5.0)
    proven = GUARD.accept([ON], world.view(), False)[1]
    world.x, world.y, world.speed = 65.0, side * 0.3, speed
    beside = thing("car", 66.0, 0.0)

    def told(gap_m):
        y = side * (0.3 + world.view().ego.width_m / 2 + gap_m + beside.width_m / 2)
        world.objects[:] = [beside.model_copy(update={"y_m": y})]
        return GUARD.recheck(proven, world.view())

    assert proven.committed(65.0)
    assert told(0.08).abort is AbortAction.YIELD
    assert told(0.2).abort is not AbortAction.YIELD
    world.y = -world.y
    assert told(0.08 + 0.6).abort is not AbortAction.YIELD, "its error is on the other side"


def test_recheck_in_oncoming_lane_stops_before_wreck():
    """In an oncoming lane, a stop is better than a contact with a wreck."""
    world = World(straight_road(), [thing("lead", 72.0)])
    (gap, _), told = closed_loop(
        world,
        [BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)],
        66.0,
        thing("wreck", 85.0, LANE_M, kind=K.BARRIER, length=1.0, width=3.0),
    )
    assert gap > 0.0
    assert isinstance(told, ExecutionOutcome) or told.behavior.name == "wait"


def test_recheck_on_rails_stops_only_against_contact():
    """On rails the ego goes on if that touches no object, and stops only if it would."""
    world = World(zone(ZoneKind.JUNCTION), speed=5.0)
    proven = GUARD.accept([ON], world.view(), False)[1]
    rails = World(zone(ZoneKind.LEVEL_CROSSING), x=70.0, speed=4.0)
    beside = thing("walker", 78.0, -1.9, kind=K.PEDESTRIAN)
    rails.objects = [beside]
    assert GUARD.recheck(proven, rails.view()).abort is AbortAction.FINISH
    rails.objects = [thing("walker", 84.0, kind=K.PEDESTRIAN)]
    assert GUARD.recheck(proven, rails.view()).abort is AbortAction.YIELD


def test_where_contact_cannot_be_helped_the_brakes_bite_hard():
    world = World(zone(), speed=5.0)
    proven = GUARD.accept([ON], world.view(), False)[1]
    world.x = 65.0
    world.objects.append(thing("walker", 65.0 + 2.45 + 3.2, kind=K.PEDESTRIAN))
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.YIELD
    assert verdict.brake_mps2 == pytest.approx(world.ego().limits.max_braking_mps2)


def test_a_person_is_spared_before_a_thing():
    """Going on would run over a walker; the stop is hit from the side by a slow car."""
    world = World(zone(), speed=4.0)
    proven = GUARD.accept([ON], world.view(), False)[1]
    world.x = 65.0
    world.objects += [
        thing("walker", 76.0, kind=K.PEDESTRIAN),
        thing("crossing", 68.5, -9.0, sideways=3.0, yaw=np.pi / 2),
    ]
    assert GUARD.recheck(proven, world.view()).abort is AbortAction.YIELD


# ---- harm, beside the same reckoned by hand


@pytest.mark.parametrize(("one", "other", "person"), [(True, False, True), (False, True, True), (False, False, False)])
def test_of_two_contacts_a_person_and_the_quicker_count(one, other, person):
    assert collision_mitigation._worse(PredictedContact(one, 2.0), PredictedContact(other, 5.0)) == PredictedContact(
        person, 5.0
    )
    assert (
        collision_mitigation._worse(PredictedContact(one, 2.0), None)
        == collision_mitigation._worse(None, PredictedContact(one, 2.0))
        == PredictedContact(one, 2.0)
    )
    assert collision_mitigation._worse(None, None) is None


@pytest.mark.parametrize(("kind", "person"), [(K.PEDESTRIAN, True), (K.BICYCLE, True), (K.CAR, False), (K.CONE, False)])
def test_finishing_contact_has_ego_speed_and_person_flag(kind, person):
    """A contact ahead is at the ego's speed, and with a person or not."""
    found = collision_mitigation._finishing(on_way(thing("it", 75.0, kind=kind)), False)
    assert found.person is person
    assert found.speed_mps == pytest.approx(5.0, abs=0.2)


@pytest.mark.parametrize(
    ("vx", "vy", "speed"),
    [(-4.0, 0.0, 9.0), (0.0, -4.0, math.hypot(5.0, 4.0)), (-3.0, 2.0, math.hypot(8.0, 2.0))],
)
def test_a_contact_with_who_moves_is_at_the_relative_speed(vx, vy, speed):
    """They are where we are in 1.5 s."""
    meets = 65.0 + 5.0 * 1.5
    it = thing("it", meets - vx * 1.5, -vy * 1.5, speed=vx, sideways=vy, yaw=math.atan2(vy, vx))
    t = np.linspace(0.0, 3.0, 31)
    case = on_way(it)
    found = collision_mitigation._with_moving(case, 65.0 + 5.0 * t[None], t)
    assert found.speed_mps == pytest.approx(speed, abs=0.1)
    assert not found.person


@pytest.mark.parametrize(
    ("speed", "giving_way", "braked_for"), [(5.0, False, False), (5.0, True, True), (0.0, False, True)]
)
def test_finishing_far_pedestrian_is_braked_for_later(speed, giving_way, braked_for):
    """An ego in motion brakes later for a far pedestrian, but a stopped ego does not set off.

    At 5 m/s, an object counts if it would be hit within 1.7 s of a stop and 2.5 s; 38 m are farther.
    """
    case = on_way(thing("it", 65.0 + FRONT_M + 0.25 + 33.0, kind=K.PEDESTRIAN), speed=speed)
    assert bool(collision_mitigation._finishing(case, giving_way)) is braked_for


def test_from_rest_one_stays_with_gentle_brakes():
    case = on_way(thing("it", 75.0, kind=K.PEDESTRIAN), speed=0.0)
    way = collision_mitigation.least_harmful_option(case, False)
    assert (way.abort, way.brake_mps2) == (AbortAction.YIELD, case.view.ego.limits.comfort_braking_mps2)


@pytest.mark.parametrize(("ahead_m", "hard"), [(10.0, None), (2.5, 6.0)])
def test_brakes_bite_hard_only_where_gentle_ones_would_meet_somebody(ahead_m, hard):
    case = on_way(thing("it", 65.0 + FRONT_M + HALF_CAR_M + ahead_m))
    assert collision_mitigation.hard_braking_mps2(case) == hard
