"""Runs the benchmarks: `python -m lab.benchmarks [--smoke] [NAME ...]`. Prints one JSON object per benchmark."""

from __future__ import annotations

import argparse
import importlib
import json

NAMES = (
    "solver_overhead",
    "addon_overhead",
    "driver_ticks",
    "query_overhead",
    "search_latency",
    "answer_forms",
    "path_search",
    "perception_stages",
    "passenger_clients",
    "carlette_ticks",
    "carlette_forks",
    "carlette_camera",
    "carlette_lidar",
    "carlette_sensors",
)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m lab.benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", choices=[*NAMES, []], help="benchmarks to run (default: all)")
    parser.add_argument("--smoke", action="store_true", help="few repetitions: only tests that the benchmarks run")
    options = parser.parse_args()
    for name in options.names or NAMES:
        figures = importlib.import_module(f"lab.benchmarks.{name}").run(options.smoke)
        rounded = {key: float(f"{value:.4g}") for key, value in figures.items()}
        print(json.dumps({name: rounded}, indent=2), flush=True)


if __name__ == "__main__":
    main()
