"""Traffic lights and signs: where they are, what they govern, and who decides their color."""

from __future__ import annotations

from collections import Counter

import pytest
from stage import DT, run, spawn

carla = pytest.importorskip("carla")

RED, YELLOW, GREEN, OFF = (getattr(carla.TrafficLightState, name) for name in ("Red", "Yellow", "Green", "Off"))
LIGHT_LANDMARK = "1000001"
FOR_EVER_S = 10_000.0
BEFORE_A_LIGHT_M = 100.0


@pytest.fixture
def lights(world):
    found = list(world.get_actors().filter("*traffic_light*"))
    assert found
    return found


@pytest.fixture
def light(lights):
    return lights[0]


def stop_places(world, light):
    """As evaluators find them: along the box's x axis, a meter apart, and each on a lane."""
    box, pose = light.trigger_volume, light.get_transform()
    place = -0.9 * box.extent.x
    found = []
    while place < 0.9 * box.extent.x:
        point = pose.transform(box.location + carla.Location(x=place))
        found.append(world.get_map().get_waypoint(point))
        place += 1.0
    return found


def lanes_ahead(waypoint, meters: int = 25):
    """Road and lane of all that a waypoint leads to."""
    found, here = set(), [waypoint]
    for _ in range(meters):
        found |= {(item.road_id, item.lane_id) for item in here}
        here = [after for item in here for after in item.next(1.0)]
    return found


# -- where they are


def test_there_is_one_light_for_each_signal_of_the_map(world, lights) -> None:
    landmarks = world.get_map().get_all_landmarks_of_type(LIGHT_LANDMARK)
    assert Counter(item.get_opendrive_id() for item in lights) == Counter({landmark.id for landmark in landmarks})


def test_each_light_is_found_by_its_signal_and_its_landmark(world, lights) -> None:
    for light in lights:
        sign_id = light.get_opendrive_id()
        assert world.get_traffic_light_from_opendrive_id(sign_id).id == light.id
        (landmark, *_) = (
            item for item in world.get_map().get_all_landmarks_of_type(LIGHT_LANDMARK) if item.id == sign_id
        )
        assert world.get_traffic_light(landmark).id == light.id


def test_a_waypoint_before_a_light_finds_it_and_its_landmark(world, lights) -> None:
    for light in lights:
        for stop in light.get_stop_waypoints():
            before = stop.previous(10.0)[0]
            assert light.id in {item.id for item in world.get_traffic_lights_from_waypoint(before, BEFORE_A_LIGHT_M)}
            marks = before.get_landmarks_of_type(BEFORE_A_LIGHT_M, LIGHT_LANDMARK)
            assert light.get_opendrive_id() in {mark.id for mark in marks}


def test_the_lights_of_a_junction_are_those_before_it(world, lights) -> None:
    junctions = {
        after.junction_id
        for light in lights
        for stop in light.get_stop_waypoints()
        for after in stop.next(15.0)
        if after.is_junction
    }
    found = {item.id for junction in junctions for item in world.get_traffic_lights_in_junction(junction)}
    assert found
    assert found <= {item.id for item in lights}


# -- what they govern


def test_traffic_light_stop_waypoints_lie_before_junction(world, lights) -> None:
    """Each trigger box has stop waypoints, which lie on driving lanes at most 15 m before a junction."""
    for light in lights:
        assert light.trigger_volume.extent.x > 1.0
        stops = light.get_stop_waypoints()
        assert stops
        for stop in [*stops, *stop_places(world, light)]:
            assert stop.lane_type == carla.LaneType.Driving
            assert any(after.is_junction for meters in (5.0, 10.0, 15.0) for after in stop.next(meters))


def test_every_stop_leads_to_a_lane_that_the_light_governs(world, lights) -> None:
    for light in lights:
        governed = {(waypoint.road_id, waypoint.lane_id) for waypoint in light.get_affected_lane_waypoints()}
        for stop in [*light.get_stop_waypoints(), *stop_places(world, light)]:
            assert lanes_ahead(stop) & governed


@pytest.mark.carlette_only
def test_every_governed_lane_has_a_stop_that_leads_to_it(world, lights) -> None:
    for light in lights:
        reached = set().union(*(lanes_ahead(stop) for stop in light.get_stop_waypoints()))
        driving = [
            waypoint for waypoint in light.get_affected_lane_waypoints() if waypoint.lane_type == carla.LaneType.Driving
        ]
        assert {(item.road_id, item.lane_id) for item in driving} <= reached


def test_vehicle_in_trigger_box_reports_light_and_color(world, light) -> None:
    """A car in the trigger box of a light reports that light and its color."""
    stop = light.get_stop_waypoints()[0].transform
    stop.location.z += 0.3
    light.set_state(RED)
    light.set_red_time(FOR_EVER_S)
    car = spawn(world, stop)
    run(world, 3)
    assert car.is_at_traffic_light()
    assert car.get_traffic_light().id == light.id
    assert car.get_traffic_light_state() == RED


