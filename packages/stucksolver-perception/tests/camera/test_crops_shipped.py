"""The network that ships: it loads, it is small and quick, and it says nothing of a picture that shows nothing."""

import numpy as np
import pytest

from stucksolver.scene.surroundings import LightState
from stucksolver_perception.camera.attributes import AttributeReader
from stucksolver_perception.camera.crop_network import CropNetwork
from stucksolver_perception.camera.traffic_lights import LightReader
from stucksolver_perception.measurements import CameraFrame
from stucksolver_perception.network_files import DATA
from stucksolver_perception.rig import load_rig

pytest.importorskip("onnxruntime")
pytest.importorskip("PIL")
CAMERA = load_rig().camera
SLOWEST_MS = 120.0
"""For thirty boxes on one thread; about 16 ms where nobody else computes."""


@pytest.fixture(scope="module")
def network() -> CropNetwork:
    return CropNetwork()


def test_it_is_small() -> None:
    assert (DATA / "crops.onnx").stat().st_size < 3_000_000


@pytest.mark.parametrize("gray", [0, 90, 255])
def test_nothing_is_said_of_a_picture_without_anything(network: CropNetwork, gray: int) -> None:
    frame = CameraFrame(0.0, np.full((900, 1600, 3), gray, np.uint8))
    boxes = np.array([[20.0, 0, 0.8, 4.5, 1.9, 1.6, 0], [12.0, 2, 0.2, 0.4, 0.4, 0.4, 0], [-9.0, 0, 1, 4, 2, 2, 0]])
    for item in AttributeReader(network=network).read(frame, CAMERA, boxes):
        assert item.kind is None
        assert not item.brake_lights
        assert not item.emergency_lights
        assert not item.hazard_lights
        assert not item.door_open
    head = np.array([[30.0, 0, 5, 0.3, 0.2, 0.66, -np.pi / 2]])
    assert LightReader(network=network).read(frame, CAMERA, [head]) == ((LightState.UNKNOWN, 0.0),)
