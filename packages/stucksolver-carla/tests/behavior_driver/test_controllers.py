"""What steering and pedals promise to the road and the passengers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from behavior_driver.fakes import TICK_S, FakeWorld
from behavior_driver.roads import straight_road
from stucksolver_carla.drivers.behavior import BehaviorDriver, DrivePoint
from stucksolver_carla.drivers.behavior.controllers import MAX_STEER, MAX_STEER_STEP, PedalController, SteerController
from stucksolver_carla.drivers.behavior.path import Projection, make_path
from stucksolver_carla.drivers.behavior.route_line import smooth_step
from stucksolver_carla.drivers.behavior.steer_map import SteerMap
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

MODEL = VehicleModel(2.4, 1.0, 2.9, math.radians(70.0))


def swing_out(speed, shift, over):
    """Largest offset (m) and speed of a drive that shifts sideways, from standstill if slow."""
    world = FakeWorld(straight_road())
    ego = world.add_ego(50.0, 0.0, 0.0, speed if speed > 5.0 else 0.0)
    driver = BehaviorDriver(ego)
    along = np.arange(0.0, over + 25.0, 0.5)
    aside = shift * smooth_step((along - 1.0) / over)
    driver.follow([DrivePoint(50.0 + x, y, speed) for x, y in zip(along, aside, strict=True)])
    worst = fastest = 0.0
    for _ in range(900):
        ego.apply_control(driver.run_step())
        world.tick()
        worst, fastest = max(worst, abs(driver.lateral_error_m)), max(fastest, ego.speed)
    assert driver.path_left_m < 0.4 and ego.speed < 0.1
    return worst, fastest


@pytest.mark.parametrize("side", [-2.9, 2.9])
@pytest.mark.parametrize(("speed", "over"), [(3.5, 9.0), (2.0, 9.0), (1.0, 9.5)])
def test_steering_tight_swing_out_from_standstill_stays_within_30_cm(speed, over, side):
    """A tight swing-out from a standstill is tracked within 0.3 m."""
    worst, fastest = swing_out(speed, side, over)
    assert worst < 0.3
    assert fastest < speed + 0.2


def test_a_lane_change_at_speed_is_tracked():
    assert swing_out(8.0, 3.5, 25.0)[0] < 0.3


@given(st.lists(st.tuples(st.floats(-5.0, 5.0), st.floats(-3.0, 3.0), st.floats(0.0, 15.0)), min_size=1, max_size=30))
def test_steer_stays_within_its_published_limits_whatever_happens(states):
    path = make_path(np.arange(0.0, 50.0), np.zeros(50), np.full(50, 5.0))
    controller, before = SteerController(MODEL), 0.0
    for lateral, heading, speed in states:
        steer = controller.step(path, Projection(20.0, lateral, heading), speed)
        assert abs(steer) <= MAX_STEER and abs(steer - before) <= MAX_STEER_STEP + 1e-9
        before = steer


@given(st.floats(-0.7, 0.7))
def test_the_steer_map_is_its_own_inverse(angle):
    steer_map = SteerMap(math.radians(70.0))
    assert steer_map.angle(steer_map.steer(angle)) == pytest.approx(angle, abs=0.01)


@pytest.mark.integration
@given(st.floats(0.45, 1.1), st.floats(0.05, 0.6))
def test_the_steer_map_learns_what_the_wheels_really_do(share, steer):
    steer_map, lock = SteerMap(math.radians(70.0)), math.radians(70.0)
    for _ in range(600):
        steer_map.observe(steer, 5.0, 5.0 / 2.9 * math.tan(steer * lock * share), 2.9)
    assert steer_map.angle(steer) == pytest.approx(steer * lock * share, rel=0.03)


@given(st.floats(-9.0, 3.0), st.floats(0.0, 20.0), st.floats(-9.0, 3.0))
def test_pedals_are_never_pressed_together_and_keep_their_limits(first, speed, second):
    pedals = PedalController()
    for wanted in (first, second):
        throttle, brake = pedals.step(wanted, speed, TICK_S)
        assert throttle == 0.0 or brake == 0.0
        assert 0.0 <= throttle <= 0.75
        assert 0.0 <= brake <= (1.0 if wanted < -4.0 else 0.5)


def test_a_car_at_rest_is_held_by_the_brake():
    assert PedalController().step(-0.1, 0.0, TICK_S) == (0.0, 0.5)
