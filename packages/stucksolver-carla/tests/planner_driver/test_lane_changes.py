"""Lane changes of the route: in a gap, and not into anybody."""

from __future__ import annotations

import carla
import numpy as np
import pytest
from planner_stage import LEFT, RIGHT, LitWorld, drive

from stucksolver_carla.drivers.behavior import DriverOptions
from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift, offset_of
from stucksolver_carla.drivers.behavior.route_lane_changes import lane_changes
from stucksolver_carla.drivers.planner import PlannerDriver


def scene(speed=10.0, limit_kmh=50.0):
    """On its way from the left lane to the right one."""
    world = LitWorld()
    ego = world.add_ego(10.0, LEFT, 0.0, speed)
    ego.speed_limit = limit_kmh
    driver = PlannerDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True), world.map)
    driver.set_destination(carla.Location(390.0, RIGHT, 0.0))
    return world, ego, driver


def touches(world, ego, margin_m=0.0):
    return any(
        abs(actor.x - ego.x) < 4.7 + margin_m and abs(actor.y - ego.y) < 2.0
        for actor in world.actors
        if actor is not ego
    )


def test_lane_changes_of_route_have_their_available_length() -> None:
    """The lane changes of a route are found with the length that is available for them."""
    _, _, driver = scene()
    (change,) = lane_changes(driver.route, driver._planner.route_line)
    assert change.lateral_m == pytest.approx(3.5, abs=0.05)
    assert change.first_m <= change.begins_m < change.last_m
    offsets = change.line_at(np.array([change.begins_m, change.begins_m + change.length_m]))
    assert offsets == pytest.approx([0.0, 3.5], abs=0.05)


@pytest.mark.integration
@pytest.mark.parametrize("abreast_m", [-8.0, -3.0, 0.0, 4.0, 9.0])
def test_nobody_abreast_is_touched_and_the_lane_is_reached(abreast_m) -> None:
    world, ego, driver = scene()
    world.add("vehicle.a", 10.0 + abreast_m, RIGHT, speed=11.0)
    for _ in range(400):
        drive(world, ego, driver, 0.05)
        assert not touches(world, ego)
    assert abs(ego.y - RIGHT) < 0.3


@pytest.mark.integration
@pytest.mark.parametrize("gap_m", [24.0, 30.0])
def test_lane_change_joins_faster_flow_without_contact(gap_m) -> None:
    """A traffic flow faster than the limit is joined without a contact from behind.

    Its cars do not brake for the ego.
    """
    world, ego, driver = scene(7.5, 30.0)
    for k in range(14):
        world.add("vehicle.a", 40.0 - gap_m * k, RIGHT, speed=11.0)
    for _ in range(600):
        drive(world, ego, driver, 0.05)
        assert not touches(world, ego)
        if ego.x > 340.0:
            break
    assert abs(ego.y - RIGHT) < 0.3


def test_lateral_shifts_to_both_sides_add_up() -> None:
    """Shifts to either side add up and end where they began."""
    s = np.linspace(0.0, 100.0, 201)
    right, left = LateralShift(0.5, 10.0, 20.0, 40.0, 50.0), LateralShift(-0.3, 60.0, 70.0, 80.0, 90.0)
    offset = offset_of([right, left], s)
    assert offset.max() == pytest.approx(0.5)
    assert offset.min() == pytest.approx(-0.3)
    assert (offset[0], offset[-1]) == pytest.approx((0.0, 0.0))
