"""Thousands of ticks of the client's traffic manager against carlette: counts hangs and rescues.

```
python -m lab.benchmarks.carlette_soak --ticks 200000 --cars 20 --map demo_town --ledger soak.jsonl
```

The client runs in its own process, and the server logs its rescues. The program prints progress to standard error and
one line of JSON to standard output. With a ledger the run can be stopped at any time: the next run with the same ledger
does the missing ticks, and both are counted together.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import re
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import IO, Any

from lab.benchmarks.carlette_clients import STEP_S, running_server, spawn_shuffled, synchronous_manager
from stucksolver_eval.simulator_server import set_synchronous

MANAGER_PORT = 8771
"""Port of the traffic manager."""
HANG_S = 30.0
"""Time without a reported tick after which a client counts as hanging (s). A rescue takes about half a second."""
REPORT_TICKS = 500
"""Number of ticks between two reports."""
WOKEN = "from a lost wake-up"
COUNTED = ("ticks", "hangs", "rescues")


def soak(ticks: int, cars: int, town: str, seed: int, ledger: Path | None = None) -> dict[str, Any]:
    """Run until `ticks` ticks are done or the client hangs; return counts over this run and those in the `ledger`."""
    earlier = Counter[str]()
    for line in ledger.read_text(encoding="utf-8").splitlines() if ledger and ledger.exists() else ():
        earlier.update(json.loads(line))
    ticks = max(ticks - earlier["ticks"], 0)
    result = _run(ticks, cars, town, seed, ledger)
    counted = {name: result[name] + earlier[name] for name in COUNTED}
    return {**result, **counted, "rescues_per_10000": 1e4 * counted["rescues"] / max(counted["ticks"], 1)}


def _run(ticks: int, cars: int, town: str, seed: int, ledger: Path | None) -> dict[str, Any]:
    with tempfile.TemporaryFile("a+") as log, running_server(town, log=log) as (port, server):
        receiver, sender = multiprocessing.get_context("spawn").Pipe(duplex=False)
        arguments = (port, cars, ticks, seed, sender)
        client = multiprocessing.get_context("spawn").Process(target=_drive, args=arguments, daemon=True)
        start = time.perf_counter()
        client.start()
        sender.close()
        done, moved_m, hung, woken = 0, 0.0, False, 0
        try:
            while done < ticks:
                if not receiver.poll(HANG_S):
                    hung = True
                    _note(ledger, ticks=0, hangs=1, rescues=0)
                    break
                before = done, woken
                (done, moved_m), woken = receiver.recv(), count_rescues(log)
                _note(ledger, ticks=done - before[0], hangs=0, rescues=woken - before[1])
                print(f"{town}: {done} of {ticks} ticks, {woken} rescues", file=sys.stderr, flush=True)
        except EOFError:
            raise RuntimeError(f"the client ended after about {done} ticks; see its messages") from None
        finally:
            client.kill()
            client.join()
        seconds = time.perf_counter() - start
        return {
            "map": town,
            "cars": cars,
            "ticks": done,
            "hangs": int(hung),
            "rescues": count_rescues(log),
            "ticks_per_s": done / seconds,
            "mean_distance_m": moved_m / max(cars, 1),
            "server_memory_mb": resident_mb(server.pid),
        }


def _note(ledger: Path | None, **counts: int) -> None:
    if ledger:
        with ledger.open("a") as lines:
            lines.write(json.dumps(counts) + "\n")


def count_rescues(log: IO[str]) -> int:
    log.seek(0)
    return sum(WOKEN in line for line in log)


def resident_mb(pid: int) -> float:
    """Return the resident memory of a process on this machine (MB)."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    return int(re.search(r"VmRSS:\s+(\d+) kB", status)[1]) * 1024 / 1e6  # type: ignore[index]


def _drive(port: int, cars: int, ticks: int, seed: int, result: Any) -> None:
    """Tick a town with traffic; report the number of ticks and the total distance of all cars (m)."""
    import carla

    client = carla.Client("127.0.0.1", port)
    client.set_timeout(HANG_S)
    world = client.get_world()
    set_synchronous(world, STEP_S)
    synchronous_manager(client, MANAGER_PORT, seed)
    fleet = spawn_shuffled(world, cars, seed)
    world.tick()
    for car in fleet:
        car.set_autopilot(True, MANAGER_PORT)
    moved_m = 0.0
    for tick in range(1, ticks + 1):
        world.tick()
        snapshot = world.get_snapshot()
        there = [item for item in (snapshot.find(car.id) for car in fleet) if item is not None]
        moved_m += STEP_S * sum(item.get_velocity().length() for item in there)
        if tick % REPORT_TICKS == 0 or tick == ticks:
            result.send((tick, moved_m))


def main() -> None:
    """Print one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ticks", type=int, default=20000)
    parser.add_argument("--cars", type=int, default=20)
    parser.add_argument("--map", default="demo_town", help="a town or an .xodr file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ledger", type=Path, help="file with the counts of interrupted runs")
    options = parser.parse_args()
    result = soak(options.ticks, options.cars, options.map, options.seed, options.ledger)
    print(json.dumps(result), flush=True)
    sys.exit(bool(result["hangs"]))


if __name__ == "__main__":
    main()
