"""Soak test of one server: loads towns in turn, with traffic and an ego, and checks every measurement.

```
python -m lab.benchmarks.carlette_soak_sensors --minutes 120 --ledger soak_sensors.jsonl
```

Each round is a separate client process. It loads a town, spawns 20 cars of the traffic manager and an ego with a
camera, a LiDAR and the small sensors, ticks, and destroys everything. The program prints progress to standard error and
one line of JSON to standard output. The ledger gets one line per round; the next run with the same ledger continues at
its end.
"""

from __future__ import annotations

import argparse
import itertools
import json
import multiprocessing
import statistics
import sys
import tempfile
import time
from pathlib import Path
from queue import Empty, Queue
from typing import IO, TYPE_CHECKING, Any

from lab.benchmarks.carlette_clients import (
    STEP_S,
    free_port,
    listen,
    running_server,
    spawn_shuffled,
    synchronous_manager,
)
from lab.benchmarks.carlette_sensors import CAMERA, LIDAR, SMALL
from lab.benchmarks.carlette_soak import count_rescues, resident_mb
from stucksolver_eval.simulator_server import set_synchronous

if TYPE_CHECKING:
    import carla

TOWNS = ("demo_town", "grid_town", "interurban", "Town01", "Town04", "Town10HD")
CARS = 20
"""Number of cars of the traffic manager."""
SENSORS = (CAMERA, LIDAR, *SMALL)
TICKS = 300
"""Number of ticks per round."""
LONGEST_ROUND_S = 900.0
"""Time after which a round counts as hanging (s)."""
CLIENT_TIMEOUT_S = 60.0
"""Timeout of the client's calls (s)."""
LONGEST_WAIT_S = 120.0
"""Time to wait for one measurement (s)."""
COUNTED = ("ticks", "missing", "misframed", "surplus", "collisions")
"""Counts per round. `missing` measurements never came; `misframed` ones had a frame other than the tick's."""
ENDINGS = ("crashed", "failed", "hung")
"""Failures of clients: killed by a signal, ended by an exception such as a timeout, or hung."""


def soak(minutes: float, ledger: Path, ticks: int, towns: tuple[str, ...] = TOWNS) -> dict[str, Any]:
    """Run rounds until `minutes` are over; return sums over all rounds in the `ledger`."""
    done = len(_rounds(ledger))
    with tempfile.TemporaryFile("a+") as log, running_server(towns[0], log=log) as (port, server):
        deadline = time.monotonic() + 60.0 * minutes
        for number, town in zip(itertools.count(done), itertools.cycle(towns), strict=False):
            if time.monotonic() >= deadline:
                break
            found = {"round": number, "town": town, **_round(port, town, ticks, number)}
            found |= {"rss_mb": round(resident_mb(server.pid), 1), "rescues": count_rescues(log)}
            with ledger.open("a") as lines:
                lines.write(json.dumps(found) + "\n")
            print(json.dumps(found), file=sys.stderr, flush=True)
        _show_errors(log)
    return _summary(_rounds(ledger))


def _rounds(ledger: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in ledger.read_text(encoding="utf-8").splitlines()] if ledger.exists() else []


def _round(port: int, town: str, ticks: int, seed: int) -> dict[str, Any]:
    """Return the counts of one client. A client that crashes or hangs is counted and killed."""
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    client = context.Process(target=_drive, args=(port, town, ticks, seed, sender), daemon=True)
    start = time.monotonic()
    client.start()
    sender.close()
    ending, found = "hung", dict.fromkeys(COUNTED, 0)
    try:
        if receiver.poll(LONGEST_ROUND_S):
            found, ending = receiver.recv(), ""
    except EOFError:
        # The client ended without a result: it crashed or raised an error.
        client.join()
        ending = "crashed" if (client.exitcode or 0) < 0 else "failed"
    finally:
        client.kill()
        client.join()
    return {**found, **{text: int(text == ending) for text in ENDINGS}, "seconds": round(time.monotonic() - start, 1)}


