"""Time to fork a world, and its tick rate with carlette's own traffic, without a client or sockets."""

from __future__ import annotations

import time

from carlette.in_process import Traffic, World, open_world, populate

FLEETS = (0, 20, 50)
"""Numbers of cars."""
FORKS = 50
"""Number of forks whose median counts."""


def run(smoke: bool) -> dict[str, float]:
    """Return `fork_ms_*` (median), `ticks_per_s_*` and `ratio_*` with 0, 20 and 50 cars.

    A ratio compares the rate with that of the empty town.
    """
    ticks = 100 if smoke else 2000
    figures: dict[str, float] = {}
    for cars in FLEETS:
        world = open_world("demo_town", seed=1)
        populate(world, cars, seed=1)
        world.traffic = Traffic(world, seed=1) if cars else None
        _seconds(world, ticks // 10)
        figures[f"fork_ms_{cars}_cars"] = _fork_ms(world)
        figures[f"ticks_per_s_{cars}_cars"] = ticks / _seconds(world, ticks)
    for cars in FLEETS[1:]:
        figures[f"ratio_{cars}_cars"] = figures[f"ticks_per_s_{cars}_cars"] / figures["ticks_per_s_0_cars"]
    return figures


def _seconds(world: World, ticks: int) -> float:
    """Return the CPU time (s), which is less affected by other programs on the machine."""
    start = time.process_time()
    for _ in range(ticks):
        world.tick()
    return time.process_time() - start


def _fork_ms(world: World) -> float:
    times = []
    for _ in range(FORKS):
        start = time.perf_counter()
        world.fork()
        times.append(time.perf_counter() - start)
    return 1e3 * sorted(times)[FORKS // 2]
