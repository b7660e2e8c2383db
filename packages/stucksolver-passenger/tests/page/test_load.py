"""Fifty pages at once, while the vehicle drives."""

from __future__ import annotations

import asyncio

import pytest
from riding import DRAWING, Riding
from sitting import PASSENGER_ASKED, parked

from stucksolver_passenger.server.options import PageOptions
from stucksolver_passenger.server.process import PassengerServer

pytestmark = pytest.mark.integration
pytest.importorskip("uvicorn", reason="the extra `passenger` is not installed")
httpx = pytest.importorskip("httpx")

CLIENTS = 50
EVENTS, TICKS = 9, 21


async def pages(server, vehicle, count, is_over):
    """Open so many until it is over; events that each got."""
    headers = {"authorization": f"Bearer {server.tokens.operator()}"}  # a passenger's token opens few pages
    limits = httpx.Limits(max_connections=None)
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{server.port}", headers=headers, limits=limits) as client:
        return await asyncio.gather(*(one_page(client, vehicle, is_over) for _ in range(count)))


async def one_page(client, vehicle, is_over):
    events = 0
    async with client.stream("GET", f"/api/vehicles/{vehicle}/stream", timeout=60.0) as answer:
        assert answer.status_code == 200
        async for line in answer.aiter_lines():
            events += line.startswith("event:")
            if events >= EVENTS and is_over():
                return events
    raise AssertionError("the stream ended by itself")


@pytest.mark.release
@pytest.mark.slow
def test_fifty_pages_are_served_at_once_while_the_vehicle_drives():
    """How late the loop's ticks begin meanwhile is for docs/passenger.md, not for a test: machines are noisy."""
    with (
        PassengerServer(PageOptions(drawing=DRAWING)) as server,
        Riding(server, "watched", parked(), PASSENGER_ASKED, tempo=1.0) as ride,
    ):
        began = len(ride.lateness_s)
        # If the vehicle stood still meanwhile, or a page got nothing, this would never be over.
        got = asyncio.run(pages(server, "watched", CLIENTS, lambda: len(ride.lateness_s) >= began + TICKS))
    assert len(got) == CLIENTS and min(got) >= EVENTS
