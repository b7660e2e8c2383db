"""Long ways back: off a level crossing with the guard's rechecks, and in a street."""

from __future__ import annotations

import math

import pytest

from places import BACK_OFF, CROSSING, CROSSWALK, GUARD, HALF_M, QUEUE, codes, gate, street
from stucksolver.guard import RejectCode
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import BackUp, KeepLane
from stucksolver.scene import ObjectKind
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from worlds import World, thing

C, K = RejectCode, ObjectKind


def backed_off(world, *, at=None):
    return carried_out(world, BACK_OFF, at=at)


def carried_out(world, behavior, *, at=None, seconds=60.0):
    """Drive a plan; `at` is called on every tick. Return the outcome and the nearest gap (m)."""
    execution = Execution(RecoveryPlan(behaviors=(behavior,)), GUARD, False)
    verdict = execution.start(world.view(), 0.0)
    assert verdict.accepted, str(verdict)
    nearest_m, outcome = math.inf, None
    while world.time_s < seconds and outcome is None:
        if at is not None:
            at(world)
        step = execution.tick(FrenetScene(world.surroundings()), world.time_s)
        outcome = step if isinstance(step, ExecutionOutcome) else None
        if outcome is None:
            world.drive(step)
            nearest_m = min(nearest_m, world.clearance())
    return outcome, nearest_m


def test_execution_backs_off_crossing_to_its_end():
    world = World(CROSSING, [gate(17.0)], x=40.0)
    outcome, _ = backed_off(world)
    assert outcome.finished, outcome.text
    assert world.x + HALF_M < 20.0


@pytest.mark.parametrize("onto_m", [34.0, 24.0, 16.0])
def test_execution_person_behind_stops_back_up(onto_m):
    """Somebody steps behind the ego, on the rails or beyond them. The ego stops before them, also on the rails."""
    world = World(CROSSING, [QUEUE])

    def step_in(now):
        if now.x - HALF_M < onto_m + 4.0 and len(now.objects) == 1:
            now.objects.append(thing("person", onto_m, -0.5, kind=K.PEDESTRIAN))

    _, nearest_m = backed_off(world, at=step_in)
    assert nearest_m > 0.3
    assert world.x - HALF_M > onto_m


@pytest.mark.parametrize("backs", [True, False], ids=["back", "ahead"])
@pytest.mark.parametrize("arrives_s", [6.0, 10.0, 14.0])
def test_execution_slow_ego_on_long_crossing_lets_train_by(backs, arrives_s):
    """A train comes into sight while the ego leaves a long crossing, most of which is not in the train's path."""
    train_s = 36.0 if backs else 44.0
    world = World(CROSSING, x=50.0 if backs else 30.0, dt=0.1)
    behavior = BackUp(distance_m=34.0, speed_mps=1.0) if backs else KeepLane(distance_m=35.0, speed_mps=1.0)
    size = {"kind": K.UNKNOWN, "length": 40.0, "width": 2.7, "yaw": math.pi / 2}

    def come(now):
        if now.time_s >= 1.5 and not now.objects:
            now.objects.append(thing("train", train_s, -20.0 - 9.0 * arrives_s, sideways=9.0, **size))

    _, nearest_m = carried_out(world, behavior, at=come)
    assert nearest_m > 0.3


def test_execution_car_from_behind_stops_back_up():
    """A car that comes into sight behind stops before the crossing; the ego does not back into it."""
    world = World(CROSSING, [QUEUE])

    def arrive(now):
        if now.time_s > 4.0 and len(now.objects) == 1:
            now.objects.append(thing("car", -5.0, speed=8.0))
        now.objects[1:] = [
            o.model_copy(update={"vx_mps": max(o.vx_mps - 3.5 * now.dt, 0.0)}) if o.x_m > 8.0 else o
            for o in now.objects[1:]
        ]

    _, nearest_m = backed_off(world, at=arrive)
    assert nearest_m > 0.3


def test_execution_sight_lost_on_rails_pauses_back_up():
    """Without sight behind, the ego stops also past the commit point, and continues when it sees again."""
    world, stood = World(CROSSING, [QUEUE]), []

    def lose(now):
        now.behind_m = 3.5 if 6.0 < now.time_s < 9.0 else 80.0
        if 8.0 < now.time_s < 9.0:
            stood.append(abs(now.speed))

    outcome, _ = backed_off(world, at=lose)
    assert max(stood) < 0.1
    assert outcome.finished, outcome.text


def test_back_up_keeps_its_bound():
    """40 m leave the longest zone; nobody needs more."""
    assert BackUp(distance_m=40.0).distance_m == 40.0
    with pytest.raises(ValueError, match="40"):
        BackUp(distance_m=40.5)


# ---- how far


@pytest.mark.parametrize(
    ("distance_m", "behind_m", "seen"), [(8.0, 15.5, True), (20.0, 30.0, False), (20.0, 58.0, True)]
)
def test_back_up_far_in_street_needs_sight_for_traffic_at_the_limit(distance_m, behind_m, seen):
    """In an ordinary street, traffic at 13.4 m/s from beyond the sight must be able to stop behind the ego."""
    found = codes(World(street(), [QUEUE], behind_m=behind_m), BackUp(distance_m=distance_m, speed_mps=2.0))
    assert found == (set() if seen else {C.PATH_NOT_VISIBLE})


def test_back_up_far_beyond_a_place_needs_the_same_sight():
    """Only the way out of the place is exempt, not 20 m beyond it."""
    world = World(CROSSWALK, [QUEUE], behind_m=45.0)
    assert codes(world, BackUp(distance_m=14.0, speed_mps=2.0)) == set()
    assert codes(world, BackUp(distance_m=27.0, speed_mps=2.0)) == {C.PATH_NOT_VISIBLE}


def test_execution_askew_back_up_ends_off_its_path():
    """A body that is not straightened leaves the proven path. There the plan ends, also on rails."""
    world = World(CROSSING, yaw=-0.3)
    execution = Execution(RecoveryPlan(behaviors=(BACK_OFF,)), GUARD, False)
    assert execution.start(world.view(), 0.0).accepted
    outcome, backs_mps = None, 1.5
    while world.time_s < 20.0 and outcome is None:
        world.x -= backs_mps * math.cos(world.yaw) * world.dt
        world.y -= backs_mps * math.sin(world.yaw) * world.dt
        world.speed, world.time_s, world.frame = -backs_mps, world.time_s + world.dt, world.frame + 1
        step = execution.tick(FrenetScene(world.surroundings()), world.time_s)
        outcome = step if isinstance(step, ExecutionOutcome) else None
    assert outcome is not None and not outcome.finished
    assert C.DEVIATION in execution.last_verdict.codes
    assert abs(world.y) < 1.1
