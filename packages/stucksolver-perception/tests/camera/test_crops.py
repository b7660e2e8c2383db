"""Crops of the picture: where boxes are in it, and what is cut."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_perception.camera.crops import CROP_PX, FILL, MARGIN, corners_of, cut_crops, features_of, windows_of
from stucksolver_perception.rig import load_rig

CAMERA = load_rig().camera


def box(x: float, y: float = 0.0, z: float = 0.8, yaw: float = 0.0, size: tuple[float, ...] = (4.5, 1.9, 1.6)):
    return np.array([[x, y, z, *size, yaw]])


def test_corners_lie_around_the_middle_as_the_box_is_turned() -> None:
    turned = corners_of(box(10.0, 2.0, 1.0, np.pi / 2))[0]
    assert np.allclose(turned.max(0), [10.95, 4.25, 1.8])
    assert np.allclose(turned.min(0), [9.05, -0.25, 0.2])


def test_windows_of_car_ahead_has_projected_middle_and_width() -> None:
    """A car ahead is in the middle of the image and as wide as the lens projects it."""
    windows = windows_of(CAMERA, box(30.0))
    left, _, right, _ = windows.rectangle[0]
    assert windows.usable.all()
    assert abs((left + right) / 2 - 800) < 1e-6
    assert abs((right - left) - CAMERA.focal_px * 1.9 / (30.0 - 2.25 - 0.8)) < 1e-6


@given(st.floats(-60, 60), st.floats(-40, 40), st.floats(-3.2, 3.2))
def test_rectangles_stay_in_the_picture_and_crops_are_wider(x: float, y: float, yaw: float) -> None:
    windows = windows_of(CAMERA, box(x, y, yaw=yaw))
    assert (windows.rectangle >= 0).all()
    assert (windows.rectangle <= [1600, 900, 1600, 900]).all()
    if windows.usable[0]:
        sides = windows.rectangle[0, 2:] - windows.rectangle[0, :2]
        assert windows.side[0] >= MARGIN * sides.max() - 1e-9


def test_what_is_behind_beside_or_tiny_is_not_usable() -> None:
    boxes = np.concatenate([box(-20.0), box(1.0), box(10.0, 30.0), box(60.0, size=(0.1, 0.1, 0.1)), box(20.0)])
    assert windows_of(CAMERA, boxes).usable.tolist() == [False, False, False, False, True]


def test_a_crop_shows_what_is_in_its_square() -> None:
    rgb = np.zeros((900, 1600, 3), np.uint8)
    rgb[400:500, 700:800] = (250, 10, 20)
    for side in (100.0, 40.0):
        crop = cut_crops(rgb, np.array([[750.0, 450.0]]), np.array([side]))[0]
        assert (crop == (250, 10, 20)).all()
    half = cut_crops(rgb, np.array([[800.0, 450.0]]), np.array([80.0]))[0]
    assert (half[:, :31] == (250, 10, 20)).all()
    assert (half[:, 33:] == 0).all()


def test_cut_crops_large_crop_averages_pixels() -> None:
    """A large crop is the mean of its pixels and not a sample of them."""
    rgb = np.zeros((900, 1600, 3), np.uint8)
    rgb[:, ::2] = 200
    crop = cut_crops(rgb, np.array([[800.0, 450.0]]), np.array([128.0]))[0]
    assert np.abs(crop[2:-2, 2:-2].astype(int) - 100).max() < 30


def test_outside_the_picture_there_is_gray() -> None:
    rgb = np.zeros((900, 1600, 3), np.uint8)
    crop = cut_crops(rgb, np.array([[1600.0, 900.0]]), np.array([200.0]))[0]
    assert (crop[: CROP_PX // 2, : CROP_PX // 2] == 0).all()
    assert (crop[CROP_PX // 2 :] == FILL).all()
    assert (cut_crops(rgb, np.array([[5000.0, 0.0]]), np.array([50.0])) == FILL).all()


def test_no_boxes_give_no_crops() -> None:
    none = windows_of(CAMERA, np.zeros((0, 7)))
    assert len(none.usable) == 0
    assert cut_crops(np.zeros((900, 1600, 3), np.uint8), none.center, none.side).shape == (0, CROP_PX, CROP_PX, 3)


def test_features_distinguish_rear_from_front_and_left_from_right() -> None:
    boxes = np.concatenate([box(20.0), box(20.0, yaw=np.pi), box(20.0, yaw=np.pi / 2)])
    ahead, left = features_of(CAMERA, boxes, windows_of(CAMERA, boxes))[:, 6:8].T
    assert np.allclose(ahead, [-1, 1, 0], atol=1e-6)  # it shows its rear, its front, its left side
    assert np.allclose(left, [0, 0, 1], atol=1e-6)
