"""The planner on routes of `bench220`, without an infraction."""

from __future__ import annotations

import csv

import pytest

from stucksolver.commands import main

pytest.importorskip("carla")

pytestmark = pytest.mark.integration


@pytest.fixture
def driven(route, tmp_path):
    """Drives one route. Returns its success and infractions, as the table has them."""
    words = ["evaluate", "--suite", "bench220", "--routes", route, "--recovery", "none", "--driver", "planner"]
    assert main([*words, "--jobs", "1", "--replays", "none", "--out", str(tmp_path)]) == 0
    with (tmp_path / "routes.csv").open(encoding="utf-8") as file:
        (row,) = csv.DictReader(file)
    return row["success"], row["infractions"]


@pytest.mark.parametrize(
    "route", [*(pytest.param(item, marks=pytest.mark.release) for item in ("1000", "1042")), "1242"]
)
def test_it_goes_round_what_blocks_its_lane_without_touching_anything(driven) -> None:
    assert driven == ("1", "")


@pytest.mark.slow
@pytest.mark.parametrize("route", ["1400", pytest.param("1431", marks=pytest.mark.release)])
def test_it_gives_doors_room_and_lets_an_emergency_vehicle_past(driven) -> None:
    assert driven == ("1", "")


@pytest.mark.slow
@pytest.mark.parametrize(
    "route", ["1084", *(pytest.param(item, marks=pytest.mark.release) for item in ("1132", "1184"))]
)
def test_it_joins_and_crosses_streams_that_brake_for_nobody(driven) -> None:
    assert driven == ("1", "")


@pytest.mark.release
@pytest.mark.parametrize("route", ["1064", "1083", "1191", "1332"])
def test_planner_waits_for_shortest_gap_in_flow(driven) -> None:
    """The planner waits for the shortest gap in a flow that has no others."""
    assert driven == ("1", "")
