"""Recording and replaying over the wire."""

from __future__ import annotations

from pathlib import Path

import pytest
from stage import run, settled, soon

carla = pytest.importorskip("carla")
pytestmark = pytest.mark.carlette_only
"""The texts and the format are carlette's own."""


def test_a_drive_is_recorded_told_and_played_again(client, world, spots, recordings: Path) -> None:
    car = settled(world, spots[0])
    start = car.get_location()
    assert client.start_recorder("drive.log") == str(recordings / "drive.log")
    car.apply_control(carla.VehicleControl(throttle=0.7))
    run(world, 60)
    end = car.get_location()
    client.stop_recorder()
    assert "Frames: 61" in client.show_recorder_file_info("drive.log", False)
    assert end.distance(start) > 3.0
    assert "Replaying file" in client.replay_file(str(recordings / "drive.log"), 0.0, 0.0, 0)
    world.tick()
    assert car.get_location().distance(start) < 0.5
    run(world, 60)
    assert car.get_location().distance(end) < 0.5
    client.stop_replayer(True)
    assert soon(lambda: car.is_alive)


def test_recorder_missing_or_foreign_file_is_reported_in_text(client, world, recordings: Path) -> None:
    """A missing file and a log of another program are reported in the text that the call returns."""
    recordings.mkdir(exist_ok=True)
    (recordings / "other.log").write_bytes(b"CARLA_RECORDER")
    assert "not found on server" in client.replay_file("none.log", 0.0, 0.0, 0)
    assert "is not a carlette log" in client.show_recorder_file_info("other.log", True)
    assert "exists and is not a carlette log" in client.start_recorder("other.log")


def test_no_name_leads_out_of_the_folder_for_logs(client, world, tmp_path: Path) -> None:
    for name in (str(tmp_path / "mine.log"), "../mine.log", "/dev/full", "~/mine.log/../../mine.log"):
        assert "where the server keeps logs" in client.start_recorder(name)
        assert "where the server keeps logs" in client.show_recorder_file_info(name, True)
        assert "where the server keeps logs" in client.replay_file(name, 0.0, 0.0, 0)
    assert not list(tmp_path.iterdir())
