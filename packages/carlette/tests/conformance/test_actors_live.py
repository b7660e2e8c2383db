"""Actors: brought in, found, moved, driven and taken away."""

from __future__ import annotations

import math

import pytest
from stage import CAR, WALKER, above, ahead, blueprint, run, settled, spawn

carla = pytest.importorskip("carla")


# -- bringing in and finding


def test_spawned_actor_is_in_next_snapshot_with_its_attributes(world, spots) -> None:
    """A spawned actor is in the next snapshot, with the attributes and the position that it was given."""
    car = spawn(world, spots[0], role_name="hero", color="10,20,30")
    assert world.get_snapshot().find(car.id) is not None
    assert car.is_alive and car.is_active
    assert (car.attributes["role_name"], car.attributes["color"]) == ("hero", "10,20,30")
    assert car.get_location().distance(spots[0].location) < 0.3
    assert car.bounding_box.extent.x == pytest.approx(2.45, abs=0.05)
    assert car.get_world().id == world.id
    assert world.get_actor(car.id).type_id == CAR


def test_the_speed_limit_is_there_from_the_first_snapshot(world, spots) -> None:
    for spot in spots[:5]:
        assert 10.0 <= spawn(world, spot).get_speed_limit() <= 130.0


def test_spawn_at_occupied_place_fails_and_next_spot_succeeds(world, spots) -> None:
    """At an occupied place, a spawn returns None or raises an error; at a free spot it succeeds."""
    spawn(world, spots[0])
    assert world.try_spawn_actor(blueprint(world), spots[0]) is None
    with pytest.raises(RuntimeError, match="Spawn failed because of collision at spawn position"):
        world.spawn_actor(blueprint(world), spots[0])
    assert world.try_spawn_actor(blueprint(world), spots[1]) is not None


def test_a_car_can_be_staged_far_below_another(world, spots) -> None:
    spawn(world, spots[0])
    below = above(spots[0], -50.0)
    staged = world.try_spawn_actor(blueprint(world), below)
    staged.set_simulate_physics(False)
    run(world, 40)
    assert staged.is_alive
    assert staged.get_location().z == pytest.approx(below.location.z, abs=0.5)


@pytest.mark.parametrize("height_m", [0.2, 1.0])
def test_a_car_above_the_road_is_accepted_and_lands(world, spots, height_m: float) -> None:
    on_road = world.get_map().get_waypoint(spots[0].location).transform
    car = world.try_spawn_actor(blueprint(world), above(on_road, height_m))
    run(world, 30)
    assert car.get_location().z == pytest.approx(on_road.location.z, abs=0.15)


def test_actors_are_found_by_pattern_and_by_id(world, spots) -> None:
    car, walker = spawn(world, spots[0]), spawn(world, above(spots[5], 0.5), WALKER)
    sensor = world.spawn_actor(blueprint(world, "sensor.other.collision"), carla.Transform(), attach_to=car)
    world.tick()
    actors = world.get_actors()
    for pattern in ("vehicle*", "*vehicle*", "*vehicle.*", "vehicle.*"):
        assert [item.id for item in actors.filter(pattern)] == [car.id]
    assert [item.id for item in actors.filter("walker.*")] == [walker.id]
    assert [item.id for item in actors.filter("*sensor*")] == [sensor.id]
    assert {actor.id for actor in world.get_actors([car.id, walker.id])} == {car.id, walker.id}
    assert world.get_actor(9_999_999) is None
    assert isinstance(walker, carla.Walker)
    assert sensor.parent.id == car.id


def test_an_attached_actor_goes_with_its_parent(world, spots) -> None:
    car = settled(world, spots[0])
    place = carla.Transform(carla.Location(x=1.0, z=2.0))
    sensor = world.spawn_actor(blueprint(world, "sensor.other.collision"), place, attach_to=car)
    car.apply_control(carla.VehicleControl(throttle=0.6))
    run(world, 40)
    assert sensor.get_location().distance(car.get_transform().transform(place.location)) < 0.4


def test_a_destroyed_actor_is_gone_and_its_place_free(world, spots) -> None:
    car = spawn(world, spots[0])
    assert car.destroy()
    world.tick()
    assert world.get_snapshot().find(car.id) is None
    assert not car.is_alive
    assert world.try_spawn_actor(blueprint(world), spots[0]) is not None


def test_actor_destroyed_by_another_client_raises_error(client, world, spots) -> None:
    """A call on an actor that another client has destroyed raises an error, and the server continues."""
    car = spawn(world, spots[0])
    client.apply_batch_sync([carla.command.DestroyActor(car.id)], True)
    with pytest.raises(RuntimeError):
        car.set_simulate_physics(False)
    world.tick()


# -- moving by hand


