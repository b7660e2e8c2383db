"""The client's traffic manager drives for thousands of ticks: it never hangs, keeps its lanes, and repeats itself.

CARLETTE_CLIENT_PYTHON and CARLETTE_CLIENT_VERSION name another interpreter and the version of its client.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from serving import free_port, running_server

pytestmark = pytest.mark.integration

pytest.importorskip("carla")

PYTHON = os.environ.get("CARLETTE_CLIENT_PYTHON", sys.executable)
VERSION = os.environ.get("CARLETTE_CLIENT_VERSION", "0.9.16")
WATCHDOG_S = 250


def traffic(port: int, cars: int, ticks: int) -> dict[str, object]:
    """A run in a process of its own; a hang ends as a failure."""
    program = str(Path(__file__).with_name("traffic_run.py"))
    command = [PYTHON, program, str(port), str(free_port()), str(cars), str(ticks)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=WATCHDOG_S)
    assert done.returncode == 0, done.stderr
    result: dict[str, object] = json.loads(done.stdout.splitlines()[-1])
    return result


def serve(map_name: str):
    return running_server("--map", map_name, "--client-version", VERSION, "--seed", "11")


@pytest.mark.release
def test_twenty_cars_drive_for_thousands_of_ticks_in_their_lanes(town01: Path) -> None:
    with serve(str(town01)) as port:
        result = traffic(port, 20, 2000)
    assert result["cars"] == 20
    assert result["moved"] == 20
    assert result["median_m"] < 0.05
    assert result["p95_m"] < 0.5


@pytest.mark.slow
def test_the_same_seed_drives_the_same_traffic_bit_for_bit() -> None:
    with serve("demo_town") as port:
        first, second = traffic(port, 10, 250), traffic(port, 10, 250)
    with serve("demo_town") as port:
        third = traffic(port, 10, 250)
    assert first["moved"] > 5
    assert first["digest"] == second["digest"] == third["digest"]
