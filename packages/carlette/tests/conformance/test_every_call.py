"""Each call of the client that has an answer gets one: nothing hangs, nothing is unknown to the server."""

from __future__ import annotations

import pytest
from stage import WALKER, above, blueprint, run, spawn

carla = pytest.importorskip("carla")

ZERO = carla.Vector3D()
FL_DOOR, FL_WHEEL = carla.VehicleDoor.FL, carla.VehicleWheelLocation.FL_Wheel

CLIENT = {
    "get_available_maps": (),
    "get_client_version": (),
    "get_required_files": ("", False),
    "get_server_version": (),
    "show_recorder_file_info": ("no.log", True),
    "show_recorder_collisions": ("no.log", "a", "a"),
    "show_recorder_actors_blocked": ("no.log", 1.0, 1.0),
    "stop_recorder": (),
    "stop_replayer": (True,),
    "set_replayer_time_factor": (1.0,),
    "set_replayer_ignore_hero": (False,),
    "set_replayer_ignore_spectator": (False,),
}
WORLD = {
    "get_actors": (),
    "get_blueprint_library": (),
    "get_environment_objects": (carla.CityObjectLabel.Buildings,),
    "get_level_bbs": (carla.CityObjectLabel.Buildings,),
    "enable_environment_objects": ([], False),
    "get_lightmanager": (),
    "get_map": (),
    "get_names_of_all_objects": (),
    "get_random_location_from_navigation": (),
    "get_settings": (),
    "get_snapshot": (),
    "get_spectator": (),
    "get_vehicles_light_states": (),
    "get_weather": (),
    "set_pedestrians_cross_factor": (0.1,),
    "set_pedestrians_seed": (1,),
    "freeze_all_traffic_lights": (False,),
    "reset_all_traffic_lights": (),
    "get_imui_sensor_gravity": (),
    "set_imui_sensor_gravity": (9.81,),
    "set_annotations_traverse_translucency": (False,),
}
ACTOR = {
    "add_force": (ZERO,),
    "add_impulse": (ZERO,),
    "add_torque": (ZERO,),
    "add_angular_impulse": (ZERO,),
    "enable_constant_velocity": (ZERO,),
    "disable_constant_velocity": (),
    "get_acceleration": (),
    "get_angular_velocity": (),
    "set_collisions": (True,),
    "set_enable_gravity": (True,),
    "set_simulate_physics": (True,),
    "set_target_velocity": (ZERO,),
    "set_target_angular_velocity": (ZERO,),
    "get_component_names": (),
    "get_bone_names": (),
    "get_bone_world_transforms": (),
    "get_bone_relative_transforms": (),
    "get_socket_names": (),
    "get_socket_world_transforms": (),
    "get_socket_relative_transforms": (),
}
VEHICLE = {
    **ACTOR,
    "apply_ackermann_control": (carla.VehicleAckermannControl(),),
    "get_ackermann_controller_settings": (),
    "apply_ackermann_controller_settings": (carla.AckermannControllerSettings(),),
    "get_control": (),
    "get_failure_state": (),
    "get_light_state": (),
    "get_physics_control": (),
    "get_speed_limit": (),
    "get_telemetry_data": (),
    "get_traffic_light": (),
    "get_traffic_light_state": (),
    "is_at_traffic_light": (),
    "get_wheel_steer_angle": (FL_WHEEL,),
    "set_wheel_steer_direction": (FL_WHEEL, 5.0),
    "get_wheel_pitch_angle": (FL_WHEEL,),
    "set_wheel_pitch_angle": (FL_WHEEL, 5.0),
    "get_vehicle_bone_world_transforms": (),
    "open_door": (FL_DOOR,),
    "close_door": (FL_DOOR,),
    "show_debug_telemetry": (False,),
}
PEDESTRIAN = {
    "get_bones": (),
    "set_bones": (carla.WalkerBoneControlIn(),),
    "blend_pose": (0.0,),
    "show_pose": (),
    "hide_pose": (),
    "get_pose_from_animation": (),
    "get_control": (),
}
LIGHT = {
    "get_affected_lane_waypoints": (),
    "get_elapsed_time": (),
    "get_green_time": (),
    "get_yellow_time": (),
    "get_red_time": (),
    "get_group_traffic_lights": (),
    "get_light_boxes": (),
    "get_opendrive_id": (),
    "get_pole_index": (),
    "get_stop_waypoints": (),
    "is_frozen": (),
    "reset_group": (),
}


def answers(thing, calls) -> None:
    """Calls what this version of the client has."""
    for name, arguments in calls.items():
        if hasattr(thing, name):
            getattr(thing, name)(*arguments)


def test_calls_of_the_client(client, world) -> None:
    answers(client, CLIENT)
    run(world, 2)


def test_calls_of_the_world(world) -> None:
    answers(world, WORLD)
    run(world, 2)


def test_calls_of_a_vehicle(world, spots) -> None:
    answers(spawn(world, spots[0]), VEHICLE)
    run(world, 2)


def test_calls_of_a_walker(world, spots) -> None:
    walker = spawn(world, above(spots[0], 1.0), WALKER)
    answers(walker, PEDESTRIAN)
    run(world, 2)


def test_calls_of_a_walkers_controller(world, spots) -> None:
    walker = spawn(world, above(spots[0], 1.0), WALKER)
    controller = world.spawn_actor(blueprint(world, "controller.ai.walker"), carla.Transform(), attach_to=walker)
    world.tick()
    controller.start()
    controller.go_to_location(spots[3].location)
    controller.set_max_speed(1.4)
    run(world, 5)
    controller.stop()
    run(world, 2)


def test_calls_of_a_traffic_light(world) -> None:
    answers(world.get_actors().filter("*traffic_light*")[0], LIGHT)
    run(world, 2)


@pytest.mark.carlette_only
def test_what_needs_a_renderer_is_refused_by_name(world) -> None:
    with pytest.raises(RuntimeError, match="wall_17"):
        world.apply_color_texture_to_object("wall_17", carla.MaterialParameter.Diffuse, carla.TextureColor(2, 2))
    with pytest.raises(RuntimeError, match="wall_17"):
        texture = carla.TextureFloatColor(2, 2)
        world.apply_float_color_texture_to_object("wall_17", carla.MaterialParameter.Diffuse, texture)


@pytest.mark.carlette_only
def test_a_sensor_is_not_on_ros(world, spots) -> None:
    car = spawn(world, spots[0])
    sensor = world.spawn_actor(blueprint(world, "sensor.other.collision"), carla.Transform(), attach_to=car)
    world.tick()
    sensor.enable_for_ros()
    assert not sensor.is_enabled_for_ros()
    sensor.disable_for_ros()
    world.tick()
