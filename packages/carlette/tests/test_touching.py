"""Bodies never pass through each other, exchange momentum, and tell the collision sensors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from carlette.errors import RequestError, SpawnCollisionError
from carlette.geometry import Pose, Vector
from carlette.physics.overlap import boxes_of, overlaps
from carlette.world.spawn import spawn
from straight import CAR, LANE_Y_M, add, drive, launch, on_lane, speed_of, straight_world, ticks

WALL = "static.prop.container"
DEBRIS = "static.prop.dirtdebris01"
CONE = "static.prop.constructioncone"


def front(world, car) -> float:
    return world.pose(car).location.x + car.box.extent.x


def depth(world, one, other) -> float:
    """How deep two actors stand in each other, m."""
    boxes = boxes_of(world.bodies, np.array([one.row, other.row]))
    found = overlaps(boxes, np.array([0]), np.array([1]))
    return float(found.depth.max(initial=0.0))


@pytest.mark.integration
@given(st.floats(2.0, 60.0), st.floats(-1.6, 1.6))
@settings(max_examples=25)
def test_a_car_never_passes_through_an_immovable_prop(mps: float, aside_m: float) -> None:
    world = straight_world()
    car = add(world)
    wall = add(world, WALL, x=90.0, y=LANE_Y_M + aside_m)
    launch(world, car, mps)
    drive(world, car, throttle=1.0)
    passed = False
    for _ in ticks(world, 80):
        assert depth(world, car, wall) < 0.01
        place = world.pose(car).location
        if place.x > 90.0 and not passed:
            # A car that is turned aside may go round, but only where there is room beside the wall.
            passed = True
            assert abs(place.y - world.pose(wall).location.y) > wall.box.extent.y + car.box.extent.y - 0.4
    assert world.pose(wall).location.x == 90.0


def test_collision_pushes_parked_car_and_conserves_momentum() -> None:
    """A parked car that is hit is pushed, and the momentum is conserved."""
    world = straight_world()
    car, parked = add(world, CAR, 50.0), add(world, CAR, 70.0)
    launch(world, car, 15.0)
    while not world.bodies.velocity[parked.row, 0]:
        before = speed_of(world, car)
        world.tick()
        if speed_of(world, parked):
            assert speed_of(world, car) + speed_of(world, parked) == pytest.approx(before, abs=0.5)
    assert speed_of(world, parked) > speed_of(world, car) > 0.0


def test_a_hit_off_center_spins_the_car() -> None:
    world = straight_world()
    car, parked = add(world, CAR, 50.0), add(world, CAR, 60.0, y=LANE_Y_M + 1.6)
    launch(world, car, 15.0)
    list(ticks(world, 20))
    assert abs(world.pose(parked).rotation.yaw) > 0.5


def test_a_cone_flies_and_the_car_hardly_notices() -> None:
    world = straight_world()
    car, cone = add(world, CAR, 50.0), add(world, CONE, 60.0)
    launch(world, car, 10.0)
    drive(world, car, throttle=0.5)
    list(ticks(world, 40))
    assert world.pose(cone).location.x > 65.0
    assert speed_of(world, car) > 7.0


def test_flat_debris_is_driven_over() -> None:
    world = straight_world()
    car = add(world)
    add(world, DEBRIS, 60.0)
    launch(world, car, 10.0)
    list(ticks(world, 40))
    assert front(world, car) > 62.0
    assert not world.collisions


def test_a_walker_that_is_hit_is_pushed_along() -> None:
    world = straight_world()
    car, walker = add(world, CAR, 50.0), add(world, "walker.pedestrian.0001", 60.0, z=1.0)
    launch(world, car, 8.0)
    list(ticks(world, 40))
    assert world.pose(walker).location.x > 61.0
    assert world.pose(walker).location.x > front(world, car) - 0.1


def test_collision_sensors_of_both_cars_report_with_opposite_impulses() -> None:
    world = straight_world()
    car, parked = add(world, CAR, 50.0), add(world, CAR, 60.0)
    for item in (car, parked):
        spawn(world, "sensor.other.collision", {}, Pose(), parent_id=item.id)
    launch(world, car, 10.0)
    events = next(w.collisions for w in ticks(world, 40) if w.collisions)
    assert {(event.actor_id, event.other_id) for event in events} == {(car.id, parked.id), (parked.id, car.id)}
    by_actor = {event.actor_id: event.impulse.x for event in events}
    assert by_actor[car.id] == -by_actor[parked.id] < -1000.0


def test_cars_that_pass_beside_each_other_do_not_collide() -> None:
    world = straight_world()
    car = add(world)
    add(world, CAR, 80.0, y=-LANE_Y_M)
    spawn(world, "sensor.other.collision", {}, Pose(), parent_id=car.id)
    launch(world, car, 20.0)
    assert not any(w.collisions for w in ticks(world, 80))


@pytest.mark.parametrize("place", [{"x": 50.0}, {"x": 53.0}, {"x": 50.0, "z": 0.8}, {"x": 50.0, "yaw": 90.0}])
def test_a_taken_place_is_refused(place: dict[str, float]) -> None:
    world = straight_world()
    add(world, CAR, 50.0)
    with pytest.raises(SpawnCollisionError, match="Spawn failed because of collision at spawn position"):
        add(world, CAR, **place)
    assert sum(actor.type_id == CAR for actor in world.actors.values()) == 1


@pytest.mark.parametrize(
    "place", [{"x": 50.0, "z": -50.0}, {"x": 50.0, "y": -1.75}, {"x": 56.0}, {"x": 50.0, "z": 5.0}]
)
def test_a_free_place_is_accepted_also_far_below_or_above(place: dict[str, float]) -> None:
    world = straight_world()
    add(world, CAR, 50.0)
    assert add(world, CAR, **place).id in world.actors


def test_props_may_stand_anywhere() -> None:
    world = straight_world()
    add(world, CAR, 50.0)
    assert add(world, CONE, 50.0).id in world.actors


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_a_place_that_is_not_finite_is_refused(bad: float) -> None:
    world = straight_world()
    with pytest.raises(RequestError, match="not finite"):
        spawn(world, CAR, {}, Pose(Vector(bad, 0.0, 0.0)))


def test_unknown_kinds_and_parents_are_refused_by_name() -> None:
    world = straight_world()
    with pytest.raises(RequestError, match=r"sensor\.camera\.dvs"):
        spawn(world, "sensor.camera.dvs", {}, Pose())
    with pytest.raises(RequestError, match="4711"):
        spawn(world, "sensor.other.collision", {}, Pose(), parent_id=4711)


def test_a_sensor_rides_along_with_its_parent() -> None:
    world = straight_world()
    car = add(world)
    sensor = spawn(world, "sensor.other.collision", {}, Pose(Vector(1.0, 0.0, 2.0)), parent_id=car.id)
    launch(world, car, 10.0)
    list(ticks(world, 10))
    assert world.pose(sensor).location.x == pytest.approx(world.pose(car).location.x + 1.0, abs=1e-6)
    assert on_lane(0.0).location.y == world.pose(sensor).location.y
