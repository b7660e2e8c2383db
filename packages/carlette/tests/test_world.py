"""The world is one value: it can be copied, forked and repeated bit for bit."""

from __future__ import annotations

import os
import pickle

import pytest

from carlette.errors import MapError, UnknownActorError
from carlette.opendrive.map_file import MapFile
from carlette.opendrive.road_network import RoadNetwork
from carlette.world.world import World
from straight import CAR, add, drive, launch, speed_of, straight_road, straight_world, ticks


def busy_world(seed: int = 3) -> World:
    world = straight_world(slope=0.02, seed=seed)
    car, other = add(world, CAR, 50.0, z=1.0), add(world, CAR, 80.0, z=1.6)
    walker = add(world, "walker.pedestrian.0001", 120.0, z=4.0)
    add(world, "static.prop.constructioncone", 100.0, z=2.0)
    drive(world, car, throttle=0.9, steer=0.02)
    drive(world, other, throttle=0.2)
    world.walkers.control[walker.index] = (-1.0, 0.1, 0.0, 1.5, 0.0)
    return world


def run(world: World, count: int = 200) -> bytes:
    return b"".join(w.bodies.record.tobytes() for w in ticks(world, count))


@pytest.mark.integration
def test_the_same_commands_give_the_same_world_bit_for_bit() -> None:
    assert run(busy_world()) == run(busy_world())


@pytest.mark.integration
def test_a_pickled_copy_goes_on_exactly_as_the_original() -> None:
    world = busy_world()
    run(world, 50)
    copy = pickle.loads(pickle.dumps(world))
    assert run(copy) == run(world)


def test_a_fork_goes_on_exactly_as_the_original() -> None:
    world = busy_world()
    run(world, 50)
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os.write(writer, run(world, 5))
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        theirs = pipe.read()
    os.waitpid(child, 0)
    assert theirs == run(world, 5)


def test_every_actor_is_in_every_record_and_active() -> None:
    world = busy_world()
    for _ in ticks(world, 20):
        assert set(world.bodies.record["id"].tolist()) == set(world.actors)
        assert (world.bodies.record["state"] == 1).all()


def test_actors_keep_their_motion_when_others_go() -> None:
    world = straight_world()
    first, second, third = (add(world, CAR, x) for x in (50.0, 80.0, 110.0))
    for car in (first, second, third):
        launch(world, car, float(car.id))
    assert world.remove(second.id)
    assert not world.remove(second.id)
    world.tick()
    assert speed_of(world, first) == pytest.approx(first.id, abs=0.2)
    assert speed_of(world, third) == pytest.approx(third.id, abs=0.2)
    assert world.pose(third).location.x > 110.0
    with pytest.raises(UnknownActorError, match=str(second.id)):
        world.actor(second.id, "test")


def test_the_step_is_the_float32_of_the_settings() -> None:
    world = straight_world()
    world.tick()
    assert world.step_s == 0.05000000074505806
    assert world.elapsed_s == world.step_s


def test_a_map_without_driving_lanes_is_refused() -> None:
    with pytest.raises(MapError, match="driving"):
        RoadNetwork(MapFile("walkway", straight_road(lane="sidewalk")))
