"""The table of turned sensors: what it is about, and what is refused."""

from __future__ import annotations

from tests.lidar.synthetic import drive

from lab.perception.evaluation.miscalibration_errors import Errors, as_table, main


def test_miscalibration_table_row_contains_errors_accusations_and_distances():
    """A row contains the number of errors, their quantiles, the drives with a detection and the distances to it."""
    errors = Errors(3, [0.1, -0.3, 0.2], [], [40.0, 60.0], [])
    told = as_table({"lidar-turned": errors}).splitlines()[2:]
    assert told == [
        "| lidar-turned: LiDAR | 3 | 0.20, 0.29, 0.30 | 2 | 50, 60 |",
        "| lidar-turned: camera | 3 | - | 0 | - |",
    ]


def test_a_drive_is_played_healthy_and_with_each_turned_sensor(tmp_path, capsys):
    drive(tmp_path / "one", seed=1)
    assert main(["--data", str(tmp_path)]) == 0
    cases = [line.split(":")[0] for line in capsys.readouterr().out.splitlines()[2:]]
    assert cases == ["| none"] * 2 + ["| lidar-turned"] * 2 + ["| camera-turned"] * 2


def test_a_folder_without_recordings_is_refused(tmp_path, capsys):
    assert main(["--data", str(tmp_path)]) == 2
    assert "no recordings found" in capsys.readouterr().err
