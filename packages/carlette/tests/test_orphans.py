"""What is attached to an actor that is destroyed stays where it was and is nobody's child any more, as in CARLA.

CARLA's dispatcher destroys the one actor that was named; Unreal lets go of what hangs on it and keeps its place.
"""

from __future__ import annotations

import numpy as np
import pytest

from carlette.blueprints import load_catalog
from carlette.blueprints.sensor_definitions import IN_THE_CLIENT
from carlette.client_versions import DEFAULT_VERSION, VERSIONS
from carlette.geometry import Pose, Rotation, Vector
from carlette.sensors import make_sensor
from carlette.simulator import Simulator
from carlette.world.spawn import spawn
from straight import add, launch, on_lane, straight_world, ticks

SENSORS = [
    definition
    for definition in load_catalog().definitions
    if definition.startswith("sensor.") and definition not in IN_THE_CLIENT
]
MOUNT = Pose(Vector(1.0, 0.5, 1.6), Rotation(yaw=30.0))


def orphaned(kind: str = "sensor.other.imu", count: int = 5):
    """A world, a child on a moving car after some ticks, and where it was when the car was destroyed."""
    world = straight_world()
    car = add(world)
    launch(world, car, 10.0)
    child = spawn(world, kind, {}, MOUNT, parent_id=car.id)
    for _ in ticks(world, count):
        pass
    place = world.pose(child)
    world.remove(car.id)
    return world, child, car, place


def test_orphaned_child_stays_in_place_and_stops() -> None:
    """The child of a destroyed actor stays in the world at its position and stops."""
    world, child, _, place = orphaned()
    for _ in ticks(world, 10):
        pass
    assert world.pose(child) == place
    assert not world.bodies.velocity[child.row].any()
    record = world.bodies.record[child.row]
    assert record["id"] == child.id and np.allclose(record["location"], place.location, atol=1e-4)


def test_orphaned_child_teleports_in_world_frame() -> None:
    """The child of a destroyed actor is teleported in the world frame, not in the frame of its former parent."""
    world, child, _, _ = orphaned()
    world.teleport(child, on_lane(700.0, z=2.0))
    world.tick()
    assert world.pose(child) == on_lane(700.0, z=2.0)


def test_it_still_says_whose_child_it_was() -> None:
    _, child, car, _ = orphaned()
    assert child.parent_id == car.id


def test_a_grandchild_follows_its_own_parent_still() -> None:
    world, child, _, _ = orphaned("static.prop.constructioncone")
    grandchild = spawn(world, "sensor.other.gnss", {}, Pose(Vector(z=1.0)), parent_id=child.id)
    world.teleport(child, on_lane(300.0))
    world.tick()
    assert world.pose(grandchild).location == Vector(300.0, on_lane(0.0).location.y, 1.0)


@pytest.mark.parametrize("kind", SENSORS)
def test_orphaned_sensor_of_any_kind_does_not_fail(kind: str, caplog) -> None:
    """A sensor whose parent is destroyed continues or is silent, and none fails."""
    simulator = Simulator(straight_world().roads, VERSIONS[DEFAULT_VERSION], [], 0)
    world = simulator.world
    car, other = add(world), add(world, x=80.0)
    launch(world, car, 10.0)
    make_sensor(kind, {}).load(world)
    sensor = spawn(world, kind, {}, MOUNT, parent_id=car.id)
    simulator.hub.is_wanted = lambda stream: True
    for number in range(12):
        if number == 4:
            world.remove(car.id)
        simulator.tick()
        simulator.publish()
    assert sensor.id in world.actors and other.id in world.actors
    assert "failed" not in caplog.text
