"""A driver that pushes a car along is immobilized, at whatever speed: it stops, and then goes round it."""

from __future__ import annotations

import math

import numpy as np
import pytest

carla = pytest.importorskip("carla")

from fake_agents import FakeAgent, RoadOption  # noqa: E402
from townstage import CAR  # noqa: E402

import stucksolver_carla  # noqa: E402
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects  # noqa: E402
from stucksolver_carla.stack.contact import EgoFootprint, PushDetector  # noqa: E402

START, PARKED = (11, -1, 20.0), (11, -1, 50.0)
EGO_AT_5 = EgoFootprint(0.0, 0.0, 0.0, 0.0, 2.4, 0.9, 5.0, 0.0)


def around(*bodies, top=1.5):
    """Cars as (x, y, vx)."""
    x, y, vx = (np.array(column, dtype=float) for column in zip(*bodies, strict=True))
    same = np.zeros(len(bodies))
    return NearbyObjects(
        actor_id=tuple(range(1, len(bodies) + 1)),
        is_walker=same.astype(bool),
        x=x,
        y=y,
        yaw=same,
        half_length=same + 2.4,
        half_width=same + 0.9,
        bottom=same + top - 1.5,
        top=same + top,
        vx=vx,
        vy=same,
    )


@pytest.mark.parametrize(
    ("body", "is_pushed"),
    [
        ((4.85, 0.0, 5.1), True),
        ((4.75, 0.5, 4.6), True),
        ((4.85, 0.0, 0.0), False),
        ((5.6, 0.0, 5.0), False),
        ((0.0, 1.9, -5.0), False),
        ((0.0, 3.5, 5.0), False),
    ],
    ids=["bumper to bumper", "askew", "just struck", "a car ahead as quick", "brushed", "in the next lane"],
)
def test_what_moves_as_one_with_the_ego_is_pushed(body, is_pushed):
    assert (PushDetector().update(EGO_AT_5, around(body)) == {1}) == is_pushed


def test_who_stands_pushes_nothing_and_a_bridge_is_not_pushed():
    at_rest = EGO_AT_5._replace(vx=0.0)
    assert not PushDetector().update(at_rest, around((4.8, 0.0, 0.0)))
    assert not PushDetector().update(EGO_AT_5, around((4.8, 0.0, 5.0), top=7.0))


def test_push_detector_keeps_pushed_object_until_it_stops():
    """A pushed object rolls on until it stops or speeds up."""
    pushing, ego = PushDetector(), EGO_AT_5._replace(vx=1.0)
    assert pushing.update(EGO_AT_5, around((4.8, 0.0, 5.0))) == {1}
    assert pushing.update(ego, around((8.0, 0.0, 3.0))) == {1}
    assert not pushing.pushed_ids
    assert pushing.update(ego, around((9.5, 0.0, 1.0))) == {1}
    assert not pushing.update(ego, around((9.9, 0.0, 0.0)))
    assert not pushing.update(ego, around((10.2, 0.0, 1.0)))
    assert pushing.update(EGO_AT_5, around((4.8, 0.0, 5.0))) == {1}
    assert not pushing.update(ego, around((9.0, 0.0, 6.0)))


def blind_driver(stage):
    """An agent that looks for nobody, on its way down the street towards a parked car."""
    parked = stage.add(CAR, PARKED)
    car = stage.add(CAR, START, role="hero")
    stage.ticks(2)
    agent = FakeAgent(car)
    plan = [(stage.map.get_waypoint_xodr(11, -1, float(s)), RoadOption.LANEFOLLOW) for s in range(20, 120)]
    agent.set_global_plan(plan)
    return car, parked, agent


def drive(stage, car, driver, seconds):
    for _ in range(round(20 * seconds)):
        car.apply_control(driver.run_step())
        stage.world.tick()


@pytest.mark.integration
def test_alone_it_pushes_the_car_down_the_street(stage):
    car, parked, agent = blind_driver(stage)
    before = parked.get_location()
    drive(stage, car, agent, 20.0)
    assert parked.get_location().distance(before) > 12.0
    assert parked.get_velocity().length() > 1.0


@pytest.mark.slow
@pytest.mark.integration
def test_solver_pushing_driver_stops_and_passes_car(stage):
    """With the solver, the driver stops pushing within seconds and passes the car."""
    car, parked, agent = blind_driver(stage)
    events, touching, struck = [], False, 0
    helped = stucksolver_carla.attach(agent, ladder="evaluation", clock="lockstep", on_event=events.append)
    pushed_s, told = 0.0, set()
    for _ in range(round(20 * 60.0)):
        drive(stage, car, helped, 0.05)
        status = helped._stack.status()
        pushed_s += 0.05 * status.pushes
        struck += status.pushes and not touching
        touching = status.pushes
        told |= {o.stationary_s > 3.0 for o in helped._stack.surroundings().objects if status.pushes}
    helped.close()
    said = "\n".join(f"{e.time_s:.1f} {e.kind.value} {e.text}" for e in events)
    assert any(e.text == "contact" for e in events), said
    assert (pushed_s < 4.0, struck) == (True, 1), said
    assert told == {True}, "what is pushed has stood for as long as before"
    assert math.hypot(*_apart(car, parked)) > 10.0 and _apart(car, parked)[0] > 0.0, said


@pytest.mark.integration
def test_ground_covered_by_pushing_is_no_progress(stage):
    car, _, agent = blind_driver(stage)
    helped = stucksolver_carla.attach(agent, ladder="evaluation", clock="lockstep", observe_only=True)
    progress = []
    for _ in range(round(20 * 14.0)):
        drive(stage, car, helped, 0.05)
        status = helped._stack.status()
        if status.pushes:
            progress.append(status.progress_m)
    helped.close()
    assert len(progress) > 100
    assert progress[-1] - progress[0] < 0.1


def _apart(car, other):
    """How far the car is ahead of the other, and beside it."""
    here, there = car.get_location(), other.get_transform()
    along, right = there.get_forward_vector(), there.get_right_vector()
    dx, dy = here.x - there.location.x, here.y - there.location.y
    return dx * along.x + dy * along.y, dx * right.x + dy * right.y
