"""The paper's three cases, from the scene through a model's prompt and answer to the drive."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec

import pytest
from chat_server import ChatServer

from stucksolver.plan.behaviors import ChangeLane
from stucksolver_eval.cases import CASES, run_cases
from stucksolver_eval.cases.figure import draw_figure

if find_spec("openai") is None:  # importing it takes as long as collecting five hundred tests
    pytest.skip("the openai package is not installed: add the extra [llm] (README, Install)", allow_module_level=True)
pytestmark = [pytest.mark.integration, pytest.mark.release]

DRIVE_S = {"pedestrians": 37.0, "open_door": 25.0, "cyclists": 28.0}
"""Until the people have crossed, and each plan is over: a picture costs more than everything else in a tick."""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    with ChatServer() as server:
        cases = tuple(replace(case, drive_s=DRIVE_S[case.name]) for case in CASES if case.name in DRIVE_S)
        return run_cases(cases, f"openai:reader@{server.url}", tmp_path_factory.mktemp("cases"))


def test_people_crossing_at_red_mean_no_plan(results):
    assert results[0].decided.decision.plan is None
    assert results[0].progress_m > 5.0


def test_case_car_with_open_door_is_passed_left(results):
    """A car with an open door is passed in the left lane."""
    plan = results[1].decided.decision.plan
    assert isinstance(plan.behaviors[0], ChangeLane) and plan.behaviors[0].side == "left"
    assert results[1].progress_m > 50.0


def test_cyclists_are_overtaken_when_a_passenger_asks(results):
    assert results[2].decided.trigger == "guidance"
    assert results[2].decided.decision.plan is not None
    assert results[2].progress_m > 40.0


def test_nobody_is_touched(results):
    assert [result.collisions for result in results] == [0, 0, 0]


def test_every_decision_was_made_of_a_picture(results):
    assert all(result.decided.scene.image is not None for result in results)


def test_the_figure_has_three_rows(results, tmp_path):
    from PIL import Image

    draw_figure(results, tmp_path / "cases.png")
    with Image.open(tmp_path / "cases.png") as figure:
        assert figure.width > 1600 and figure.height > 1400
