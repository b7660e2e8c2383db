"""Rays meet the road, whatever stands on it, and nothing else."""

from __future__ import annotations

import pytest

from carlette.geometry import Vector
from carlette.world.rays import ROAD_LABEL, SIDEWALK_LABEL, TERRAIN_LABEL, cast
from straight import LANE_Y_M, add, straight_world

DOWN = Vector(z=-1.0)
CAR_LABEL = 14


def test_a_ray_down_meets_the_road_at_its_height() -> None:
    world = straight_world(slope=0.05)
    (hit,) = cast(world, Vector(100.0, LANE_Y_M, 12.3), DOWN, 20.0)
    assert hit.place.z == pytest.approx(5.0, abs=0.01)
    assert hit.distance_m == pytest.approx(7.3, abs=0.01)
    assert hit.label == ROAD_LABEL


@pytest.mark.parametrize(("y", "label"), [(LANE_Y_M, ROAD_LABEL), (5.0, SIDEWALK_LABEL), (30.0, TERRAIN_LABEL)])
def test_the_ground_is_labelled_by_what_it_is(y: float, label: int) -> None:
    assert cast(straight_world(), Vector(50.0, y, 2.0), DOWN, 5.0)[0].label == label


def test_a_car_is_met_before_the_road_below_it() -> None:
    world = straight_world()
    car = add(world, x=50.0, yaw=30.0)
    world.tick()
    on_car, on_road = cast(world, Vector(50.0, LANE_Y_M, 10.0), DOWN, 20.0)
    assert on_car.label == CAR_LABEL
    assert on_car.place.z == pytest.approx(world.pose(car).location.z + car.box.center.z + car.box.extent.z, abs=0.02)
    assert on_road.label == ROAD_LABEL


def test_a_level_ray_meets_the_side_of_a_turned_box() -> None:
    world = straight_world()
    car = add(world, x=50.0, yaw=90.0)
    world.tick()
    (hit,) = cast(world, Vector(40.0, LANE_Y_M, 1.0), Vector(x=5.0), 20.0)
    assert hit.distance_m == pytest.approx(10.0 - car.box.extent.y, abs=0.1)


def test_ray_ending_above_or_starting_below_road_hits_nothing() -> None:
    """A ray that ends before the road, begins below it or points away from it hits nothing."""
    world = straight_world()
    assert cast(world, Vector(50.0, LANE_Y_M, 10.0), DOWN, 9.5) == []
    assert cast(world, Vector(50.0, LANE_Y_M, -1.0), DOWN, 50.0) == []
    assert cast(world, Vector(50.0, LANE_Y_M, 2.0), Vector(z=1.0), 50.0) == []
