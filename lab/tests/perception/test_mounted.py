"""What only a recording makes of CARLA's pictures."""

from __future__ import annotations

import io
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("carla")

from PIL import Image

from lab.perception.recording.recording_sensors import encoded, instance_ids


def shown(bgra: np.ndarray) -> SimpleNamespace:
    return SimpleNamespace(raw_data=bgra.astype(np.uint8).tobytes(), height=bgra.shape[0], width=bgra.shape[1])


def test_an_id_is_green_and_256_times_blue() -> None:
    blue, green, red = 2, 7, 99
    assert instance_ids(shown(np.array([[[blue, green, red, 255]]]))).tolist() == [[2 * 256 + 7]]


def test_a_lamp_of_a_few_pixels_keeps_its_color() -> None:
    bgra = np.full((32, 32, 4), 20)
    bgra[15:17, 15:17] = [0, 0, 250, 255]
    rgb = np.asarray(Image.open(io.BytesIO(encoded(shown(bgra)))))
    red, green, blue = rgb[15:17, 15:17].astype(float).mean(axis=(0, 1))
    assert red > 200.0
    assert max(green, blue) < 60.0
