"""What the driver promises, driven for real: on the simulator, through the carla client."""

from __future__ import annotations

import carla
import numpy as np
import pytest

from behavior_driver.conftest import town_file
from behavior_driver.stage import Stage, drive, simulator
from carlette.maps import DEMO_TOWN
from stucksolver_carla.drivers.behavior import BehaviorDriver, DrivePoint, DriverOptions

pytestmark = pytest.mark.integration

AVENUE, STREET = (3, -1), (11, 1)
BEHIND_M = (4.5, 6.0)


@pytest.fixture(scope="module")
def demo_town():
    with simulator(DEMO_TOWN) as world:
        yield world


@pytest.fixture
def avenue(demo_town):
    """Two lanes each way, straight for 480 m."""
    stage = Stage(demo_town, *AVENUE)
    yield stage
    stage.clear()


@pytest.fixture
def street(demo_town):
    """One lane each way, straight, with a traffic light at its end."""
    stage = Stage(demo_town, *STREET)
    yield stage
    stage.clear()


@pytest.mark.parametrize("blueprint", ["vehicle.audi.a2", "static.prop.trafficcone01", "static.prop.container"])
def test_it_stops_behind_whatever_stands_in_its_lane_and_stays(avenue, blueprint):
    car, driver = avenue.ego(5, 200)
    avenue.add(blueprint, 70)
    ticks = avenue.drive(car, driver, 18.0)
    assert BEHIND_M[0] <= ticks.gap[-1] <= BEHIND_M[1]
    assert np.all(ticks.speed[-40:] < 0.1)
    assert np.diff(ticks.speed).min() / 0.05 > -4.05


def test_parked_or_oncoming_car_beside_lane_does_not_stop_driver(street):
    """A car that is parked beside the lane and an oncoming car do not stop the driver."""
    car, driver = street.ego(5, 180, options=DriverOptions(ignore_traffic_lights=True))
    street.add("vehicle.audi.a2", 60, right=2.6)
    street.add("vehicle.audi.a2", 150, right=-3.5, turn=180.0, speed=8.0)
    ticks = street.drive(car, driver, 40.0, driver.done)
    assert driver.done()
    assert np.all(np.isinf(ticks.gap))


def test_it_follows_cyclists_at_their_speed_and_never_passes(avenue):
    car, driver = avenue.ego(5, 300)
    for s in (35, 39):
        avenue.add("vehicle.bh.crossbike", s, speed=4.2)
    ticks = avenue.drive(car, driver, 22.0)
    steady = slice(-160, None)
    assert np.all(np.abs(ticks.speed[steady] - 4.2) < 0.3)
    assert ticks.gap[steady].min() > 5.0 and ticks.gap[steady].max() < 8.0


def test_it_lets_a_walker_cross(avenue):
    car, driver = avenue.ego(5, 120)
    walker = avenue.add("walker.pedestrian.0001", 45, right=6.0, turn=-90.0)
    ahead = avenue.place(45, turn=-90.0).get_forward_vector()
    avenue.drive(car, driver, 3.0)
    walker.apply_control(carla.WalkerControl(ahead, 1.3))
    ticks = avenue.drive(car, driver, 30.0, driver.done)
    assert ticks.gap.min() > 2.0
    assert ticks.speed[:200].min() < 4.0
    assert driver.done()


def test_it_stops_at_a_red_light_and_goes_at_green(demo_town, street):
    car, driver = street.ego(100, len(street.lane) - 2)
    behind = street.lane[-1].next(25.0)[0]
    driver.set_destination(behind.transform.location)
    lights = list(demo_town.get_actors().filter("*traffic_light*"))
    for light in lights:
        light.set_state(carla.TrafficLightState.Red)
        light.freeze(True)
    demo_town.tick()
    ticks = street.drive(car, driver, 25.0)
    to_junction = street.lane[-1].transform.location.distance(car.get_location()) - car.bounding_box.extent.x
    assert ticks.speed[-1] < 0.1
    assert 0.5 < to_junction < 6.0
    for light in lights:
        light.set_state(carla.TrafficLightState.Green)
    street.drive(car, driver, 25.0, driver.done)
    assert driver.done()


@pytest.mark.parametrize(("speed", "over"), [(3.5, 9.5), (2.0, 9.0)])
def test_driver_swings_out_from_standstill_and_returns(avenue, speed, over):
    """The driver swings out around an obstacle from a standstill and returns."""
    car, driver = avenue.ego(30, 120)
    avenue.add("static.prop.container", 38)
    assert avenue.drive(car, driver, 2.0).speed.max() < 0.1
    driver.follow(avenue.shifted(car, -2.9, over, 24.0, speed))
    ticks = avenue.drive(car, driver, 20.0, lambda: driver.path_left_m < 1.0)
    assert driver.path_left_m < 1.0
    assert np.abs(ticks.lateral).max() < 0.35
    assert ticks.speed.max() < speed + 0.2
    driver.release()
    ticks = avenue.drive(car, driver, 30.0, driver.done)
    assert driver.done()
    assert abs(ticks.lateral[-1]) < 0.2


