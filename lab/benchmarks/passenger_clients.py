"""Effect of open pages on the control loop: one drive at 20 Hz, alternating with and without 50 listening pages.

```
python -m lab.benchmarks.passenger_clients --full                     # 5 minutes with 50 pages, 5 without
python -m lab.benchmarks.passenger_clients --seconds 60 --clients 20  # shorter
python -m lab.benchmarks.passenger_clients --smoke                    # a few seconds of each, to test that it works
```

A report of the late ticks is printed to standard error. Except with `--smoke`, the exit code is 1 if a tick was late
with pages. Most work for the pages is done in the server's process; the part left in the control loop is `page_work`.

A car is stopped behind a parked one. The real solver searches for a plan to pass it, and all contents of a page are
sent: thoughts and conversation, the bird's-eye view at 10 Hz, a camera image at 5 Hz. The server and the pages each
have their own process, on any cores of the machine. Slices with and without pages alternate, so that other load on the
machine affects both.
"""

from __future__ import annotations

import argparse
import asyncio
import io
import json
import multiprocessing
import os
import sys
import time
from dataclasses import dataclass, field
from importlib import import_module
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

TICK_S = 0.05
"""Period of the control loop (s)."""
CLIENTS = 50
"""Number of pages."""
SECONDS, SLICE_S = 300.0, 30.0
"""Duration with pages, and length of a slice (s)."""
SMOKE_S, SMOKE_SLICE_S = 4.0, 2.0
"""The same for a smoke test (s)."""
LATE_S = 0.05
"""Delay of its start beyond which a tick is late (s): one whole tick."""
VIEW_TICKS, PICTURE_TICKS = 2, 4
"""Ticks between two bird's-eye views and between two camera images."""
OPEN_S = 30.0
"""Time limit for opening all pages (s). Ours."""
PICTURE_PX = (800, 450)
"""Size of the camera image (px)."""
CORE_TESTS = Path(__file__).parents[2] / "packages" / "stucksolver" / "tests"
"""The small world of the core's tests, which the drive uses."""


@dataclass
class Half:
    """Ticks with or without pages: the delay of the start and the duration of the work of each (s)."""

    late_s: list[float] = field(default_factory=list)
    work_s: list[float] = field(default_factory=list)
    page_s: list[float] = field(default_factory=list)
    """Durations of the part of the work for pages (s)."""
    late: int = 0
    """Number of late ticks."""

    def figures(self) -> dict[str, float]:
        """Return counts, and times in milliseconds."""
        late, work, page = sorted(self.late_s), sorted(self.work_s), sorted(self.page_s)
        return {
            "ticks": len(late),
            "late": self.late,
            "behind_median_ms": 1000 * _quantile(late, 0.5),
            "behind_p99_ms": 1000 * _quantile(late, 0.99),
            "behind_worst_ms": 1000 * late[-1],
            "work_median_ms": 1000 * _quantile(work, 0.5),
            "work_p99_ms": 1000 * _quantile(work, 0.99),
            "page_work_median_ms": 1000 * _quantile(page, 0.5),
            "page_work_p99_ms": 1000 * _quantile(page, 0.99),
        }


