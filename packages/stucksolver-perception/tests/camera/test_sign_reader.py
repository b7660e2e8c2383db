"""The recognizer itself, where its package is installed, on a sign of carlette's camera."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from carlette.camera.models.signs import DETOUR, FACE_M, ROAD_CLOSED, post_sign
from carlette.camera.rendering import tags
from carlette.camera.rendering.renderer import RenderPart
from carlette.camera.rendering.view import CameraView, matrix_of
from carlette.geometry import Pose, Rotation
from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.tools.gallery import Studio
from stucksolver.scene import SignWord
from stucksolver_perception.camera import sign_reader
from stucksolver_perception.camera.sign_reader import PACKAGE, SignReader, SignReaderError, scale_of, unavailable_reason
from stucksolver_perception.camera.sign_targets import swaths
from stucksolver_perception.rig import load_rig

installed = pytest.mark.skipif(find_spec(PACKAGE) is None, reason=f"{PACKAGE} not installed (the extra `signs`)")
RIG = load_rig().camera
AWAY_M = 15.0


def ahead_of(kind):
    """The camera's image with a sign 15 m ahead, 3 m to the right."""
    studio = Studio(RoadNetwork(load_map(DEMO_TOWN)))
    studio.extra.append(
        RenderPart(post_sign(kind), matrix_of(studio.place(AWAY_M, 3.0, 0.0, 180.0)), 0, tags.TRAFFIC_SIGN)
    )
    studio.world.tick()
    eye = Pose(studio.place(0.0, 0.0, RIG.mount.z_m).location, Rotation(0.0, studio.spot.rotation.yaw, 0.0))
    return studio.shoot(CameraView(eye, RIG.width_px, RIG.height_px, RIG.fov_deg))


@installed
@pytest.mark.parametrize(
    ("kind", "word"), [("206", SignWord.STOP), (ROAD_CLOSED, SignWord.ROAD_CLOSED), (DETOUR, SignWord.DETOUR)]
)
def test_a_sign_ahead_is_read_where_it_is(kind, word):
    image, reader = ahead_of(kind), SignReader()
    parts = [swath for swath in swaths(RIG) if swath is not None]
    found = [(part, item) for part in parts for item in reader.read(part.crop(image), part.single)]
    assert {item.word for _, item in found} == {word}
    column, row, _ = RIG.project(np.array([[RIG.mount.x_m + AWAY_M, -3.0, FACE_M]]))
    for part, item in found:
        assert part.left + item.column == pytest.approx(column[0], abs=8.0)
        assert part.top + item.row == pytest.approx(row[0], abs=8.0)


@installed
def test_a_speed_and_an_empty_picture_are_no_words():
    image, reader = ahead_of("274"), SignReader()
    assert [reader.read(part.crop(image), part.single) for part in swaths(RIG) if part is not None] == [()] * 3
    assert reader.read(np.zeros((60, 60, 3), np.uint8), True) == ()


def test_without_the_package_the_remedy_is_named(monkeypatch):
    monkeypatch.setattr(sign_reader, "PACKAGE", "no_such_package")
    assert unavailable_reason() == "no_such_package not installed; add the extra [signs] (README, Install)"
    with pytest.raises(SignReaderError, match="no_such_package cannot be loaded"):
        SignReader().read(np.zeros((60, 60, 3), np.uint8), True)


def test_small_crops_are_enlarged_and_no_crop_is_large():
    assert scale_of(200, 160, enlarge=True) == 2.0
    assert scale_of(40, 40, enlarge=True) == 4.0
    assert scale_of(640, 340, enlarge=False) == 1.0
    assert scale_of(1472, 900, enlarge=True) == 0.5
