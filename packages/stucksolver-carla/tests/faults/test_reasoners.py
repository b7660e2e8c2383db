"""Reasoners that are silent, wrong, contradictory or hostile: the guard carries the safety."""

from __future__ import annotations

import pytest

from stucksolver import CONTINUE, StuckSolver
from stucksolver.plan import Execute
from stucksolver.reasoners.faulty import FAULTY, make_faulty
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.solver import EventKind
from worlds import LANE_M, World, drive, ladder, straight_road, thing

ROADS = {"two way": straight_road(), "two lanes": straight_road(left=LineKind.BROKEN)}
TALKATIVE = [name for name in FAULTY if name != "silent"]
BRIEF = ladder(rungs={"reasoner": {"tries": 1000}, "passenger": None, "remote": None})


def street(road, seed):
    """A parked car, people beside the road, and traffic both ways."""
    traffic = [thing(f"car{k}", 125.0 + 13.0 * seed + 55.0 * k, LANE_M, speed=-9.0) for k in range(4)]
    people = [thing("walker", 85.0, -4.0, kind=ObjectKind.PEDESTRIAN)]
    return World(road, [thing("lead", 75.0), *people, *traffic], x=64.0, sight_m=500.0)


@pytest.mark.integration
@pytest.mark.parametrize(("road", "seed"), list(zip(ROADS.values(), (0, 2), strict=True)), ids=ROADS)
@pytest.mark.parametrize("name", TALKATIVE)
def test_whatever_it_says_nobody_is_touched(name, seed, road):
    world = street(road, seed)
    seen = drive(world, 24.0, reasoner=make_faulty(name, seed), ladder=BRIEF)
    assert seen.nearest_m > 0.25
    assert len(seen.directives) == 480


@pytest.mark.parametrize(
    "kind", [ObjectKind.PEDESTRIAN, ObjectKind.ANIMAL, ObjectKind.UNKNOWN, ObjectKind.CAR, ObjectKind.CONE]
)
def test_drive_over_restricted_kind_is_never_performed(kind):
    """No pedestrian, animal, unknown or solid object is driven over, whatever a reasoner says."""
    world = World(ROADS["two way"], [thing("it", 75.0, kind=kind)], x=66.0)
    seen = drive(world, 20.0, reasoner=make_faulty("always_drive_over"), ladder=BRIEF)
    assert not any(isinstance(d, Execute) and d.behavior.name == "drive_over" for d in seen.directives)
    assert seen.nearest_m > 0.25


def test_a_silent_one_costs_the_recovery_and_nothing_else():
    silent = make_faulty("silent")
    world = street(ROADS["two way"], 0)
    seen = drive(world, 17.0, reasoner=silent, clock="wall", ladder=BRIEF)
    assert set(map(type, seen.directives)) == {type(CONTINUE)}
    assert "no answer within 10 s" in seen.texts(EventKind.FAILED)[0]
    silent.cancel()


def test_late_answer_is_checked_against_present_world():
    """A late answer is checked against the world as it is now."""
    world = street(ROADS["two way"], 1)
    seen = drive(world, 40.0, reasoner=make_faulty("late"), ladder=BRIEF, clock="latency:3")
    assert seen.nearest_m > 0.3


@pytest.mark.integration
def test_the_same_seed_is_wrong_in_the_same_way():
    once, again = (
        drive(street(ROADS["two way"], 0), 15.0, reasoner=make_faulty("random", 7), ladder=BRIEF) for _ in range(2)
    )
    assert once.events == again.events


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(ValueError, match="random, always_left, always_drive_over, silent, late, contradictory"):
        make_faulty("evil")


@pytest.mark.integration
def test_listener_that_raises_is_reported_and_dropped():
    """A listener that raises an error is reported and not called again."""
    calls = []

    def broken(event):
        calls.append(event.kind)
        raise OSError("the pipe is broken")

    world = World(ROADS["two way"], [thing("lead", 75.0)], x=66.0)
    with StuckSolver(world.scene, clock="lockstep", on_event=broken) as solver:
        for _ in range(500):
            world.drive(solver.step(world.status(), world.surroundings))
    assert calls == [EventKind.TRIGGERED]
    assert world.x > 100.0
