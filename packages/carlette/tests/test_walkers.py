"""Pedestrians and animals walk, jump, step onto sidewalks, are hit and (where told so) die."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from carlette.blueprints import AttributeType
from carlette.geometry import Pose, Vector
from carlette.opendrive.road_network import CURB_M
from carlette.physics.walkers import LIES_S, MOST_MPS
from carlette.world.spawn import spawn
from straight import CAR, add, launch, speed_of, straight_world, ticks

WALKER = "walker.pedestrian.0001"
STAND_M = 0.93


def walk(world, walker, x=0.0, y=0.0, speed=1.5, jump=False) -> None:
    world.walkers.control[walker.index] = (x, y, 0.0, speed, jump)


def mortal(world, x: float):
    attributes = {"is_invincible": (AttributeType.BOOL, "false")}
    return spawn(world, WALKER, attributes, Pose(Vector(x, 1.75, STAND_M)))


def test_a_walker_keeps_its_speed_and_way() -> None:
    world = straight_world()
    walker = add(world, WALKER, z=STAND_M)
    walk(world, walker, x=3.0, y=4.0, speed=2.0)
    list(ticks(world, 10))
    assert world.bodies.velocity[walker.row, :2].tolist() == pytest.approx([1.2, 1.6])


@pytest.mark.parametrize(("asked", "walked"), [(-3.0, 0.0), (1e6, MOST_MPS), (math.nan, 0.0)])
def test_absurd_speeds_are_clamped(asked: float, walked: float) -> None:
    world = straight_world()
    walker = add(world, WALKER, z=STAND_M)
    walk(world, walker, x=1.0, speed=asked)
    world.tick()
    assert speed_of(world, walker) == pytest.approx(walked)
    assert world.bodies.record["walk_speed"][walker.row] == pytest.approx(walked)


def test_a_walker_steps_onto_the_sidewalk_and_down_again() -> None:
    world = straight_world()
    walker = add(world, WALKER, z=STAND_M)
    walk(world, walker, y=1.0, speed=2.0)
    list(ticks(world, 40))
    assert world.pose(walker).location.z == pytest.approx(STAND_M + CURB_M, abs=0.01)
    walk(world, walker, y=-1.0, speed=2.0)
    list(ticks(world, 50))
    assert world.pose(walker).location.z == pytest.approx(STAND_M, abs=0.01)


def test_walker_jump_has_unreal_height_and_lands() -> None:
    """A jump is as high as in Unreal and ends on the ground."""
    world = straight_world()
    walker = add(world, WALKER, z=STAND_M)
    list(ticks(world, 2))
    walk(world, walker, jump=True)
    heights = [w.pose(walker).location.z - STAND_M for w in ticks(world, 60)]
    assert 0.7 < max(heights) < 1.0
    assert heights[-1] == pytest.approx(0.0, abs=0.01)
    # Held down, the button makes no second jump.
    assert sum(height > 0.1 for height in heights) < 20


@pytest.mark.integration
def test_walker_hit_hard_dies_and_disappears_unless_invincible() -> None:
    """A walker that is hit hard dies and is removed, unless it is invincible."""
    world = straight_world()
    car, victim, immune = add(world, CAR, 50.0), mortal(world, 60.0), add(world, WALKER, 100.0, z=STAND_M)
    walk(world, victim, speed=1.0, y=-0.01)
    launch(world, car, 10.0)
    list(ticks(world, 40))
    assert world.walkers.dead[victim.index]
    walk(world, victim, x=1.0, speed=3.0)
    list(ticks(world, int(LIES_S / world.step_s) + 10))
    assert victim.id not in world.actors
    assert immune.id in world.actors
    launch(world, car, 15.0)
    list(ticks(world, 100))
    assert immune.id in world.actors


def test_a_soft_touch_kills_nobody() -> None:
    world = straight_world()
    car, walker = add(world, CAR, 50.0), mortal(world, 54.0)
    launch(world, car, 1.0)
    list(ticks(world, 60))
    assert not world.walkers.dead[walker.index]


@pytest.mark.integration
@given(st.floats(1.0, 40.0), st.floats(-0.9, 0.9))
@settings(max_examples=20)
def test_no_car_passes_through_a_walker(mps: float, aside_m: float) -> None:
    world = straight_world()
    car, walker = add(world, CAR, 50.0), add(world, WALKER, 65.0, z=STAND_M, y=1.75 + aside_m)
    sensor = spawn(world, "sensor.other.collision", {}, Pose(), parent_id=car.id)
    launch(world, car, mps)
    hits = [hit for w in ticks(world, 60) for hit in w.collisions]
    reached = world.pose(car).location.x + car.box.extent.x > 66.0
    assert not reached or {(item.sensor_id, item.other_id) for item in hits} == {(sensor.id, walker.id)}


def test_animal_walks_like_walker_with_own_size() -> None:
    """An animal walks like a walker, has its own size, and slows a car that hits it."""
    world = straight_world()
    cow = add(world, "animal.cow", 60.0, z=0.725)
    walk(world, cow, y=1.0, speed=1.2)
    list(ticks(world, 20))
    assert world.pose(cow).location.y == pytest.approx(1.75 + 1.2, abs=0.1)
    assert cow.box.extent == (1.2, 0.4, 0.725)
    car = add(world, CAR, 40.0)
    launch(world, car, 15.0)
    before = speed_of(world, car)
    list(ticks(world, 30))
    assert speed_of(world, car) < before - 1.0


def test_without_gravity_an_actor_stays_up_until_it_returns() -> None:
    world = straight_world()
    car = add(world, z=3.0)
    world.surface.weightless[car.surface] = True
    list(ticks(world, 20))
    assert world.pose(car).location.z == 3.0
    world.surface.weightless[car.surface] = False
    list(ticks(world, 40))
    assert world.pose(car).location.z == 0.0
