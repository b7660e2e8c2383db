"""Radar and obstacle detector."""

from __future__ import annotations

import math

import msgpack
import numpy as np
import pytest
from mounting import Mounted, mount, street

from carlette.geometry import Pose, Rotation, Vector
from straight import LANE_Y_M, add, launch

BUMPER = Pose(Vector(2.6, 0.0, 0.7))
DENSE = {"points_per_second": 40000, "horizontal_fov": 30, "vertical_fov": 10}


def detections(one: Mounted) -> np.ndarray:
    """(n, 4): velocity, azimuth, altitude, depth."""
    return np.frombuffer(one.body(), "<f4").reshape(-1, 4)


@pytest.mark.integration
def test_radar_measures_range_and_closing_speed() -> None:
    """The radar measures the range and the closing speed of the car ahead."""
    world = street()
    own, other = add(world, x=50.0), add(world, x=80.0)
    one = mount(world, "sensor.other.radar", BUMPER, own.id, **DENSE)
    for _ in range(3):
        launch(world, own, 10.0)
        launch(world, other, 4.0)
        world.tick()
        found = detections(one)
    back = world.pose(other).location.x + other.box.center.x - other.box.extent.x
    gap = back - world.pose(one.actor).location.x
    ahead = found[(np.abs(found[:, 1]) < 0.02) & (np.abs(found[:, 2]) < 0.005)]
    assert len(ahead) > 5
    assert ahead[:, 3].min() == pytest.approx(gap, abs=0.1)
    closing = world.bodies.velocity[other.row, 0] - world.bodies.velocity[own.row, 0]
    assert ahead[:, 0] == pytest.approx(np.full(len(ahead), closing), abs=0.1)
    assert closing < -5.0


def test_radar_static_objects_approach_with_ego_speed() -> None:
    """A static object approaches at the speed with which the radar drives toward it."""
    world = street()
    own = add(world, x=50.0)
    one = mount(world, "sensor.other.radar", BUMPER, own.id, **DENSE)
    for _ in range(3):
        launch(world, own, 10.0)
        world.tick()
        found = detections(one)
    speed = float(world.bodies.velocity[own.row, 0])
    assert len(found) > 100
    assert found[:, 0] == pytest.approx(-speed * np.cos(found[:, 1]) * np.cos(found[:, 2]), abs=0.05)


def test_radar_detections_lie_in_field_of_view_and_range() -> None:
    """Detections lie in the cone of the radar and not beyond its range."""
    world = street()
    one = mount(
        world, "sensor.other.radar", Pose(Vector(50, 1.75, 1)), points_per_second=40000, horizontal_fov=60,
        vertical_fov=20, range=30,
    )  # fmt: skip
    found = detections(one)
    across, up = np.tan(found[:, 1]), np.tan(found[:, 2]) / np.cos(found[:, 1])
    assert ((across / math.tan(math.radians(30))) ** 2 + (up / math.tan(math.radians(10))) ** 2).max() <= 1.0 + 1e-4
    ahead = found[:, 3] * np.cos(found[:, 1]) * np.cos(found[:, 2])
    assert 25.0 < ahead.max() <= 30.0 + 1e-3
    height = 1.0 + found[:, 3] * np.sin(found[:, 2])
    on_road = np.abs(LANE_Y_M + found[:, 3] * np.cos(found[:, 2]) * np.sin(found[:, 1])) < 3.4
    assert height[on_road] == pytest.approx(np.zeros(on_road.sum()), abs=0.01)


def found_by(one: Mounted) -> list[tuple[int, int, float]]:
    """Who found whom, and how far away."""
    return [(me[0], other[0], distance) for me, other, distance in map(msgpack.unpackb, one.bodies())]


def test_obstacle_detector_reports_first_object_and_distance() -> None:
    """The obstacle detector reports the first object ahead and its distance."""
    world = street()
    own, other = add(world, x=50.0), add(world, x=62.0)
    add(world, x=75.0)
    world.tick()
    one = mount(world, "sensor.other.obstacle", BUMPER, own.id, distance=20, hit_radius=0.5)
    ((finder, met, distance),) = found_by(one)
    back = world.pose(other).location.x + other.box.center.x - other.box.extent.x
    assert (finder, met) == (own.id, other.id)
    assert distance == pytest.approx(back - world.pose(one.actor).location.x - 0.5, abs=2e-3)


@pytest.mark.parametrize(("aside_m", "is_met"), [(0.0, True), (1.3, True), (1.7, False)])
def test_obstacle_detector_lateral_reach_is_hit_radius(aside_m: float, is_met: bool) -> None:
    """An object is detected at a lateral offset up to half its width plus the hit radius."""
    world = street()
    other = add(world, x=60.0)
    y = LANE_Y_M + aside_m
    one = mount(world, "sensor.other.obstacle", Pose(Vector(50.0, y, 0.7)), distance=20, hit_radius=0.4)
    assert other.box.extent.y == pytest.approx(1.08, abs=0.01)
    assert bool(found_by(one)) is is_met


def test_obstacle_detector_only_dynamics_excludes_props_and_ground_never_counts() -> None:
    """With only_dynamics, props are excluded; the ground is never an obstacle."""
    world = street()
    add(world, "static.prop.container", x=60.0)
    ahead = Pose(Vector(50.0, LANE_Y_M, 0.3))
    assert found_by(mount(world, "sensor.other.obstacle", ahead, distance=20, hit_radius=0.5))
    assert not found_by(mount(world, "sensor.other.obstacle", ahead, distance=20, hit_radius=0.5, only_dynamics="true"))
    down = Pose(Vector(20.0, LANE_Y_M, 0.3), Rotation(pitch=-60))
    assert not found_by(mount(world, "sensor.other.obstacle", down, distance=20))


def test_nothing_ahead_is_no_message() -> None:
    world = street()
    own = add(world, x=50.0)
    assert not found_by(mount(world, "sensor.other.obstacle", BUMPER, own.id, distance=20))
