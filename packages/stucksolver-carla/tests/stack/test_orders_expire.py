"""An order that nobody renews expires on the road: a stop before the commit point, finishing after it."""

from __future__ import annotations

import math

import numpy as np
import pytest

carla = pytest.importorskip("carla")

from fake_agents import FakeAgent  # noqa: E402
from test_agent_plan import driver_on  # noqa: E402
from test_carla_stack import KEEP, STREET, STREET_END, WAIT, speed_of, swerve  # noqa: E402
from townstage import TICK_S  # noqa: E402

import stucksolver_carla  # noqa: E402
from stucksolver.plan import CONTINUE, Execute, PathPoint, SafeStop  # noqa: E402
from stucksolver.plan.directive import EXPIRES_TICKS  # noqa: E402

LEFT_M = 3.0
SECOND = round(1.0 / TICK_S)
STOP_M = 5.0**2 / (2 * 3.0) + 5.0 * EXPIRES_TICKS * TICK_S
"""From 5 m/s: the ticks for which the order is good, then a gentle stop."""


def silent(stage, car, stack, directive, seconds):
    """The control loop goes on with what was said last, or nothing; nobody asks the solver. Speeds of all ticks."""
    speeds = []
    for _ in range(round(seconds / TICK_S)):
        car.apply_control(stack.perform(directive))
        stage.world.tick()
        speeds.append(speed_of(car))
    return np.array(speeds)


@pytest.mark.integration
@pytest.mark.parametrize("says_nothing", [True, False])
def test_directive_expired_stops_on_path_then_driver_drives(stage, says_nothing):
    """Without answers, the ego stops on the path; then the driver drives by itself."""
    car, stack = stage.ego(STREET, STREET_END)
    order = swerve(stack, LEFT_M, 80.0)
    stage.drive(car, stack, 3.0, order)
    begun = car.get_location()
    speeds = silent(stage, car, stack, None if says_nothing else order, 4.0)
    at_rest = int((speeds < 0.1).argmax())
    assert speeds[:EXPIRES_TICKS].min() > 3.0, "it is good for so long"
    assert 0 < at_rest < 3 * SECOND
    speeds = silent(stage, car, stack, None, 6.0)
    assert speeds[-1] > 2.0, "it is never left standing by us"
    lane = stage.map.get_waypoint(car.get_location())
    assert lane.transform.location.distance(car.get_location()) < 0.5, "back on its route"
    assert begun.distance(car.get_location()) > STOP_M


def test_the_silent_vehicle_goes_no_further_than_a_stop_takes(stage):
    car, stack = stage.ego(STREET, STREET_END)
    order = swerve(stack, LEFT_M, 80.0)
    stage.drive(car, stack, 3.0, order)
    begun = car.get_location()
    for _ in range(4 * SECOND):
        car.apply_control(stack.perform(None))
        stage.world.tick()
        if speed_of(car) < 0.1:
            break
    assert begun.distance(car.get_location()) < STOP_M + 1.0


@pytest.mark.integration
def test_directive_expired_past_commit_point_finishes_path(stage):
    """Without answers, a path is finished where a stop would not be safe."""
    car, stack = stage.ego(STREET, STREET_END)
    order = swerve(stack, LEFT_M, 40.0)
    committed = order.model_copy(update={"path": tuple(p.model_copy(update={"no_stop": True}) for p in order.path)})
    stage.drive(car, stack, 3.0, committed)
    speeds = silent(stage, car, stack, None, 4.0)
    assert speeds.min() > 3.0
    assert abs(offset_m(stage, car)) > 2.0, "still on the path"
    silent(stage, car, stack, None, 10.0)
    assert abs(offset_m(stage, car)) < 0.5, "done with it, it drives its route"


def offset_m(stage, car):
    """From the middle of the street's lane (meters, left positive)."""
    here = car.get_location()
    middle = stage.map.get_waypoint_xodr(11, -1, 60.0).transform
    right = middle.get_right_vector()
    return (middle.location.x - here.x) * right.x + (middle.location.y - here.y) * right.y


def test_a_safe_stop_does_not_expire(stage):
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 3.0)
    stage.drive(car, stack, 3.0, SafeStop(reason="nothing more can be done"))
    assert silent(stage, car, stack, None, 3.0).max() < 0.1


@pytest.mark.integration
def test_hold_expires_once_it_stands(stage):
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 3.0)
    stage.drive(car, stack, 3.0, Execute(behavior=WAIT))
    assert silent(stage, car, stack, None, 4.0)[-1] > 2.0


# ---- how hard

LEAST, MOST = 0.85, 1.25
"""Of what was ordered: pedals are learnt while the vehicle brakes, and too hard is the safer error."""


def braked_mps2(stage, car, stack, brake_mps2):
    """Mean deceleration from nine tenths of the speed down to 1 m/s."""
    stage.drive(car, stack, 4.0, CONTINUE)
    begun = speed_of(car)
    assert begun > 5.0
    speeds = [begun]
    order = Execute(behavior=WAIT, brake_mps2=brake_mps2)
    for _ in range(5 * SECOND):
        stage.drive(car, stack, TICK_S, order)
        speeds.append(speed_of(car))
    speeds = np.array(speeds)
    assert speeds[-1] < 0.1
    first, last = int((speeds < 0.9 * begun).argmax()), int((speeds < 1.0).argmax())
    return (speeds[first] - speeds[last]) / ((last - first) * TICK_S)


@pytest.mark.parametrize("brake_mps2", [2.0, 3.0, 4.5, 6.0])
def test_the_driver_brakes_as_hard_as_it_is_told(stage, brake_mps2):
    car, stack = stage.ego(STREET, STREET_END)
    assert LEAST * brake_mps2 < braked_mps2(stage, car, stack, brake_mps2) < MOST * brake_mps2


