"""What the real, unmodified client gets from the server: a list of promises."""

from __future__ import annotations

import math
import time

import pytest
from serving import running_server
from straight import straight_road

carla = pytest.importorskip("carla")

CAR = "vehicle.lincoln.mkz_2020"
DT = 0.05


@pytest.fixture(scope="module")
def server():
    with running_server("--map", "demo_town") as port:
        yield port


@pytest.fixture(scope="module")
def client(server):
    client = carla.Client("127.0.0.1", server)
    client.set_timeout(10.0)
    return client


def make_synchronous(world) -> None:
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, DT
    world.apply_settings(settings)


@pytest.fixture
def world(client):
    """A fresh episode in synchronous mode."""
    world = client.load_world("demo_town")
    make_synchronous(world)
    return world


@pytest.fixture
def spots(world):
    return world.get_map().get_spawn_points()


def blueprint(world, type_id: str = CAR, **attributes: str):
    found = world.get_blueprint_library().find(type_id)
    for name, value in attributes.items():
        found.set_attribute(name, value)
    return found


def spawn(world, transform, type_id: str = CAR, **attributes: str):
    actor = world.spawn_actor(blueprint(world, type_id, **attributes), transform)
    world.tick()
    return actor


def ahead(transform, metres: float):
    way = transform.get_forward_vector()
    place = carla.Location(way.x * metres, way.y * metres, way.z * metres)
    return carla.Transform(transform.location + place, transform.rotation)


def run(world, ticks: int) -> None:
    for _ in range(ticks):
        world.tick()


# -- world, map, time


def test_the_server_has_the_clients_version_and_map(client, world) -> None:
    assert client.get_server_version() == client.get_client_version()
    assert world.get_map().name == "Carla/Maps/demo_town"
    assert len(world.get_map().get_spawn_points()) > 10
    assert "/Game/Carla/Maps/demo_town" in client.get_available_maps()


def test_each_tick_is_one_frame_and_one_step(world) -> None:
    first = world.get_snapshot()
    frames = [world.tick() for _ in range(5)]
    last = world.get_snapshot()
    assert frames == list(range(first.frame + 1, first.frame + 6)) == [*frames[:-1], last.frame]
    assert last.timestamp.elapsed_seconds - first.timestamp.elapsed_seconds == pytest.approx(5 * DT)


def test_delta_seconds_is_the_float32_and_the_settings_the_double(world) -> None:
    world.tick()
    assert world.get_snapshot().timestamp.delta_seconds == 0.05000000074505806
    assert world.get_settings().fixed_delta_seconds == 0.05


def test_in_asynchronous_mode_the_world_ticks_by_itself_at_20_hz(world) -> None:
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = False, None
    world.apply_settings(settings)
    first, start = world.wait_for_tick().frame, time.monotonic()
    time.sleep(1.0)
    passed = world.wait_for_tick().frame - first
    assert passed / (time.monotonic() - start) == pytest.approx(20.0, abs=4.0)


def test_in_synchronous_mode_it_does_not(world) -> None:
    before = world.get_snapshot().frame
    time.sleep(0.3)
    assert world.get_snapshot().frame == before


def test_loading_a_world_gives_a_new_episode_without_the_old_actors(client, world, spots) -> None:
    old, frame = world.id, world.get_snapshot().frame
    spawn(world, spots[0])
    fresh = client.load_world("demo_town", reset_settings=False)
    assert fresh.id != old
    assert fresh.get_settings().synchronous_mode
    assert not fresh.get_actors().filter("vehicle.*")
    assert fresh.tick() > frame
    assert not client.reload_world().get_settings().synchronous_mode


def test_an_unknown_map_is_an_error_that_names_it(client, world) -> None:
    with pytest.raises(RuntimeError, match="Map 'Atlantis' not found"):
        client.load_world("Atlantis")
    world.tick()


def test_a_world_can_be_made_of_an_opendrive_text(client, world) -> None:
    made = client.generate_opendrive_world(straight_road())
    assert made.get_map().name.endswith("OpenDriveMap")
    assert made.get_map().get_topology()
    with pytest.raises(RuntimeError, match="XML"):
        client.generate_opendrive_world("<nonsense")


# -- actors


def test_a_spawned_actor_is_in_the_next_snapshot_with_all_it_was_given(world, spots) -> None:
    car = spawn(world, spots[0], role_name="hero", color="10,20,30")
    assert world.get_snapshot().find(car.id) is not None
    assert car.is_alive
    assert (car.attributes["role_name"], car.attributes["color"]) == ("hero", "10,20,30")
    assert car.get_location().distance(spots[0].location) < 0.2
    assert car.bounding_box.extent.x == pytest.approx(2.446, abs=0.01)
    assert car.get_speed_limit() > 0.0
    assert world.get_actor(car.id).type_id == CAR


