"""Two of the paper's cases with the student in place of a language model, from the scene to the drive."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stucksolver.plan.behaviors import ChangeLane, DriveOver
from stucksolver_eval.cases import CASES, run_cases

pytestmark = [pytest.mark.integration, pytest.mark.release]

DRIVE_S = {"cyclists": 12.0, "paper_bag": 34.0}
"""Until the cyclists are being overtaken, and until the bag is behind the vehicle."""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    cases = tuple(replace(case, drive_s=DRIVE_S[case.name]) for case in CASES if case.name in DRIVE_S)
    return {
        item.case.name: item for item in run_cases(cases, "distilled", tmp_path_factory.mktemp("cases"), pictures=False)
    }


def test_the_student_drives_over_the_bag_beside_a_disabled_car(results):
    kinds = [type(behavior) for behavior in results["paper_bag"].decided.decision.plan.behaviors]
    assert kinds[:2] == [ChangeLane, DriveOver]
    last = results["paper_bag"].moments[-1]
    assert last.ego_m > max(last.others_m)


def test_the_student_does_what_a_passenger_asks_for(results):
    assert results["cyclists"].decided.trigger == "guidance"
    assert isinstance(results["cyclists"].decided.decision.plan.behaviors[0], ChangeLane)


def test_each_decision_is_the_students_own(results):
    assert all(result.decided.reasoner.startswith("distilled") for result in results.values())
    assert all(result.unanswered == 0 and result.collisions == 0 for result in results.values())
