"""The table of sensor faults: what counts as a collision, a wait and a request, and what is refused."""

from __future__ import annotations

import pytest

from lab.perception.evaluation.sensor_fault_campaign import (
    HEALTHY,
    FaultCampaignError,
    FaultCampaignSpec,
    as_table,
    campaign,
    counted,
    main,
)
from stucksolver_eval.results.outcome import InterventionRecord, RouteOutcome, TimedInfraction
from stucksolver_perception.carla import FAULTS


def outcome(**others):
    told = {"route_id": "7", "scenario": "Accident", "town": "grid_town", "seed": 1, "arm": "rules", **others}
    return RouteOutcome(**told)


def plan(moves):
    return InterventionRecord(
        start_s=1.0, end_s=2.0, place_m=3.0, rung="rules", behaviors=(), moves=moves, finished=True
    )


def test_collisions_waits_requests_and_plans_are_counted_over_all_routes():
    hit = TimedInfraction(kind="collisions_vehicle", time_s=12.3, text="Agent collided against a car")
    red = TimedInfraction(kind="red_light", time_s=20.0, text="ran a red light")
    first = outcome(
        infractions=(hit, red), track=((0.0, 0.0), (1.0, 5.0), (2.0, 5.1), (3.0, 5.2), (4.0, 9.0)), asked_s=3.0
    )
    second = outcome(route_id="8", track=((0.0, 0.0), (1.0, 6.0)), interventions=(plan(True), plan(False)))
    row = counted("lidar-missing", [first, second])
    assert row.collisions == ("7 at 12 s: Agent collided against a car",)
    assert (row.routes, row.crashed, row.stood_s, row.asked, row.plans) == (2, 0, 2.0, 1, 1)
    assert row.driven_m == pytest.approx(15.0)


def test_a_drive_that_crashed_is_no_drive_without_collisions():
    row = counted("lidar-missing", [outcome(state="crashed"), outcome(track=((0.0, 0.0), (1.0, 4.0)))])
    assert (row.routes, row.crashed) == (1, 1)
    assert "| lidar-missing | 1, 1 crashed | 0 |" in as_table([row])


def test_fault_campaign_default_covers_all_faults_and_none(tmp_path):
    """By default, all sensor faults are driven, and the sensors without a fault as well."""
    assert FaultCampaignSpec(tmp_path).faults == (HEALTHY, *FAULTS)


def test_fault_campaign_invalid_choice_is_one_line_error(tmp_path, capsys):
    """An unknown fault or suite is an error of one line, with exit code 2."""
    with pytest.raises(
        FaultCampaignError, match=r"unknown sensor fault: 'lidar-melted'\. Choose from none, lidar-missing"
    ):
        campaign(FaultCampaignSpec(tmp_path, faults=("lidar-melted",)))
    assert main(["--out", str(tmp_path), "--suite", "no_such_suite"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
