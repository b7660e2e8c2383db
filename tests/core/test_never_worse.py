"""With the add-on no driver does worse than alone: no stop without end, no hand-back to a driver that rams."""

from __future__ import annotations

import pytest
from own_drivers import Patient, Ramming, SwingsOut, alone
from worlds import drive, ladder, straight_road, thing

from stucksolver import SafeStop
from stucksolver.reason import ReasonerError, RuleReasoner
from stucksolver.scene import LineKind
from stucksolver.solver import EventKind

SOLID = straight_road(oncoming=LineKind.SOLID)
SOON = ladder(rungs={"rules": {"tries": 2, "cooldown_s": 1.0}, "model": None, "passenger": None})


class Silent:
    """Never answers."""

    name = "silent"

    def decide(self, request):
        raise ReasonerError("no answer")


def stops(seen):
    return sum(isinstance(d, SafeStop) for d in seen.directives)


@pytest.mark.parametrize("reasoner", [Silent(), RuleReasoner()], ids=["silent", "rules"])
@pytest.mark.parametrize("far_m", [None, 31.0, 60.0])
def test_remote_nothing_in_path_never_holds(reasoner, far_m):
    """Nothing within reach of the driver: help is called, and the vehicle is left to its driver."""
    objects = [] if far_m is None else [thing("far", 50.0 + 2.45 + far_m + 2.3)]
    world = Patient(SOLID, objects, starts_s=117.0)
    seen = drive(world, 123.0, ladder=SOON, reasoner=reasoner)
    assert stops(seen) == 0
    assert EventKind.ASKED in seen.kinds()
    assert world.x > 60.0


@pytest.mark.parametrize("reasoner", [Silent(), RuleReasoner()], ids=["silent", "rules"])
def test_stop_blocker_gone_ends_without_a_reasoner(reasoner):
    def leaves(world):
        if world.hazard_lights and world.time_s > 100.0:
            world.objects = []

    world = Patient(SOLID, [thing("lead", 62.0)], starts_s=1.0)
    seen = drive(world, 120.0, ladder=SOON, reasoner=reasoner, every_tick=leaves)
    assert stops(seen) > 0
    assert not isinstance(seen.directives[-1], SafeStop)
    assert world.x > 80.0


def test_ramming_driver_hand_back_rams_no_more():
    """It rams once by itself; from the first plan on, the guard stops it before it touches again."""
    world = Ramming(SOLID, [thing("lead", 62.0)])
    before = alone(Ramming(SOLID, [thing("lead", 62.0)]), 120.0)
    seen = drive(world, 120.0, ladder=SOON)
    assert EventKind.STARTED in seen.kinds()
    assert world.contacts <= 1
    assert world.score(50.0) >= before - 1.0


def test_self_passing_driver_is_let_go():
    seen_alone = SwingsOut(SOLID, [thing("lead", 62.0)], patience_s=60.0)
    before = alone(seen_alone, 240.0)
    assert before == 100.0
    world = SwingsOut(SOLID, [thing("lead", 62.0)], patience_s=60.0)
    drive(world, 240.0, ladder=SOON, reasoner=Silent())
    assert world.score(50.0) >= before
