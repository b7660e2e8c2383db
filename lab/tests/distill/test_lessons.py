"""What a campaign teaches: what its drives were worth, and what is thought of the plans that were not driven."""

from __future__ import annotations

import pytest

from lab.language.plan_search.campaign_samples import HARM_M, capped, worth_m
from lab.language.plan_search.decision_samples import JudgedPlan
from lab.language.plan_search.grade import Grade
from stucksolver.plan import RecoveryPlan


def grade(recovered_after_s: float | None, completion: float = 100.0, collisions: int = 0) -> Grade:
    return Grade(
        recovered_after_s=recovered_after_s,
        collisions=collisions,
        infractions=0,
        near_misses=0,
        comfort=1.0,
        driving_score=completion,
        completion=completion,
        success=completion == 100.0,
        state="Completed",
    )


def change(speed: float, value_m: float | None, *more: dict[str, object]) -> JudgedPlan:
    out = {"name": "change_lane", "side": "left", "distance_m": 15.0, "speed_mps": speed}
    return JudgedPlan(plan=RecoveryPlan.model_validate({"behaviors": [out, *more]}), value_m=value_m)


@pytest.mark.parametrize(
    ("driven", "worth"),
    [
        (grade(None), 0.0),
        (grade(20.0), 40.0),
        (grade(20.0, completion=50.0), 20.0),
        (grade(90.0), 0.0),
        (grade(20.0, collisions=1), HARM_M),
    ],
)
def test_run_worth_is_saved_time_times_completion_unless_harmful(driven: Grade, worth: float) -> None:
    """The worth is 1 m for each second saved, times the route completion; with a collision it is HARM_M."""
    assert worth_m(driven) == worth


def test_plan_not_driven_value_is_capped_by_similar_plan() -> None:
    """The value of a plan that was not driven is capped by the best driven plan of its kind."""
    back: dict[str, object] = {"name": "rejoin_route"}
    driven = [change(1.0, 0.0), change(1.5, 5.0), change(1.0, 40.0, back)]
    assert capped(change(2.0, 45.0), driven).value_m == 5.0
    assert capped(change(2.0, 45.0, back), driven).value_m == 40.0
    assert capped(change(2.0, 3.0), driven).value_m == 3.0
    assert capped(change(2.0, None), driven).value_m is None
    assert capped(change(2.0, 45.0), ()).value_m == 45.0
