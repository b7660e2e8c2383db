"""Traffic lights by the camera: what is doubtful is unknown."""

import numpy as np
import pytest

from stucksolver.scene.surroundings import LightState
from stucksolver_perception.camera.crop_network import LIGHTS
from stucksolver_perception.camera.traffic_lights import LightFilter, LightReader, boxes_of_heads, combined, facing
from stucksolver_perception.measurements import CameraFrame
from stucksolver_perception.rig import load_rig

CAMERA = load_rig().camera
LEAST = np.array([0.9, 0.9, 0.95, 0.9, 0.0])
TOWARDS_US = -np.pi / 2
"""The yaw of a head whose lamps look back along the road."""


def head(name: str, sure: float) -> list[float]:
    told = [(1.0 - sure) / 4] * 5
    told[LIGHTS.index(name)] = sure
    return told


def test_heads_of_a_light_are_combined() -> None:
    assert combined(np.array([head("red", 0.97), head("unseen", 0.9)]), LEAST) == (LightState.RED, 0.97)
    assert combined(np.array([head("green", 0.96), head("red", 0.6)]), LEAST)[0] is LightState.GREEN


@pytest.mark.parametrize(
    "heads",
    [
        np.zeros((0, 5)),
        np.array([head("unseen", 1.0)]),
        np.array([head("green", 0.94)]),
        np.array([head("green", 0.99), head("red", 0.99)]),
    ],
    ids=["no head", "none seen", "not sure", "two disagree"],
)
def test_a_doubtful_light_is_unknown(heads: np.ndarray) -> None:
    assert combined(heads, LEAST) == (LightState.UNKNOWN, 0.0)


def test_a_head_faces_the_lens_or_not() -> None:
    heads = np.array([[30.0, 0, 5, 0.3, 0.2, 0.6, yaw] for yaw in (TOWARDS_US, -TOWARDS_US, 0.0)])
    assert np.allclose(facing(CAMERA, heads), [1.0, -1.0, 0.0], atol=1e-6)
    assert np.allclose(boxes_of_heads(heads)[0], [30, 0, 5, 0.6, 0.4, 1.2, TOWARDS_US])


def test_a_light_that_cannot_be_seen_is_not_looked_at() -> None:
    class Blind:
        least_light = LEAST

        def run(self, crops: np.ndarray, features: np.ndarray) -> object:
            assert len(crops) == len(features) == 0
            return type("Told", (), {"light": np.zeros((0, 5))})

    behind = np.array([[-30.0, 0, 5, 0.3, 0.2, 0.6, TOWARDS_US]])
    turned = np.array([[30.0, 0, 3, 0.3, 0.2, 0.6, -TOWARDS_US]])
    frame = CameraFrame(0.0, np.zeros((900, 1600, 3), np.uint8))
    reader = LightReader(network=Blind())  # type: ignore[arg-type]
    assert reader.read(frame, CAMERA, [behind, turned, np.zeros((0, 7))]) == ((LightState.UNKNOWN, 0.0),) * 3
    assert reader.read(frame, CAMERA, []) == ()


def test_a_state_counts_after_two_looks_that_agree() -> None:
    shown = LightFilter()
    shown.add(7, LightState.GREEN, 0.99, 0.0)
    assert shown.state(7, 0.0) is LightState.UNKNOWN
    shown.add(7, LightState.GREEN, 0.97, 0.5)
    assert shown.look(7, 0.5) == (LightState.GREEN, 0.97)
    assert shown.state(8, 0.5) is LightState.UNKNOWN


def test_a_change_is_unknown_until_it_is_confirmed() -> None:
    shown = LightFilter()
    for time_s, state in ((0.0, LightState.GREEN), (0.5, LightState.GREEN), (1.0, LightState.YELLOW)):
        shown.add(7, state, 0.99, time_s)
    assert shown.state(7, 1.0) is LightState.UNKNOWN
    shown.add(7, LightState.YELLOW, 0.99, 1.5)
    assert shown.state(7, 1.5) is LightState.YELLOW


def test_light_filter_unread_for_1_s_is_unknown() -> None:
    """A light that was not read for a second is unknown."""
    shown = LightFilter()
    for time_s in (0.0, 0.5):
        shown.add(7, LightState.GREEN, 0.99, time_s)
    shown.add(7, LightState.UNKNOWN, 0.0, 1.4)
    assert shown.state(7, 1.4) is LightState.GREEN
    assert shown.state(7, 1.6) is LightState.UNKNOWN
    shown.add(7, LightState.GREEN, 0.99, 9.0)
    assert shown.state(7, 9.0) is LightState.UNKNOWN
    shown.forget(before_s=10.0)
    assert shown.look(7, 9.0) == (LightState.UNKNOWN, 0.0)
