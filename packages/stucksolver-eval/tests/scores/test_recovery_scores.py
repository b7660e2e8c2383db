"""Recovery's own figures: each word as the design fixes it."""

from __future__ import annotations

from typing import Any

import pytest
from outcomes import noted, outcome, plan, spell, spoken

from stucksolver_eval.metrics.recovery import RecoveryMetrics, key_of, recovery_figures
from stucksolver_eval.results.outcome import QueryRecord, Reliability, RouteOutcome


def figures(alone: RouteOutcome | None = None, **changes: Any) -> RecoveryMetrics:
    return recovery_figures([outcome(**changes)], None if alone is None else {key_of(alone): alone})


def test_a_short_stop_is_no_immobilization() -> None:
    assert figures(spells=(spell(10, 19.9),)).met == 0
    assert figures(spells=(spell(10, 20.0),)).met == 1


def test_a_short_stop_with_a_plan_is_one() -> None:
    assert figures(spells=(spell(10, 15),), interventions=(plan(12, 14),)).met == 1


def test_time_to_recover_is_told_by_median_and_p95() -> None:
    found = figures(spells=tuple(spell(0, t) for t in (10.0, 20.0, 60.0)))
    assert (found.left, found.median_s, found.p95_s) == (3, 20.0, pytest.approx(56.0))


def test_recovered_means_15_m_within_60_s() -> None:
    assert figures(interventions=(plan(50, 60),)).recovered == 1
    slow = tuple((float(t), t / 5.0) for t in range(400))
    assert figures(interventions=(plan(50, 60, place_m=10.0),), track=slow).recovered == 0


def test_without_an_infraction_from_the_plans_start_on() -> None:
    assert figures(interventions=(plan(50, 60),), infractions=(noted(55),)).recovered == 0
    assert figures(interventions=(plan(50, 60),), infractions=(noted(49),)).recovered == 1


def test_recoveries_are_counted_by_rung() -> None:
    assert figures(interventions=(plan(50, 60), plan(100, 110))).by_rung == {"rules": 2}


def test_to_act_where_the_scenario_says_wait_is_false() -> None:
    assert figures(expected="wait", interventions=(plan(50, 60),)).false == 1
    assert figures(expected="wait", interventions=(plan(50, 60, moves=False),)).false == 0


def test_recovery_action_is_false_where_driver_alone_recovers() -> None:
    """An intervention is false if the driver alone recovered at the same position within 60 s."""
    alone = outcome(arm="driver alone", spells=(spell(45, 80, place_m=48),))
    assert figures(alone, interventions=(plan(50, 60),)).false == 1
    late = outcome(arm="driver alone", spells=(spell(45, 106, place_m=48),))
    assert figures(late, interventions=(plan(50, 60),)).false == 0
    elsewhere = outcome(arm="driver alone", spells=(spell(45, 80, place_m=80),))
    assert figures(elsewhere, interventions=(plan(50, 60),)).false == 0


def test_recovery_missed_is_permanent_stop_without_intervention() -> None:
    """A stop is missed if it never ends, no plan was tried and a wait was not expected."""
    stuck = spell(10, 200, recovered=False)
    assert figures(spells=(stuck,)).missed == 1
    assert figures(spells=(stuck,), interventions=(plan(12, 14),)).missed == 0
    assert figures(spells=(stuck,), expected="wait").missed == 0


def test_recovery_harm_counts_until_10_s_after_plan() -> None:
    """Harm counts from the start of a plan until 10 s after its end."""
    infractions = tuple(noted(t) for t in (49.9, 50.0, 70.0, 70.1))
    found = figures(interventions=(plan(50, 60),), infractions=infractions, near_misses=(noted(65, "near_miss"),))
    assert (found.harm, found.infractions) == (3, 5)


def test_harm_of_overlapping_plans_counts_once() -> None:
    assert figures(interventions=(plan(50, 60), plan(62, 70)), infractions=(noted(65),)).harm == 1


