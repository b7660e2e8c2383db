"""Checks for slowdowns: `python -m lab.benchmarks.against [--keep]` compares ratios with those in baseline.json.

Absolute times differ between machines, so each metric of `solver_overhead` is divided by the time of an empty loop
measured in the same run. The minimum of several rounds counts, because other load only adds time. Machines still differ
in their caches and in the relative speed of numpy and plain Python. The threshold is therefore wide: it finds an
algorithm that has become worse, not a change of 10 %.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path

from lab.benchmarks import solver_overhead

BASELINE = Path(__file__).with_name("baseline.json")
ROUNDS = 5
"""Number of rounds whose minimum counts."""
MAX_FACTOR = 2.5
"""Ratio to the baseline above which a metric is an error.

On a two-core machine with a load of ten, four runs of five rounds were within a factor of 1.7.
"""
LOOP = "us_empty_loop"


def measured(rounds: int = ROUNDS) -> dict[str, float]:
    """Return each metric as a multiple of the empty loop's time; the minimum over the rounds."""
    least: dict[str, float] = {}
    for _ in range(rounds):
        figures = solver_overhead.run(smoke=True)
        for name, value in figures.items():
            if name.startswith("us_") and name != LOOP:
                ratio = value / figures[LOOP]
                least[name] = min(least.get(name, ratio), ratio)
    return least


def slower(now: Mapping[str, float], before: Mapping[str, float]) -> list[str]:
    """Return one line for each metric that is too slow or no longer measured."""
    found = [f"{name}: no longer measured; if this is intended, run --keep" for name in before if name not in now]
    for name, value in now.items():
        if name in before and value > MAX_FACTOR * before[name]:
            found.append(f"{name}: {value / before[name]:.1f} times the baseline, more than {MAX_FACTOR}")
    return found


def main() -> int:
    """Return 1 if a metric is too slow or missing."""
    parser = argparse.ArgumentParser(prog="python -m lab.benchmarks.against", description=__doc__)
    parser.add_argument("--keep", action="store_true", help="write the ratios of this machine as the new baseline")
    now = measured()
    if parser.parse_args().keep:
        BASELINE.write_text(
            json.dumps({name: float(f"{ratio:.3g}") for name, ratio in now.items()}, indent=1) + "\n", encoding="utf-8"
        )
        return 0
    before = json.loads(BASELINE.read_text(encoding="utf-8"))
    for name, ratio in now.items():
        change = f"{ratio / before[name]:.2f} times the baseline" if name in before else "new"
        print(f"{name}: {ratio:.4g} empty loops, {change}")
    found = slower(now, before)
    print("\n".join(f"error: {line}" for line in found), file=sys.stderr, end="\n" if found else "")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
