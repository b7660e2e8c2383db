"""Each way of moving, from plan to pedals: the guard proves it, the stack drives it, the simulator judges it."""

from __future__ import annotations

import math

import pytest

carla = pytest.importorskip("carla")

from townstage import CAR, TICK_S  # noqa: E402

from stucksolver.guard import Guard, GuardPolicy  # noqa: E402
from stucksolver.plan import CONTINUE, RecoveryPlan, SafeStop  # noqa: E402
from stucksolver.plan.behaviors import (  # noqa: E402
    BackUp,
    BorrowOncomingLane,
    Creep,
    DriveOver,
    HazardLights,
    Nudge,
    PullOver,
    RejoinRoute,
    ReplanRoute,
)
from stucksolver.scene.frenet_scene import FrenetScene  # noqa: E402
from stucksolver.solver.state_machine.execution import Execution, ExecutionOutcome  # noqa: E402
from stucksolver.solver.state_machine.minimal_risk import minimal_risk  # noqa: E402

pytestmark = pytest.mark.integration

STREET, STREET_END = (11, -1, 40.0), (13, -1, 100.0)
GUARD = Guard(GuardPolicy(solid_line="autonomous"))
WALKING_MPS = 8 / 3.6


def carry_out(stage, car, stack, *behaviors, seconds=60.0):
    """Executes a plan from standstill; the outcome, and the (offset, speed along the heading) of every tick."""
    stage.drive(car, stack, 1.0, SafeStop(reason="to begin at rest"))
    execution = Execution(RecoveryPlan(behaviors=behaviors), GUARD, guided=False)
    verdict = execution.start(FrenetScene(stack.surroundings()), stack.status().time_s)
    assert verdict.accepted, str(verdict)
    trail = []
    for _ in range(round(seconds / TICK_S)):
        view = FrenetScene(stack.surroundings())
        trail.append((view.ego_s, view.ego_d, view.ego.speed_mps))
        result = execution.tick(view, stack.status().time_s)
        if isinstance(result, ExecutionOutcome):
            car.apply_control(stack.perform(CONTINUE))
            stage.world.tick()
            return result, trail
        car.apply_control(stack.perform(result))
        stage.world.tick()
    raise AssertionError(f"it never ended: {trail[-1]}")


def watch_collisions(stage, car):
    """A list that fills with what the car runs into."""
    found = []
    sensor = stage.world.spawn_actor(
        stage.world.get_blueprint_library().find("sensor.other.collision"), carla.Transform(), attach_to=car
    )
    sensor.listen(lambda event: found.append(event.other_actor.type_id))
    stage.actors.insert(0, sensor)
    return found


@pytest.mark.parametrize("distance_m", [2.0, 8.0, 30.0])
def test_backing_up_goes_straight_back_and_stands(stage, distance_m):
    car, stack = stage.ego(STREET, STREET_END)
    outcome, trail = carry_out(stage, car, stack, BackUp(distance_m=distance_m))
    assert outcome.finished, outcome.text
    assert trail[0][0] - trail[-1][0] == pytest.approx(distance_m, abs=1.6)
    assert max(abs(d) for _, d, _ in trail) < 0.2
    assert -1.5 < min(v for *_, v in trail) < -0.4
    assert abs(trail[-1][2]) < 0.2


@pytest.mark.release
def test_backing_up_first_it_swings_out_from_close_behind(stage):
    car, stack = stage.ego(STREET, STREET_END)
    parked = stage.add(CAR, (11, -1, 47.5))
    bumps = watch_collisions(stage, car)
    stage.drive(car, stack, 11.0, SafeStop(reason="until the car has stood for long enough"))
    borrow = BorrowOncomingLane(past_object_id=str(parked.id), speed_mps=5.0)
    outcome, trail = carry_out(stage, car, stack, BackUp(distance_m=5.0), borrow)
    assert outcome.finished, outcome.text
    assert trail[-1][0] - trail[0][0] > 12.0
    assert not bumps


def test_a_flat_thing_is_driven_over_at_walking_pace(stage):
    car, stack = stage.ego(STREET, STREET_END)
    litter = stage.add("static.prop.creasedbox01", (11, -1, 50.0))
    stage.ticks(40)
    outcome, trail = carry_out(stage, car, stack, DriveOver(object_id=str(litter.id)))
    assert outcome.finished, outcome.text
    assert trail[-1][0] - trail[0][0] > 12.0
    assert max(v for *_, v in trail) < WALKING_MPS + 0.3


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_nudge_stays_within_the_lane(stage, side):
    car, stack = stage.ego(STREET, STREET_END)
    outcome, trail = carry_out(stage, car, stack, Nudge(side=side, offset_m=0.6, distance_m=10.0))
    assert outcome.finished, outcome.text
    turn = 1 if side == "left" else -1
    assert trail[-1][1] * turn == pytest.approx(0.6, abs=0.2)
    lane = FrenetScene(stack.surroundings()).ego_lane
    half = FrenetScene(stack.surroundings()).ego.width_m / 2
    right, _, left = lane.at(trail[-1][0])
    assert all(right < d - half and d + half < left for _, d, _ in trail)


def test_pulled_over_it_stands_at_the_edge_and_comes_back(stage):
    car, stack = stage.ego(STREET, STREET_END)
    outcome, trail = carry_out(stage, car, stack, HazardLights(), PullOver())
    assert outcome.finished, outcome.text
    assert trail[-1][1] < -0.4
    assert int(car.get_light_state()) & 48 == 48
    outcome, trail = carry_out(stage, car, stack, HazardLights(on=False), RejoinRoute())
    assert outcome.finished, outcome.text
    assert abs(trail[-1][1]) < 0.3
    assert int(car.get_light_state()) & 48 == 0


def test_the_minimal_risk_condition_ends_at_rest_with_hazard_lights(stage):
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 2.0)
    plan = minimal_risk(GUARD, FrenetScene(stack.surroundings()), "nothing more can be done")
    assert [b.name for b in plan.behaviors] == ["hazard_lights", "pull_over", "request_assistance"]
    execution = Execution(plan, GUARD, guided=False)
    assert execution.start(FrenetScene(stack.surroundings()), stack.status().time_s).accepted
    told = []
    for _ in range(400):
        result = execution.tick(FrenetScene(stack.surroundings()), stack.status().time_s)
        if isinstance(result, ExecutionOutcome):
            break
        told.append(result)
        car.apply_control(stack.perform(result))
        stage.world.tick()
    assert isinstance(told[-1], SafeStop)
    velocity = car.get_velocity()
    assert math.hypot(velocity.x, velocity.y) < 0.1
    assert int(car.get_light_state()) & 48 == 48


def test_creep_and_replan_end_stopped_on_route(stage):
    """Creeping and a new route leave the vehicle stopped on its route."""
    car, stack = stage.ego(STREET, STREET_END)
    outcome, trail = carry_out(stage, car, stack, Creep(distance_m=6.0), ReplanRoute())
    assert outcome.finished, outcome.text
    assert max(s for s, *_ in trail) - trail[0][0] == pytest.approx(6.0, abs=1.6)
    assert max(v for *_, v in trail) < WALKING_MPS