def test_teleports_and_target_velocities_take_effect_in_the_next_tick(world, spots) -> None:
    car = settled(world, spots[0])
    car.set_transform(spots[5])
    world.tick()
    assert car.get_location().distance(spots[5].location) < 0.6
    run(world, 30)
    way = spots[5].get_forward_vector()
    car.set_target_velocity(carla.Vector3D(6.0 * way.x, 6.0 * way.y, 0.0))
    world.tick()
    assert car.get_velocity().length() == pytest.approx(6.0, abs=0.4)
    car.set_location(spots[7].location)
    world.tick()
    assert car.get_location().distance(spots[7].location) < 0.8


def test_without_physics_a_car_stays_where_it_is_put(world, spots) -> None:
    car = spawn(world, spots[0])
    car.set_simulate_physics(False)
    place = above(spots[0], 3.0)
    car.set_transform(place)
    car.apply_control(carla.VehicleControl(throttle=1.0))
    run(world, 20)
    assert car.get_location().distance(place.location) < 0.01


@pytest.mark.carlette_only
def test_a_transform_that_is_not_finite_never_enters_the_world(world, spots) -> None:
    car = spawn(world, spots[0])
    place = car.get_location()
    car.set_transform(carla.Transform(carla.Location(math.nan, 0.0, 0.0)))
    car.set_location(carla.Location(math.inf, 0.0, 0.0))
    car.set_target_velocity(carla.Vector3D(math.nan, 0.0, 0.0))
    run(world, 5)
    assert car.get_location().distance(place) < 1.0


# -- driving


def test_throttle_moves_the_car_ahead_and_brake_stops_it(world, spots) -> None:
    car = settled(world, spots[0])
    car.apply_control(carla.VehicleControl(throttle=0.5))
    run(world, 60)
    assert car.get_velocity().length() > 2.0
    way = car.get_transform().get_forward_vector()
    assert car.get_velocity().dot(way) == pytest.approx(car.get_velocity().length(), abs=0.2)
    car.apply_control(carla.VehicleControl(brake=1.0))
    run(world, 80)
    assert car.get_velocity().length() < 0.1


def test_a_control_is_held_until_another_comes(world, spots) -> None:
    car = settled(world, spots[0])
    car.apply_control(carla.VehicleControl(throttle=0.4, steer=0.1))
    run(world, 60)
    held = car.get_control()
    assert (held.throttle, held.steer, held.brake) == pytest.approx((0.4, 0.1, 0.0))


def test_brake_nan_is_full_brake(world, spots) -> None:
    """A brake of NaN is a full brake, which is how CARLA's traffic manager uses it."""
    car = settled(world, spots[0])
    car.set_target_velocity(spots[0].get_forward_vector() * 5.0)
    car.apply_control(carla.VehicleControl(brake=math.nan))
    run(world, 60)
    assert car.get_velocity().length() < 0.1


def test_steering_turns_right_for_positive_values(world, spots) -> None:
    car = settled(world, spots[0])
    before = car.get_transform().get_right_vector()
    start = car.get_location()
    car.apply_control(carla.VehicleControl(throttle=0.5, steer=0.5))
    run(world, 60)
    assert (car.get_location() - start).dot(before) > 0.2
    assert car.get_angular_velocity().z > 1.0


def test_acceleration_is_the_change_of_velocity(world, spots) -> None:
    car = settled(world, spots[0])
    car.apply_control(carla.VehicleControl(throttle=0.7))
    run(world, 20)
    before = car.get_velocity()
    world.tick()
    change = (car.get_velocity() - before) / 0.05
    assert car.get_acceleration().distance(change) < 1.5


def test_constant_velocity_holds_the_speed_until_it_is_switched_off(world, spots) -> None:
    car = settled(world, spots[0])
    car.enable_constant_velocity(carla.Vector3D(4.0, 0.0, 0.0))
    run(world, 40)
    assert car.get_velocity().length() == pytest.approx(4.0, abs=0.3)
    car.disable_constant_velocity()
    car.apply_control(carla.VehicleControl(brake=1.0))
    run(world, 60)
    assert car.get_velocity().length() < 0.2


def test_ackermann_control_reaches_its_speed(world, spots) -> None:
    car = settled(world, spots[0])
    for _ in range(80):
        car.apply_ackermann_control(carla.VehicleAckermannControl(speed=3.0))
        world.tick()
    assert car.get_velocity().length() == pytest.approx(3.0, abs=0.6)


def test_lights_of_a_vehicle_can_be_read_back(world, spots) -> None:
    car = spawn(world, spots[0])
    both = carla.VehicleLightState.LeftBlinker | carla.VehicleLightState.RightBlinker
    car.set_light_state(carla.VehicleLightState(both))
    world.tick()
    assert int(car.get_light_state()) == int(both)
    assert int(world.get_vehicles_light_states()[car.id]) == int(both)


