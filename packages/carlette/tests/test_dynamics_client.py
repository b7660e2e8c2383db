"""What the real client reads and writes of vehicles, walkers and animals."""

from __future__ import annotations

import math

import pytest

from serving import running_server
from straight import straight_road

pytestmark = pytest.mark.integration

carla = pytest.importorskip("carla")

MKZ = "vehicle.lincoln.mkz_2020"
DT = 0.05


@pytest.fixture(scope="module")
def client():
    with running_server("--map", "demo_town") as port:
        client = carla.Client("127.0.0.1", port)
        client.set_timeout(60.0)
        yield client


@pytest.fixture
def world(client):
    world = client.generate_opendrive_world(straight_road())
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, DT
    world.apply_settings(settings)
    return world


def place(x: float, y: float = 1.75, z: float = 0.1, **turn: float):
    return carla.Transform(carla.Location(x, y, z), carla.Rotation(**turn))


def spawn(world, type_id: str = MKZ, x: float = 50.0, y: float = 1.75, z: float = 0.1, **attributes: str):
    blueprint = world.get_blueprint_library().find(type_id)
    for name, value in attributes.items():
        blueprint.set_attribute(name, value)
    actor = world.spawn_actor(blueprint, place(x, y, z))
    world.tick()
    return actor


def run(world, ticks: int) -> None:
    for _ in range(ticks):
        world.tick()


def in_gear(world, car) -> None:
    """Puts a new car into gear by hand, as people do in CARLA to be rid of its slow first start."""
    car.apply_control(carla.VehicleControl(manual_gear_shift=True, gear=1))
    world.tick()
    car.apply_control(carla.VehicleControl(manual_gear_shift=False))


def full_throttle_speed(world, car, ticks: int = 40) -> float:
    in_gear(world, car)
    car.apply_control(carla.VehicleControl(throttle=1.0))
    run(world, ticks)
    return car.get_velocity().x


def changed(car, **fields):
    control = car.get_physics_control()
    for name, value in fields.items():
        setattr(control, name, value)
    car.apply_physics_control(control)
    return control


def test_physics_control_fields_survive_write_and_read(world) -> None:
    """The fields of the physics control can be written and read back."""
    car = spawn(world)
    curve = [carla.Vector2D(0.0, 300.0), carla.Vector2D(4000.0, 350.0)]
    gears = [carla.GearPhysicsControl(3.0, 0.4, 0.8), carla.GearPhysicsControl(1.5, 0.4, 0.8)]
    wheels = car.get_physics_control().wheels
    for wheel in wheels:
        wheel.tire_friction, wheel.max_brake_torque = 2.0, 900.0
    changed(car, torque_curve=curve, max_rpm=5000.0, final_ratio=3.0, forward_gears=gears, wheels=wheels, mass=1500.0)
    world.tick()
    found = car.get_physics_control()
    assert [(item.x, item.y) for item in found.torque_curve] == [(0.0, 300.0), (4000.0, 350.0)]
    assert (found.max_rpm, found.final_ratio, found.mass) == (5000.0, 3.0, 1500.0)
    assert [gear.ratio for gear in found.forward_gears] == [3.0, 1.5]
    assert {(item.tire_friction, item.max_brake_torque) for item in found.wheels} == {(2.0, 900.0)}


@pytest.mark.parametrize(
    ("fields", "faster"),
    [({"mass": 4000.0}, False), ({"mass": 1200.0}, True), ({"final_ratio": 2.0}, False), ({}, None)],
)
def test_the_physics_control_changes_how_a_car_drives(world, fields, faster) -> None:
    usual, other = spawn(world), spawn(world, y=-1.75)
    changed(other, **fields)
    speeds = []
    for car in (usual, other):
        car.apply_control(carla.VehicleControl(throttle=0.8))
    run(world, 40)
    speeds = [abs(car.get_velocity().x) for car in (usual, other)]
    if faster is None:
        assert speeds[0] == pytest.approx(speeds[1], rel=1e-3)
    else:
        assert (speeds[1] > 1.05 * speeds[0]) == faster
        assert (speeds[1] < 0.95 * speeds[0]) != faster


