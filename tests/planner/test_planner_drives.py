"""The planner on routes of `bench220`, without an infraction."""

from __future__ import annotations

import csv

import pytest

from stucksolver.cli import main

pytest.importorskip("carla")

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def driven(request, tmp_path_factory):
    """Success and infractions of each route that is tested now, as the table has them; one command drives them all."""
    routes = [one.callspec.params["route"] for one in request.session.items if one.path == request.path]
    out = tmp_path_factory.mktemp("planner")
    words = [
        "evaluate",
        "--suite",
        "bench220",
        "--routes",
        ",".join(routes),
        "--recovery",
        "none",
        "--driver",
        "planner",
    ]
    assert main([*words, "--driver", "planner", "--jobs", "1", "--replays", "none", "--out", str(out)]) == 0
    with (out / "routes.csv").open(encoding="utf-8") as file:
        return {row["route_id"]: (row["success"], row["infractions"]) for row in csv.DictReader(file)}


@pytest.mark.parametrize("route", [*(pytest.param(one, marks=pytest.mark.release) for one in ("1000", "1042")), "1242"])
def test_it_goes_round_what_blocks_its_lane_without_touching_anything(route, driven) -> None:
    assert driven[route] == ("1", "")


@pytest.mark.slow
@pytest.mark.parametrize("route", ["1400", pytest.param("1431", marks=pytest.mark.release)])
def test_it_gives_doors_room_and_lets_an_emergency_vehicle_past(route, driven) -> None:
    assert driven[route] == ("1", "")


@pytest.mark.slow
@pytest.mark.parametrize("route", ["1084", *(pytest.param(one, marks=pytest.mark.release) for one in ("1132", "1184"))])
def test_it_joins_and_crosses_streams_that_brake_for_nobody(route, driven) -> None:
    assert driven[route] == ("1", "")


@pytest.mark.release
@pytest.mark.parametrize("route", ["1064", "1083", "1191", "1332"])
def test_it_waits_for_the_shortest_gap_in_a_stream_that_has_no_others(route, driven) -> None:
    assert driven[route] == ("1", "")