class Car:
    """A world with its solver and its session at the server."""

    def __init__(self, desk: Any, vehicle: str) -> None:
        sys.path.insert(0, str(CORE_TESTS))
        worlds = import_module("worlds")
        from stucksolver import StuckSolver

        self._desk, self._vehicle, self._number = desk, vehicle, 0
        # The car never passes, because too little of the oncoming lane is in sight. It is immobilized in every tick.
        self._world = worlds.World(worlds.straight_road(), [worlds.thing("parked", 75.0)], sight_m=40.0)
        self._solver = StuckSolver(self._world.scene, clock="wall", on_event=desk.ear(vehicle))
        self._seat = desk.add(vehicle, self._solver)
        self._picture = _picture()

    def tick(self) -> float:
        """Do the work of a stack's loop in one tick; return the time spent on the page (s)."""
        world = self._world
        directive = self._solver.step(world.status(), world.surroundings)
        world.drive(directive)
        began = time.monotonic()
        self._show()
        return time.monotonic() - began

    def _show(self) -> None:
        world = self._world
        self._seat.tick(world.status(), world.scene)
        self._number += 1
        if self._number % VIEW_TICKS == 0:
            ego = [0, "car", "ego", 4.9, 1.85, world.x, world.y, 0.0]
            view = {"time": world.time_s, "speed": world.speed, "actors": [ego], "lights": [], "path": []}
            self._desk.show_view(self._vehicle, view)
        if self._number % PICTURE_TICKS == 0:
            self._desk.show_picture(self._vehicle, self._picture)

    def close(self) -> None:
        """Close the solver and the vehicle session."""
        self._solver.close()
        self._desk.leave(self._vehicle)


def measure(seconds: float, slice_s: float, clients: int = CLIENTS) -> dict[str, float]:
    """Measure with and without pages, `seconds` each.

    Raises:
        RuntimeError: Pages do not open or receive nothing.
    """
    from stucksolver_passenger.gateway import PassengerGateway
    from stucksolver_passenger.server.options import PageOptions
    from stucksolver_passenger.server.process import PassengerServer

    halves = {True: Half(), False: Half()}
    events, received = 0, 0
    with PassengerServer(PageOptions()) as server, PassengerGateway(server.address) as desk:
        car = Car(desk, "car-1")
        token = server.tokens.operator()  # a passenger's token opens few pages
        _drive(car, Half(), 2.0)  # warm-up: loads everything
        left_s = seconds
        while left_s > 0.0:
            for watched in (False, True):
                pages = Pages(server.port, token, clients) if watched else None
                if pages is not None:
                    _until_open(car, pages)
                _drive(car, halves[watched], min(slice_s, left_s))
                if pages is not None:
                    counts = pages.close()
                    events, received = events + sum(n for n, _ in counts), received + sum(size for _, size in counts)
                    if min(n for n, _ in counts) == 0:
                        raise RuntimeError("a page received no event: the server serves fewer pages than expected")
            left_s -= slice_s
        car.close()
    alone, with_pages = halves[False].figures(), halves[True].figures()
    compared = ("behind_median_ms", "behind_p99_ms", "work_median_ms", "work_p99_ms")
    return {
        "clients": clients,
        "cores": os.cpu_count() or 0,
        "load_of_the_machine": os.getloadavg()[0],
        "events_sent": events,
        "sent_mb": received / 1e6,
        **{f"without_{name}": value for name, value in alone.items()},
        **{f"with_{name}": value for name, value in with_pages.items()},
        **{f"ratio_{name.removesuffix('_ms')}": with_pages[name] / alone[name] for name in compared},
    }


def _drive(car: Car, half: Half, seconds: float) -> None:
    """Drive at 20 Hz in wall time. After a late tick the schedule restarts, so that the next one is not late, too."""
    due = time.monotonic()
    end = due + seconds
    while due < end:
        time.sleep(max(due - time.monotonic(), 0.0))
        began = time.monotonic()
        half.page_s.append(car.tick())
        half.late_s.append(began - due)
        half.late += began - due >= LATE_S
        half.work_s.append(time.monotonic() - began)
        due = max(due + TICK_S, time.monotonic() if began - due >= LATE_S else 0.0)


class Pages:
    """Listening pages in their own process, until they are closed."""

    def __init__(self, port: int, token: str, count: int) -> None:
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_listen, args=(theirs, port, token, count), daemon=True)
        self._process.start()
        theirs.close()

    @property
    def open(self) -> bool:
        """True if all pages have received their first event."""
        return self._ours.poll() and bool(self._ours.recv())

    def close(self) -> list[tuple[int, int]]:
        """Close the pages; return the number of events and bytes that each received."""
        self._ours.send("over")
        counts: list[tuple[int, int]] = self._ours.recv()
        self._process.join()
        return counts


