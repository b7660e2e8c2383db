"""The blueprint library holds what scenarios ask for, with CARLA's ids, types and sizes."""

from __future__ import annotations

import pytest

from carlette.blueprints import AttributeType, load_catalog

ASKED_FOR = [
    "vehicle.lincoln.mkz_2020",
    "vehicle.dodge.charger_police_2020",
    "vehicle.bh.crossbike",
    "vehicle.diamondback.century",
    "vehicle.gazelle.omafiets",
    "vehicle.tesla.model3",
    "walker.pedestrian.0001",
    "walker.pedestrian.0049",
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
    "static.prop.streetbarrier",
    "static.prop.mesh",
    "sensor.other.collision",
    "sensor.other.lane_invasion",
]


def attributes(type_id: str) -> dict[str, str]:
    return {attribute.id: attribute.value for attribute in load_catalog().definitions[type_id].attributes}


@pytest.mark.parametrize("type_id", ASKED_FOR)
def test_scenarios_find_their_blueprint(type_id: str) -> None:
    assert type_id in load_catalog().definitions


@pytest.mark.parametrize(
    "wanted",
    [
        {"base_type": "car", "special_type": "", "has_lights": "true"},
        {"base_type": "car", "generation": "2", "special_type": ""},
        {"special_type": "emergency"},
        {"has_dynamic_doors": "true", "base_type": "car"},
        {"base_type": "bicycle"},
        {"base_type": "motorcycle"},
        {"base_type": "truck"},
    ],
)
def test_every_filter_of_the_scenarios_finds_a_vehicle(wanted: dict[str, str]) -> None:
    vehicles = load_catalog().vehicles
    assert any(wanted.items() <= attributes(vehicle).items() for vehicle in vehicles)


def test_every_vehicle_offers_colors_and_typed_attributes() -> None:
    for type_id in load_catalog().vehicles:
        by_id = {attribute.id: attribute for attribute in load_catalog().definitions[type_id].attributes}
        assert by_id["color"].recommended
        assert by_id["generation"].type is AttributeType.INT
        assert by_id["has_lights"].type is AttributeType.BOOL


def test_sizes_are_those_of_the_real_simulator() -> None:
    box = load_catalog().vehicles["vehicle.lincoln.mkz_2020"].box
    assert box.extent.x == pytest.approx(2.446, abs=0.01)
    assert box.extent.y == pytest.approx(0.918, abs=0.01)
    assert sum(not vehicle.is_extra for vehicle in load_catalog().vehicles.values()) == 41


def test_background_vehicle_blueprints_are_nine_of_published_results() -> None:
    """Background traffic has the nine vehicle models that occur in published results on CARLA."""
    wanted = {"base_type": "car", "special_type": "", "has_lights": "true"}
    found = {
        vehicle.removeprefix("vehicle.")
        for vehicle in load_catalog().vehicles
        if wanted.items() <= attributes(vehicle).items()
    }
    assert found == {
        "audi.tt", "chevrolet.impala", "dodge.charger_2020", "ford.mustang", "lincoln.mkz_2017", "lincoln.mkz_2020",
        "mercedes.coupe_2020", "mini.cooper_s_2021", "nissan.patrol_2021",
    }  # fmt: skip


def test_vehicles_come_in_the_order_in_which_carla_defines_them() -> None:
    """From a listing of the library of CARLA 0.9.13 on Linux, backwards; what it has not comes last."""
    order = list(load_catalog().vehicles)
    listed = ["audi.a2", "audi.tt", "chevrolet.impala", "audi.etron", "lincoln.mkz_2017", "ford.mustang"]
    listed += ["lincoln.mkz_2020", "mercedes.coupe_2020", "dodge.charger_2020", "mini.cooper_s_2021"]
    listed += ["nissan.patrol_2021", "volkswagen.t2_2021", "mitsubishi.fusorosa", "carlette.schoolbus"]
    places = [order.index(f"vehicle.{item}") for item in listed]
    assert places == sorted(places)


def test_only_vehicles_of_the_second_generation_have_opening_doors() -> None:
    models = [vehicle for vehicle in load_catalog().vehicles.values() if not vehicle.is_extra]
    assert not [model.id for model in models if model.generation == 1 and model.has_doors]
    shut = {model.id for model in models if model.generation == 2 and not model.has_doors}
    assert shut == {"vehicle.carlamotors.european_hgv", "vehicle.tesla.cybertruck", "vehicle.mitsubishi.fusorosa"}
    assert {model.id for model in models if model.generation == 2 and not model.has_lights} == {
        "vehicle.carlamotors.european_hgv"
    }
