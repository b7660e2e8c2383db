"""The catalogue has what CARLA 0.9.16 has, and says what it has beyond that."""

from __future__ import annotations

import pytest

from carlette.blueprints import AttributeType, load_catalog
from carlette.blueprints.library import EXTRA

CATALOG = load_catalog()


def attributes(type_id: str) -> dict[str, str]:
    return {attribute.id: attribute.value for attribute in CATALOG.definitions[type_id].attributes}


def test_carlas_own_are_counted_and_unmarked() -> None:
    def usual(prefix: str) -> int:
        return sum(
            id.startswith(prefix) and EXTRA not in definition.tags.split(",")
            for id, definition in CATALOG.definitions.items()
        )

    assert (usual("vehicle."), usual("walker.pedestrian."), usual("static.prop.")) == (41, 52, 100)


@pytest.mark.parametrize(
    "type_id",
    [
        "animal.dog",
        "animal.deer",
        "animal.cow",
        "walker.flagger.0001",
        "vehicle.carlette.schoolbus",
        "static.prop.crossinggate",
        "static.prop.paperbag",
        "static.prop.ball",
        "static.prop.toy",
        "static.prop.rock",
        "static.prop.cardboardbox",
        "static.prop.cardoor_front",
    ],
)
def test_what_carla_lacks_carries_tag_and_attribute(type_id: str) -> None:
    assert EXTRA in CATALOG.definitions[type_id].tags.split(",")
    assert attributes(type_id)[EXTRA] == "true"


def test_blueprint_patterns_for_walkers_and_vehicles_exclude_animals() -> None:
    """A random choice among the walkers or the vehicles never gives an animal."""
    assert not any(id.startswith(("walker.", "vehicle.")) for id in CATALOG.definitions if "animal" in id)


@pytest.mark.parametrize("type_id", sorted(CATALOG.walkers))
def test_every_walker_stands_in_its_box_and_names_its_speeds(type_id: str) -> None:
    model = CATALOG.walkers[type_id]
    assert 0.1 < model.box.extent.z < 1.1
    speed = next(attribute for attribute in CATALOG.definitions[type_id].attributes if attribute.id == "speed")
    still, walk, run = map(float, speed.recommended)
    assert still == 0.0 < walk < run
    assert speed.type is AttributeType.FLOAT and speed.is_modifiable


def test_children_are_smaller_and_only_some_walkers_take_a_wheelchair() -> None:
    heights = {}
    for model in CATALOG.walkers.values():
        heights.setdefault(model.age, set()).add(model.box.extent.z)
    assert max(heights["child"]) < 0.7
    assert attributes("walker.pedestrian.0001")["can_use_wheelchair"] == "true"
    assert attributes("walker.pedestrian.0030")["can_use_wheelchair"] == "false"
    assert "use_wheelchair" not in attributes("walker.pedestrian.0030")


@pytest.mark.parametrize(
    ("type_id", "half"),
    [
        # CARLA's own figures, found in two independent public dumps; the bus's box includes its mirrors and a margin.
        ("vehicle.mitsubishi.fusorosa", (5.136, 1.972, 2.126)),
        ("vehicle.tesla.model3", (2.396, 1.082, 0.744)),
        ("vehicle.dodge.charger_police_2020", (2.619, 0.965, 0.819)),
        ("vehicle.bh.crossbike", (0.755, 0.433, 0.806)),
        ("static.prop.container", (0.966, 0.506, 0.857)),
        ("static.prop.busstoplb", (0.947, 1.938, 1.369)),
        ("static.prop.dirtdebris01", (0.929, 0.757, 0.074)),
    ],
)
def test_boxes_are_those_of_the_real_simulator(type_id: str, half: tuple[float, float, float]) -> None:
    box = (CATALOG.vehicles.get(type_id) or CATALOG.props[type_id]).box
    assert tuple(box.extent) == pytest.approx(half, abs=0.002)


@pytest.mark.parametrize("type_id", sorted(CATALOG.vehicles))
def test_every_vehicle_has_carlas_attributes(type_id: str) -> None:
    found = attributes(type_id)
    model = CATALOG.vehicles[type_id]
    assert found["base_type"] in {"car", "truck", "van", "bus", "motorcycle", "bicycle"}
    assert int(found["number_of_wheels"]) == model.wheels in {2, 4, 6}
    assert found["generation"] in {"1", "2"}
    assert {"role_name", "color", "sticky_control", "terramechanics", "special_type", "object_type"} <= set(found)
    assert model.wheelbase_m < 2.0 * model.box.extent.x
