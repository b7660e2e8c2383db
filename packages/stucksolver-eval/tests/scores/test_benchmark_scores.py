"""Bench2Drive's scores with its quirks, against values worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stucksolver_eval.criteria import Infraction
from stucksolver_eval.criteria.penalties import FACTORS, KINDS, score_route
from stucksolver_eval.metrics.efficiency import corrected_efficiency, efficiency, route_efficiency
from stucksolver_eval.metrics.multi_ability import ABILITIES, AbilityCase, ability_scores, passed_junction
from stucksolver_eval.metrics.smoothness import CORRECTED, filters, smoothness


def test_factors_multiply_for_each_event() -> None:
    noted = [Infraction(kind, 0.0, "") for kind in ("collisions_pedestrian", "collisions_pedestrian", "red_light")]
    scores = score_route(80.0, noted)
    assert scores.penalty == 0.175  # 0.5 * 0.5 * 0.7
    assert scores.composed == 14.0


def test_the_share_outside_the_lanes_is_taken_off() -> None:
    assert score_route(100.0, [Infraction("outside_route_lanes", 0.0, "", 12.5)]).composed == 87.5


@pytest.mark.parametrize("kind", ["min_speed_infractions", "route_dev", "vehicle_blocked", "route_timeout"])
def test_these_cost_nothing_by_themselves(kind: str) -> None:
    assert score_route(60.0, [Infraction(kind, 0.0, "", 10.0)]).composed == 60.0


def test_scores_are_rounded_to_six_digits() -> None:
    assert score_route(100.0 / 3.0, []).composed == 33.333333


def test_there_are_twelve_kinds_and_each_factor_has_one() -> None:
    assert len(KINDS) == len(set(KINDS)) == 12
    assert set(FACTORS) < set(KINDS)


def test_the_groups_are_as_large_as_the_benchmarks() -> None:
    assert {name: len(types) for name, types in ABILITIES.items()} == {
        "Overtaking": 9,
        "Merging": 16,
        "Emergency_Brake": 12,
        "Give_Way": 2,
        "Traffic_Signs": 19,
    }
    assert len(frozenset().union(*ABILITIES.values())) == 44


def case(scenario: str, success: bool, completion: float = 100.0, obeyed: bool = True) -> AbilityCase:
    return AbilityCase(scenario, success, completion, obeyed, first_junction=92, points=200)


def test_sign_ability_failed_route_counts_beyond_junction_entry() -> None:
    """A failed route of signs counts if it is driven eight points into the junction and the sign was obeyed."""
    # (92 + 8) / 200 = 50 %.
    assert passed_junction(case("T_Junction", False, 50.1))
    assert not passed_junction(case("T_Junction", False, 50.0))
    assert not passed_junction(case("T_Junction", False, 50.1, obeyed=False))


def test_abilities_are_success_rates_of_groups_and_their_mean() -> None:
    cases = [
        case("Accident", True),
        case("HighwayExit", False),
        case("ControlLoss", True),
        case("ControlLoss", False),
        case("InvadingTurn", True),
        case("T_Junction", False, 60.0),
        case("BlockedIntersection", False, 10.0),
    ]
    # BlockedIntersection belongs to two groups.
    expected = {"Overtaking": 100.0, "Merging": 0.0, "Emergency_Brake": 100 / 3, "Give_Way": 100.0, "Traffic_Signs": 50}
    found = ability_scores(cases)
    assert {name: found[name] for name in expected} == pytest.approx(expected)
    assert found["mean"] == pytest.approx(sum(expected.values()) / 5)


def test_ability_scores_empty_group_has_no_rate_or_mean() -> None:
    """A group without routes has no rate, and then there is no mean."""
    found = ability_scores([case("Accident", True)])
    assert (found["Overtaking"], found["Merging"], found["mean"]) == (100.0, None, None)


def texts(*values: float) -> list[str]:
    return [f"on average at {value}% of it" for value in values]


def test_efficiency_drops_what_is_above_1000_percent() -> None:
    assert route_efficiency(texts(50.0, 150.0, 1000.01)) == 100.0
    assert route_efficiency(texts(2000.0)) is None


def test_efficiency_is_the_mean_over_routes_that_have_entries() -> None:
    assert efficiency([texts(100.0), texts(50.0, 150.0, 40.0), []]) == 90.0
    assert efficiency([[]]) is None


def test_corrected_efficiency_counts_a_stuck_end_and_no_value_twice() -> None:
    assert corrected_efficiency([(texts(100.0), 0.0)]) == 50.0
    assert corrected_efficiency([(texts(100.0, 40.0, 40.0), None)]) == 70.0


def motion(count: int, lon: float = 0.0, lat: float = 0.0, yaw_dps: float = 0.0) -> dict[str, np.ndarray]:
    ahead, right = np.tile([1.0, 0.0, 0.0], (count, 1)), np.tile([0.0, 1.0, 0.0], (count, 1))
    return {
        "acceleration": lon * ahead + lat * right,
        "angular_velocity": np.tile([0.0, 0.0, yaw_dps], (count, 1)),
        "forward_vector": ahead,
        "right_vector": right,
    }


@pytest.mark.parametrize(
    ("values", "good"),
    [
        ({"lon": 2.39}, True),
        ({"lon": 2.41}, False),
        ({"lon": -4.04}, True),
        ({"lon": -4.06}, False),
        ({"lat": 4.88}, True),
        ({"lat": -4.90}, False),
    ],
)
def test_constant_accelerations_are_held_against_the_bounds(values: dict[str, float], good: bool) -> None:
    assert smoothness(motion(40, **values)) == float(good)


def test_smoothness_yaw_rate_limit_is_degrees_unless_corrected() -> None:
    """As rated, the yaw rate limit of 0.95 counts in degrees per second; in the corrected version, in rad/s."""
    assert smoothness(motion(40, yaw_dps=0.94)) == 1.0
    assert smoothness(motion(40, yaw_dps=1.0)) == 0.0
    assert smoothness(motion(40, yaw_dps=1.0), CORRECTED) == 1.0
    # 0.95 rad/s.
    assert smoothness(motion(40, yaw_dps=54.4), CORRECTED) == 1.0
    assert smoothness(motion(40, yaw_dps=54.5), CORRECTED) == 0.0


def ramp(jerk_mps3: float) -> dict[str, np.ndarray]:
    info = motion(20)
    info["acceleration"][:, 0] = jerk_mps3 * 0.05 * (np.arange(20) - 9.5)
    return info


def test_jerk_comes_out_halved_as_rated() -> None:
    # 5 m/s³ at 20 Hz is read as 2.5 m/s³, below 4.13.
    assert smoothness(ramp(5.0)) == 1.0
    assert smoothness(ramp(5.0), CORRECTED) == 0.0
    assert smoothness(ramp(4.0), CORRECTED) == 1.0


def test_jumps_of_the_rate_lose_multiples_of_two_pi() -> None:
    info = motion(20)
    info["angular_velocity"][10:, 2] = 2 * math.pi
    assert smoothness(info) == 1.0


def test_only_whole_blocks_of_twenty_count() -> None:
    info = motion(59)
    info["acceleration"][25, 0] = 50.0
    info["acceleration"][50, 0] = 50.0
    # The last 19 samples are dropped; of two blocks one is good.
    assert smoothness(info) == 0.5


def test_a_short_route_is_one_block() -> None:
    assert smoothness(motion(3)) == 1.0
    assert smoothness(motion(19, lon=3.0)) == 0.0
    with pytest.raises(ValueError, match="at least 3 samples"):
        smoothness(motion(2))


@pytest.mark.parametrize("count", [3, 4, 6, 7, 20])
def test_the_filters_are_exact_on_parabolas(count: int) -> None:
    t = np.arange(count, dtype=float)
    smooth, slope = filters(count)
    assert smooth @ (2 + 3 * t - 0.5 * t * t) == pytest.approx(2 + 3 * t - 0.5 * t * t)
    assert slope @ (2 + 3 * t - 0.5 * t * t) == pytest.approx(3 - t)


def test_in_the_middle_the_filter_has_the_published_weights() -> None:
    # Savitzky and Golay (1964): seven points, quadratic: (-2, 3, 6, 7, 6, 3, -2) / 21, slope (-3 ... 3) / 28.
    smooth, slope = filters(20)
    assert smooth[10, 7:14] * 21 == pytest.approx([-2, 3, 6, 7, 6, 3, -2])
    assert slope[10, 7:14] * 28 == pytest.approx([-3, -2, -1, 0, 1, 2, 3])
