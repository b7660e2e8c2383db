"""The people of the first case look different, and nothing else about them does."""

from __future__ import annotations

import pytest

pytest.importorskip("carla")

from carlette.blueprints import load_catalog
from carlette.camera.models.people import clothes_of
from stucksolver_eval.scenarios.types.street.people_at_red_light import WALKERS


def test_case_pedestrians_differ_only_in_clothes() -> None:
    """The pedestrians on the crosswalk are equal in size, mass and age, and each has clothes of another color."""
    people = [load_catalog().walkers[walker] for walker in WALKERS]
    assert len({(person.box, person.mass_kg, person.age) for person in people}) == 1
    clothes = [clothes_of(person.id, person.gender, person.age) for person in people]
    assert len({clothe.top for clothe in clothes}) == len(WALKERS)
