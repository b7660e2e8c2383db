"""Fuzzes a server for a given time, and checks that it does not crash, hang, or block a well-behaved client.

```
python -m lab.benchmarks.carlette_fuzz --minutes 10
```

It sends the same input as `packages/carlette/tests/fuzz`, with a new seed each time: calls with random arguments,
batches, noise on both ports, connections that end with a reset. After each, a well-behaved client must get its tick and
a snapshot of finite numbers. It prints progress to standard error and one line of JSON to standard output. A failure
names its seed.
"""

from __future__ import annotations

import argparse
import json
import random
import socket
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from lab.benchmarks.carlette_clients import running_server
from lab.benchmarks.carlette_soak import resident_mb

TESTS = Path(__file__).resolve().parents[2] / "packages" / "carlette" / "tests"
"""Folder of the fuzzing code."""
REPORT_S = 30.0
"""Time between two reports (s)."""
MOST_NOISE_BYTES = 400
"""Maximum length of one noise message (bytes)."""
OURS = "Traceback"
LOG = "errors.log"


def fuzz(minutes: float, seed: int) -> dict[str, Any]:
    """Return the counts of the inputs, the number of internal errors in the server's log, and its memory (MB)."""
    sys.path[:0] = [str(TESTS), str(TESTS / "fuzz")]
    nonsense = __import__("nonsense")
    counts: Counter[str] = Counter()
    end = time.monotonic() + 60.0 * minutes
    with (
        tempfile.TemporaryDirectory() as folder,
        (Path(folder) / LOG).open("a") as log_file,
        running_server(log=log_file, folder=Path(folder)) as (port, server),
    ):
        log = Path(folder) / LOG
        healthy, warm_mb, reported = nonsense.Healthy(port), 0.0, time.monotonic()
        while time.monotonic() < end:
            seed += 1
            try:
                _one(nonsense, port, random.Random(seed), counts)
                healthy.check()
            except (AssertionError, OSError) as error:
                last = log.read_text(errors="replace", encoding="utf-8")[-2000:]
                raise SystemExit(f"{last}\nseed {seed}: {error!r}; exit status {server.poll()}") from error
            if time.monotonic() - reported > REPORT_S:
                reported, warm_mb = time.monotonic(), warm_mb or resident_mb(server.pid)
                print(f"seed {seed}: {dict(counts)}, {resident_mb(server.pid):.0f} MB", file=sys.stderr, flush=True)
        errors = log.read_text(errors="replace", encoding="utf-8").count(OURS)
        memory = {"memory_mb_warm": warm_mb, "memory_mb_end": resident_mb(server.pid)}
        return {"minutes": minutes, **counts, "checks": sum(counts.values()), "errors_in_log": errors, **memory}


def _one(nonsense: Any, port: int, chance: random.Random, counts: Counter[str]) -> None:
    kind = chance.choice(("calls", "batch", "noise", "cut"))
    counts[kind] += 1
    if kind == "noise":
        _say(nonsense, port + chance.randrange(2), chance.randbytes(chance.randrange(MOST_NOISE_BYTES)), chance)
        return
    if kind == "cut":
        request = nonsense.packed_request((chance.choice(nonsense.method_names()), chance.randrange(2**32)))
        _say(nonsense, port, request[: chance.randrange(1 + len(request))], chance)
        return
    raw = nonsense.Raw(port)
    actors = nonsense.actor_ids(raw)
    if kind == "batch":
        raw.call("apply_batch", nonsense.likely_commands(chance, actors), chance.random() < 0.2)
    else:
        for _ in range(20):
            method = chance.choice(nonsense.method_names())
            raw.call(method, *nonsense.likely_arguments(chance, method, actors))
    if chance.random() < 0.1:
        raw.call("load_new_episode", "", True, 0)
    raw.socket.close()


def _say(nonsense: Any, port: int, data: bytes, chance: random.Random) -> None:
    with socket.create_connection(("127.0.0.1", port), timeout=5) as sock:
        if chance.random() < 0.5:
            nonsense.resets(sock)
        sock.sendall(data)


def main() -> None:
    """Print one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(json.dumps(fuzz(options.minutes, options.seed)), flush=True)


if __name__ == "__main__":
    main()
