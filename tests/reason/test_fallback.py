"""Several reasoners share the time that there is."""

from __future__ import annotations

import time

import pytest
from worlds import World, straight_road, thing

from stucksolver.reason import ReasonerError, RuleReasoner
from stucksolver.reason.fallback import FallbackReasoner

SCENE = World(straight_road(), [thing("car", 60.0)]).scene()


class Slow:
    """Has no answer; notes what it is told it may take, and takes some of that."""

    def __init__(self, share=0.0):
        self.name, self.share, self.limits = "slow", share, []

    def answer_within(self, limit_s):
        self.limits.append(limit_s)

    def decide(self, scene):
        time.sleep(self.share * self.limits[-1])
        raise ReasonerError("no idea")


def test_the_one_before_leaves_its_share_to_the_one_after():
    first, second = Slow(share=0.5), Slow()
    both = FallbackReasoner([first, second, RuleReasoner()])
    both.answer_within(0.4)
    assert both.decide(SCENE) == RuleReasoner().decide(SCENE)
    assert first.limits == [pytest.approx(0.2, abs=0.01)]
    assert second.limits[0] > first.limits[0]


def test_rules_take_no_time_from_a_model():
    model = Slow()
    both = FallbackReasoner([model, RuleReasoner()])
    both.answer_within(30.0)
    both.decide(SCENE)
    assert model.limits == [pytest.approx(30.0, abs=0.1)]
