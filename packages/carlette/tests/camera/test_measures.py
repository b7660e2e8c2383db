"""Meshes are made to measure: what a camera shows is what others run into."""

from __future__ import annotations

import numpy as np
import pytest

from carlette.blueprints import load_catalog
from carlette.camera.models.cycles import cycle_mesh
from carlette.camera.models.lamps import lamp_meshes
from carlette.camera.models.mesh import Mesh
from carlette.camera.models.props import prop_mesh
from carlette.camera.models.vehicles import vehicle_mesh
from carlette.geometry import Box

OUT_M = 0.07
SHORT_SHARE = 0.2
ALL_LIT, PAINT = 0x7FF, (90, 90, 90)
BEYOND = ("crossinggate", "table", "garbage", "dirtdebris", "maptable", "toy", "helmet")
"""Props of which a lamp, a leg or a stone stands out."""


def overhang(meshes: list[Mesh], box: Box) -> np.ndarray:
    """How far the things stand out of the box on each of its six sides."""
    points = np.concatenate([mesh.corners.reshape(-1, 3) for mesh in meshes])
    low, high = np.subtract(box.center, box.extent), np.add(box.center, box.extent)
    return np.concatenate([low - points.min(axis=0), points.max(axis=0) - high])


def assert_fills(meshes: list[Mesh], box: Box) -> None:
    out = overhang(meshes, box)
    assert out.max() < OUT_M
    assert (out > -SHORT_SHARE * np.array([*box.extent, *box.extent]) - 0.03).all()


@pytest.mark.parametrize("type_id", sorted(load_catalog().vehicles))
def test_vehicles_fill_their_boxes(type_id) -> None:
    model = load_catalog().vehicles[type_id]
    if model.is_two_wheeler:
        motor = model.base_type == "motorcycle"
        meshes = [cycle_mesh(type_id, model.box, model.wheelbase_m, PAINT, 0.3, motor=motor)]
    else:
        lamps, _ = lamp_meshes(type_id, model.box, ALL_LIT, 1)
        meshes = [vehicle_mesh(type_id, model.box, model.wheelbase_m, PAINT), lamps]
    assert_fills(meshes, model.box)


def test_props_fill_their_boxes() -> None:
    for model in load_catalog().props.values():
        if not any(word in model.id for word in BEYOND):
            out = overhang([prop_mesh(model.id, model.box)], model.box)
            assert out.max() < OUT_M, model.id
