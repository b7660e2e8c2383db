"""The whole driver in a world without a server: a bicycle, boxes and a straight road."""

from __future__ import annotations

import carla
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behavior_driver.fakes import TICK_S, FakeWorld, box
from behavior_driver.roads import LANE_Y, straight_road
from stucksolver_carla.drivers.behavior import BehaviorDriver, DrivePoint, DriverOptions
from stucksolver_carla.drivers.behavior.nearby_objects import GroundTruthObjects

HOME = LANE_Y[-1]


def scene(behavior="normal", speed=0.0, x=10.0, y=HOME, to=(250.0, HOME)):
    world = FakeWorld(straight_road())
    ego = world.add_ego(x, y, 0.0, speed)
    driver = BehaviorDriver(ego, behavior, DriverOptions(ignore_traffic_lights=True))
    driver.set_destination(carla.Location(*to, 0.0))
    return world, ego, driver


def drive(world, ego, driver, seconds):
    speeds = []
    for _ in range(round(seconds / TICK_S)):
        ego.apply_control(driver.run_step())
        world.tick()
        speeds.append(ego.speed)
    return np.array(speeds)


@pytest.mark.parametrize(("behavior", "kmh"), [("cautious", 40.0), ("normal", 47.0), ("aggressive", 49.0)])
def test_each_profile_reaches_its_speed_and_stops_at_the_end(behavior, kmh):
    world, ego, driver = scene(behavior)
    speeds = drive(world, ego, driver, 40.0)
    assert speeds.max() * 3.6 == pytest.approx(kmh, abs=1.0)
    assert driver.done() and speeds[-1] < 0.1
    assert abs(ego.x - 250.0) < 2.0


@pytest.mark.parametrize(("behavior", "gap"), [("cautious", 6.0), ("normal", 5.0), ("aggressive", 4.0)])
def test_each_profile_keeps_its_published_braking_distance(behavior, gap):
    world, ego, driver = scene(behavior)
    world.add("vehicle.a", 100.0, HOME)
    drive(world, ego, driver, 30.0)
    assert driver.hazard.gap == pytest.approx(gap, abs=0.4)


@pytest.mark.integration
@settings(max_examples=15)
@given(st.floats(3.0, 13.0), st.floats(0.0, 8.0), st.floats(1.0, 3.0))
def test_it_never_runs_into_something_it_could_stop_for(speed, lead_speed, reserve):
    world, ego, driver = scene(speed=speed)
    free = reserve + max(speed**2 - lead_speed**2, 0.0) / (2.0 * 6.5) + 0.15 * speed
    world.add("vehicle.a", 10.0 + 4.7 + free, HOME, speed=lead_speed)
    for _ in range(200):
        drive(world, ego, driver, TICK_S)
        assert driver.hazard is None or driver.hazard.gap > 0.2


def test_a_leader_that_brakes_hard_is_not_hit():
    world, ego, driver = scene(speed=13.0)
    leader = world.add("vehicle.a", 30.0, HOME, speed=12.0)
    drive(world, ego, driver, 4.0)
    while leader.speed > 0.0:
        leader.speed = max(leader.speed - 8.0 * TICK_S, 0.0)
        drive(world, ego, driver, TICK_S)
    drive(world, ego, driver, 8.0)
    assert ego.speed < 0.1
    assert driver.hazard.gap > 1.5


def test_a_lane_change_of_the_route_is_driven():
    world, ego, driver = scene(to=(250.0, LANE_Y[-2]))
    drive(world, ego, driver, 40.0)
    assert driver.done()
    assert ego.y == pytest.approx(LANE_Y[-2], abs=0.1)


@pytest.mark.integration
@settings(max_examples=10)
@given(st.floats(-3.5, 3.5), st.floats(0.0, 8.0))
def test_release_beside_lane_returns_and_counts_driven_distance(beside, speed):
    """After `release`, the driver returns from beside the lane and counts the distance that was driven."""
    world, ego, driver = scene()
    ego.x, ego.y, ego.speed = 80.0, HOME + beside, speed
    driver.follow([DrivePoint(80.0 + k, HOME + beside, 8.0) for k in range(30)])
    drive(world, ego, driver, 2.0)
    before = driver.path_left_m
    driver.release()
    assert driver.path_left_m == pytest.approx(250.0 - ego.x, abs=2.0) != before
    drive(world, ego, driver, 5.0)
    assert ego.y == pytest.approx(HOME, abs=0.35 + abs(beside) * 0.1)
    assert abs(ego.yaw) < 0.25


class Sensed:
    """The client's bodies, told with the doubt of sensors."""

    def __init__(self, world, ego):
        self.world, self.ego = world, ego

    def within(self, range_m):
        found = GroundTruthObjects(self.world, self.ego.id, range_m)
        found.doubt_m = 0.3
        return found


