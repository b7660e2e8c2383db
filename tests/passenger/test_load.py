"""Fifty pages at once, while the vehicle drives."""

from __future__ import annotations

import asyncio
import time

import pytest
from riding import DRAWING, Riding
from sitting import PASSENGER_ASKED, parked

from stucksolver.passenger import PageOptions, PassengerServer

pytestmark = pytest.mark.integration
pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")
httpx = pytest.importorskip("httpx")

CLIENTS = 50
SECONDS = 4.0


async def pages(server, vehicle, count):
    """Open so many for a while; events that each got."""
    headers = {"authorization": f"Bearer {server.tokens.passenger(vehicle)}"}
    limits = httpx.Limits(max_connections=None)
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{server.port}", headers=headers, limits=limits) as client:
        return await asyncio.gather(*(one_page(client, vehicle) for _ in range(count)))


async def one_page(client, vehicle):
    events, end = 0, time.monotonic() + SECONDS
    async with client.stream("GET", f"/api/vehicles/{vehicle}/stream", timeout=30.0) as answer:
        assert answer.status_code == 200
        async for line in answer.aiter_lines():
            events += line.startswith("event:")
            if time.monotonic() > end:
                return events
    raise AssertionError("the stream ended by itself")


def test_fifty_pages_are_served_at_once_while_the_vehicle_drives():
    """How late the loop's ticks begin meanwhile is for docs/passenger.md, not for a test: machines are noisy."""
    with (
        PassengerServer(PageOptions(drawing=DRAWING)) as server,
        Riding(server, "watched", parked(), PASSENGER_ASKED, tempo=1.0) as ride,
    ):
        time.sleep(1.0)
        began = len(ride.lateness_s)
        got = asyncio.run(pages(server, "watched", CLIENTS))
        ticks = len(ride.lateness_s) - began
    assert len(got) == CLIENTS and min(got) > 2 * SECONDS
    assert ticks > 5 * SECONDS, "the vehicle went on driving"
