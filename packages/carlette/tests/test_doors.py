"""An open door takes room beside the car, and only there."""

from __future__ import annotations

import pickle

import pytest

from carlette.errors import SpawnCollisionError
from carlette.geometry import Pose, Vector
from carlette.physics.doors import ALL, REACH_M, STOP_ARM
from carlette.world.spawn import spawn
from straight import CAR, LANE_Y_M, add, launch, speed_of, straight_world, ticks

MKZ, WALKER = "vehicle.lincoln.mkz_2020", "walker.pedestrian.0001"
FRONT_LEFT, FRONT_RIGHT, HOOD = 0, 1, 4
BESIDE_M = 2.3
"""Between the middles of two cars that pass: mirror to mirror, without a door between."""


def parked(door: int | None = None):
    world = straight_world()
    car = add(world, MKZ, 80.0)
    if door is not None:
        world.doors.move(car.row, car.box, door, True)
        list(ticks(world, 20))
    return world, car


def pass_by(world, side: float):
    """A car drives past on that side; whom it hit."""
    passing = add(world, CAR, 60.0, y=LANE_Y_M + side * BESIDE_M)
    sensor = spawn(world, "sensor.other.collision", {}, Pose(), parent_id=passing.id)
    launch(world, passing, 12.0)
    hits = [hit for w in ticks(world, 60) for hit in w.collisions if hit.sensor_id == sensor.id]
    return passing, {item.other_id for item in hits}


def test_cars_pass_while_the_doors_are_shut() -> None:
    world, _ = parked()
    assert not pass_by(world, -1.0)[1]
    assert not pass_by(world, 1.0)[1]


@pytest.mark.parametrize(("door", "side"), [(FRONT_LEFT, -1.0), (FRONT_RIGHT, 1.0), (2, -1.0), (3, 1.0)])
def test_an_open_door_is_hit_on_its_side_only(door: int, side: float) -> None:
    world, car = parked(door)
    assert not pass_by(world, -side)[1]
    passing, hits = pass_by(world, side)
    assert hits == {car.id}
    assert speed_of(world, passing) < 11.0


def test_all_opens_all_four_and_closing_shuts_them() -> None:
    world, car = parked(ALL)
    assert sorted(world.doors.door.tolist()) == [0, 1, 2, 3]
    world.doors.move(car.row, car.box, FRONT_LEFT, False)
    list(ticks(world, 20))
    assert sorted(world.doors.door.tolist()) == [1, 2, 3]
    world.doors.move(car.row, car.box, ALL, False)
    list(ticks(world, 20))
    assert not len(world.doors)
    assert not pass_by(world, -1.0)[1]


def test_hood_and_trunk_take_no_room() -> None:
    world, _ = parked(HOOD)
    assert not len(world.doors)


def test_open_door_extends_0_9_m_beyond_unchanged_box() -> None:
    """An open door extends 0.9 m beyond the car, and the bounding box of the car does not change."""
    world, car = parked(FRONT_LEFT)
    center, half = world.doors.boxes(world.bodies)
    assert -center[0, 1] + half[0, 1] == pytest.approx(car.box.extent.y + REACH_M)
    assert car.box.extent.y == pytest.approx(0.918, abs=0.001)


def test_open_door_leaves_with_car_and_is_copied_with_world() -> None:
    """A door is removed with its car, and is part of a copy of the world."""
    world, car = parked(FRONT_LEFT)
    other = add(world, MKZ, 120.0)
    world.doors.move(other.row, other.box, FRONT_RIGHT, True)
    assert len(pickle.loads(pickle.dumps(world)).doors) == 2
    world.remove(car.id)
    assert world.doors.row.tolist() == [other.row]


def test_school_bus_stop_arm_extends_on_left() -> None:
    """The stop arm of the school bus extends 0.5 m on the left."""
    world = straight_world()
    bus = add(world, "vehicle.carlette.schoolbus", 80.0)
    world.doors.move(bus.row, bus.box, STOP_ARM, True)
    list(ticks(world, 20))
    center, half = world.doors.boxes(world.bodies)
    assert -center[0, 1] + half[0, 1] == pytest.approx(bus.box.extent.y + 0.5)


def test_nothing_is_spawned_into_an_open_door() -> None:
    beside = {False: (80.7, LANE_Y_M - 1.5), True: (80.7, LANE_Y_M + 1.5)}
    for door, is_right in ((FRONT_LEFT, False), (FRONT_RIGHT, True)):
        world, _ = parked(door)
        free, taken = (Pose(Vector(*beside[side], 1.0)) for side in (not is_right, is_right))
        spawn(world, WALKER, {}, free)
        with pytest.raises(SpawnCollisionError):
            spawn(world, WALKER, {}, taken)
