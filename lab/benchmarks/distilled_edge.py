"""The student on a small computer: one core and a limit of 1 GiB of memory, in a process that has nothing else.

The process loads the solver, the guard, the rules and the student, and decides the scenes of `distilled_latency`. It is
pinned to one core. Its address space is limited, which is stricter than a limit of the memory in use: reserved memory
counts as well. `ms_*` are milliseconds of wall time for a decision, `cpu_ms_*` of processor time, which other load on
that core changes less. `mb_peak` is the most memory in use (VmHWM), `mb_reserved` the most address space (VmPeak), both
in units of 10^6 bytes. `*_words` is the same with the interpreter of a passenger's utterances.
"""

from __future__ import annotations

import json
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path

LIMIT_BYTES = 1 << 30
"""Limit of the address space (bytes): 1 GiB, the memory of the smallest boards on which onnxruntime runs."""
ROOT = Path(__file__).parents[2]
"""Root of the repository."""


def run(smoke: bool) -> dict[str, float]:
    """Return the metrics of this module's docstring."""
    alone, words = (_measured("smoke" if smoke else "full", more) for more in ("", "words"))
    figures = alone | {f"{name}_words": words[name] for name in ("mb_peak", "mb_reserved")}
    return figures | {"ms_reading": words["ms_reading"]}


def _measured(extent: str, more: str) -> dict[str, float]:
    """Return the measurements of a new process.

    Raises:
        RuntimeError: The process fails, for example because of too little memory.
    """
    paths = os.pathsep.join(filter(None, sys.path))
    result = subprocess.run(
        [sys.executable, "-m", "lab.benchmarks.distilled_edge", extent, more],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    if result.returncode:
        raise RuntimeError(f"with {LIMIT_BYTES >> 20} MiB the student fails:\n{result.stderr[-2000:]}")
    return dict(json.loads(result.stdout))


def _measure(smoke: bool, words: bool) -> dict[str, float]:
    """Limit this process, load the student and query it."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
    began = time.perf_counter()
    from lab.benchmarks.distilled_latency import questions
    from stucksolver_language.student import DistilledReasoner

    reasoner, asked = DistilledReasoner(), list(questions(20 if smoke else 400))
    reasoner.decide(asked[0])
    figures = {"s_start": time.perf_counter() - began}
    times, spent = [], []
    for request in asked[1:]:
        wall, cpu = time.perf_counter(), time.process_time()
        reasoner.decide(request)
        times.append(1e3 * (time.perf_counter() - wall))
        spent.append(1e3 * (time.process_time() - cpu))
    for name, found in (("ms", times), ("cpu_ms", spent)):
        hundredths = statistics.quantiles(found, n=100)
        figures |= {f"{name}_p50": hundredths[49], f"{name}_p95": hundredths[94]}
    if words:
        figures["ms_reading"] = _reading_ms(2 if smoke else 40)
    unwanted = {"carla", "carlette", "torch", "stucksolver_eval"} & set(sys.modules)
    if unwanted:
        raise RuntimeError(f"unnecessary modules were loaded: {sorted(unwanted)}")
    return figures | {"mb_peak": _status_mb("VmHWM"), "mb_reserved": _status_mb("VmPeak")}


def _reading_ms(times: int) -> float:
    """Return the median time of an interpretation (ms), after a first one, which loads the weights."""
    from stucksolver_language.intent.network import NetworkInterpreter

    reader, took = NetworkInterpreter(), []
    for number in range(times + 1):
        began = time.perf_counter()
        reader.read(f"please go round the {number + 2} parked cars on the left", "Standing behind a stopped car.")
        took.append(1e3 * (time.perf_counter() - began))
    return statistics.median(took[1:])


def _status_mb(name: str) -> float:
    """Return a line of this process's status (10^6 bytes). The kernel counts it from the start of the program."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) for line in lines if line.startswith(f"{name}:")) * 1024 / 1e6


if __name__ == "__main__":
    print(json.dumps(_measure("smoke" in sys.argv, "words" in sys.argv)))
