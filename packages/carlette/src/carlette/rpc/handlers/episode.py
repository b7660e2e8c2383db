"""Connection, episode and settings."""

from __future__ import annotations

import math
from typing import Any

from carlette.errors import MapError, RequestError
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.wire.encode import WORLD_STREAM
from carlette.world.settings import EpisodeSettings

methods = Methods()

SHORTEST_STEP_S = 1e-4
"""Shortest fixed step that a client may set (s). Ours."""
LONGEST_STEP_S = 10.0
"""Longest fixed step that a client may set (s). Ours."""


@methods.value("version")
def version(session: ClientSession) -> str:
    return session.simulator.version.name


@methods.value("get_episode_info")
def get_episode_info(session: ClientSession) -> Any:
    simulator = session.simulator
    return [simulator.episode_id, [simulator.token(WORLD_STREAM)]]


@methods.value("get_sensor_token")
def get_sensor_token(session: ClientSession, stream_id: int) -> Any:
    token = session.simulator.token(stream_id)
    session.simulator.hub.expect(stream_id)
    return [token]


@methods.value("get_episode_settings")
def get_episode_settings(session: ClientSession) -> Any:
    """Return the fields of `carla.WorldSettings` in the order of the wire."""
    it = session.world.settings
    fixed = [False] if it.fixed_delta_s is None else [True, it.fixed_delta_s]
    return [
        it.synchronous,
        it.no_rendering,
        fixed,
        it.substepping,
        it.max_substep_delta_s,
        it.max_substeps,
        it.max_culling_distance_m,
        it.deterministic_ragdolls,
        it.tile_stream_distance_m,
        it.actor_active_distance_m,
        it.spectator_as_ego,
    ]


@methods.value("set_episode_settings")
def set_episode_settings(session: ClientSession, wire: list[Any]) -> int:
    fixed = float(wire[2][1]) if wire[2][0] else None
    if fixed and not SHORTEST_STEP_S <= fixed <= LONGEST_STEP_S:
        bounds = f"{SHORTEST_STEP_S:g} to {LONGEST_STEP_S:g}"
        raise RequestError(f"fixed_delta_seconds is {fixed}; give {bounds} seconds, or 0 for a variable step")
    # Store valid values only: all other clients read them.
    kinds = (bool, float, int, float, bool, float, float, bool)
    others = [kind(item) for kind, item in zip(kinds, wire[3:11], strict=False)]
    if not all(map(math.isfinite, others)) or not all(abs(other) < 2**31 for other in others):
        raise RequestError(f"set_episode_settings: {others} are not finite numbers within 32 bits; give real ones")
    session.world.settings = EpisodeSettings(bool(wire[0]), bool(wire[1]), fixed or None, *others)
    return session.world.frame


@methods.void("load_new_episode")
def load_new_episode(session: ClientSession, name: str, reset_settings: bool = True, layers: int = 0xFFFF) -> None:
    del layers  # a map without buildings has no layers
    _switch(lambda: session.simulator.load_map(name, reset_settings), name)


@methods.void("copy_opendrive_to_file")
def copy_opendrive_to_file(session: ClientSession, text: str, parameters: list[Any]) -> None:
    del parameters  # they shape the mesh that a renderer would show
    _switch(lambda: session.simulator.load_text(text), "OpenDriveMap")


def _switch(load: Any, name: str) -> None:
    try:
        load()
    except MapError as error:
        raise RequestError(f"Map '{name}' not found: {error}") from error


@methods.void("load_map_layer", "unload_map_layer")
def ignore_map_layer(session: ClientSession, layers: int) -> None:
    del session, layers
