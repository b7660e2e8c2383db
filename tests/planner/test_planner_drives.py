"""The planner on routes of `dev` that its elder brother does not finish."""

from __future__ import annotations

import csv
import subprocess
import sys

import pytest

pytest.importorskip("carla")

pytestmark = pytest.mark.integration


@pytest.mark.parametrize("route", ["1000", "1042", "1242"])
def test_it_goes_round_what_blocks_its_lane_without_touching_anything(route, tmp_path) -> None:
    command = "import sys; from stucksolver.cli import main; sys.exit(main())"
    words = ["evaluate", "--suite", "dev", "--routes", route, "--recovery", "none", "--driver", "planner"]
    more = ["--jobs", "1", "--replays", "none", "--out", str(tmp_path / "out")]
    done = subprocess.run([sys.executable, "-c", command, *words, *more], capture_output=True, text=True, timeout=280)
    assert done.returncode == 0, done.stderr[-2000:]
    with (tmp_path / "out" / "routes.csv").open(encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    assert (row["success"], row["infractions"]) == ("1", "")
