"""Time: ticks, frames, snapshots and settings."""

from __future__ import annotations

import time

import pytest
from stage import DT, run, soon, spawn

carla = pytest.importorskip("carla")


def test_each_tick_is_one_frame_and_one_step(world) -> None:
    first = world.get_snapshot()
    frames = [world.tick() for _ in range(5)]
    last = world.get_snapshot()
    assert frames == list(range(first.frame + 1, first.frame + 6)) == [*frames[:-1], last.frame]
    assert last.timestamp.elapsed_seconds - first.timestamp.elapsed_seconds == pytest.approx(5 * DT)


def test_delta_seconds_is_the_float32_and_the_settings_the_double(world) -> None:
    world.tick()
    assert world.get_snapshot().timestamp.delta_seconds == 0.05000000074505806
    assert world.get_settings().fixed_delta_seconds == 0.05


@pytest.mark.parametrize("delta", [0.1, 0.025])
def test_another_step_is_taken_from_the_settings(world, delta: float) -> None:
    settings = world.get_settings()
    settings.fixed_delta_seconds = delta
    world.apply_settings(settings)
    world.tick()
    assert world.get_snapshot().timestamp.delta_seconds == pytest.approx(delta)


def test_every_setting_can_be_read_back(world) -> None:
    before = world.get_settings()
    settings = world.get_settings()
    settings.no_rendering_mode = True
    settings.substepping, settings.max_substep_delta_time, settings.max_substeps = True, 0.005, 12
    settings.max_culling_distance = 300.0
    settings.deterministic_ragdolls = False
    settings.tile_stream_distance, settings.actor_active_distance = 650.0, 640.0
    settings.spectator_as_ego = False
    world.apply_settings(settings)
    assert world.get_settings() == settings
    world.apply_settings(before)


@pytest.mark.carlette_only
def test_asynchronous_world_ticks_at_20_hz(world) -> None:
    """In asynchronous mode, the world ticks without cues, at no more than 20 Hz within a tolerance of 20 %."""
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = False, None
    world.apply_settings(settings)
    start, first = time.monotonic(), world.wait_for_tick().frame
    while (passed := world.wait_for_tick().frame - first) < 20:
        pass
    # A busy machine may make it slower, but nothing makes it faster.
    assert passed < 24.0 * (time.monotonic() - start)


def test_in_synchronous_mode_it_does_not(world) -> None:
    before = world.get_snapshot().frame
    time.sleep(0.3)
    assert world.get_snapshot().frame == before


def test_on_tick_callback_runs_each_frame_until_removed(world) -> None:
    """A callback of on_tick is called for each frame until it is removed."""
    frames: list[int] = []
    number = world.on_tick(lambda snapshot: frames.append(snapshot.frame))
    ticked = [world.tick() for _ in range(3)]
    assert soon(lambda: set(ticked) <= set(frames))
    world.remove_on_tick(number)
    last = world.tick()
    assert last not in frames


def test_every_snapshot_has_every_actor(world, spots) -> None:
    for spot in spots[:3]:
        spawn(world, spot)
        snapshot = world.get_snapshot()
        ids = {item.id for item in snapshot}
        assert ids == {actor.id for actor in world.get_actors()}
        assert all(snapshot.has_actor(object_id) for object_id in ids)
    assert world.get_spectator().id in ids


def test_an_asynchronous_batch_can_tick(client, world) -> None:
    before = world.get_snapshot().frame
    client.apply_batch([], True)
    assert soon(lambda: world.get_snapshot().frame == before + 1)
    run(world, 1)