def _drive(port: int, town: str, ticks: int, seed: int, result: Any) -> None:
    import carla

    client = carla.Client("127.0.0.1", port)
    client.set_timeout(CLIENT_TIMEOUT_S)
    world = client.load_world(town)
    set_synchronous(world, STEP_S)
    port = free_port()
    manager = synchronous_manager(client, port, seed)
    cars = spawn_shuffled(world, 1 + CARS, seed)
    world.tick()
    for car in cars:
        car.set_autopilot(True, port)
    sensors = [listen(world, cars[0], type_id, attributes) for type_id, attributes in SENSORS]
    found = _tick(world, ticks, {item.type_id: queue for item, queue in sensors})
    for sensor, _ in sensors:
        sensor.destroy()
    client.apply_batch_sync([carla.command.DestroyActor(car) for car in cars])
    # Destroy outside of the batch: it would hold Python's lock while waiting, and the sensors' threads may need it
    # to end.
    world.tick()
    manager.set_synchronous_mode(False)
    set_synchronous(world, None)
    result.send(found)


def _tick(world: carla.World, ticks: int, queues: dict[str, Queue[int]]) -> dict[str, float]:
    """Check that each sensor sends one measurement per tick, of its frame. Collisions are only counted."""
    found: dict[str, float] = dict.fromkeys(COUNTED, 0)
    hits = queues.pop("sensor.other.collision")
    longest_s = first_s = 0.0
    for tick in range(ticks):
        frame = world.tick()
        start = time.monotonic()
        frames = [_next(queue) for queue in queues.values()]
        found["missing"] += frames.count(None)
        found["misframed"] += sum(item not in (None, frame) for item in frames)
        found["ticks"] += 1
        waited_s = time.monotonic() - start
        first_s, longest_s = (waited_s, longest_s) if tick == 0 else (first_s, max(longest_s, waited_s))
    found |= {"surplus": sum(item.qsize() for item in queues.values()), "collisions": hits.qsize()}
    return {**found, "first_wait_s": round(first_s, 2), "longest_wait_s": round(longest_s, 2)}


def _next(queue: Queue[int]) -> int | None:
    try:
        return queue.get(timeout=LONGEST_WAIT_S)
    except Empty:
        # The caller counts the missing measurement.
        return None


def _show_errors(log: IO[str]) -> None:
    """Print the end of the server's log, without its rescues."""
    log.seek(0)
    others = [line for line in log if "lost wake-up" not in line]
    print("".join(others[-100:]), file=sys.stderr, flush=True)


def _summary(rounds: list[dict[str, Any]]) -> dict[str, Any]:
    memory = [item["rss_mb"] for item in rounds]
    total = {name: sum(item[name] for item in rounds) for name in (*COUNTED, *ENDINGS)}
    return {
        "rounds": len(rounds),
        **total,
        "simulated_s": round(total["ticks"] * STEP_S, 1),
        "measurements": total["ticks"] * (len(SENSORS) - 1) - total["missing"],
        "hours": round(sum(item["seconds"] for item in rounds) / 3600.0, 2),
        "longest_wait_s": max(item.get("longest_wait_s", 0.0) for item in rounds),
        "longest_first_wait_s": max(item.get("first_wait_s", 0.0) for item in rounds),
        "rss_mb": {"first": memory[0], "median": statistics.median(memory), "last": memory[-1], "most": max(memory)},
    }


def main() -> None:
    """Print one line of JSON. The exit code is 1 if a measurement was missing, misframed or surplus."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=120.0)
    parser.add_argument("--ticks", type=int, default=TICKS, help="ticks per round")
    parser.add_argument("--ledger", type=Path, default=Path("soak_sensors.jsonl"))
    parser.add_argument("--towns", nargs="+", default=TOWNS, metavar="TOWN")
    options = parser.parse_args()
    result = soak(options.minutes, options.ledger, options.ticks, tuple(options.towns))
    print(json.dumps(result), flush=True)
    sys.exit(bool(result["missing"] or result["misframed"] or result["surplus"]))


if __name__ == "__main__":
    main()