def test_a_lane_change_at_eight_metres_a_second_is_tracked(avenue):
    car, driver = avenue.ego(5, 200)
    avenue.drive(car, driver, 4.5)
    driver.follow(avenue.shifted(car, 3.5, 25.0, 60.0, 8.0))
    ticks = avenue.drive(car, driver, 20.0, lambda: driver.path_left_m < 1.0)
    assert np.abs(ticks.lateral).max() < 0.4
    avenue.drive(car, driver, 6.0)
    assert car.get_velocity().length() < 0.1


def test_given_path_object_in_it_stops_and_beside_does_not(avenue):
    """The driver brakes for an object in a given path but not for one beside it."""
    car, driver = avenue.ego(5, 200)
    clear = car.bounding_box.extent.y + 0.35
    width = avenue.add("vehicle.audi.a2", 60).bounding_box.extent.y
    avenue.add("vehicle.audi.a2", 30, right=clear + width)
    driver.follow(avenue.shifted(car, 0.0, 1.0, 100.0, 8.0))
    ticks = avenue.drive(car, driver, 15.0)
    assert ticks.speed[-1] < 0.1
    assert 1.0 < ticks.gap[-1] < 2.0
    assert ticks.speed.max() > 7.5


def test_it_holds_until_released(avenue):
    car, driver = avenue.ego(5, 100)
    avenue.drive(car, driver, 4.0)
    driver.hold()
    assert avenue.drive(car, driver, 5.0).speed[-1] < 0.05
    driver.release()
    avenue.drive(car, driver, 30.0, driver.done)
    assert driver.done()


def test_given_path_in_reverse_is_driven_until_obstacle(avenue):
    """The driver backs up along a path and stops for an object there."""
    car, driver = avenue.ego(40, 100)
    avenue.add("vehicle.audi.a2", 26)
    places = [avenue.place(40 - k).location for k in range(16)]
    driver.follow([DrivePoint(place.x, place.y, 1.5) for place in places[:6]], reverse=True)
    assert np.abs(avenue.drive(car, driver, 9.0).lateral).max() < 0.1
    assert driver.path_left_m < 0.3
    driver.follow([DrivePoint(place.x, place.y, 1.5) for place in places[5:]], reverse=True)
    ticks = avenue.drive(car, driver, 12.0)
    assert ticks.speed[-1] < 0.1
    assert 1.0 < ticks.gap[-1] < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Town01", pytest.param("Town10HD", marks=pytest.mark.release)])
def test_it_drives_a_route_with_turns_within_the_lane(name):
    with simulator(town_file(name)) as world:
        car, driver = _longest_of_some_routes(world)
        ticks = drive(world, car, driver, 120.0, driver.done)
        turns = {point.command for point in driver.route} & {"left", "right"}
    assert driver.done() and turns
    assert np.percentile(np.abs(ticks.lateral), 95) < 0.4


def _longest_of_some_routes(world):
    spots = world.get_map().get_spawn_points()
    blueprint = world.get_blueprint_library().find("vehicle.tesla.model3")
    car = world.spawn_actor(blueprint, spots[0])
    world.tick()
    driver = BehaviorDriver(car, options=DriverOptions(ignore_traffic_lights=True))
    for spot in spots[5::7]:
        driver.set_destination(spot.location)
        commands = {point.command for point in driver.route}
        if 300 <= len(driver.route) <= 600 and {"left", "right"} & commands:
            break
    return car, driver


def test_given_path_object_to_drive_over_does_not_stop(avenue):
    """The driver stops for an object in its path but not for one that it may drive over."""
    car, driver = avenue.ego(5, 100)
    flat = avenue.add("static.prop.creasedbox01", 18)
    driver.follow(avenue.shifted(car, 0.0, 1.0, 30.0, 2.0))
    avenue.drive(car, driver, 12.0)
    assert driver.hazard is not None and driver.hazard.actor_id == flat.id
    driver.follow(avenue.shifted(car, 0.0, 1.0, 30.0, 2.0), ignore=frozenset({flat.id}))
    ticks = avenue.drive(car, driver, 8.0)
    assert ticks.speed[-1] > 1.0


def test_given_path_without_hazard_check_ignores_obstacle(avenue):
    """Without hazard checks on a path, the driver hits an obstacle; on its route it checks again."""
    car, driver = avenue.ego(5, 100, options=DriverOptions(heeds_on_path=False))
    parked = avenue.add("vehicle.audi.a2", 30)
    driver.follow(avenue.shifted(car, 0.0, 1.0, 40.0, 4.0))
    avenue.drive(car, driver, 8.0)
    assert driver.hazard is None
    apart = car.get_location().distance(parked.get_location())
    assert apart < 0.1 + car.bounding_box.extent.x + parked.bounding_box.extent.x
    driver.release()
    avenue.drive(car, driver, 0.1)
    assert driver.hazard is not None
