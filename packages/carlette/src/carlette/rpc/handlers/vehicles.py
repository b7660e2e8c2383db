"""Vehicles: control, lights, doors, physics."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from carlette.blueprints import load_catalog
from carlette.errors import RequestError
from carlette.physics.ackermann import GAINS, Ackermann
from carlette.physics.doors import STOP_ARM
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.rpc.telemetry import telemetry, wheel_angle
from carlette.rpc.vehicle_physics import physics_control, take_physics_control
from carlette.world.actor import Actor

methods = Methods()

Wire = Sequence[Any]
ACKERMANN_VALUES = 5
"""Number of values of an Ackermann command."""
MOST_LIGHTS = 2**32 - 1
"""Largest combination of light flags, 32 bits."""
SCHOOL_BUS = "school"
SPECIAL_1 = 512
"""`carla.VehicleLightState.Special1`: the flashing lights of a school bus. They also swing out its stop arm."""


@methods.void("apply_control_to_vehicle")
def apply_control_to_vehicle(session: ClientSession, actor_id: int, control: Wire) -> None:
    actor = session.vehicle(actor_id, "apply_control_to_vehicle")
    if actor_id in session.world.ackermanns:
        session.world.ackermanns[actor_id].active = False
    session.world.fleet.control[actor.index] = control


@methods.void("apply_ackermann_control_to_vehicle")
def apply_ackermann_control_to_vehicle(session: ClientSession, actor_id: int, control: Wire) -> None:
    actor = session.vehicle(actor_id, "apply_ackermann_control_to_vehicle")
    values = [float(item) for item in control]
    if len(values) != ACKERMANN_VALUES or not all(map(math.isfinite, values)):
        raise RequestError(
            f"apply_ackermann_control_to_vehicle: {values} are not {ACKERMANN_VALUES} finite numbers: "
            "give steer, steer speed, speed, acceleration and jerk"
        )
    _controller(session, actor.id).command(values)


def _controller(session: ClientSession, actor_id: int) -> Ackermann:
    return session.world.ackermanns.setdefault(actor_id, Ackermann())


@methods.value("get_ackermann_controller_settings")
def get_ackermann_controller_settings(session: ClientSession, actor_id: int) -> Any:
    session.vehicle(actor_id, "get_ackermann_controller_settings")
    found = session.world.ackermanns.get(actor_id)
    return list(found.gains if found else GAINS)


@methods.void("apply_ackermann_controller_settings")
def apply_ackermann_controller_settings(session: ClientSession, actor_id: int, gains: Wire) -> None:
    session.vehicle(actor_id, "apply_ackermann_controller_settings")
    values = tuple(float(gain) for gain in gains[:6])
    if len(values) != len(GAINS) or not all(map(math.isfinite, values)):
        raise RequestError(f"apply_ackermann_controller_settings: {values} are not six finite gains")
    _controller(session, actor_id).gains = values


@methods.value("get_physics_control")
def get_physics_control(session: ClientSession, actor_id: int) -> Any:
    return physics_control(session.world, session.vehicle(actor_id, "get_physics_control"))


@methods.void("apply_physics_control")
def apply_physics_control(session: ClientSession, actor_id: int, wire: Wire) -> None:
    take_physics_control(session.world, session.vehicle(actor_id, "apply_physics_control"), wire)


@methods.value("get_vehicle_light_state")
def get_vehicle_light_state(session: ClientSession, actor_id: int) -> Any:
    actor = session.vehicle(actor_id, "get_vehicle_light_state")
    return [int(session.world.fleet.light_state[actor.index])]


@methods.void("set_vehicle_light_state")
def set_vehicle_light_state(session: ClientSession, actor_id: int, state: Wire) -> None:
    actor = session.vehicle(actor_id, "set_vehicle_light_state")
    flags = int(state[0])
    if not 0 <= flags <= MOST_LIGHTS:
        raise RequestError(f"set_vehicle_light_state: {flags} is not a combination of carla.VehicleLightState flags")
    session.world.fleet.light_state[actor.index] = flags
    if load_catalog().vehicles[actor.type_id].special_type == SCHOOL_BUS:
        session.world.doors.move(actor.row, actor.box, STOP_ARM, bool(flags & SPECIAL_1))


@methods.value("get_vehicle_light_states")
def get_vehicle_light_states(session: ClientSession) -> Any:
    fleet = session.world.fleet
    ids = session.world.bodies.record["id"][fleet.row].tolist()
    return [list(pair) for pair in zip(ids, fleet.light_state.tolist(), strict=True)]


@methods.void("open_vehicle_door")
def open_vehicle_door(session: ClientSession, actor_id: int, door: int) -> None:
    _move_door(session, session.vehicle(actor_id, "open_vehicle_door"), door, True)


@methods.void("close_vehicle_door")
def close_vehicle_door(session: ClientSession, actor_id: int, door: int) -> None:
    _move_door(session, session.vehicle(actor_id, "close_vehicle_door"), door, False)


def _move_door(session: ClientSession, actor: Actor, door: int, opening: bool) -> None:
    """Move a door. As in CARLA, it does nothing if the doors of the vehicle's blueprint do not move."""
    if load_catalog().vehicles[actor.type_id].has_doors:
        session.world.doors.move(actor.row, actor.box, door, opening)


@methods.value("get_wheel_steer_angle")
def get_wheel_steer_angle(session: ClientSession, actor_id: int, wheel: int) -> float:
    """Return a wheel's angle after the steering curve (degrees). The rear wheels do not steer."""
    actor = session.vehicle(actor_id, "get_wheel_steer_angle")
    return math.degrees(wheel_angle(session.world, actor)) if wheel < 2 else 0.0


@methods.value("get_wheel_pitch_angle")
def get_wheel_pitch_angle(session: ClientSession, actor_id: int, wheel: int) -> float:
    del wheel
    session.vehicle(actor_id, "get_wheel_pitch_angle")
    return 0.0


@methods.void("set_wheel_steer_direction", "set_wheel_pitch_angle")
def show_wheel(session: ClientSession, actor_id: int, wheel: int, degrees: float) -> None:
    del wheel, degrees  # CARLA, too, only shows the wheel
    session.vehicle(actor_id, "set_wheel_steer_direction")


@methods.void(
    "enable_carsim", "use_carsim_road", "enable_chrono_physics", "restore_physx_physics", "show_vehicle_debug_telemetry"
)
def ignore_physics_engine(session: ClientSession, actor_id: int, *_: Any) -> None:
    session.vehicle(actor_id, "enable_carsim")


@methods.value("get_telemetry_data")
def get_telemetry_data(session: ClientSession, actor_id: int) -> Any:
    return telemetry(session.world, session.vehicle(actor_id, "get_telemetry_data"))
