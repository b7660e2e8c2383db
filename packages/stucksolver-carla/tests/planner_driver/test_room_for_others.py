"""Room beside doors, and a lane for emergency vehicles."""

from __future__ import annotations

import carla
import numpy as np
import pytest
from planner_stage import LEFT, RIGHT, LitWorld, drive

from behavior_driver.fakes import box
from stucksolver.scene.boxes import separation
from stucksolver_carla.drivers.behavior import BehaviorDriver, DriverOptions
from stucksolver_carla.drivers.planner import PlannerDriver
from stucksolver_carla.drivers.planner.door_clearance import DOOR_M
from stucksolver_carla.drivers.planner.emergency_yield import EMERGENCY_LAMPS

SIZE = (2.35, 1.0)
"""Half length and half width of the ego and of the cars it passes (m)."""
HALF_WIDTH_M = SIZE[1]
PARKED_Y = 2 * 3.5 + HALF_WIDTH_M + 0.05
"""Beside the right lane, up to its edge."""


def scene(lane=RIGHT, speed=0.0, x=10.0):
    world = LitWorld()
    ego = world.add_ego(x, lane, 0.0, speed)
    driver = PlannerDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True), world.map)
    driver.set_destination(carla.Location(380.0, lane, 0.0))
    return world, ego, driver


@pytest.mark.integration
def test_parked_car_is_passed_beyond_door_within_lane() -> None:
    """A parked car is passed out of reach of its door and within the lane."""
    world, ego, driver = scene()
    world.add("vehicle.a", 120.0, PARKED_Y)
    seen = np.array(drive(world, ego, driver, 25.0))
    beside = np.abs(seen[:, 0] - 120.0) < 4.7
    assert beside.any()
    free = PARKED_Y - HALF_WIDTH_M - (seen[beside, 1] + HALF_WIDTH_M)
    assert free.min() > DOOR_M + 0.1
    assert seen[:, 1].min() - HALF_WIDTH_M > 3.5
    assert abs(seen[-1, 1] - RIGHT) < 0.1


@pytest.mark.integration
def test_beside_what_has_no_doors_it_keeps_to_the_middle() -> None:
    world, ego, driver = scene()
    world.add("static.prop.container", 120.0, PARKED_Y, bounding_box=box(0.6, 0.6, 0.8))
    seen = np.array(drive(world, ego, driver, 20.0))
    assert np.abs(seen[:, 1] - RIGHT).max() < 0.1


@pytest.mark.integration
def test_waiting_car_in_adjacent_lane_is_not_parked() -> None:
    """A car that waits in the adjacent lane is not a parked car."""
    world, ego, driver = scene()
    world.add("vehicle.a", 120.0, LEFT + 0.6)
    seen = np.array(drive(world, ego, driver, 20.0))
    assert np.abs(seen[:, 1] - RIGHT).max() < 0.1


@pytest.mark.parametrize(("lit", "aside"), [(True, True), (False, False)])
def test_emergency_lights_behind_make_ego_move_aside(lit, aside) -> None:
    """The ego moves aside for emergency lights behind it and for no other vehicle."""
    world, ego, driver = scene(LEFT, 8.0, 60.0)
    other = world.add("vehicle.ford.ambulance", 30.0, LEFT, speed=8.5)
    world.lamps = {other.id: EMERGENCY_LAMPS if lit else 0}
    seen = np.array(drive(world, ego, driver, 8.0))
    assert (seen[-1, 1] > RIGHT - 0.4) == aside


@pytest.mark.integration
def test_it_comes_back_once_the_emergency_vehicle_is_past() -> None:
    world, ego, driver = scene(LEFT, 8.0, 60.0)
    other = world.add("vehicle.ford.ambulance", 30.0, LEFT, speed=8.5)
    world.lamps = {other.id: EMERGENCY_LAMPS}
    drive(world, ego, driver, 5.0)
    other.speed = 20.0
    seen = np.array(drive(world, ego, driver, 16.0))
    assert seen[:, 1].max() > RIGHT - 0.3
    assert abs(seen[-1, 1] - LEFT) < 0.3


@pytest.mark.integration
def test_pull_out_between_parked_cars_matches_behavior_driver() -> None:
    """The planner's path out from between parked cars is that of the behavior driver."""
    ways = []
    for kind in (BehaviorDriver, PlannerDriver):
        world = LitWorld()
        ego = world.add_ego(60.0, PARKED_Y + 0.3)
        cars = [world.add("vehicle.a", 60.0 + away, PARKED_Y + 0.3) for away in (-10.0, 10.0)]
        driver = kind(ego, "normal", DriverOptions(ignore_traffic_lights=True), world.map)
        driver.set_destination(carla.Location(380.0, RIGHT, 0.0), carla.Location(60.0, RIGHT, 0.0))
        out = []
        for _ in range(300):
            drive(world, ego, driver, 0.05)
            out.append((ego.x, ego.y))
            assert all(separation((ego.x, ego.y, ego.yaw), SIZE, (car.x, car.y, 0.0), SIZE) > 0.0 for car in cars)
        assert abs(ego.y - RIGHT) < 0.3
        ways.append([place for place in out if place[1] > RIGHT + 0.45])
    assert ways[0] == ways[1]