@pytest.mark.parametrize("brake_mps2", [3.0, 4.5, 6.0])  # gentler is no brake at all: it slows by 2.5 m/s² in gear
def test_an_agents_driver_brakes_as_hard_as_it_is_told(stage, brake_mps2):
    car, driver = driver_on(stage, FakeAgent, end=(11, -1, 110.0))
    for _ in range(5 * SECOND):
        car.apply_control(driver.run_step())
        stage.world.tick()
    driver.hold(brake_mps2)
    begun, speeds = speed_of(car), []
    for _ in range(4 * SECOND):
        car.apply_control(driver.run_step())
        stage.world.tick()
        speeds.append(speed_of(car))
    speeds = np.array(speeds)
    first, last = int((speeds < 0.9 * begun).argmax()), int((speeds < 1.0).argmax())
    assert begun > 4.0 and speeds[-1] < 0.1
    assert LEAST * brake_mps2 < (speeds[first] - speeds[last]) / ((last - first) * TICK_S) < MOST * brake_mps2


def test_agent_driver_stop_on_curved_path_stays_on_it(stage):
    """An agent's driver that stops on a curved path stays on it.

    The proven stop is along the path, not along its tangent.
    """
    car, driver = driver_on(stage, FakeAgent, end=(11, -1, 110.0))
    here = car.get_transform()
    yaw = math.radians(here.rotation.yaw)
    angles = np.linspace(0.0, 1.5, 60)
    ahead, aside = 12.0 * np.sin(angles), 12.0 * (1.0 - np.cos(angles))
    xs = here.location.x + ahead * math.cos(yaw) + aside * math.sin(yaw)
    ys = here.location.y + ahead * math.sin(yaw) - aside * math.cos(yaw)
    driver.follow([(float(x), float(y), 4.0) for x, y in zip(xs, ys, strict=True)])
    for _ in range(6 * SECOND):
        if speed_of(car) > 3.3:
            break
        car.apply_control(driver.run_step())
        stage.world.tick()
    assert speed_of(car) > 3.0

    def off_m():
        place = car.get_location()
        return float(np.hypot(xs - place.x, ys - place.y).min())

    before = off_m()
    driver.hold(2.0)
    for _ in range(4 * SECOND):
        car.apply_control(driver.run_step())
        stage.world.tick()
    assert speed_of(car) < 0.1
    assert off_m() < max(before, 0.2) + 0.25


# ---- orders that cannot be performed


def unfit():
    """Orders as no guard would give them, made without validation."""
    point = PathPoint(x_m=0.0, y_m=0.0, speed_mps=3.0)
    far = PathPoint(x_m=50.0, y_m=0.0, speed_mps=3.0)
    spoilt = PathPoint.model_construct(x_m=math.nan, y_m=0.0, speed_mps=3.0, no_stop=False)
    order = Execute(behavior=KEEP, path=(point, far))
    return {
        "one point": order.model_copy(update={"path": (point,)}),
        "one place": order.model_copy(update={"path": (point, point, point)}),
        "NaN": order.model_copy(update={"path": (point, spoilt, far)}),
        "speed is text": order.model_copy(update={"path": (point, far.model_copy(update={"speed_mps": "fast"}))}),
        "too many": order.model_copy(update={"path": (point, far) * 100_000}),
        "points are texts": order.model_copy(update={"path": ("here", "there")}),
        "path is none": order.model_copy(update={"path": None}),
        "ids": order.model_copy(update={"ignore": ("the bag",)}),
        "brake": Execute(behavior=WAIT).model_copy(update={"brake_mps2": math.nan}),
        "expiry": order.model_copy(update={"expires_ticks": "never"}),
        "a dict": {"kind": "execute"},
        "a text": "continue",
    }


@pytest.mark.integration
@pytest.mark.parametrize("name", sorted(unfit()))
def test_directive_not_performable_stops_and_is_reported_once(stage, capsys, name):
    """A directive that cannot be performed stops the ego and is reported once."""
    car, stack = stage.ego(STREET, STREET_END)
    stage.drive(car, stack, 3.0)
    stage.drive(car, stack, 3.0, unfit()[name])
    assert speed_of(car) < 0.1
    assert capsys.readouterr().err.count("the vehicle stops") == 1
    stage.drive(car, stack, 3.0, CONTINUE)
    assert speed_of(car) > 1.0


# ---- beside an agent


def test_solver_failure_in_agent_process_keeps_its_loop(stage, capsys):
    """A solver that fails in the agent's process does not end its loop."""
    car, driver = driver_on(stage, FakeAgent, end=(11, -1, 110.0), keeps_going=False)
    helped = stucksolver_carla.attach(driver.agent, ladder="evaluation", clock="lockstep")
    order = None

    def path(status, surroundings):
        nonlocal order
        order = order or swerve(helped._stack, LEFT_M, 60.0)
        return order

    helped.solver.step = path
    for _ in range(6 * SECOND):
        if speed_of(car) > 2.0:
            break
        car.apply_control(helped.run_step())
        stage.world.tick()
    assert speed_of(car) > 2.0
    helped.solver.step = lambda status, surroundings: 1 / 0
    speeds = []
    for _ in range(3 * SECOND):
        car.apply_control(helped.run_step())
        stage.world.tick()
        speeds.append(speed_of(car))
    assert min(speeds) < 0.1, "it has stopped"
    assert "ZeroDivisionError" in helped.fault
    assert capsys.readouterr().err.count("the solver has failed") == 1
    helped.close()