def _until_open(car: Car, pages: Pages) -> None:
    end = time.monotonic() + OPEN_S
    while not pages.open:
        if time.monotonic() > end:
            raise RuntimeError(f"the pages were not open after {OPEN_S:g} s")
        car.tick()
        time.sleep(TICK_S)


def _listen(theirs: Connection, port: int, token: str, count: int) -> None:
    """Run the pages' process. It represents phones, which take no time of the vehicle's cores."""
    os.nice(19)
    counts = [[0, 0] for _ in range(count)]

    async def one(number: int) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=1 << 22)
        lines = ["GET /api/vehicles/car-1/stream HTTP/1.1", f"host: 127.0.0.1:{port}", f"authorization: Bearer {token}"]
        writer.write(("\r\n".join(lines) + "\r\n\r\n").encode())
        while data := await reader.read(1 << 16):
            counts[number][0] += data.count(b"event: ")
            counts[number][1] += len(data)

    async def run() -> None:
        tasks = [asyncio.create_task(one(number)) for number in range(count)]
        while any(events == 0 for events, _ in counts):
            await asyncio.sleep(0.05)
        for each in counts:
            each[:] = [0, 0]
        theirs.send(True)
        while not theirs.poll():
            await asyncio.sleep(0.1)
        for task in tasks:
            task.cancel()

    asyncio.run(run())
    theirs.send([(events, size) for events, size in counts])


def _picture() -> bytes:
    from PIL import Image

    file = io.BytesIO()
    Image.effect_noise(PICTURE_PX, 40.0).save(file, "JPEG", quality=60)
    return file.getvalue()


def _quantile(ordered: list[float], share: float) -> float:
    return ordered[min(int(share * len(ordered)), len(ordered) - 1)]


def run(smoke: bool) -> dict[str, float]:
    """Return all metrics. With `smoke`, a few seconds only: a test that it runs, without a result on late ticks."""
    return measure(SMOKE_S, SMOKE_SLICE_S) if smoke else measure(SECONDS, SLICE_S)


def report(figures: dict[str, float]) -> str:
    """Return the late ticks with and without pages, one line each."""
    head = f"{figures['clients']:.0f} pages, machine load {figures['load_of_the_machine']:.1f}"
    rows = [
        f"{name} pages: {figures[f'{name}_late']:.0f} of {figures[f'{name}_ticks']:.0f} ticks late, "
        f"the worst {figures[f'{name}_behind_worst_ms']:.1f} ms; "
        f"work for the page {figures[f'{name}_page_work_p99_ms']:.2f} ms (99 %)"
        for name in ("without", "with")
    ]
    return "\n".join([head, *rows])


def main() -> int:
    """Print all metrics as JSON, and the report; return 1 if a tick was late with pages, except with `--smoke`."""
    parser = argparse.ArgumentParser(description="Ticks of the control loop with and without listening pages.")
    lengths = parser.add_mutually_exclusive_group()
    lengths.add_argument("--smoke", action="store_true", help="a few seconds only")
    lengths.add_argument("--full", action="store_true", help="five minutes with 50 pages and five without (default)")
    lengths.add_argument("--seconds", type=float, default=SECONDS, help="duration with pages, and again without")
    parser.add_argument("--clients", type=int, default=CLIENTS, help="number of pages")
    options = parser.parse_args()
    seconds, slice_s = (SMOKE_S, SMOKE_SLICE_S) if options.smoke else (options.seconds, SLICE_S)
    figures = measure(seconds, slice_s, options.clients)
    print(json.dumps(figures, indent=2))
    print(report(figures), file=sys.stderr)
    return 0 if options.smoke else int(figures["with_late"] > 0)


if __name__ == "__main__":
    sys.exit(main())
