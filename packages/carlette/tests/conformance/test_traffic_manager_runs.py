"""The client's own TrafficManager against the server."""

from __future__ import annotations

import pytest
from stage import run, spawn

from serving import free_port

carla = pytest.importorskip("carla")


@pytest.fixture
def manager(client):
    found = client.get_trafficmanager(free_port())
    found.set_synchronous_mode(True)
    found.set_random_device_seed(2000)
    yield found
    found.set_synchronous_mode(False)
    found.shut_down()


def test_cars_on_autopilot_drive(world, manager, spots) -> None:
    cars = [spawn(world, spot) for spot in spots[:6]]
    starts = [car.get_location() for car in cars]
    for car in cars:
        car.set_autopilot(True, manager.get_port())
        manager.ignore_lights_percentage(car, 100)
    run(world, 100)
    moved = [car.get_location().distance(start) for car, start in zip(cars, starts, strict=True)]
    assert sorted(moved)[2] > 5.0


def test_a_batch_can_put_new_cars_on_autopilot(client, world, manager, spots) -> None:
    command, car = carla.command, world.get_blueprint_library().find("vehicle.tesla.model3")
    batch = [
        command.SpawnActor(car, spot).then(command.SetAutopilot(command.FutureActor, True, manager.get_port()))
        for spot in spots[:4]
    ]
    answers = client.apply_batch_sync(batch, True)
    assert not any(answer.error for answer in answers)
    cars = world.get_actors([answer.actor_id for answer in answers])
    run(world, 100)
    assert max(item.get_velocity().length() for item in cars) > 2.0


def test_cars_stop_before_a_red_light(world, manager) -> None:
    light = world.get_actors().filter("*traffic_light*")[0]
    light.set_state(carla.TrafficLightState.Red)
    light.set_red_time(10_000.0)
    stop = light.get_stop_waypoints()[0]
    start = stop.previous(25.0)[0].transform
    start.location.z += 0.5
    car = spawn(world, start)
    car.set_autopilot(True, manager.get_port())
    run(world, 300)
    assert car.get_velocity().length() < 0.2
    assert car.get_location().distance(stop.transform.location) < 12.0
    assert not world.get_map().get_waypoint(car.get_location()).is_junction


def test_every_wish_of_an_evaluator_is_accepted(world, manager, spots) -> None:
    car, other = spawn(world, spots[0]), spawn(world, spots[1])
    for item in (car, other):
        item.set_autopilot(True, manager.get_port())
    manager.set_hybrid_physics_mode(True)
    manager.set_hybrid_physics_radius(50.0)
    manager.global_percentage_speed_difference(10.0)
    manager.set_global_distance_to_leading_vehicle(3.0)
    manager.auto_lane_change(car, False)
    manager.update_vehicle_lights(car, True)
    manager.distance_to_leading_vehicle(car, 5.0)
    manager.vehicle_lane_offset(car, 0.2)
    manager.vehicle_percentage_speed_difference(car, -20.0)
    manager.set_desired_speed(other, 20.0)
    manager.set_path(
        car, [item.transform.location for item in world.get_map().get_waypoint(spots[0].location).next(30)]
    )
    manager.ignore_lights_percentage(car, 50.0)
    manager.ignore_signs_percentage(car, 50.0)
    manager.ignore_vehicles_percentage(car, 50.0)
    manager.ignore_walkers_percentage(car, 50.0)
    manager.collision_detection(car, other, False)
    run(world, 40)
    manager.set_hybrid_physics_mode(False)
    run(world, 20)
    assert car.is_alive and other.is_alive


def test_a_car_that_shall_not_move_brakes(world, manager, spots) -> None:
    car = spawn(world, spots[0])
    car.set_autopilot(True, manager.get_port())
    run(world, 60)
    manager.vehicle_percentage_speed_difference(car, 100.0)
    run(world, 100)
    assert car.get_velocity().length() < 0.3


def test_the_world_can_be_loaded_again_while_cars_are_driven(client, world, manager, spots) -> None:
    town = world.get_map().name.rsplit("/", 1)[-1]
    for _ in range(2):
        here = client.get_world()
        cars = [spawn(here, spot) for spot in spots[:3]]
        for car in cars:
            car.set_autopilot(True, manager.get_port())
        run(here, 40)
        assert client.load_world(town, False).get_settings().synchronous_mode
    run(client.get_world(), 5)
