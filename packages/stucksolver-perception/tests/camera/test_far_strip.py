"""The strip around the horizon."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver_perception.camera.horizon_strip import FILL, STRIP_ROWS, cut_rows, horizon_row, look_of, strip_top
from stucksolver_perception.rig import load_rig

CAMERA = load_rig().camera


def test_horizon_row_is_middle_and_rises_with_nose_down() -> None:
    """The horizon of a level camera is its middle row and rises as the nose goes down."""
    assert horizon_row(CAMERA) == CAMERA.height_px / 2
    assert horizon_row(CAMERA, 0.01) == pytest.approx(CAMERA.height_px / 2 - 0.01 * CAMERA.focal_px, abs=0.01)


def test_project_far_point_at_lens_height_lies_on_horizon() -> None:
    """A point far away at the height of the lens lies on the horizon row."""
    _, row, _ = CAMERA.project(np.array([[1e6, 0.0, CAMERA.mount.z_m]]))
    assert row[0] == pytest.approx(horizon_row(CAMERA), abs=0.01)


def test_the_strip_has_the_horizon_in_its_middle() -> None:
    assert strip_top(CAMERA) + STRIP_ROWS // 2 == round(horizon_row(CAMERA))


@pytest.mark.parametrize("top", [-300, -10, 0, 50, 95, 400])
def test_cut_rows_outside_image_are_gray(top: int) -> None:
    """Rows outside the image are gray, and the others are those of the image."""
    rgb = np.random.default_rng(1).integers(0, 100, (100, 8, 3)).astype(np.uint8)
    strip = cut_rows(rgb, top, 20)
    assert strip.shape == (20, 8, 3)
    for k in range(20):
        wanted = rgb[top + k] if 0 <= top + k < 100 else np.full((8, 3), FILL)
        assert (strip[k] == wanted).all()


def test_fog_lowers_the_contrast_and_night_the_brightness() -> None:
    random = np.random.default_rng(2)
    clear = random.integers(40, 220, (STRIP_ROWS, 64, 3)).astype(np.uint8)
    fog = (180 + 0.1 * clear).astype(np.uint8)
    night = (0.1 * clear).astype(np.uint8)
    assert look_of(fog)[1] < look_of(clear)[1]
    assert look_of(night)[0] < look_of(clear)[0]


def test_look_of_empty_plain_is_not_fog() -> None:
    """An empty plain under a clear sky does not count as fog."""
    plain = np.full((STRIP_ROWS, 64, 3), 60, np.uint8)
    plain[: STRIP_ROWS // 2] = 150
    fog = np.linspace(150, 60, STRIP_ROWS).astype(np.uint8)[:, None, None].repeat(64, 1).repeat(3, 2)
    assert look_of(plain)[1] == 90.0
    assert look_of(fog)[1] <= 1.0


@pytest.mark.parametrize("gray", range(0, 256, 15))
@pytest.mark.parametrize("width", [1, 64, 1280])
def test_look_of_gray_band_is_exact_on_every_processor(gray: int, width: int) -> None:
    """Measure steps of whole gray levels without any rounding: at an edge between two classes it would decide."""
    strip = np.full((STRIP_ROWS, width, 3), gray, np.uint8)
    strip[STRIP_ROWS // 2 :] = 255 - gray
    assert look_of(strip).tolist() == [127.5, abs(255 - 2 * gray)]