def test_doors_open_and_close(world, spots) -> None:
    car = settled(world, spots[0])
    car.open_door(carla.VehicleDoor.FL)
    car.open_door(carla.VehicleDoor.FR)
    run(world, 5)
    car.close_door(carla.VehicleDoor.All)
    run(world, 5)
    assert car.is_alive


def test_physics_control_shows_wheels_in_centimetres_and_takes_the_mass(world, spots) -> None:
    car = settled(world, spots[0])
    control = car.get_physics_control()
    place = car.get_location()
    for wheel in control.wheels:
        assert math.hypot(wheel.position.x / 100 - place.x, wheel.position.y / 100 - place.y) < 3.0
    assert len(control.wheels) == 4
    assert control.wheels[0].max_steer_angle > 20.0
    control.mass = 2222.0
    car.apply_physics_control(control)
    world.tick()
    assert car.get_physics_control().mass == 2222.0


# -- walkers


def test_a_walker_walks_where_it_is_told(world, spots) -> None:
    walker = spawn(world, above(spots[0], 1.0), WALKER)
    run(world, 20)
    start = walker.get_location()
    walker.apply_control(carla.WalkerControl(spots[0].get_forward_vector(), 1.5))
    run(world, 40)
    assert walker.get_location().distance(start) == pytest.approx(3.0, abs=0.3)
    assert walker.get_control().speed == pytest.approx(1.5)


def test_a_walker_has_a_head_above_its_feet(world, spots) -> None:
    walker = spawn(world, above(spots[0], 1.0), WALKER)
    run(world, 20)
    bones = {transform.name: transform for transform in walker.get_bones().bone_transforms}
    head, foot = bones["crl_Head__C"], bones["crl_foot__R"]
    assert 1.2 < head.world.location.z - foot.world.location.z < 2.0
    assert head.world.location.distance(walker.get_location()) < 1.5


# -- batches


def test_batch_spawn_applies_chained_commands_to_new_actors(client, world, spots) -> None:
    """A batch spawns actors and applies the chained commands to them; each command has its own error."""
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
    gone = client.apply_batch_sync([command.DestroyActor(item.actor_id) for item in (first, other)], True)
    assert not any(item.error for item in gone)
    assert client.apply_batch_sync([command.DestroyActor(first.actor_id)], False)[0].error


def test_a_batch_moves_drives_and_pushes(client, world, spots) -> None:
    car, walker = settled(world, spots[0]), spawn(world, above(spots[9], 1.0), WALKER)
    command, zero = carla.command, carla.Vector3D()
    batch = [
        command.ApplyTransform(car.id, spots[4]),
        command.ApplyVehicleControl(car.id, carla.VehicleControl(brake=0.3)),
        command.ApplyTargetVelocity(car.id, zero),
        command.ApplyTargetAngularVelocity(car.id, zero),
        command.ApplyImpulse(car.id, zero),
        command.ApplyForce(car.id, zero),
        command.ApplyTorque(car.id, zero),
        command.ApplyAngularImpulse(car.id, zero),
        command.ApplyVehiclePhysicsControl(car.id, car.get_physics_control()),
        command.SetEnableGravity(car.id, True),
        command.ApplyWalkerControl(walker.id, carla.WalkerControl(speed=1.0)),
        command.ApplyWalkerState(walker.id, above(spots[8], 1.0), 1.0),
    ]
    assert [item.error for item in client.apply_batch_sync(batch, True)] == [""] * len(batch)
    assert car.get_location().distance(spots[4].location) < 0.8
    assert car.get_control().brake == pytest.approx(0.3)
    assert walker.get_location().distance(spots[8].location) < 1.5


# -- collisions


def test_collision_sensor_reports_other_actor_in_collision_frame(world, spots) -> None:
    """The collision sensor names the actor that was hit, in the frame of the collision."""
    car = settled(world, spots[0])
    wall = spawn(world, ahead(spots[0], 12.0), "static.prop.container")
    sensor = world.spawn_actor(blueprint(world, "sensor.other.collision"), carla.Transform(), attach_to=car)
    events = []
    sensor.listen(events.append)
    car.apply_control(carla.VehicleControl(throttle=1.0))
    frames = []
    for _ in range(150):
        frames.append(world.tick())
        if events:
            break
    assert events[0].other_actor.id == wall.id
    assert events[0].other_actor.type_id == "static.prop.container"
    assert events[0].actor.id == car.id
    assert events[0].normal_impulse.length() > 100.0
    assert events[0].frame in frames[-20:]
    sensor.stop()
    sensor.destroy()
