"""Any number of clients at the same time."""

from __future__ import annotations

import threading

import pytest
from stage import spawn

carla = pytest.importorskip("carla")


def test_one_client_ticks_and_the_other_sees_the_frames(world, new_client) -> None:
    other = new_client().get_world()
    seen: list[int] = []
    waiter = threading.Thread(target=lambda: seen.append(other.wait_for_tick(10.0).frame))
    waiter.start()
    frames = []
    while waiter.is_alive():
        frames.append(world.tick())
        waiter.join(0.01)
    assert seen[0] in frames


def test_both_see_and_move_the_same_actors(world, new_client, spots) -> None:
    car = spawn(world, spots[0], role_name="shared")
    other = new_client().get_world()
    theirs = other.get_actor(car.id)
    assert theirs.attributes["role_name"] == "shared"
    theirs.apply_control(carla.VehicleControl(throttle=1.0))
    for _ in range(30):
        world.tick()
    assert car.get_velocity().length() > 1.0
    assert theirs.destroy()
    world.tick()
    assert world.get_snapshot().find(car.id) is None


def test_both_can_tick_in_turn(world, new_client) -> None:
    other = new_client().get_world()
    frames = [item.tick() for item in (world, other, world, other)]
    assert frames == list(range(frames[0], frames[0] + 4))


def test_many_come_and_go(world, new_client) -> None:
    for _ in range(20):
        assert new_client().get_world().id == world.id
    world.tick()
