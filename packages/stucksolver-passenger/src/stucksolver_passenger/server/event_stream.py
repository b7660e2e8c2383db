"""The live updates of a page: server-sent events (WHATWG HTML, section 9.2), the newest of each kind."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from json import dumps

from stucksolver_passenger.server.fleet_state import Board, Vehicle
from stucksolver_passenger.socket_frames import Topic

KEEP_ALIVE_S = 10.0
"""Longest silence before a comment is sent (s), because proxies and phones close silent connections. Ours."""
ORDER = (Topic.SCENERY, Topic.NOW, Topic.VIEW, Topic.PICTURE)


async def events(
    board: Board, vehicle_id: str, pictures: bool, gone: Callable[[], Awaitable[bool]]
) -> AsyncIterator[str]:
    """Yield the vehicle's updates until `gone` returns that the page is closed.

    A slow page gets fewer updates: newer ones replace the missed ones, and no update is queued for it.
    """
    sent: dict[Topic, int] = {}
    wanted = [topic for topic in ORDER if pictures or topic not in (Topic.VIEW, Topic.PICTURE)]
    here: Vehicle | None = None
    while not await gone():
        vehicle = board.vehicle(vehicle_id)
        if vehicle is not here:
            here, sent = vehicle, {}  # the vehicle has joined, possibly again, so everything is new
            if vehicle is not None:
                yield _event(Topic.HELLO, dumps(vehicle.name))
        news = [] if vehicle is None else [topic for topic in wanted if _is_new(vehicle, topic, sent)]
        if vehicle is not None and news:
            text = "".join(_event(topic, vehicle.shown[topic][1]) for topic in news)
            sent.update({topic: vehicle.shown[topic][0] for topic in news})
            yield text
            continue
        try:
            await asyncio.wait_for(board.change(), KEEP_ALIVE_S)
        except asyncio.TimeoutError:
            # Nothing has changed, so a comment keeps the connection open.
            yield ": still here\n\n"


def _is_new(vehicle: Vehicle, topic: Topic, sent: dict[Topic, int]) -> bool:
    return topic in vehicle.shown and vehicle.shown[topic][0] != sent.get(topic)


def _event(topic: Topic, payload: str) -> str:
    """Return an event with one line of data. JSON and base64 contain no line breaks."""
    return f"event: {topic.value}\ndata: {payload}\n\n"
