"""A fork is a world of its own that goes the same way under the same commands, bit for bit."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from carlette.errors import SpawnCollisionError
from carlette.opendrive.map_file import find_map, map_folders
from carlette.opendrive.road_network import RoadNetwork
from carlette.world.actor import ActorKind
from carlette.world.spawn import spawn
from carlette.world.world import World
from straight import CAR, add, drive, straight_world

TYPES = (CAR, "vehicle.bh.crossbike", "walker.pedestrian.0001", "static.prop.constructioncone")
unit = st.floats(-1.0, 1.0)
commands = st.one_of(
    st.tuples(st.just("spawn"), st.integers(0, len(TYPES) - 1), st.floats(10.0, 90.0)),
    st.tuples(st.just("destroy"), st.integers(0, 9), st.none()),
    st.tuples(st.just("drive"), st.integers(0, 9), st.tuples(unit, unit, unit)),
    st.tuples(st.just("walk"), st.integers(0, 9), st.tuples(unit, unit, st.floats(0.0, 5.0))),
    st.tuples(st.just("tick"), st.integers(1, 8), st.none()),
)


def obey(world: World, command) -> None:
    """Runs one random command; it means the same in equal worlds."""
    name, number, detail = command
    if name == "tick":
        for _ in range(number):
            world.tick()
    elif name == "spawn":
        try:
            add(world, TYPES[number], detail, z=0.3)
        except SpawnCollisionError:
            return
    else:
        kinds = {"destroy": tuple(ActorKind), "drive": (ActorKind.VEHICLE,), "walk": (ActorKind.WALKER,)}[name]
        able = [item for item in world.actors.values() if item.kind in kinds and item is not world.spectator]
        actor = able[number % len(able)] if able else None
        if actor is not None and name == "destroy":
            world.remove(actor.id)
        elif actor is not None and name == "drive":
            drive(world, actor, *detail)
        elif actor is not None:
            world.walkers.control[actor.index] = (detail[0], detail[1], 0.0, detail[2], 0.0)


def state(world: World) -> bytes:
    """Everything that a snapshot shows, and what it does not."""
    bodies = world.bodies
    shown = bodies.record.tobytes() + bodies.position.tobytes() + bodies.velocity.tobytes() + bodies.angular.tobytes()
    hidden = world.fleet.steer.tobytes() + world.surface.looked.tobytes()
    return shown + hidden + repr((world.frame, world.elapsed_s, world.collisions, list(world.actors))).encode()


@pytest.mark.integration
@settings(max_examples=60)
@given(st.lists(commands, max_size=12), st.lists(commands, max_size=12))
def test_fork_and_pickle_evolve_like_original(before, after) -> None:
    """A fork and a pickle evolve like the original under the same commands."""
    world = straight_world(slope=0.01)
    for command in before:
        obey(world, command)
    fork, copy = world.fork(), pickle.loads(pickle.dumps(world))
    assert state(fork) == state(copy) == state(world)
    for command in after:
        for item in (world, fork, copy):
            obey(item, command)
        assert state(fork) == state(copy) == state(world)


def town(cars: int, name: str = "demo_town") -> World:
    """A town with rolling cars."""
    world = World(RoadNetwork(find_map(name, map_folders([]))), seed=4)
    for spot in world.roads.spawn_points():
        if len(world.fleet) < cars:
            try:
                car = spawn(world, CAR, {}, spot)
            except SpawnCollisionError:
                continue
            drive(world, car, throttle=0.4, steer=0.01)
    return world


@pytest.mark.integration
def test_town_fork_copies_lights_and_leaves_original_unchanged() -> None:
    """A fork of a town has its lights, and does not change the original."""
    world = town(10)
    world.tick()
    untouched = state(world)
    fork = world.fork()
    for _ in range(300):
        fork.tick()
    assert state(world) == untouched
    for _ in range(300):
        world.tick()
    assert state(world) == state(fork)
    assert np.array_equal(world.signals.lights.elapsed, fork.signals.lights.elapsed)


def test_a_fork_shares_the_map_and_nothing_else_that_changes() -> None:
    world = town(3)
    fork = world.fork()
    assert fork.roads is world.roads
    assert fork.spectator is fork.actors[world.spectator.id]
    assert fork.spectator is not world.spectator
    assert not any(np.shares_memory(getattr(fork.bodies, name), column) for name, column in vars(world.bodies).items())