def test_a_car_on_open_road_stands_at_no_light(world, lights, spots) -> None:
    stops = [waypoint.transform.location for light in lights for waypoint in light.get_stop_waypoints()]
    free = next(spot for spot in spots if min(stop.distance(spot.location) for stop in stops) > 30.0)
    car = spawn(world, free)
    world.tick()
    assert not car.is_at_traffic_light()
    assert car.get_traffic_light() is None


# -- who decides their color


def test_traffic_light_group_cycles_through_all_colors(world, light) -> None:
    """The lights of a group change without a client, and each shows red, yellow and green within one cycle."""
    group = light.get_group_traffic_lights()
    assert light.id in {item.id for item in group}
    assert len({item.id for item in group}) == len(group)
    for item in group:
        item.set_green_time(0.5)
        item.set_yellow_time(0.3)
        item.set_red_time(0.2)
    light.reset_group()
    for item in group:
        item.set_green_time(0.5)
        item.set_yellow_time(0.3)
        item.set_red_time(0.2)
    seen = set()
    for _ in range(round(len(group) * 1.5 / DT)):
        world.tick()
        seen |= {(item.id, item.get_state()) for item in group}
    assert {(item.id, color) for item in group for color in (RED, YELLOW, GREEN)} <= seen


def test_times_can_be_read_back(world, light) -> None:
    light.set_green_time(4.0)
    light.set_yellow_time(5.0)
    light.set_red_time(6.0)
    world.tick()
    assert (light.get_green_time(), light.get_yellow_time(), light.get_red_time()) == (4.0, 5.0, 6.0)


@pytest.mark.parametrize("color", [RED, YELLOW, GREEN])
def test_traffic_light_set_with_long_time_holds_color(world, light, color) -> None:
    """A light that is set with a long time holds its color, and its elapsed time advances."""
    world.tick()
    light.set_state(color)
    for set_time in (light.set_green_time, light.set_yellow_time, light.set_red_time):
        set_time(FOR_EVER_S + light.get_elapsed_time())
    world.tick()
    start = light.get_elapsed_time()
    run(world, 400)
    assert light.get_state() == light.state == color
    assert light.get_elapsed_time() - start == pytest.approx(400 * DT, abs=0.1)


@pytest.mark.carlette_only
def test_traffic_light_restored_times_resume_group_cycle(world, light) -> None:
    """A held light returns to the cycle of its group when its times are restored."""
    before = light.get_state(), light.get_green_time(), light.get_yellow_time(), light.get_red_time()
    light.set_state(RED)
    light.set_red_time(FOR_EVER_S)
    run(world, 20)
    state, green_s, yellow_s, red_s = before
    light.set_state(state)
    light.set_green_time(green_s)
    light.set_yellow_time(yellow_s)
    light.set_red_time(red_s)
    seen = set()
    for _ in range(round(4 * 16.0 / DT)):
        world.tick()
        seen.add(light.get_state())
    assert seen == {RED, YELLOW, GREEN}


def test_a_light_can_be_switched_off(world, light) -> None:
    light.set_state(OFF)
    run(world, 20)
    assert light.get_state() == OFF


def test_frozen_lights_stand_still_until_they_are_thawed(world, lights) -> None:
    world.freeze_all_traffic_lights(True)
    world.tick()
    before = [item.get_state() for item in lights]
    run(world, 400)
    assert [item.get_state() for item in lights] == before
    assert all(item.is_frozen() for item in lights)
    world.freeze_all_traffic_lights(False)
    run(world, 400)
    assert not any(item.is_frozen() for item in lights)
    assert [item.get_state() for item in lights] != before


def test_a_frozen_light_can_still_be_set(world, light) -> None:
    light.freeze(True)
    for color in (GREEN, RED):
        light.set_state(color)
        run(world, 2)
        assert light.get_state() == color


def test_a_reset_undoes_what_was_set(world, lights) -> None:
    for item in lights:
        item.set_state(RED)
        item.set_red_time(FOR_EVER_S)
    run(world, 5)
    world.reset_all_traffic_lights()
    run(world, 400)
    assert any(item.get_state() == GREEN for item in lights)


# -- signs


def test_signs_have_a_trigger_box_on_a_driving_lane(world) -> None:
    for sign in world.get_actors().filter("traffic.stop"):
        box = sign.trigger_volume
        assert box.extent.x > 0.0
        place = sign.get_transform().transform(box.location)
        assert world.get_map().get_waypoint(place, False, carla.LaneType.Driving) is not None