def test_a_taken_place_gives_none_and_a_staged_one_below_it_an_actor(world, spots) -> None:
    spawn(world, spots[0])
    assert world.try_spawn_actor(blueprint(world), spots[0]) is None
    below = carla.Transform(spots[0].location - carla.Location(z=50.0), spots[0].rotation)
    staged = world.try_spawn_actor(blueprint(world), below)
    staged.set_simulate_physics(False)
    run(world, 20)
    assert staged.get_location().z == pytest.approx(below.location.z, abs=1e-3)


def test_a_destroyed_actor_is_gone(world, spots) -> None:
    car = spawn(world, spots[0])
    assert car.destroy()
    world.tick()
    assert world.get_snapshot().find(car.id) is None
    assert world.try_spawn_actor(blueprint(world), spots[0]) is not None


def test_throttle_moves_the_car_ahead_and_brake_stops_it(world, spots) -> None:
    car = spawn(world, spots[0])
    car.apply_control(carla.VehicleControl(throttle=0.5))
    run(world, 40)
    assert car.get_velocity().length() > 2.0
    assert car.get_control().throttle == pytest.approx(0.5)
    car.apply_control(carla.VehicleControl(brake=math.nan))
    run(world, 60)
    assert car.get_velocity().length() == 0.0
    assert car.get_control().brake == 1.0


def test_a_transform_that_is_not_finite_never_enters_the_world(world, spots) -> None:
    car = spawn(world, spots[0])
    place = car.get_location()
    car.set_transform(carla.Transform(carla.Location(math.nan, 0.0, 0.0)))
    car.set_location(carla.Location(math.inf, 0.0, 0.0))
    car.set_target_velocity(carla.Vector3D(math.nan, 0.0, 0.0))
    run(world, 5)
    assert car.get_location().distance(place) < 1.0


def test_teleports_and_target_velocities_take_effect_in_the_next_tick(world, spots) -> None:
    car = spawn(world, spots[0])
    car.set_transform(spots[5])
    world.tick()
    assert car.get_location().distance(spots[5].location) < 0.5
    way = spots[5].get_forward_vector()
    car.set_target_velocity(carla.Vector3D(6.0 * way.x, 6.0 * way.y, 0.0))
    world.tick()
    assert car.get_velocity().length() == pytest.approx(6.0, abs=0.2)


def test_hazard_lights_can_be_read_back(world, spots) -> None:
    car = spawn(world, spots[0])
    both = carla.VehicleLightState.LeftBlinker | carla.VehicleLightState.RightBlinker
    car.set_light_state(carla.VehicleLightState(both))
    assert int(car.get_light_state()) == int(both)


def test_physics_control_shows_wheels_in_centimetres_and_takes_the_mass(world, spots) -> None:
    car = spawn(world, spots[0])
    control = car.get_physics_control()
    wheel, place = control.wheels[0].position, car.get_location()
    assert math.hypot(wheel.x / 100 - place.x, wheel.y / 100 - place.y) < 3.0
    control.mass = 2222.0
    car.apply_physics_control(control)
    assert car.get_physics_control().mass == 2222.0


def test_a_walker_walks_where_it_is_told(world, spots) -> None:
    walker = spawn(world, carla.Transform(spots[0].location + carla.Location(z=1.0)), "walker.pedestrian.0005")
    run(world, 10)
    start = walker.get_location()
    walker.apply_control(carla.WalkerControl(carla.Vector3D(0.0, 1.0, 0.0), 1.5))
    run(world, 40)
    assert walker.get_location().y - start.y == pytest.approx(3.0, abs=0.2)
    assert walker.get_transform().rotation.yaw == pytest.approx(90.0, abs=1.0)


def test_ackermann_control_reaches_its_speed(world, spots) -> None:
    car = spawn(world, spots[0])
    for _ in range(60):
        car.apply_ackermann_control(carla.VehicleAckermannControl(speed=3.0))
        world.tick()
    assert car.get_velocity().length() == pytest.approx(3.0, abs=0.4)


# -- batches


