"""The blueprint library: what evaluators and scenarios ask it for."""

from __future__ import annotations

import fnmatch

import pytest
from stage import spawn

carla = pytest.importorskip("carla")

ASKED_FOR = [
    "vehicle.lincoln.mkz_2020",
    "vehicle.dodge.charger_police_2020",
    "vehicle.tesla.model3",
    "vehicle.bh.crossbike",
    "vehicle.diamondback.century",
    "vehicle.gazelle.omafiets",
    "walker.pedestrian.0001",
    "controller.ai.walker",
    "sensor.other.collision",
    "sensor.other.lane_invasion",
    "static.prop.warningaccident",
    "static.prop.warningconstruction",
    "static.prop.trafficwarning",
    "static.prop.dirtdebris01",
    "static.prop.dirtdebris02",
    "static.prop.constructioncone",
    "static.prop.container",
    "static.prop.advertisement",
    "static.prop.busstoplb",
    "static.prop.foodcart",
    "static.prop.vendingmachine",
]
FILTERS = [
    {"base_type": "car", "special_type": "", "has_lights": True},
    {"base_type": "car", "has_lights": True},
    {"base_type": "car", "generation": 2},
    {"base_type": "car", "generation": 2, "special_type": ""},
    {"special_type": "emergency"},
    {"base_type": "car", "has_dynamic_doors": True},
    {"base_type": "bicycle"},
]
READ = {str: "as_str", bool: "as_bool", int: "as_int"}


@pytest.fixture
def library(world):
    return world.get_blueprint_library()


@pytest.mark.parametrize("type_id", ASKED_FOR)
def test_what_scenarios_ask_for_is_there(library, type_id: str) -> None:
    assert library.find(type_id).id == type_id
    assert [item.id for item in library.filter(type_id)] == [type_id]


@pytest.mark.parametrize("wanted", FILTERS, ids=lambda wanted: " ".join(f"{k}={v}" for k, v in wanted.items()))
def test_what_scenarios_filter_by_has_matches_of_the_right_type(library, wanted) -> None:
    def matches(one) -> bool:
        return all(
            one.has_attribute(name) and getattr(one.get_attribute(name), READ[type(value)])() == value
            for name, value in wanted.items()
        )

    assert any(matches(item) for item in library.filter("vehicle.*"))


def test_attributes_have_the_types_that_scenarios_compare(library) -> None:
    kind = carla.ActorAttributeType
    expected = {
        "base_type": kind.String,
        "special_type": kind.String,
        "generation": kind.Int,
        "has_lights": kind.Bool,
        "has_dynamic_doors": kind.Bool,
    }
    for item in library.filter("vehicle.*"):
        assert {name: item.get_attribute(name).type for name in expected} == expected
        assert item.get_attribute("number_of_wheels").as_int() >= 2


def test_every_color_list_has_a_color_to_choose(library) -> None:
    colored = [item for item in library.filter("vehicle.*") if item.has_attribute("color")]
    assert colored
    for item in colored:
        colors = item.get_attribute("color").recommended_values
        assert colors
        item.set_attribute("color", colors[0])
        assert item.get_attribute("color").as_color()


def test_the_library_is_in_the_same_order_each_time(world, library) -> None:
    assert [item.id for item in library] == [item.id for item in world.get_blueprint_library()]


def test_tags_are_the_parts_of_the_id(library) -> None:
    car = library.find("vehicle.tesla.model3")
    assert set(car.tags) >= {"vehicle", "tesla", "model3"}
    assert car.has_tag("vehicle") and not car.has_tag("walker")


def test_patterns_match_as_in_a_shell(library) -> None:
    ids = [item.id for item in library]
    for pattern in ("vehicle.*", "*constructioncone*", "walker.pedestrian.*", "*"):
        assert {item.id for item in library.filter(pattern)} == set(fnmatch.filter(ids, pattern))


def test_what_is_not_there_is_an_error(world, library, spots) -> None:
    with pytest.raises(IndexError):
        library.find("vehicle.trabant.601")


def test_a_role_reaches_the_actor(world, spots) -> None:
    for role, spot in zip(("hero", "background", "scenario no lights"), spots, strict=False):
        assert spawn(world, spot, role_name=role).attributes["role_name"] == role


@pytest.mark.carlette_only
@pytest.mark.integration
def test_every_sensor_that_is_offered_can_be_attached(world, library, spots) -> None:
    car = spawn(world, spots[0])
    for item in library.filter("sensor.*"):
        assert world.spawn_actor(item, carla.Transform(), attach_to=car).is_alive is not None
    world.tick()
