"""A vehicle has 30 km/h until it touches the box of a speed sign, as in CARLA."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import box as rectangle

from carlette.maps import SHIPPED
from carlette.opendrive.map_file import MapFile, load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.speed_limit_boxes import BOX_SHARE
from carlette.world.world import World
from straight import LANE_Y_M, add, drive, straight_road

SIGN_M = 100.0
HALF_M = BOX_SHARE * 3.5


def sign(kmh: float, lanes: tuple[int, int] = (-1, -1), s: float = SIGN_M, unit: str = "km/h") -> str:
    return (
        f'<signal name="Speed" id="{s:g}" s="{s}" t="-5" zOffset="0" orientation="+" dynamic="no" country="OpenDRIVE" '
        f'type="274" subtype="{kmh:g}" value="{kmh}" unit="{unit}" hOffset="0" pitch="0" roll="0" height="1" width="1">'
        f'<validity fromLane="{lanes[0]}" toLane="{lanes[1]}"/></signal>'
    )


def signed(*signs: str) -> World:
    return World(RoadNetwork(MapFile("signed", straight_road(signals="".join(signs)))))


def limit(world: World, car) -> float:
    return float(world.bodies.record["speed_limit"][car.row])


def test_spawned_vehicle_has_30_kmh_limit_on_any_road() -> None:
    """A vehicle has a limit of 30 km/h wherever it is spawned, whatever the road says."""
    world = signed(sign(90.0))
    assert [limit(world, add(world, x=x)) for x in (50.0, 300.0)] == [30.0, 30.0]


@pytest.mark.integration
def test_vehicle_limit_changes_when_bumper_reaches_sign_box() -> None:
    """A vehicle gets the limit of a sign when its bumper touches the box of the sign, and keeps it."""
    world = signed(sign(90.0), sign(60.0, s=160.0))
    car = add(world, x=80.0)
    drive(world, car, throttle=0.6)
    seen: dict[float, float] = {}
    for _ in range(400):
        world.tick()
        seen.setdefault(
            limit(world, car), float(world.bodies.position[car.row, 0]) + car.box.extent.x + car.box.center.x
        )
    assert list(seen) == [30.0, 90.0, 60.0]
    assert seen[90.0] == pytest.approx(SIGN_M - 2 * HALF_M, abs=1.0)
    assert seen[60.0] == pytest.approx(160.0 - 2 * HALF_M, abs=1.0)


def test_a_sign_counts_for_its_lanes_alone() -> None:
    world = signed(sign(90.0))
    assert limit(world, add(world, x=SIGN_M - 1.0, y=-LANE_Y_M, yaw=180.0)) == 30.0


def test_vehicle_teleported_into_sign_box_gets_its_limit() -> None:
    """A vehicle that a client teleports into the box of a sign gets its limit."""
    world = signed(sign(90.0))
    car = add(world, x=50.0)
    world.teleport(car, world.pose(car)._replace(location=world.pose(car).location._replace(x=SIGN_M - 1.0)))
    world.tick()
    assert limit(world, car) == 90.0


def test_speed_sign_value_is_kmh_and_missing_value_ignored() -> None:
    """The value counts as km/h, whatever the unit; a sign without a value is ignored."""
    world = signed(sign(25.0, unit="mph"), sign(-1.0, s=200.0))
    cars = [add(world, x=x) for x in (SIGN_M - 1.0, 199.0)]
    assert [limit(world, car) for car in cars] == [25.0, 30.0]


@pytest.mark.integration
@settings(max_examples=60, deadline=None)
@given(st.floats(90.0, 108.0), st.floats(-2.0, 5.5), st.floats(-180.0, 180.0))
def test_touching_means_that_the_vehicles_outline_overlaps_the_box(x: float, y: float, yaw: float) -> None:
    world = signed(sign(90.0))
    car = add(world, x=x, y=y, yaw=yaw)
    extent, center = car.box.extent, car.box.center
    outline = rectangle(center.x - extent.x, center.y - extent.y, center.x + extent.x, center.y + extent.y)
    outline = affinity.translate(affinity.rotate(outline, yaw, origin=(0, 0)), x, y)
    here = rectangle(SIGN_M - 2 * HALF_M, LANE_Y_M - HALF_M, SIGN_M, LANE_Y_M + HALF_M)
    gap = outline.distance(here) if not outline.intersects(here) else -outline.intersection(here).area
    if abs(gap) > 1e-3:
        assert (limit(world, car) == 90.0) == (gap < 0.0)


def test_grid_town_streets_have_speed_sign_after_junction() -> None:
    """Each street of the generated town has a speed sign for cars that leave a junction."""
    roads = RoadNetwork(load_map(SHIPPED / "grid_town.xodr"))
    streets = [
        waypoint
        for waypoint in roads.map.generate_waypoints(5.0)
        if not waypoint.is_junction and 12.0 < waypoint.s < 20.0
    ]
    assert len(roads.speed_boxes) >= len({street.road_id for street in streets})
    assert set(roads.speed_boxes.kmh.tolist()) == {30.0, 40.0, 50.0}