def test_a_batch_spawns_and_applies_what_follows_to_the_new_actors(client, world, spots) -> None:
    command = carla.command
    lights = carla.VehicleLightState(carla.VehicleLightState.Position)
    batch = [
        command.SpawnActor(blueprint(world), spot)
        .then(command.SetVehicleLightState(command.FutureActor, lights))
        .then(command.SetSimulatePhysics(command.FutureActor, False))
        for spot in (spots[0], spots[0], spots[5])
    ]
    first, twice, other = client.apply_batch_sync(batch, True)
    assert not first.error and not other.error
    assert "collision" in twice.error
    assert int(world.get_actor(first.actor_id).get_light_state()) == int(lights)
    gone = client.apply_batch_sync([command.DestroyActor(one.actor_id) for one in (first, other)], True)
    assert not any(one.error for one in gone)
    assert client.apply_batch_sync([command.DestroyActor(first.actor_id)], False)[0].error


def test_an_asynchronous_batch_can_tick(client, world) -> None:
    before = world.get_snapshot().frame
    client.apply_batch([], True)
    deadline = time.monotonic() + 5.0
    while world.get_snapshot().frame == before and time.monotonic() < deadline:
        time.sleep(0.01)
    assert world.get_snapshot().frame == before + 1


# -- sensors


def test_the_collision_sensor_names_what_was_hit_in_the_frame_it_happened(world, spots) -> None:
    car = spawn(world, spots[0])
    wall = spawn(world, ahead(spots[0], 12.0), "static.prop.container")
    sensor = world.spawn_actor(blueprint(world, "sensor.other.collision"), carla.Transform(), attach_to=car)
    events = []
    sensor.listen(events.append)
    car.apply_control(carla.VehicleControl(throttle=1.0))
    for _ in range(100):
        frame = world.tick()
        if events:
            break
    deadline = time.monotonic() + 2.0
    while not events and time.monotonic() < deadline:
        time.sleep(0.01)
    assert events[0].other_actor.id == wall.id
    assert events[0].other_actor.type_id == "static.prop.container"
    assert events[0].actor.id == car.id
    assert events[0].normal_impulse.length() > 1000.0
    assert frame - 1 <= events[0].frame <= frame
    sensor.destroy()


def test_no_blueprint_is_offered_for_what_is_not_simulated(world) -> None:
    offered = {one.id for one in world.get_blueprint_library().filter("sensor.*")}
    assert offered == {"sensor.other.collision", "sensor.other.lane_invasion"}


# -- lights, weather, scenery


def test_traffic_lights_can_be_found_read_set_and_frozen(world) -> None:
    lights = list(world.get_actors().filter("*traffic_light*"))
    assert lights
    light = lights[0]
    assert light.trigger_volume.extent.x > 1.0
    assert light.get_stop_waypoints()
    assert light.id in {one.id for one in light.get_group_traffic_lights()}
    light.set_state(carla.TrafficLightState.Red)
    light.set_red_time(10_000.0)
    run(world, 100)
    assert light.state == carla.TrafficLightState.Red
    assert light.get_elapsed_time() == pytest.approx(100 * DT, abs=0.1)
    light.freeze(True)
    run(world, 2)
    assert light.is_frozen()
    world.reset_all_traffic_lights()


def test_weather_is_kept(world) -> None:
    weather = carla.WeatherParameters(cloudiness=80.0, precipitation=30.0)
    world.set_weather(weather)
    assert world.get_weather().cloudiness == 80.0
    assert world.get_weather().precipitation == 30.0


def test_a_point_above_the_road_projects_onto_it(world, spots) -> None:
    place = spots[0].location
    hit = world.ground_projection(carla.Location(place.x, place.y, place.z + 5.0), 20.0)
    assert hit.location.z == pytest.approx(place.z - 0.5, abs=0.1)


def test_what_is_only_for_show_is_accepted(client, world) -> None:
    world.debug.draw_point(carla.Location())
    world.get_spectator().set_transform(carla.Transform(carla.Location(1.0, 2.0, 3.0)))
    client.start_recorder("nothing.log")
    client.stop_recorder()
    world.tick()
    assert world.get_spectator().get_location().z == 3.0
    assert list(world.get_environment_objects()) == []
    assert list(world.get_lightmanager().get_all_lights()) == []


# -- robustness


def test_many_clients_come_and_go(server, world) -> None:
    for _ in range(20):
        other = carla.Client("127.0.0.1", server)
        other.set_timeout(5.0)
        assert other.get_world().id == world.id
    world.tick()


def test_an_actor_that_is_gone_is_an_error_that_names_it(client, world, spots) -> None:
    car = spawn(world, spots[0])
    client.apply_batch_sync([carla.command.DestroyActor(car.id)], True)
    with pytest.raises(RuntimeError, match=str(car.id)):
        car.set_simulate_physics(False)
    world.tick()