@pytest.mark.parametrize("ahead", [(), (30.0,)], ids=["free", "a car further on"])
def test_driver_sensor_mode_returns_past_stopped_vehicle_alongside(ahead):
    """In sensor mode, the driver returns to its lane past a vehicle that has stopped there.

    A plan may end in the adjacent lane, next to a passed vehicle that never drives on.
    """
    world, ego, _ = scene()
    ego.perceiver = Sensed(world, ego)
    driver = BehaviorDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True))
    ego.x, ego.y = 80.0, HOME + 3.4
    passed = world.add("vehicle.a", ego.x - 4.3, HOME)
    for away in ahead:
        world.add("vehicle.b", ego.x + away, HOME)
    driver.set_destination(carla.Location(250.0, HOME, 0.0), carla.Location(ego.x, HOME, 0.0))
    for _ in range(round(12.0 / TICK_S)):
        drive(world, ego, driver, TICK_S)
        assert abs(ego.y - HOME) > 2.0 or ego.x - passed.x > 4.7
    assert ego.y == pytest.approx(HOME, abs=0.6)
    assert ego.x > 95.0


def test_driver_sensor_mode_waits_for_traffic_in_own_lane():
    """In sensor mode, the driver waits beside its lane for vehicles that move there."""
    world, ego, _ = scene()
    ego.perceiver = Sensed(world, ego)
    driver = BehaviorDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True))
    ego.x, ego.y = 80.0, HOME + 3.4
    driver.set_destination(carla.Location(250.0, HOME, 0.0), carla.Location(ego.x, HOME, 0.0))
    for k in range(6):
        world.add("vehicle.a", ego.x - 4.0 - 12.0 * k, HOME, speed=6.0)
    drive(world, ego, driver, 6.0)
    assert ego.y == pytest.approx(HOME + 3.4, abs=0.5)


@pytest.mark.parametrize(("ahead_m", "beside_m", "waits"), [(2.3, 1.4, True), (2.3, 1.8, False), (0.0, 1.4, False)])
def test_driver_sensor_mode_waits_for_pedestrian_before_corner(ahead_m, beside_m, waits):
    """In sensor mode, the driver waits for a pedestrian that may be in front of its corner.

    0.2 m beside it, as perceived; not for a pedestrian that is farther away or beside its middle.
    """
    world, ego, _ = scene()
    ego.perceiver = Sensed(world, ego)
    driver = BehaviorDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True))
    driver.set_destination(carla.Location(250.0, HOME, 0.0))
    world.add("walker.pedestrian.1", ego.x + ahead_m, HOME + beside_m, bounding_box=box(0.2, 0.2, 0.9))
    drive(world, ego, driver, 4.0)
    assert (ego.x < 10.5) == waits


@pytest.mark.parametrize("sensed", [True, False])
def test_driver_sensor_mode_stops_at_once_before_pedestrian(sensed):
    """In sensor mode, the driver stops at once before a pedestrian that steps out close ahead.

    Where positions are exact, the last part of the speed takes longer.
    """
    world, ego, driver = scene(speed=1.0)
    if sensed:
        ego.perceiver = Sensed(world, ego)
        driver = BehaviorDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True))
        driver.set_destination(carla.Location(250.0, HOME, 0.0))
    began = ego.x
    world.add("walker.pedestrian.1", ego.x + 5.0, HOME, bounding_box=box(0.2, 0.2, 0.9))
    drive(world, ego, driver, 3.0)
    assert ego.speed < 0.06
    assert (ego.x - began < 0.18) == sensed


def test_an_ego_put_somewhere_else_goes_on_from_there():
    world, ego, driver = scene()
    drive(world, ego, driver, 2.0)
    ego.x = 200.0
    drive(world, ego, driver, 25.0)
    assert driver.done()


def test_without_a_route_it_brakes():
    world = FakeWorld(straight_road())
    ego = world.add_ego(10.0, HOME, 0.0, 5.0)
    assert drive(world, ego, BehaviorDriver(ego), 4.0)[-1] < 0.1


def test_thirty_bodies_beside_the_lane_do_not_slow_it_down():
    world, ego, driver = scene(speed=12.0)
    for k in range(15):
        world.add("vehicle.a", 20.0 + 5.0 * k, HOME + 3.2)
        world.add("static.prop.trafficcone01", 20.0 + 5.0 * k, HOME - 1.8, bounding_box=box(0.2, 0.2, 0.4))
    for _ in range(60):
        control = driver.run_step()
        assert control.brake == 0.0
        ego.apply_control(control)
        world.tick()
