"""With the add-on no driver does worse than alone: no stop without end, no hand-back to a driver that rams."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from grids import WHOLE
from own_drivers import ROUTE_M, Patient, Ramming, SwingsOut, alone
from stucksolver import CONTINUE, SafeStop
from stucksolver.reasoners import ReasonerError, SearchReasoner
from stucksolver.scene import LineKind, Zone, ZoneKind
from stucksolver.solver import EventKind
from worlds import drive, ladder, straight_road, stubborn, thing

SOLID = straight_road(oncoming=LineKind.SOLID)
SOON = ladder(rungs={"reasoner": {"tries": 2, "cooldown_s": 1.0}, "model": None, "passenger": None})


SECONDS = 260.0
"""Longer than all waits, the stop and one hold together (s)."""
STANDS_BACK = 100.0 * 6.0 / ROUTE_M
"""The score of 6 m of the route, no part of which is passed: 5 m that a driver leaves, and a touch."""


class Silent:
    """Never answers."""

    name = "silent"

    def decide(self, request):
        raise ReasonerError("no answer")


def stops(result):
    return sum(isinstance(d, SafeStop) for d in result.directives)


@pytest.mark.integration
@pytest.mark.parametrize(
    ("reasoner", "far_m"),
    [(Silent(), None), (Silent(), 31.0), (Silent(), 60.0), (SearchReasoner(), None), (SearchReasoner(), 60.0)],
)
def test_remote_nothing_in_path_never_holds(reasoner, far_m):
    """Nothing within reach of the driver: help is called, and the vehicle is left to its driver."""
    objects = [] if far_m is None else [thing("far", 50.0 + 2.45 + far_m + 2.3)]
    world = Patient(SOLID, objects, starts_s=117.0)
    seen = drive(world, 123.0, ladder=SOON, reasoner=reasoner)
    assert stops(seen) == 0
    assert EventKind.ASKED in seen.kinds()
    assert world.x > 60.0


@pytest.mark.integration
@pytest.mark.parametrize("reasoner", [Silent(), SearchReasoner()], ids=["silent", "search"])
def test_stop_blocker_gone_ends_without_a_reasoner(reasoner):
    def leaves(world):
        if world.hazard_lights and world.time_s > 100.0:
            world.objects = []

    world = Patient(SOLID, [thing("lead", 62.0)], starts_s=1.0)
    seen = drive(world, 120.0, ladder=SOON, reasoner=reasoner, every_tick=leaves)
    assert stops(seen) > 0
    assert not isinstance(seen.directives[-1], SafeStop)
    assert world.x > 80.0


@pytest.mark.integration
def test_ramming_driver_hand_back_rams_no_more():
    """It rams once by itself; from the first plan on, the guard stops it before it touches again."""
    world = Ramming(SOLID, [thing("lead", 62.0)])
    seen = drive(world, 200.0, ladder=SOON)
    assert EventKind.HELD in seen.kinds()
    assert world.contacts == 1


@pytest.mark.integration
def test_half_done_plan_begins_three_times_at_most():
    """A back-up whose next step is refused is not begun for ever; each time it is a longer one."""
    world = Ramming(SOLID, [thing("lead", 62.0)])
    seen = drive(world, 150.0, ladder=stubborn())
    assert 1 <= seen.texts(EventKind.STARTED).count("back_up, borrow_oncoming_lane") <= 3


DRIVERS = {
    "patient": lambda wait_s, things: Patient(SOLID, things, dt=0.1, starts_s=wait_s),
    "ramming": lambda wait_s, things: Ramming(SOLID, things, dt=0.1, cruise_mps=2.0 + wait_s / 10.0),
    "swings out": lambda wait_s, things: SwingsOut(SOLID, things, dt=0.1, patience_s=wait_s),
}


@pytest.mark.integration
@settings(max_examples=8 if WHOLE else 3, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    driver=st.sampled_from(sorted(DRIVERS)),
    wait_s=st.floats(0.0, 60.0),
    at_m=st.floats(56.0, 85.0),
    aside_m=st.floats(-0.6, 0.3),
    leaves_s=st.sampled_from([25.0, 70.0, 1e3]),
    reasoner=st.sampled_from([Silent, SearchReasoner]),
)
@example(driver="swings out", wait_s=60.0, at_m=62.0, aside_m=0.0, leaves_s=1e3, reasoner=Silent)
@example(driver="ramming", wait_s=20.0, at_m=62.0, aside_m=0.0, leaves_s=1e3, reasoner=SearchReasoner)
@example(driver="patient", wait_s=40.0, at_m=62.0, aside_m=0.0, leaves_s=70.0, reasoner=Silent)
def test_any_driver_scores_no_worse_than_alone(driver, wait_s, at_m, aside_m, leaves_s, reasoner):
    """A driver that waits, rams or passes by itself, before something that stays or leaves."""

    def leaves(world):
        if world.time_s > leaves_s:
            world.objects = []

    by_itself = DRIVERS[driver](wait_s, [thing("lead", at_m, aside_m)])
    before = alone(by_itself, SECONDS, every_tick=leaves)
    world = DRIVERS[driver](wait_s, [thing("lead", at_m, aside_m)])
    drive(world, SECONDS, ladder=SOON, reasoner=reasoner(), every_tick=leaves)
    assert world.contacts <= by_itself.contacts
    # Where neither arrives, it may stand a hold's gap before the place where the driver alone stands.
    assert world.score(50.0) >= before - STANDS_BACK


class MakesNoProgress(Patient):
    """Moves, but comes no nearer to its destination."""

    def status(self):
        return super().status().model_copy(update={"progress_m": 0.0})


def test_remote_moving_without_progress_is_left_to_its_driver():
    """With nothing in its path, a moving vehicle is neither stopped nor driven to a place to stop."""
    junction = Zone(kind=ZoneKind.JUNCTION, start_m=0.0, end_m=130.0)
    world = MakesNoProgress(straight_road(oncoming=LineKind.SOLID, zones=(junction,)), cruise_mps=2.0)
    seen = drive(world, 60.0, ladder=SOON, reasoner=Silent())
    assert EventKind.ASKED in seen.kinds()
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
