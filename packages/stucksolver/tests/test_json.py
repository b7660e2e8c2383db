"""All that crosses the boundary has one JSON form, strict and versioned."""

from __future__ import annotations

import json

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from instances import of
from stucksolver.plan import Decision, Directive, Execute
from stucksolver.plan.behaviors import REGISTRY, AnyBehavior, ChangeLane, describe, parse_behavior
from stucksolver.plan.json_schemas import ADAPTERS, VERSION, schemas
from stucksolver.scene import RoadGeometry, Scene, Status, Surroundings
from worlds import World, searched, straight_road, thing

TYPES = {"status": Status, "surroundings": Surroundings, "scene": Scene, "decision": Decision, "directive": Directive}


@pytest.mark.integration
@pytest.mark.parametrize("name", TYPES)
@settings(max_examples=15, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_round_trip_through_json_changes_nothing(name, data):
    value = data.draw(of(TYPES[name]))
    text = ADAPTERS[name].dump_json(value)
    again = ADAPTERS[name].validate_json(text)
    assert again == value
    assert type(again) is type(value)
    assert ADAPTERS[name].dump_json(again) == text


@pytest.mark.parametrize("behavior", REGISTRY.values(), ids=REGISTRY)
@settings(max_examples=15)
@given(data=st.data())
def test_every_behavior_survives_json_inside_a_directive(behavior, data):
    directive = Execute(behavior=data.draw(of(behavior)))
    again = ADAPTERS["directive"].validate_json(directive.model_dump_json())
    assert again == directive
    assert type(again.behavior) is behavior


def examples() -> dict[str, dict[str, object]]:
    world = World(straight_road(), [thing("car", 60.0)])
    scene = world.scene()
    decision = searched(world, scene)
    models = {
        "status": world.status(),
        "surroundings": world.surroundings(),
        "scene": scene,
        "decision": decision,
        "directive": Execute(behavior=ChangeLane(side="left", distance_m=20.0, speed_mps=5.0)),
    }
    return {name: json.loads(model.model_dump_json()) for name, model in models.items()}


def numbers_in(value: object, path: tuple[object, ...] = ()) -> list[tuple[object, ...]]:
    """Where the floats of a JSON value are."""
    if isinstance(value, float):
        return [path]
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [found for key, child in children for found in numbers_in(child, (*path, key))]


def replaced(value: object, path: tuple[object, ...], new: object) -> object:
    copy = json.loads(json.dumps(value))
    inner = copy
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = new
    return copy


@pytest.mark.parametrize("name", TYPES)
def test_an_unknown_field_is_refused(name):
    with pytest.raises(ValidationError):
        ADAPTERS[name].validate_python({**examples()[name], "role_name": "scenario"})


@pytest.mark.parametrize("name", TYPES)
@pytest.mark.parametrize("bad", [float("nan"), float("inf"), float("-inf")])
def test_nan_and_infinity_are_refused_wherever_a_number_stands(name, bad):
    example = examples()[name]
    ADAPTERS[name].validate_python(example)
    places = [p for p in numbers_in(example) if "parameters" not in p]
    for path in places[:3] + places[-3:]:
        with pytest.raises(ValidationError):
            ADAPTERS[name].validate_python(replaced(example, path, bad))


@pytest.mark.parametrize("name", ["scene", "decision"])
def test_another_version_is_refused(name):
    with pytest.raises(ValidationError):
        ADAPTERS[name].validate_python({**examples()[name], "version": 2})


def test_schemas_exist_for_each_type_with_version():
    """Each of the five types has one schema, with the version."""
    found = schemas()
    assert set(found) == set(TYPES)
    assert {schema["$id"] for schema in found.values()} == {f"stucksolver/v{VERSION}/{name}" for name in TYPES}
    assert json.loads(json.dumps(found)) == found


@pytest.mark.parametrize("name", ["status", "surroundings", "scene", "decision"])
def test_a_schema_forbids_unknown_fields(name):
    assert schemas()[name]["additionalProperties"] is False
    assert schemas()[name]["properties"].keys() == TYPES[name].model_fields.keys()


def test_the_schema_of_decisions_holds_every_behavior_with_its_bounds():
    definitions = schemas()["decision"]["$defs"]
    assert {cls.__name__ for cls in REGISTRY.values()} <= definitions.keys()
    assert (
        definitions["ChangeLane"]["properties"]["distance_m"] | {"minimum": 15.0, "maximum": 150.0}
        == (definitions["ChangeLane"]["properties"]["distance_m"])
    )


def test_a_reasoner_is_told_the_schema_of_each_offered_behavior():
    offers = describe(tuple(REGISTRY))
    assert [o.parameters["properties"]["name"]["const"] for o in offers] == list(REGISTRY)


def test_offering_an_unknown_behavior_names_the_closed_list():
    with pytest.raises(KeyError, match=r"fly.*borrow_oncoming_lane"):
        describe(("fly",))


@pytest.mark.parametrize(
    "data",
    [
        {"name": "fly"},
        {"name": "wait", "duration_s": 61.0},
        {"name": "wait", "duration_s": 0.0},
        {"name": "keep_lane", "distance_m": 20.0, "speed_mps": 12.0},
        {"name": "change_lane", "side": "up", "distance_m": 20.0, "speed_mps": 5.0},
        {"name": "borrow_oncoming_lane", "past_object_id": "car", "speed_mps": 5.0, "ignore_guard": True},
    ],
)
def test_a_behavior_outside_the_list_or_its_bounds_is_refused(data):
    with pytest.raises(ValidationError):
        parse_behavior(data)


@given(behavior=of(AnyBehavior))
def test_parsing_gives_back_what_was_written(behavior):
    assert parse_behavior(json.loads(behavior.model_dump_json())) == behavior


def test_a_lane_longer_than_its_road_is_refused():
    road = straight_road()
    with pytest.raises(ValidationError, match="beyond the reference line"):
        RoadGeometry(**{**road.model_dump(), "reference": road.reference[:100]})


def test_a_lane_whose_columns_differ_in_length_is_refused():
    lane = straight_road().lanes[0].model_dump()
    with pytest.raises(ValidationError, match="one value for each station"):
        type(straight_road().lanes[0])(**{**lane, "width_m": lane["width_m"][:-1]})
