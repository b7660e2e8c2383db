"""The rasteriser alone: which pixels a quad covers, what hides what, and how colors mix."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from carlette.camera.rendering.raster import Raster
from carlette.camera.rendering.view import CameraView
from carlette.geometry import Pose

GRAY, RED, BLUE = 0xFF808080, 0xFFFF0000, 0xFF0000FF


def view(width=64, height=48) -> CameraView:
    return CameraView(Pose(), width, height, 90.0)


def quads(corners, *shades) -> tuple:
    """Quads (n, 4, 3) and the colors of their corners: one for all, one for each quad, or (n, 4)."""
    corners = np.ascontiguousarray(corners, np.float32)
    colors = np.broadcast_to(np.array(shades, np.uint32).reshape(len(shades), -1), (len(corners), 4))
    return corners, np.ascontiguousarray(colors).view(np.uint8).reshape(-1, 4, 4)


def wall(ahead, left=-100.0, right=100.0, low=-100.0, high=100.0):
    """A quad across the view that faces the camera."""
    return [(ahead, right, high), (ahead, right, low), (ahead, left, low), (ahead, left, high)]


def drawn(*calls, size=None) -> tuple[np.ndarray, np.ndarray]:
    raster = Raster()
    pixels = raster.begin(size or view())
    pixels[:] = 0
    raster.blend()
    for call in calls:
        raster.draw(*call)
    return pixels.copy(), raster.depth()


def test_raster_quad_facing_camera_is_drawn_back_is_not() -> None:
    """A quad that faces the camera is drawn, and its back is not."""
    pixels, depth = drawn(quads([wall(5.0)], GRAY))
    assert (pixels == GRAY).all()
    assert np.allclose(depth, 5.0, rtol=1e-6)
    behind, far = drawn(quads([wall(5.0)[::-1]], GRAY))
    assert not behind.any()
    assert (far == 1000.0).all()


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_the_nearest_quad_is_seen_whatever_the_order(order) -> None:
    three = [quads([wall(4.0, right=0.0)], RED), quads([wall(5.0)], BLUE), quads([wall(6.0)], GRAY)]
    pixels, _ = drawn(*(three[item] for item in order))
    assert (pixels[:, :32] == RED).all()
    assert (pixels[:, 32:] == BLUE).all()


def test_of_two_quads_in_one_plane_the_first_stays() -> None:
    pixels, _ = drawn(quads([wall(5.0)], RED), quads([wall(5.0)], BLUE))
    assert (pixels == RED).all()


@pytest.mark.parametrize("seed", range(8))
def test_raster_quads_sharing_edges_cover_each_pixel_once(seed) -> None:
    """Quads that share edges leave out no pixel and draw none twice."""
    random = np.random.default_rng(seed)
    lines = np.linspace(-8, 8, 12)
    grid = np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1)
    grid[1:-1, 1:-1] += random.uniform(-0.35, 0.35, (10, 10, 2))  # still convex
    points = np.concatenate([np.full((12, 12, 1), 5.0), grid], axis=-1)
    # A quarter of light for each time that a pixel is drawn.
    cells = [
        (points[i + 1, j + 1], points[i + 1, j], points[i, j], points[i, j + 1]) for i in range(11) for j in range(11)
    ]
    raster = Raster()
    pixels = raster.begin(view(640, 480))
    pixels[:] = 0
    raster.blend(add=True)
    raster.use_depth(False)
    raster.draw(*quads(cells, 0xFF404040))
    assert (pixels & 0xFF == 0x40).all()


def test_raster_ground_under_camera_is_clipped_at_near_plane() -> None:
    """Ground that extends under the camera is clipped at the near plane and has the correct depth."""
    up = [(-50.0, -500.0, -1.6), (900.0, -500.0, -1.6), (900.0, 500.0, -1.6), (-50.0, 500.0, -1.6)]
    size = view()
    pixels, depth = drawn(quads([up], GRAY), size=size)
    rows = np.arange(48) + 0.5
    slope = (rows - 24) / 24 * size.tangents[1]
    ahead = np.divide(1.6, slope, out=np.full(48, np.inf), where=slope > 0)
    middle = depth[:, 32]
    seen = ahead < 900
    assert np.allclose(middle[seen], ahead[seen], rtol=1e-4)
    assert (middle[~seen] == 1000.0).all()
    assert (pixels[seen] == GRAY).all()


def test_colors_change_across_a_quad_as_seen_in_perspective() -> None:
    """From 0 at 2 m to 200 at 22 m, along the ground: at 12 m it is 100, wherever that is in the picture."""
    strip = [(2.0, -9.0, -1.0), (22.0, -9.0, -1.0), (22.0, 9.0, -1.0), (2.0, 9.0, -1.0)]
    near, far = 0xFF000000, 0xFFC8C8C8
    pixels, depth = drawn(quads([strip], (near, far, far, near)), size=view(640, 480))
    column, ahead = pixels[:, 320] & 0xFF, depth[:, 320]
    on = ahead < 1000.0
    assert on.sum() > 100
    assert np.abs(column[on] - (ahead[on] - 2.0) * 10.0).max() <= 1.0


def test_raster_bent_quad_has_no_hole() -> None:
    """A quad that is not flat has no hole, and its depth lies between that of its corners."""
    bent = np.array(wall(5.0), np.float32)
    bent[2, 0] = 6.0
    pixels, depth = drawn(quads([bent], GRAY))
    assert (pixels == GRAY).all()
    assert ((depth >= 4.999) & (depth <= 6.001)).all()


def test_raster_blending_mixes_by_alpha_and_adds_light_to_white() -> None:
    """Translucent colors mix by their alpha, and added light saturates toward white."""
    pixels, _ = drawn(quads([wall(5.0)], 0xFF204060), quads([wall(4.0)], 0x80FFFFFF))
    channels = pixels.view(np.uint8).reshape(48, 64, 4)[10, 10, :3].astype(int)
    assert np.abs(channels - (np.array([0x60, 0x40, 0x20]) + 255) / 2).max() <= 1
    raster = Raster()
    light = raster.begin(view())
    light[:] = 0xFF204060
    raster.blend(add=True)
    for nearer in (5.0, 4.0):
        raster.draw(*quads([wall(nearer)], 0xFF808080))
    shown = light.view(np.uint8).reshape(48, 64, 4)[10, 10, :3] / 255
    below, added = np.array([0x60, 0x40, 0x20]) / 255, 0x80 / 255
    assert np.allclose(shown, 1 - (1 - below) * (1 - added) ** 2, atol=0.01)


def test_pictures_of_many_sizes_do_not_disturb_each_other() -> None:
    raster = Raster()
    for width in (8, 16, 32, 64, 96, 128, 16, 8):
        pixels = raster.begin(view(width, width))
        pixels[:] = 0
        raster.blend()
        raster.draw(*quads([wall(5.0, right=0.0)], RED))
        assert (pixels[:, : width // 2] == RED).all()
        assert not pixels[:, width // 2 :].any()
