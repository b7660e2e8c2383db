"""A vehicle for which a client chooses no color has one of its blueprint's, always the same for the same id."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from carlette.blueprints import AttributeType, load_catalog
from carlette.blueprints.default_color import UNPAINTED
from carlette.world.spawn import spawn
from straight import add, drive, on_lane, straight_world, ticks

CAR, POLICE, BICYCLE = "vehicle.lincoln.mkz_2020", "vehicle.dodge.charger_police_2020", "vehicle.bh.crossbike"
DEFINITIONS = load_catalog().definitions


def recommended(type_id: str) -> tuple[str, ...]:
    return next(attribute.recommended for attribute in DEFINITIONS[type_id].attributes if attribute.id == "color")


def color_of(actor) -> str:
    return actor.attributes["color"][1]


def asked(color: str):
    return {"color": (AttributeType.COLOR, color)}


def row_of_cars(attributes, type_id: str = CAR, count: int = 60) -> list[str]:
    world = straight_world()
    return [color_of(spawn(world, type_id, dict(attributes), on_lane(20.0 + 10.0 * i))) for i in range(count)]


@pytest.mark.parametrize("attributes", [{}, asked(UNPAINTED)], ids=["nothing sent", "the blueprint's default"])
def test_unpainted_cars_get_all_recommended_colors_reproducibly(attributes) -> None:
    """Cars without a chosen color get all recommended colors, and the same ones again."""
    colors = row_of_cars(attributes)
    counts = Counter(colors)
    assert set(counts) == set(recommended(CAR))
    assert max(counts.values()) < 0.4 * len(colors)
    assert row_of_cars(attributes) == colors


@pytest.mark.parametrize("color", ["255,255,255", "17,17,17", "1,2,3", "nonsense"])
def test_chosen_color_is_kept_as_sent(color: str) -> None:
    """A color that a client chose stays as it was sent."""
    assert set(row_of_cars(asked(color), count=5)) == {color}


def test_blueprints_of_one_color_have_that_color() -> None:
    assert set(row_of_cars({}, POLICE, 10)) == set(recommended(POLICE))


def test_a_bicycle_has_one_of_a_bicycles_colors() -> None:
    assert set(row_of_cars({}, BICYCLE, 30)) == set(recommended(BICYCLE))


def test_default_color_is_valid_and_not_recommended() -> None:
    """The default is a valid color outside the recommended ones, so that a client can choose any of those."""
    for definition in DEFINITIONS.values():
        for attribute in definition.attributes:
            if attribute.type is AttributeType.COLOR:
                assert attribute.value == UNPAINTED and UNPAINTED not in attribute.recommended
    assert all(0 <= int(part) <= 255 for part in UNPAINTED.split(","))


def test_what_has_no_color_gets_none() -> None:
    world = straight_world()
    for kind in ("walker.pedestrian.0001", "static.prop.constructioncone"):
        assert "color" not in add(world, kind, x=30.0 if "walker" in kind else 40.0).attributes


@pytest.mark.integration
def test_paint_moves_nothing() -> None:
    ways = []
    for attributes in ({}, asked("1,2,3")):
        world = straight_world()
        car = spawn(world, CAR, attributes, on_lane(50.0))
        drive(world, car, throttle=0.7, steer=0.05)
        ways.append(np.array([w.bodies.position.copy() for w in ticks(world, 200)]))
    assert (ways[0] == ways[1]).all()
