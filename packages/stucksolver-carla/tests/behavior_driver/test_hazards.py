"""What counts as lying in the way, and how far away it is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behavior_driver.fakes import HALF_SIZE_M, FakeWorld, box
from stucksolver_carla.drivers.behavior.nearby_objects import GroundTruthObjects
from stucksolver_carla.drivers.behavior.path import PlanarPose, make_path
from stucksolver_carla.drivers.behavior.swept_path import nearest_hazards, sweep
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

MODEL = VehicleModel(HALF_SIZE_M[0], HALF_SIZE_M[1], 2.9, 0.7)
START = PlanarPose(0.0, 0.0, 0.0)
STRAIGHT = make_path(np.arange(0.0, 100.0), np.zeros(100), np.full(100, 10.0))


def world_with(type_id="vehicle.a", x=30.0, y=0.0, yaw=0.0, **extra):
    world = FakeWorld()
    world.add_ego(0.0, 0.0)
    world.add(type_id, x, y, yaw, **extra)
    return world


def hazards(world, path=STRAIGHT, pose=START, margin=0.3, length=60.0):
    swept = sweep(path, path.project(pose), pose, MODEL, 1.8, length)
    return nearest_hazards(swept, GroundTruthObjects(world, 1).read(pose.x, pose.y), MODEL, margin, 0.5)


@given(st.floats(6.0, 55.0))
def test_the_gap_is_from_bumper_to_bumper(x):
    (found,) = hazards(world_with(x=x))
    assert found.gap == pytest.approx(x - 2.0 * HALF_SIZE_M[0], abs=0.02)


@settings(max_examples=60)
@given(st.floats(0.0, 50.0), st.floats(0.31, 3.0), st.sampled_from([-1.0, 1.0]))
def test_what_stands_beside_the_path_never_counts(x, clearance, side):
    y = side * (2.0 * HALF_SIZE_M[1] + clearance)
    assert hazards(world_with(x=x, y=y)) == []


@settings(max_examples=60)
@given(st.floats(6.0, 50.0), st.floats(-math.pi, math.pi), st.floats(-0.9, 0.9))
def test_hazard_across_path_always_counts(x, yaw, y):
    """A body across the path always counts, and the gap to it is free."""
    (found,) = hazards(world_with("static.prop.a", x + 3.0, y, yaw, bounding_box=box(2.0, 0.5, 0.5)))
    farthest = x + 3.0 - HALF_SIZE_M[0]
    assert farthest - math.hypot(2.0, 0.5) - 0.6 < found.gap <= farthest


@pytest.mark.parametrize(
    "type_id",
    ["vehicle.a", "walker.pedestrian.0001", "static.prop.trafficcone01", "static.prop.container", "else.thing"],
)
def test_anything_with_a_body_counts(type_id):
    assert len(hazards(world_with(type_id, bounding_box=box(0.2, 0.2, 0.4)))) == 1


@pytest.mark.parametrize(
    "type_id", ["sensor.camera.rgb", "traffic.traffic_light", "traffic.stop", "spectator", "controller.ai.walker"]
)
def test_what_has_no_body_does_not_count(type_id):
    assert hazards(world_with(type_id)) == []


def test_hazard_flat_object_is_ignored_and_unknown_size_counts():
    assert hazards(world_with("static.prop.flat", bounding_box=box(1.0, 1.0, 0.02))) == []
    assert len(hazards(world_with("static.prop.odd", bounding_box=box(0.0, 0.0, 0.0)))) == 1
    assert len(hazards(world_with("static.prop.odd", bounding_box=box(math.inf, 1.0, 1.0)))) == 1


@pytest.mark.parametrize("z", [-6.0, 6.0])
def test_a_road_above_or_below_is_elsewhere(z):
    assert hazards(world_with(z=z)) == []


def test_the_leader_is_known_with_its_speed_along_the_path():
    assert hazards(world_with(speed=4.0))[0].speed == pytest.approx(4.0)
    assert hazards(world_with(yaw=math.pi, speed=4.0))[0].speed == 0.0


def test_hazard_pedestrian_entering_path_counts_and_alongside_does_not():
    """A pedestrian about to step into the path counts; one that walks along it does not."""
    size = box(0.2, 0.2, 0.9)
    crossing = world_with("walker.pedestrian.1", 20.0, 3.0, -math.pi / 2, speed=1.4, bounding_box=size)
    along = world_with("walker.pedestrian.1", 20.0, 3.0, 0.0, speed=1.4, bounding_box=size)
    assert hazards(crossing)[0].is_walker
    assert hazards(along) == []


def test_an_ego_that_touches_something_may_drive_away_from_it():
    assert hazards(world_with(x=-4.65)) == []
    assert hazards(world_with(x=4.65))[0].gap == 0.0


def test_the_corner_that_swings_out_in_a_bend_is_seen():
    s = np.arange(0.0, 30.0, 0.5)
    bend = make_path(8.0 * np.sin(s / 8.0), 8.0 * (1.0 - np.cos(s / 8.0)), np.full(len(s), 3.0))
    angle = 1.2
    radius = 8.0 + HALF_SIZE_M[1] + 0.25
    x, y = radius * math.sin(angle), 8.0 - radius * math.cos(angle)
    post = world_with("static.prop.post", x, y, bounding_box=box(0.05, 0.05, 0.5))
    assert len(hazards(post, bend, margin=0.0)) == 1


def test_the_server_is_asked_for_actors_only_when_they_change():
    world = world_with()
    perception = GroundTruthObjects(world, 1)
    for _ in range(5):
        perception.read(0.0, 0.0)
    assert world.listed == 1
    world.add("vehicle.b", 40.0, 0.0)
    assert len(perception.read(0.0, 0.0)) == 2
    assert world.listed == 2
    del world.actors[1]
    assert len(perception.read(0.0, 0.0)) == 1
