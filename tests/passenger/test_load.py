"""Fifty pages at once do not make the control loop late."""

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

CLIENTS, SECONDS = 50, 6.0
LATE_S = 0.025
"""Half a tick of 20 Hz."""
MORE_LATE = 0.02
"""Of all ticks: what a busy machine may make late by itself, from one measurement to the next."""


def measured(server, vehicle, clients):
    """Shares of ticks that began late while so many pages were open, and how many events each of them got."""
    with Riding(server, vehicle, parked(), PASSENGER_ASKED, tempo=1.0) as ride:
        time.sleep(1.0)
        began = len(ride.lateness_s)
        got = asyncio.run(pages(server, vehicle, clients))
        late = [one for one in ride.lateness_s[began:] if one >= LATE_S]
        return len(late) / max(len(ride.lateness_s) - began, 1), got


async def pages(server, vehicle, count):
    """Open so many for a while; events that each got."""
    if not count:
        await asyncio.sleep(SECONDS)
        return []
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


def test_fifty_pages_do_not_make_the_control_loop_late():
    with PassengerServer(PageOptions(drawing=DRAWING)) as server:
        alone, _ = measured(server, "alone", 0)
        late, got = measured(server, "watched", CLIENTS)
    assert len(got) == CLIENTS and min(got) > 2 * SECONDS
    assert late <= alone + MORE_LATE, f"{100 * late:.1f} % of the ticks were late, {100 * alone:.1f} % without pages"
