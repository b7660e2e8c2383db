"""How sure a solution is, and which one is proposed first."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from remembering import BACK_UP, LEFT, REROUTE, RIGHT, episode, features, reading
from scipy.special import betaincinv

from stucksolver.scene import DirectedSide, GuidanceIntent, LightState
from stucksolver_passenger.memory import SolutionOutcome, SuccessRate, features_of, recall, similarity
from stucksolver_passenger.memory.success_rate import CONFIDENCE
from worlds import World, red_light, straight_road, thing

FAILED, WORKED = SolutionOutcome.FAILED, SolutionOutcome.WORKED


@given(st.integers(0, 60), st.integers(0, 60))
def test_the_lower_bound_is_the_quantile_of_the_beta_distribution(worked, failed):
    expected = betaincinv(worked + 1, failed + 1, 1.0 - CONFIDENCE)
    assert SuccessRate(worked, worked + failed).lower == pytest.approx(expected, abs=1e-6)


def test_more_successes_than_tries_are_refused():
    with pytest.raises(ValueError, match="2 of 1"):
        _ = SuccessRate(2, 1).lower


@pytest.mark.parametrize(
    ("worked", "failed", "trusted"),
    [(0, 0, False), (1, 0, False), (2, 0, True), (2, 1, False), (3, 1, True), (0, 5, False), (5, 5, False)],
)
def test_once_is_luck_and_twice_without_a_failure_is_trusted(worked, failed, trusted):
    found = recall([*[episode()] * worked, *[episode(ending=FAILED)] * failed], features())
    assert [item.trusted for item in found] == ([trusted] if worked + failed else [])


def test_recall_one_failed_solution_keeps_good_one_first():
    """One piece of bad advice neither displaces a good solution nor becomes trusted itself."""
    good, bad = [episode()] * 3, episode(BACK_UP, FAILED, text="back up a bit")
    first, second = recall([*good, bad], features())
    assert (first.solution, first.trusted, second.solution, second.trusted) == (REROUTE, True, BACK_UP, False)


def test_bad_advice_that_seemed_to_help_once_is_not_proposed():
    (lucky,) = recall([episode(BACK_UP, WORKED)], features())
    assert not lucky.trusted


def test_what_never_ended_says_nothing():
    assert recall([episode(ending=SolutionOutcome.UNFINISHED)] * 9, features()) == ()


@pytest.mark.parametrize("change", [{"obstacle": "car"}, {"motion": "towards"}, {"light": "red"}])
def test_another_obstacle_motion_or_light_is_another_kind_of_scene(change):
    assert similarity(features(), features(**change)) == 0.0
    assert recall([episode()] * 3, features(**change)) == ()


def test_recall_scene_with_one_difference_matches_two_do_not():
    """A scene that differs in one detail is similar enough for recall; one that differs in two is not."""
    assert recall([episode()] * 3, features(people=True))
    assert not recall([episode()] * 3, features(people=True, detour=False))


@pytest.mark.parametrize(
    ("state", "told"), [(LightState.RED, "red"), (LightState.OFF, "off"), (LightState.GREEN, "none")]
)
def test_a_light_that_holds_nobody_up_is_none(state, told):
    world = World(straight_road(), [thing("parked", 62.0)], controls=(red_light(5.0, state),))
    assert features_of(world.scene()).light == told


def test_words_recall_what_they_mean():
    kept = [episode(LEFT)] * 2 + [episode(RIGHT)] * 3 + [episode(REROUTE)] * 4

    def recalled(intent, side=None):
        return [item.solution for item in recall(kept, features(), reading(intent, side))]

    assert recalled(GuidanceIntent.OVERTAKE) == [RIGHT, LEFT]
    assert recalled(GuidanceIntent.OVERTAKE, DirectedSide.LEFT) == [LEFT]
    assert recalled(GuidanceIntent.TURN_AROUND) == [REROUTE]
    assert recalled(GuidanceIntent.GO) == [REROUTE, RIGHT, LEFT]
    assert recalled(GuidanceIntent.WAIT) == recalled(GuidanceIntent.NONE) == []
