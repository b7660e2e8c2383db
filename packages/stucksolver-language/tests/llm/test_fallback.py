"""Several reasoners share the time that there is."""

from __future__ import annotations

import pytest

from stucksolver.reasoners import ReasonerError, ReasonerRequest, SearchReasoner, fallback
from stucksolver.reasoners.fallback import FallbackReasoner
from worlds import World, straight_road, thing

SCENE = World(straight_road(), [thing("car", 60.0)]).scene()


class Clock:
    """Stands still unless somebody takes time: what a busy machine takes is no part of a share."""

    def __init__(self):
        self.now_s = 1000.0

    def monotonic(self):
        return self.now_s


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(fallback, "time", clock)
    return clock


class Slow:
    """Has no answer; notes what it is told it may take, and takes some of that."""

    def __init__(self, share=0.0, clock=None):
        self.name, self.share, self.limits, self.clock = "slow", share, [], clock

    def decide(self, request):
        self.limits.append(request.deadline_s)
        if self.clock is not None:
            self.clock.now_s += self.share * request.deadline_s
        raise ReasonerError("no idea")

    def cancel(self):
        """Whoever can be told to stop may be slow."""


@pytest.mark.parametrize(("share", "left_s"), [(0.0, 0.4), (0.5, 0.3), (1.0, 0.2), (1.5, 0.1), (3.0, 0.0)])
def test_the_one_before_leaves_its_share_to_the_one_after(clock, share, left_s):
    first, second = Slow(share, clock), Slow()
    both = FallbackReasoner([first, second, SearchReasoner()])
    assert (
        both.decide(ReasonerRequest(SCENE, deadline_s=0.4)).decision
        == SearchReasoner().decide(ReasonerRequest(SCENE)).decision
    )
    assert first.limits == [pytest.approx(0.2)]
    assert second.limits == [pytest.approx(left_s, abs=1e-9)]


def test_search_takes_no_time_from_a_model():
    model = Slow()
    both = FallbackReasoner([model, SearchReasoner()])
    both.decide(ReasonerRequest(SCENE, deadline_s=30.0))
    assert model.limits == [30.0]
