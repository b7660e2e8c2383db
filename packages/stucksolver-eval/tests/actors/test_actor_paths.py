"""Lines that cars of a run follow, their pedals, and who touches whom."""

from __future__ import annotations

import itertools
import math
from functools import lru_cache
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

carla = pytest.importorskip("carla")

from carlette.maps import DEMO_TOWN  # noqa: E402
from stucksolver_eval.actors import ActorState, LanePath, ScenarioActor  # noqa: E402
from stucksolver_eval.actors.lead_vehicles import boxes_touch  # noqa: E402
from stucksolver_eval.actors.vehicle_control import BodyPedals  # noqa: E402


@lru_cache(maxsize=1)
def town() -> Any:
    return carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))


def start() -> Any:
    return town().get_waypoint_xodr(3, -2, 20.0)


def right_of_lane(path: LanePath, index: int) -> float:
    waypoint = town().get_waypoint(carla.Location(path.x[index], path.y[index], path.z[index]))
    place, yaw = waypoint.transform.location, math.radians(waypoint.transform.rotation.yaw)
    return -(path.x[index] - place.x) * math.sin(yaw) + (path.y[index] - place.y) * math.cos(yaw)


def test_lane_path_grow_extends_only_to_requested_length():
    """A path grows to the requested length and at most 4 m beyond it."""
    path = LanePath([start()])
    path.grow(50.0)
    assert 50.0 <= path.s[-1] < 54.0 and not path.ended
    assert all(1.5 < after - before < 2.5 for before, after in zip(path.s[:-1], path.s[1:], strict=True))


def test_lane_path_merge_starts_at_vehicle_and_keeps_offset():
    """A path that merges begins at the vehicle, crosses over steadily and ends at its lateral offset."""
    path = LanePath([start()], offset_m=0.5, merge=(-1.5, 20.0))
    path.grow(40.0)
    rights = [right_of_lane(path, k) for k in range(len(path.x))]
    assert rights[0] == pytest.approx(-1.5, abs=0.05) and rights[-1] == pytest.approx(0.5, abs=0.05)
    assert all(after > before - 0.02 for before, after in itertools.pairwise(rights))


def test_a_car_slows_in_time_before_a_bend():
    # The ring's corner has a radius of 40 m: 10 m/s there, more before.
    path = LanePath([start()])
    path.grow(600.0)
    assert min(path.limit_mps) == pytest.approx(10.0, abs=1.5)
    for k in range(1, len(path.s)):
        braking = (path.limit_mps[k - 1] ** 2 - path.limit_mps[k] ** 2) / (2.0 * (path.s[k] - path.s[k - 1]))
        assert math.isnan(braking) or braking < 2.01


@given(st.floats(0.0, 100.0))
def test_lane_path_point_lies_at_its_arc_length(s):
    """The point at an arc length lies on the path, no farther from its start than the arc length."""
    path = LanePath([start()])
    path.grow(110.0)
    x, y = path.point(s)
    nearest = min(math.hypot(x - a, y - b) for a, b in zip(path.x, path.y, strict=True))
    assert nearest < 1.1
    assert math.hypot(x - path.x[0], y - path.y[0]) < s + 0.01


@given(st.floats(-6.0, 3.0), st.floats(0.0, 30.0))
def test_pedals_are_never_pressed_together_nor_beyond_their_ends(acceleration, speed):
    pedals = BodyPedals()
    for _ in range(5):
        throttle, brake = pedals.step(acceleration, speed, 0.05)
        assert 0.0 <= throttle <= 1.0 and 0.0 <= brake <= 1.0 and throttle * brake == 0.0


@given(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.floats(-math.pi, math.pi))
def test_touching_is_mutual_and_far_bodies_do_not(x, y, yaw):
    car = ScenarioActor(1, "vehicle.x", None, 2.4, 0.9, 0.7)
    other = ScenarioActor(2, "vehicle.y", None, 2.0, 1.0, 0.7)
    here, there = ActorState(0, 0, 0, 0, 0, 0, 0), ActorState(x, y, 0, yaw, 0, 0, 0)
    touches = boxes_touch(car, here, other, there, 0.0)
    assert touches == boxes_touch(other, there, car, here, 0.0)
    distance = math.hypot(x, y)
    if distance > math.hypot(2.4, 0.9) + math.hypot(2.0, 1.0):
        assert not touches
    if distance < 1.9:
        assert touches
