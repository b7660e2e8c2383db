"""Some props stop a car, some fly, and some are only seen."""

from __future__ import annotations

import pytest

from carlette.blueprints import load_catalog
from carlette.geometry import Pose, Rotation, Vector
from carlette.world.spawn import spawn
from straight import CAR, LANE_Y_M, add, drive, launch, on_lane, speed_of, straight_world, ticks

PROPS = load_catalog().props
BY_CONTACT = {
    kind: [item for item in PROPS.values() if item.contact == kind] for kind in ("passable", "loose", "fixed")
}


def drive_into(type_id: str, mps: float = 12.0):
    world = straight_world()
    car, prop = add(world), add(world, type_id, 62.0)
    sensor = spawn(world, "sensor.other.collision", {}, Pose(), parent_id=car.id)
    launch(world, car, mps)
    drive(world, car, throttle=0.5)
    hits = [hit for w in ticks(world, 40) for hit in w.collisions if hit.sensor_id == sensor.id]
    return world, car, prop, {item.other_id for item in hits}


def test_every_prop_is_of_one_of_three_kinds() -> None:
    assert sum(map(len, BY_CONTACT.values())) == len(PROPS)
    names = {item.id.rsplit(".", 1)[1] for item in BY_CONTACT["passable"]}
    assert {"dirtdebris01", "dirtdebris02", "dirtdebris03", "plasticbag", "paperbag", "paper"} <= names


@pytest.mark.parametrize("prop", BY_CONTACT["passable"], ids=lambda item: item.id)
def test_passable_props_are_seen_but_never_felt(prop) -> None:
    world, car, there, hits = drive_into(prop.id)
    assert not hits
    assert world.pose(car).location.x > 68.0
    assert world.pose(there).location.x == 62.0
    assert there.box.extent.x > 0.0
    assert there.id in world.bodies.record["id"].tolist()


@pytest.mark.parametrize("name", ["constructioncone", "trafficcone01", "warningconstruction", "streetbarrier", "ball"])
def test_light_props_are_pushed_away_and_reported(name: str) -> None:
    world, car, prop, hits = drive_into(f"static.prop.{name}")
    assert hits == {prop.id}
    assert world.pose(prop).location.x > 63.0
    assert speed_of(world, car) > 8.0


@pytest.mark.parametrize("name", ["container", "advertisement", "foodcart", "busstoplb", "vendingmachine", "rock"])
def test_heavy_props_stop_a_car_where_they_stand(name: str) -> None:
    world, car, prop, hits = drive_into(f"static.prop.{name}")
    assert hits == {prop.id}
    assert world.pose(prop).location.x == 62.0
    assert speed_of(world, car) < 3.0


def test_crossing_gate_stops_car_unless_raised() -> None:
    """A level crossing gate stops a car, and lets it pass when raised."""
    for roll, stops in ((0.0, True), (-85.0, False)):
        world = straight_world()
        car = add(world)
        gate = spawn(world, "static.prop.crossinggate", {}, Pose(Vector(70.0, LANE_Y_M - 3.0, 0.0)))
        world.teleport(gate, Pose(Vector(70.0, LANE_Y_M - 3.0, 0.0), Rotation(roll=roll)))
        launch(world, car, 10.0)
        drive(world, car, throttle=0.5)
        list(ticks(world, 60))
        assert (world.pose(car).location.x < 70.0) == stops


def test_a_prop_that_is_attached_does_not_push_its_carrier() -> None:
    world = straight_world()
    car = add(world)
    spawn(world, "static.prop.travelcase", {}, Pose(Vector(z=1.0)), parent_id=car.id)
    launch(world, car, 10.0)
    assert not any(w.collisions for w in ticks(world, 20))
    assert world.pose(car).location.y == LANE_Y_M


def test_collisions_off_and_on_again_leave_passable_props_passable() -> None:
    assert not add(straight_world(), "static.prop.dirtdebris01").touches
    assert add(straight_world(), CAR).touches
    assert on_lane(0.0).location.y == LANE_Y_M
