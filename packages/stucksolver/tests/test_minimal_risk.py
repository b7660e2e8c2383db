"""The minimal risk condition is the best place that can be reached; nobody is held where nobody may stand."""

from __future__ import annotations

import pytest

from grids import each_value
from stucksolver import CONTINUE, SafeStop
from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import RequestAssistance
from stucksolver.scene import LineKind, Zone, ZoneKind
from stucksolver.solver import EventKind
from stucksolver.solver.state_machine.minimal_risk import minimal_risk, stops_where_one_may_stand
from worlds import World, drive, ladder, straight_road, thing

GUARD = Guard()
ONLY_HELP = ladder(rungs={"reasoner": {"tries": 1, "cooldown_s": 1.0}, "model": None, "passenger": None})


def inside(kind, *objects, start_m=47.0, end_m=53.0, **more):
    road = straight_road(oncoming=LineKind.SOLID, zones=(Zone(kind=kind, start_m=start_m, end_m=end_m),))
    return World(road, list(objects), **more)


def wall(x, name="wall"):
    """A closed road: the stack stays behind it."""
    return thing(name, x, 1.0, width=6.0, length=1.0)


@pytest.mark.parametrize("kind", list(ZoneKind))
def test_a_vehicle_is_never_held_where_nobody_may_stand(kind):
    boxed = inside(kind, wall(54.0), wall(44.0, "behind"))
    seen = drive(boxed, 60.0, ladder=ONLY_HELP)
    assert not any(isinstance(d, SafeStop) for d in seen.directives)
    assert EventKind.ASKED in seen.kinds(), "help is called all the same"


@pytest.mark.integration
@pytest.mark.parametrize(("kind", "way"), each_value(ZoneKind, ["ahead", "back"]))
def test_it_is_left_for_a_place_in_reach(kind, way):
    world = inside(kind, wall(66.0 if way == "ahead" else 54.0))
    view = world.view()
    plan = minimal_risk(GUARD, view, "blocked")
    assert plan.behaviors[1].name in (("creep", "pull_over") if way == "ahead" else ("back_up",))
    seen = drive(world, 60.0, ladder=ONLY_HELP)
    assert isinstance(seen.directives[-1], SafeStop)
    assert GUARD.may_stand(world.view())


@pytest.mark.parametrize("kind", list(ZoneKind))
def test_help_is_not_waited_for_where_nobody_may_stand(kind):
    call = RequestAssistance(reason="blocked")
    verdict = GUARD.allows_standing(call, inside(kind).view())
    assert {r.code for r in verdict.rejects} <= {RejectCode.STOPPING_PLACE, RejectCode.PRECONDITION}
    assert not verdict.accepted
    assert GUARD.allows_standing(call, World(straight_road()).view()).accepted


def test_stop_rolling_into_junction_is_not_allowed():
    """A stop that would roll into a junction does not count as a place to stop."""
    before = inside(ZoneKind.JUNCTION, start_m=56.0, end_m=70.0, speed=5.0)
    assert not stops_where_one_may_stand(GUARD, before.view())
    before.speed = 0.0
    assert stops_where_one_may_stand(GUARD, before.view())


@pytest.mark.integration
def test_where_one_may_stand_nothing_has_changed():
    seen = drive(World(straight_road(oncoming=LineKind.SOLID), [wall(60.0)]), 60.0, ladder=ONLY_HELP)
    assert isinstance(seen.directives[-1], SafeStop) and CONTINUE in seen.directives
