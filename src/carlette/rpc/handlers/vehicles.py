"""Vehicles: control, lights, doors, physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from carlette.errors import RequestError
from carlette.physics.ackermann import ackermann_control
from carlette.physics.fleet import STEER
from carlette.rpc.registry import Methods
from carlette.rpc.session import Session
from carlette.wire.vehicle_physics import physics_control, take_physics_control

methods = Methods()

Wire = Sequence[Any]
ACKERMANN_GAINS = [0.15, 0.0, 0.25, 0.01, 0.0, 0.01]


@methods.void("apply_control_to_vehicle")
def apply_control_to_vehicle(session: Session, actor_id: int, control: Wire) -> None:
    actor = session.vehicle(actor_id, "apply_control_to_vehicle")
    session.world.fleet.control[actor.index] = control


@methods.void("apply_ackermann_control_to_vehicle")
def apply_ackermann_control_to_vehicle(session: Session, actor_id: int, control: Wire) -> None:
    actor = session.vehicle(actor_id, "apply_ackermann_control_to_vehicle")
    if not all(map(math.isfinite, control)):
        raise RequestError("apply_ackermann_control_to_vehicle: a value is not finite; give real numbers")
    fleet, bodies = session.world.fleet, session.world.bodies
    fleet.control[actor.index] = ackermann_control(fleet, bodies, actor.index, control)


@methods.value("get_ackermann_controller_settings")
def get_ackermann_controller_settings(session: Session, actor_id: int) -> Any:
    session.vehicle(actor_id, "get_ackermann_controller_settings")
    return ACKERMANN_GAINS


@methods.void("apply_ackermann_controller_settings")
def apply_ackermann_controller_settings(session: Session, actor_id: int, gains: Wire) -> None:
    del gains  # the controller here has no gains: it inverts the vehicle's model
    session.vehicle(actor_id, "apply_ackermann_controller_settings")


@methods.value("get_physics_control")
def get_physics_control(session: Session, actor_id: int) -> Any:
    return physics_control(session.world, session.vehicle(actor_id, "get_physics_control"))


@methods.void("apply_physics_control")
def apply_physics_control(session: Session, actor_id: int, wire: Wire) -> None:
    take_physics_control(session.world, session.vehicle(actor_id, "apply_physics_control"), wire)


@methods.value("get_vehicle_light_state")
def get_vehicle_light_state(session: Session, actor_id: int) -> Any:
    actor = session.vehicle(actor_id, "get_vehicle_light_state")
    return [int(session.world.fleet.light_state[actor.index])]


@methods.void("set_vehicle_light_state")
def set_vehicle_light_state(session: Session, actor_id: int, state: Wire) -> None:
    actor = session.vehicle(actor_id, "set_vehicle_light_state")
    session.world.fleet.light_state[actor.index] = int(state[0])


@methods.value("get_vehicle_light_states")
def get_vehicle_light_states(session: Session) -> Any:
    fleet = session.world.fleet
    ids = session.world.bodies.record["id"][fleet.row].tolist()
    return [list(pair) for pair in zip(ids, fleet.light_state.tolist(), strict=True)]


@methods.void("open_vehicle_door", "close_vehicle_door")
def move_door(session: Session, actor_id: int, door: int) -> None:
    del door  # doors are not part of a vehicle's box
    session.vehicle(actor_id, "open_vehicle_door")


@methods.value("get_wheel_steer_angle")
def get_wheel_steer_angle(session: Session, actor_id: int, wheel: int) -> float:
    """Degrees; the rear wheels do not steer."""
    actor = session.vehicle(actor_id, "get_wheel_steer_angle")
    fleet = session.world.fleet
    angle = math.degrees(fleet.steer[actor.index] * fleet.max_steer[actor.index])
    return angle if wheel < 2 else 0.0


@methods.value("get_wheel_pitch_angle")
def get_wheel_pitch_angle(session: Session, actor_id: int, wheel: int) -> float:
    del wheel
    session.vehicle(actor_id, "get_wheel_pitch_angle")
    return 0.0


@methods.void("set_wheel_steer_direction", "set_wheel_pitch_angle")
def show_wheel(session: Session, actor_id: int, wheel: int, degrees: float) -> None:
    del wheel, degrees  # only for show in CARLA too
    session.vehicle(actor_id, "set_wheel_steer_direction")


@methods.void(
    "enable_carsim", "use_carsim_road", "enable_chrono_physics", "restore_physx_physics", "show_vehicle_debug_telemetry"
)
def ignore_physics_engine(session: Session, actor_id: int, *_: Any) -> None:
    session.vehicle(actor_id, "enable_carsim")


@methods.value("get_telemetry_data")
def get_telemetry_data(session: Session, actor_id: int) -> Any:
    actor = session.vehicle(actor_id, "get_telemetry_data")
    control = session.world.fleet.clean_controls()[actor.index].tolist()
    speed = float(math.hypot(*session.world.bodies.velocity[actor.row].tolist()))
    steer = float(session.world.fleet.steer[actor.index])
    gear = int(session.world.bodies.record["gear"][actor.row])
    return [speed, steer, control[STEER - 1], control[STEER + 1], 0.0, gear, 0.0, []]
