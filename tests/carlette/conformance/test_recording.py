"""Recording and replaying over the wire."""

from __future__ import annotations

from pathlib import Path

import pytest
from stage import run, settled, soon

carla = pytest.importorskip("carla")
pytestmark = pytest.mark.carlette_only
"""The texts and the format are carlette's own."""


def test_a_drive_is_recorded_told_and_played_again(client, world, spots, tmp_path: Path) -> None:
    car = settled(world, spots[0])
    start = car.get_location()
    log = str(tmp_path / "drive.log")
    assert client.start_recorder(log) == log
    car.apply_control(carla.VehicleControl(throttle=0.7))
    run(world, 60)
    end = car.get_location()
    client.stop_recorder()
    assert "Frames: 61" in client.show_recorder_file_info(log, False)
    assert end.distance(start) > 3.0
    assert "Replaying file" in client.replay_file(log, 0.0, 0.0, 0)
    world.tick()
    assert car.get_location().distance(start) < 0.5
    run(world, 60)
    assert car.get_location().distance(end) < 0.5
    client.stop_replayer(True)
    assert soon(lambda: car.is_alive)


def test_a_missing_file_and_a_log_of_another_make_are_told_in_words(client, world, tmp_path: Path) -> None:
    other = tmp_path / "other.log"
    other.write_bytes(b"CARLA_RECORDER")
    assert "not found on server" in client.replay_file(str(tmp_path / "none.log"), 0.0, 0.0, 0)
    assert "is no log of carlette" in client.show_recorder_file_info(str(other), True)
    assert "exists and is no log" in client.start_recorder(str(other))


def test_a_disk_that_is_full_ends_the_recording_and_not_the_world(client, world) -> None:
    assert "it is no file" in client.start_recorder("/dev/full")
    before = world.get_snapshot().frame
    run(world, 3)
    assert world.get_snapshot().frame == before + 3
