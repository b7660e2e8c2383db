"""When a light stops the ego, and when it no longer can."""

from __future__ import annotations

import math
from types import SimpleNamespace

import carla
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from behavior_driver.fakes import FakeWorld
from stucksolver_carla.drivers.behavior.path import make_path
from stucksolver_carla.drivers.behavior.traffic_light_stops import LightWatch, StopLine, stop_lines

RED, YELLOW, GREEN = (getattr(carla.TrafficLightState, name) for name in ("Red", "Yellow", "Green"))
COMFORTABLE = 2.5


def light_at(*places, state=RED):
    light = FakeWorld().add("traffic.traffic_light", 0.0, 0.0, state=state)
    for x, y, yaw in places:
        at = carla.Transform(carla.Location(x, y, 0.0), carla.Rotation(yaw=yaw))
        light.stops.append(SimpleNamespace(transform=at))
    return light


def watch(state):
    return LightWatch([StopLine(light_at(state=state), 100.0)])


@given(st.floats(0.0, 15.0), st.floats(0.0, 99.0))
def test_red_is_obeyed_wherever_the_car_can_stop(speed, front):
    distance = watch(RED).distance_to_stop(front, speed, COMFORTABLE)
    if speed**2 / (2.0 * 5.0) < 100.0 - front - 1e-6:
        assert distance == pytest.approx(100.0 - front)


def test_light_yellow_stops_only_with_comfortable_braking():
    """A yellow light stops the ego only with comfortable braking; later it is passed even if it turns red."""
    assert watch(YELLOW).distance_to_stop(60.0, 10.0, COMFORTABLE) == pytest.approx(40.0)
    late = watch(YELLOW)
    assert late.distance_to_stop(90.0, 10.0, COMFORTABLE) is None
    late._lines[0].light.state = RED
    assert late.distance_to_stop(95.0, 10.0, COMFORTABLE) is None


def test_light_red_stops_ego_that_stopped_before_line():
    """An ego that stopped before the line after all obeys the red light."""
    late = watch(YELLOW)
    assert late.distance_to_stop(90.0, 10.0, COMFORTABLE) is None
    late._lines[0].light.state = RED
    assert late.distance_to_stop(97.0, 0.0, COMFORTABLE) == pytest.approx(3.0)


def test_green_and_passed_lights_ask_for_nothing():
    assert watch(GREEN).distance_to_stop(90.0, 5.0, COMFORTABLE) is None
    assert watch(RED).distance_to_stop(101.5, 5.0, COMFORTABLE) is None


def test_stop_lines_lie_only_at_lights_of_route_direction():
    """Only lights across the route in its direction have a stop line there."""
    path = make_path(np.arange(0.0, 100.0), np.zeros(100), np.full(100, 9.0))
    ours = light_at((40.0, 0.3, 0.0), (40.0, 3.5, 0.0))
    others = [light_at((40.0, 0.0, 180.0)), light_at((40.0, 3.5, 0.0)), light_at((140.0, 0.0, 0.0))]
    (line,) = stop_lines([ours, *others], path)
    assert line.light is ours
    assert line.s == pytest.approx(40.0, abs=0.3)


def test_a_light_passed_twice_has_two_lines():
    angle = np.arange(0.0, 4.0 * math.pi, 0.02)
    path = make_path(30.0 * np.sin(angle), 30.0 * (1.0 - np.cos(angle)), np.full(len(angle), 5.0))
    lines = stop_lines([light_at((30.0, 30.0, 90.0))], path)
    assert [round(line.s) for line in lines] == [47, 236]


def test_light_released_by_operator_does_not_stop():
    light = light_at(state=RED)
    light.id = 7
    watched = LightWatch([StopLine(light, 100.0)])
    assert watched.distance_to_stop(97.0, 0.0, 3.0) == pytest.approx(3.0)
    assert watched.distance_to_stop(97.0, 0.0, 3.0, {7}) is None
    assert watched.distance_to_stop(97.0, 0.0, 3.0, {8}) == pytest.approx(3.0)
