"""Several reasoners share the time that there is."""

from __future__ import annotations

import time

import pytest
from worlds import World, straight_road, thing

from stucksolver.reason import ReasonerError, Request, RuleReasoner
from stucksolver.reason.fallback import FallbackReasoner

SCENE = World(straight_road(), [thing("car", 60.0)]).scene()


class Slow:
    """Has no answer; notes what it is told it may take, and takes some of that."""

    def __init__(self, share=0.0):
        self.name, self.share, self.limits = "slow", share, []

    def decide(self, request):
        self.limits.append(request.deadline_s)
        time.sleep(self.share * request.deadline_s)
        raise ReasonerError("no idea")

    def cancel(self):
        """Whoever can be told to stop may be slow."""


def test_the_one_before_leaves_its_share_to_the_one_after():
    first, second = Slow(share=0.5), Slow()
    both = FallbackReasoner([first, second, RuleReasoner()])
    assert both.decide(Request(SCENE, deadline_s=0.4)).decision == RuleReasoner().decide(Request(SCENE)).decision
    assert first.limits == [pytest.approx(0.2, abs=0.01)]
    assert second.limits[0] > first.limits[0]


def test_rules_take_no_time_from_a_model():
    model = Slow()
    both = FallbackReasoner([model, RuleReasoner()])
    both.decide(Request(SCENE, deadline_s=30.0))
    assert model.limits == [pytest.approx(30.0, abs=0.1)]
