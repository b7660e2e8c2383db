"""By sensors, the base driver changes lanes in a gap, and not into anybody."""

from __future__ import annotations

import carla
import pytest

from behavior_driver.fakes import FakeWorld
from behavior_driver.roads import LANE_Y, straight_road
from stucksolver_carla.drivers.behavior import BehaviorDriver, DriverOptions
from stucksolver_carla.drivers.behavior.nearby_objects import GroundTruthObjects
from stucksolver_carla.drivers.behavior.route_lane_changes import LaneChange, LaneChangePlanner

LEFT, RIGHT = LANE_Y[-1], LANE_Y[-2]
ROADSIDE = 8.0


class Sensed:
    """The client's bodies, told with the doubt of sensors."""

    def __init__(self, world, ego):
        self.world, self.ego = world, ego

    def within(self, range_m):
        found = GroundTruthObjects(self.world, self.ego.id, range_m)
        found.doubt_m = 0.3
        return found


def scene(speed=7.5, limit_kmh=30.0, sensed=True):
    """On its way from the left lane to the right one."""
    world = FakeWorld(straight_road())
    ego = world.add_ego(10.0, LEFT, 0.0, speed)
    ego.speed_limit = limit_kmh
    if sensed:
        ego.perceiver = Sensed(world, ego)
    driver = BehaviorDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True), world.map)
    driver.set_destination(carla.Location(390.0, RIGHT, 0.0))
    return world, ego, driver


def touched(world, ego, driver, seconds):
    """Drive; True if the ego's body came within 2 m across and 4.7 m along of another's middle."""
    hit = False
    for _ in range(round(seconds / 0.05)):
        ego.apply_control(driver.run_step())
        world.tick()
        hit |= any(
            abs(actor.x - ego.x) < 4.7 and abs(actor.y - ego.y) < 2.0 for actor in world.actors if actor is not ego
        )
    return hit


@pytest.mark.integration
@pytest.mark.parametrize("abreast_m", [-7.0, -5.0, -2.0, 0.0, 4.0])
def test_lane_change_slow_passing_car_goes_first(abreast_m):
    """A car that creeps past in the adjacent lane goes first.

    As in slow traffic on a motorway: it drives 0.4 m/s faster.
    """
    world, ego, driver = scene()
    world.add("vehicle.a", 10.0 + abreast_m, RIGHT, speed=7.9)
    assert not touched(world, ego, driver, 25.0)
    assert ego.y == pytest.approx(RIGHT, abs=0.4)


def test_lane_change_with_ground_truth_follows_route():
    """With ground truth, the lane is changed where the route requires it.

    There, the driver is CARLA's, which does not check the adjacent lane.
    """
    world, ego, driver = scene(sensed=False)
    world.add("vehicle.a", 10.0, RIGHT, speed=7.9)
    assert touched(world, ego, driver, 25.0)


@pytest.mark.integration
@pytest.mark.parametrize("first_m", [0.0, 10.0, 20.0, 30.0])
def test_lane_change_joins_faster_flow_in_gap(first_m):
    """A faster traffic flow is joined in a gap, at its speed.

    Its cars do not brake for the ego.
    """
    world, ego, driver = scene()
    for k in range(12):
        world.add("vehicle.a", 30.0 + first_m - 40.0 * k, RIGHT, speed=12.0)
    assert not touched(world, ego, driver, 16.0)
    assert ego.y == pytest.approx(RIGHT, abs=0.4)


def test_lane_change_planner_second_change_uses_its_own_lane():
    """Of two changes, the second checks its own lane even if the first was early."""
    changes = [LaneChange(45.0, 40.0, -3.5, 1.0, 250.0), LaneChange(123.0, 40.0, -3.5, 3.0, 252.0)]
    first, second = LaneChangePlanner(changes, doubt_m=0.3)._due
    assert first.last_m == 123.0, "the line is in the third lane from there on"
    assert second.first_m == 85.0, "the line is in the second lane from here on"
    assert LaneChangePlanner(changes)._due == changes


@pytest.mark.integration
def test_without_a_gap_it_waits_before_its_lane_ends():
    world, ego, driver = scene()
    for k in range(40):
        world.add("vehicle.a", 60.0 - 9.0 * k, RIGHT, speed=10.0)
    assert not touched(world, ego, driver, 20.0)


@pytest.mark.parametrize(
    ("y", "speed", "sensed", "heeded"),
    [
        (ROADSIDE, 1.8, True, True),
        (ROADSIDE, 0.0, True, False),
        (LEFT, 1.8, True, False),
        (ROADSIDE, 1.8, False, False),
    ],
    ids=["sets off", "is parked", "drives in the lane beside", "with ground truth"],
)
def test_driver_vehicle_setting_off_at_roadside_is_hazard(y, speed, sensed, heeded):
    """In sensor mode, a vehicle that sets off at the roadside is expected to pull out."""
    world = FakeWorld(straight_road())
    ego = world.add_ego(80.0, RIGHT, 0.0, 7.5)
    ego.speed_limit = 30.0
    if sensed:
        ego.perceiver = Sensed(world, ego)
    driver = BehaviorDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True), world.map)
    driver.set_destination(carla.Location(390.0, RIGHT, 0.0))
    world.add("vehicle.a", 86.0, y, speed=speed)
    driver.run_step()
    assert (driver.hazard is not None) == heeded