def test_recovery_harm_is_compared_with_driver_alone() -> None:
    """The harm of the driver alone in the same time is listed next to that of the recovery."""
    alone = outcome(arm="driver alone", infractions=(noted(55), noted(150)))
    found = figures(alone, interventions=(plan(50, 60),))
    assert (found.harm, found.harm_alone, found.infractions_alone) == (0, 1, 2)
    assert figures(interventions=(plan(50, 60),)).harm_alone is None


def test_min_speed_entries_and_being_blocked_are_no_harm() -> None:
    infractions = (noted(55, "min_speed_infractions"), noted(56, "vehicle_blocked"))
    assert figures(interventions=(plan(50, 60),), infractions=infractions).harm == 0


def test_questions_are_counted_with_their_cost() -> None:
    queries = (
        QueryRecord(asked_s=10, answered_s=12.8, took_s=2.5, tokens=900, usd=0.004, outcome="nothing to do"),
        QueryRecord(asked_s=20),
    )
    queries += (
        QueryRecord(asked_s=30, answered_s=30, outcome="refused", verdict="refused: collision"),
        QueryRecord(asked_s=40, outcome="failed", verdict="failed: late"),
    )
    found = figures(queries=queries)
    assert (found.queries, found.tokens, found.latencies_s) == (4, 900, [2.5])
    assert (found.dropped, found.failed, found.refused) == (1, 1, 1)
    assert found.lost_s == pytest.approx(2.8)
    assert found.usd == pytest.approx(0.004)
    assert found.queries_per_km == pytest.approx(4 / 0.2)


def test_cost_is_that_of_the_model_alone() -> None:
    """The rules answered 64 of the 88 queries of the solver; 24 answers of the model took 150 tokens each."""
    queries = tuple(QueryRecord(asked_s=t, answered_s=t, took_s=0.001, outcome="nothing to do") for t in range(88))
    model = Reliability(
        reasoner="m", asked=24, unanswered=0, queries=24, tokens=24 * 150, usd=0.24, latencies_s=(2.0,) * 24
    )
    found = figures(queries=queries, reliability=(model,))
    assert (found.queries, found.counted_queries, found.tokens) == (88, 24, 3600)
    assert found.latencies_s == [2.0] * 24 and found.usd == pytest.approx(0.24)
    assert found.queries_per_km == pytest.approx(24 / 0.2)


@pytest.mark.parametrize(
    ("expected", "changes", "right"),
    [
        ("wait", {}, 1),
        ("wait", {"interventions": (plan(50, 60),)}, 0),
        ("ask", {}, 0),
        ("ask", {"asked_s": 30.0}, 1),
        ("ask", {"interventions": (plan(50, 60),)}, 1),
        ("ask", {"interventions": (plan(50, 60),), "infractions": (noted(52.0),)}, 0),
        ("ask", {"interventions": (plan(50, 60),), "track": ((0.0, 0.0), (50.0, 50.0), (90.0, 64.0))}, 0),
        ("recover", {}, 1),
        ("recover", {"track": ((0.0, 0.0), (1.0, 5.0))}, 0),
        ("reroute", {}, 1),
        ("reroute", {"track": ((0.0, 0.0), (90.0, 177.0))}, 1),
        ("reroute", {"track": ((0.0, 0.0), (90.0, 170.0))}, 0),
    ],
)
def test_a_stated_outcome_is_judged(expected: str, changes: dict[str, Any], right: int) -> None:
    found = figures(expected=expected, **changes)
    assert (found.judged, found.right) == (1, right)


def test_routes_that_were_not_driven_count_nothing() -> None:
    assert figures(state="crashed", spells=(spell(0, 50),)).routes == 0


def test_guidance_is_followed_by_plan_within_30_s() -> None:
    """Guidance counts as followed if a plan of the passenger rung begins within 30 s."""
    by_words = plan(55, 60).model_copy(update={"rung": "passenger"})
    said = (spoken(50, "helpful"), spoken(20, "helpful"), spoken(52, "dangerous"))
    found = figures(guidance=said, interventions=(by_words, plan(21, 30)))
    assert found.said == {"helpful": 2, "dangerous": 1}
    assert (found.followed["helpful"], found.followed["dangerous"]) == (1, 1)