def test_less_friction_needs_a_longer_way_to_stop(world) -> None:
    stops = []
    for friction in (3.5, 0.7):
        car = spawn(world, x=100.0)
        wheels = car.get_physics_control().wheels
        for wheel in wheels:
            wheel.tire_friction = friction
        changed(car, wheels=wheels)
        car.set_target_velocity(carla.Vector3D(15.0, 0.0, 0.0))
        car.apply_control(carla.VehicleControl(brake=1.0))
        run(world, 160)
        stops.append(car.get_location().x - 100.0)
        car.destroy()
    assert stops[1] > 1.5 * stops[0]


def test_physics_that_cannot_be_are_refused_and_change_nothing(world) -> None:
    car = spawn(world)
    changed(car, mass=-5.0)
    changed(car, max_rpm=math.nan)
    run(world, 3)
    assert car.get_physics_control().mass == pytest.approx(1850.0)


def test_the_wheel_angle_follows_the_steering_curve(world) -> None:
    car = spawn(world, x=300.0)
    car.apply_control(carla.VehicleControl(steer=0.5))
    run(world, 20)
    assert car.get_wheel_steer_angle(carla.VehicleWheelLocation.FL_Wheel) == pytest.approx(35.0, abs=1.0)
    assert car.get_wheel_steer_angle(carla.VehicleWheelLocation.BL_Wheel) == 0.0


def test_an_open_door_and_the_lights_come_from_the_client(world) -> None:
    parked, passing = spawn(world, x=80.0), spawn(world, x=50.0, y=-0.55)
    parked.open_door(carla.VehicleDoor.FL)
    run(world, 20)
    passing.set_target_velocity(carla.Vector3D(12.0, 0.0, 0.0))
    run(world, 60)
    assert passing.get_velocity().x < 11.0 * 0.5
    assert parked.bounding_box.extent.y == pytest.approx(0.918, abs=0.01)
    parked.close_door(carla.VehicleDoor.All)
    state = carla.VehicleLightState(carla.VehicleLightState.Brake | carla.VehicleLightState.Special1)
    parked.set_light_state(state)
    run(world, 2)
    assert int(parked.get_light_state()) == int(state)
    assert dict(world.get_vehicles_light_states())[parked.id] == state


def test_ackermann_settings_are_stored_and_target_speed_is_held(world) -> None:
    """Ackermann settings are stored, and the target speed is reached and held."""
    car = spawn(world)
    gains = carla.AckermannControllerSettings(0.2, 0.0, 0.2, 0.02, 0.0, 0.01)
    car.apply_ackermann_controller_settings(gains)
    car.apply_ackermann_control(carla.VehicleAckermannControl(speed=8.0, acceleration=2.0))
    run(world, 240)
    assert car.get_ackermann_controller_settings().speed_kp == pytest.approx(0.2)
    assert car.get_velocity().x == pytest.approx(8.0, abs=0.8)
    car.apply_ackermann_control(carla.VehicleAckermannControl(speed=0.0))
    run(world, 200)
    assert car.get_velocity().length() < 0.2
    car.apply_control(carla.VehicleControl(throttle=0.7))
    run(world, 30)
    assert car.get_velocity().x > 1.0


def test_a_control_that_is_not_sticky_is_forgotten(world) -> None:
    sticky, loose = spawn(world), spawn(world, y=-1.75, sticky_control="false")
    for car in (sticky, loose):
        in_gear(world, car)
        car.apply_control(carla.VehicleControl(throttle=0.8))
    run(world, 30)
    assert abs(sticky.get_velocity().x) > 4.0
    assert abs(loose.get_velocity().x) < 1.0


def test_impulse_and_constant_velocity_respect_mass_and_vehicle_frame(world) -> None:
    """An impulse acts by the mass, and a constant velocity in the frame of the vehicle."""
    car = spawn(world)
    mass = car.get_physics_control().mass
    car.add_impulse(carla.Vector3D(5.0 * mass, 0.0, 0.0))
    world.tick()
    assert car.get_velocity().x == pytest.approx(4.9, abs=0.2)
    turned = world.spawn_actor(world.get_blueprint_library().find(MKZ), place(300.0, yaw=90.0))
    turned.enable_constant_velocity(carla.Vector3D(3.0, 0.0, 0.0))
    run(world, 3)
    assert turned.get_velocity().y == pytest.approx(3.0, abs=0.01)
    turned.disable_constant_velocity()


