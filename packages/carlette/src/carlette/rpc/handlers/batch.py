"""Batches: many commands in one request."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from carlette.errors import RequestError
from carlette.rpc.handlers import actors, motion, traffic_lights, vehicles, walkers
from carlette.rpc.registry import BAD_ARGUMENTS, Methods
from carlette.rpc.session import ClientSession
from carlette.wire import encode

methods = Methods()

Payload = list[Any]
MOST_COMMANDS = 10_000
"""Maximum number of commands in one batch. Ours; the world stops until the batch is done."""
SPAWN_ACTOR, DESTROY_ACTOR, VEHICLE_CONTROL, CONSOLE_COMMAND = 0, 1, 2, 20
"""Indices of commands on the wire, as in CARLA."""


def _destroy(session: ClientSession, actor_id: int) -> None:
    if not actors.destroy_actor(session, actor_id):
        raise RequestError(f"unable to destroy actor: actor {actor_id} not found")


def _lights(session: ClientSession, actor_id: int, state: int) -> None:
    vehicles.set_vehicle_light_state(session, actor_id, [state])


COMMANDS: dict[int, Callable[..., Any]] = {
    DESTROY_ACTOR: _destroy,
    VEHICLE_CONTROL: vehicles.apply_control_to_vehicle,
    3: vehicles.apply_ackermann_control_to_vehicle,
    4: walkers.apply_control_to_walker,
    5: vehicles.apply_physics_control,
    6: motion.set_actor_transform,
    7: walkers.apply_walker_state,
    8: motion.set_actor_target_velocity,
    9: motion.set_actor_target_angular_velocity,
    10: motion.add_actor_impulse,
    11: motion.add_actor_force,
    12: motion.add_actor_angular_impulse,
    13: motion.add_actor_torque,
    14: motion.set_actor_simulate_physics,
    15: motion.set_actor_enable_gravity,
    16: motion.accept,
    17: motion.accept,
    18: _lights,
    19: motion.set_actor_location,
    21: traffic_lights.set_traffic_light_state,
}
"""Functions by the command's index on the wire. Each takes the actor's id first."""


@methods.bare("apply_batch")
def apply_batch(session: ClientSession, commands: Sequence[Sequence[Any]], do_tick: bool = False) -> Any:
    """Run the commands in order, then tick once if requested; return one answer per command."""
    number = _count(commands)
    if number > MOST_COMMANDS:
        # Return one answer per command: the client accepts nothing else.
        refusal = encode.failure(f"{number:,} commands in one batch; send at most {MOST_COMMANDS}")
        return [refusal] * len(commands)
    responses = [_run(session, *command[0]) for command in commands]
    if do_tick:
        session.simulator.ticks_wanted += 1
    return responses


def _count(commands: Sequence[Sequence[Any]]) -> int:
    """Count the commands, including those nested in spawns; raise `BAD_ARGUMENTS` if they are not a list."""
    number, left = 0, [commands]
    while left:
        here = left.pop()
        number += len(here)
        # Skip invalid commands here. They get their own answers later.
        spawns = (item[0][1] for item in here if _is_spawn(item))
        left += [payload[-1] for payload in spawns if payload and isinstance(payload[-1], list)]
    return number


def _is_spawn(command: Any) -> bool:
    inner = command[0] if isinstance(command, list) and command else None
    return isinstance(inner, list) and len(inner) > 1 and inner[0] == SPAWN_ACTOR and isinstance(inner[1], list)


def _run(session: ClientSession, index: int, payload: Payload) -> Any:
    try:
        if index == SPAWN_ACTOR:
            return encode.value(_spawn(session, payload))
        if index == CONSOLE_COMMAND:
            return encode.value(0)
        command = COMMANDS.get(index)
        if command is None:
            return encode.failure(f"command {index} is not known to this server")
        command(session, *payload)
        return encode.value(payload[0])
    except RequestError as error:
        # The error becomes the command's answer, so that the other commands run.
        return encode.failure(str(error))
    except BAD_ARGUMENTS as error:
        # The error becomes the command's answer, so that the other commands run.
        return encode.failure(f"command {index}: the arguments cannot be read ({error})")


def _spawn(session: ClientSession, payload: Payload) -> int:
    description, transform, parent, *_, after = payload
    actor = actors.bring_in(session, description, transform, int(parent[1]) if parent[0] else 0)
    for command in after:
        index, arguments = command[0]
        # The client did not have the id yet and left it at 0.
        _run(session, index, arguments if index in (SPAWN_ACTOR, CONSOLE_COMMAND) else [actor.id, *arguments[1:]])
    return actor.id
