"""The map and its files."""

from __future__ import annotations

from typing import Any

from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.simulator import MAP_PREFIX
from carlette.wire import encode

methods = Methods()


@methods.value("get_available_maps")
def get_available_maps(session: ClientSession) -> list[str]:
    return session.simulator.map_names


@methods.value("get_map_info")
def get_map_info(session: ClientSession) -> Any:
    roads = session.world.roads
    return [MAP_PREFIX + roads.file.name, [encode.pose(point) for point in roads.spawn_points()]]


@methods.value("get_map_data")
def get_map_data(session: ClientSession) -> str:
    return session.world.roads.file.text


@methods.value("get_required_files")
def get_required_files(session: ClientSession, folder: str = "", download: bool = False) -> list[str]:
    del session, folder, download
    return []


@methods.value("request_file", "get_navigation_mesh")
def no_file(session: ClientSession, *_: Any) -> bytes:
    del session
    return b""