def test_gravity_physics_and_collisions_can_be_switched_off(world) -> None:
    floating = spawn(world, x=100.0, z=3.0)
    floating.set_enable_gravity(False)
    run(world, 2)
    height = floating.get_location().z
    run(world, 10)
    assert floating.get_velocity().z == pytest.approx(floating.get_velocity().z)
    floating.set_target_velocity(carla.Vector3D())
    run(world, 2)
    assert abs(floating.get_velocity().z) < 0.01
    assert height > 2.0
    ghost, wall = spawn(world, x=200.0), spawn(world, "static.prop.container", x=215.0, z=0.0)
    ghost.set_collisions(False)
    ghost.set_target_velocity(carla.Vector3D(15.0, 0.0, 0.0))
    run(world, 60)
    assert ghost.get_location().x > wall.get_location().x + 3.0


@pytest.mark.skipif(not hasattr(carla.Vehicle, "get_telemetry_data"), reason="the client has no telemetry")
def test_telemetry_shows_engine_and_wheels(world) -> None:
    car = spawn(world)
    full_throttle_speed(world, car)
    data = car.get_telemetry_data()
    assert data.speed == pytest.approx(car.get_velocity().x, abs=0.1)
    assert data.engine_rpm > 800.0 and data.throttle == 1.0 and data.gear >= 1
    assert len(data.wheels) == 4
    assert sum(wheel.tire_load for wheel in data.wheels) == pytest.approx(1850.0 * 9.81, rel=0.01)


def test_an_animal_takes_a_walkers_control_by_command(client, world) -> None:
    dog = spawn(world, "animal.dog", z=0.4)
    assert dog.attributes["carlette_extra"] == "true"
    control = carla.WalkerControl(carla.Vector3D(1.0, 0.0, 0.0), 3.0)
    assert not client.apply_batch_sync([carla.command.ApplyWalkerControl(dog.id, control)], True)[0].error
    run(world, 20)
    assert dog.get_velocity().x == pytest.approx(3.0)
    assert dog.bounding_box.extent.x == pytest.approx(0.45)


def test_extras_are_listed_by_their_tag(world) -> None:
    extras = {item.id for item in world.get_blueprint_library().filter("carlette_extra")}
    assert {"animal.deer", "walker.flagger.0001", "vehicle.carlette.schoolbus", "static.prop.paperbag"} <= extras
    assert not any(extra.startswith("vehicle.tesla") for extra in extras)
    library = world.get_blueprint_library()
    assert {item.id for item in library.filter_by_attribute("carlette_extra", "true")} == extras


def test_without_navigation_mesh_location_is_none_and_walker_stays(world) -> None:
    """Without a navigation mesh, a random location is None, and the AI controller leaves its walker in place."""
    assert world.get_random_location_from_navigation() is None
    walker = spawn(world, "walker.pedestrian.0003", z=1.0)
    controller = world.spawn_actor(
        world.get_blueprint_library().find("controller.ai.walker"), carla.Transform(), attach_to=walker
    )
    world.tick()
    start = walker.get_location()
    controller.start()
    controller.set_max_speed(1.4)
    controller.go_to_location(carla.Location(70.0, 5.0, 0.0))
    run(world, 20)
    assert walker.get_location().distance(start) < 0.2
    controller.stop()
    assert controller.destroy() and walker.destroy()


def hand(walker):
    return next(
        transform for transform in walker.get_bones().bone_transforms if transform.name == "crl_hand__R"
    ).component.location


def test_flagger_shows_spawn_gesture_and_accepts_bones(world) -> None:
    """A flagger shows the gesture of its blueprint and accepts other poses."""
    hanging = spawn(world, "walker.flagger.0001", z=1.0)
    signing = spawn(world, "walker.flagger.0001", x=60.0, z=1.0, gesture="stop")
    ahead = hand(signing)
    assert ahead.x - hand(hanging).x > 0.4
    assert ahead.z - hand(hanging).z > 0.4
    arm = carla.WalkerBoneControlIn([("crl_foreArm__R", carla.Transform(carla.Location(0.0, 0.4, 0.0)))])
    hanging.set_bones(arm)
    hanging.show_pose()
    world.tick()
    out = hand(hanging)
    hanging.hide_pose()
    world.tick()
    assert out.y - hand(hanging).y == pytest.approx(0.36, abs=0.02)
