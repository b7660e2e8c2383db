"""The rig file: what it holds is found by the sensors, and one that cannot be used is refused in one clear sentence."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_perception.rig import SHIPPED, CameraRig, RigError, SensorMount, load_rig

RIG = load_rig()


@pytest.fixture
def written(tmp_path):
    """Writes a rig file that differs from the one that ships."""

    def write(old, new):
        text = SHIPPED.read_text(encoding="utf-8")
        assert old in text
        file = tmp_path / "mine.toml"
        file.write_text(text.replace(old, new, 1), encoding="utf-8")
        return file

    return write


def test_a_file_of_ones_own_is_read(written):
    rig = load_rig(written("channels = 64", "channels = 32"))
    assert rig.lidar.channels == 32
    assert rig.camera == RIG.camera


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RigError, match=r"none\.toml: the rig file cannot be read .*give a rig file"):
        load_rig(tmp_path / "none.toml")


def test_load_rig_invalid_toml_is_rejected_with_line(written):
    with pytest.raises(RigError, match=r"mine\.toml: invalid TOML: .*line"):
        load_rig(written("[camera]", "[camera"))


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("fov_deg = 70.0\n", "", r"camera\.fov_deg: Field required"),
        ("channels = 64\n", "", r"lidar\.channels: Field required"),
        ("gnss_noise_m = 0.55", "", r"gnss_noise_m: Field required"),
        ("x_m = 0.8, ", "", r"camera\.mount\.x_m: Field required"),
        ("fov_deg = 70.0", "fov_deg = 180.0", r"camera\.fov_deg: Input should be less than 180"),
        ("channels = 64", "channels = 0", r"lidar\.channels: Input should be greater than 0"),
        ("channels = 64", 'channels = "many"', r"lidar\.channels: Input should be a valid integer"),
        ("channels = 64", "chanels = 64\nchannels = 64", r"lidar\.chanels: Extra inputs are not permitted"),
    ],
)
def test_a_field_that_is_missing_or_wrong_is_named(written, old, new, told):
    with pytest.raises(RigError, match=r"mine\.toml: " + told):
        load_rig(written(old, new))


def test_load_rig_other_version_is_rejected_before_fields(written):
    """A rig of another version is rejected before its fields are checked."""
    with pytest.raises(RigError, match=r"mine\.toml: version 2 of rig files; this release reads 1"):
        load_rig(written("version = 1", "version = 2\nnew_field = 3"))
    with pytest.raises(RigError, match="version unnamed"):
        load_rig(written("version = 1", ""))


def test_mount_yaw_is_left_pitch_down_and_roll_left_up():
    """Yaw turns to the left, pitch turns down, and roll lifts the left side."""

    def ahead(**turn):
        return SensorMount(x_m=0.0, y_m=0.0, z_m=0.0, **turn).to_vehicle()[:3, :3] @ [1.0, 0.0, 0.0]

    np.testing.assert_allclose(ahead(yaw_deg=90.0), [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(ahead(pitch_deg=90.0), [0.0, 0.0, -1.0], atol=1e-12)
    left = SensorMount(x_m=0.0, y_m=0.0, z_m=0.0, roll_deg=90.0).to_vehicle()[:3, :3] @ [0.0, 1.0, 0.0]
    np.testing.assert_allclose(left, [0.0, 0.0, 1.0], atol=1e-12)


ANGLES = st.floats(-180.0, 180.0)


@given(ANGLES, ANGLES, ANGLES)
def test_a_mount_turns_and_shifts_and_does_no_more(yaw, pitch, roll):
    matrix = SensorMount(x_m=1.0, y_m=2.0, z_m=3.0, yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll).to_vehicle()
    np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1.0)
    assert matrix[:, 3].tolist() == [1.0, 2.0, 3.0, 1.0]


def test_project_center_and_edge_match_field_of_view():
    """A point straight ahead of the lens is in the middle; the edge is half the field of view to the side."""
    camera = RIG.camera
    x, z = camera.mount.x_m + 10.0, camera.mount.z_m
    edge_m = 10.0 * math.tan(math.radians(camera.fov_deg) / 2.0)
    column, row, ahead = camera.project(np.array([[x, 0.0, z], [x, edge_m, z], [x, -edge_m, z]]))
    np.testing.assert_allclose(column, [camera.width_px / 2.0, 0.0, camera.width_px], atol=1e-6)
    np.testing.assert_allclose(row, camera.height_px / 2.0)
    np.testing.assert_allclose(ahead, 10.0)


def test_what_is_higher_is_further_up_in_the_picture():
    camera = RIG.camera
    _, row, _ = camera.project(np.array([[10.0, 0.0, 3.0], [10.0, 0.0, 0.0]]))
    assert row[0] < camera.height_px / 2.0 < row[1]


@given(st.floats(-5.0, 0.0))
def test_what_is_behind_the_lens_is_told_apart(back_m):
    mount = SensorMount(x_m=0.0, y_m=0.0, z_m=1.5)
    camera = CameraRig(mount=mount, width_px=160, height_px=90, fov_deg=90.0)
    column, row, ahead = camera.project(np.array([[back_m, 1.0, 1.0]]))
    assert ahead[0] <= 0.0
    assert np.isfinite([column[0], row[0]]).all()
