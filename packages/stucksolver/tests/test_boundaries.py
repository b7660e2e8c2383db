"""What comes in is validated once: nothing that cannot be true is proven, and nothing that is raised gets through."""

from __future__ import annotations

import math

import pytest

from stucksolver import CONTINUE, StuckSolver
from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import BorrowOncomingLane, DriveOver, KeepLane
from stucksolver.scene import ObjectKind, Surroundings
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.plausibility import implausibility
from stucksolver.solver import EventKind
from stucksolver.solver.surroundings_monitor import SurroundingsMonitor
from worlds import LANE_M, World, drive, straight_road, stubborn, thing

GUARD = Guard()
BORROW = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
WORLD = World(straight_road(), [thing("lead", 65.0)])
COMING = thing("coming", 100.0, LANE_M, speed=-10.0)


def codes(behaviors, surroundings):
    return {r.code for r in GUARD.accept(behaviors, FrenetScene(surroundings), False)[0].rejects}


def seen(**changes):
    return WORLD.surroundings().model_copy(update=changes)


def with_object(**changes):
    lead = WORLD.objects[0]
    return seen(objects=(lead, COMING.model_copy(update=changes)))


UNSOUND = {
    "a velocity that is no number": with_object(vx_mps=math.nan),
    "a place without end": with_object(x_m=math.inf),
    "a negative age of an object": with_object(stationary_s=-1.0),
    "two objects of one id": with_object(id="lead"),
    "a length of nothing": with_object(length_m=0.0),
    "a ship": with_object(length_m=300.0),
    "an age below nought": seen(age_s=-3.0),
    "a time that is no number": seen(time_s=math.nan),
    "an ego nowhere": seen(ego=WORLD.ego().model_copy(update={"x_m": math.nan})),
    "brakes without bound": seen(
        ego=WORLD.ego().model_copy(
            update={"limits": WORLD.ego().limits.model_copy(update={"comfort_braking_mps2": 1e9})}
        )
    ),
    "no brakes": seen(
        ego=WORLD.ego().model_copy(
            update={"limits": WORLD.ego().limits.model_copy(update={"comfort_braking_mps2": 0.0})}
        )
    ),
}


@pytest.mark.parametrize("what", UNSOUND)
def test_nothing_is_proven_on_what_cannot_be_true(what):
    assert implausibility(UNSOUND[what])
    assert codes([BORROW], UNSOUND[what]) == {RejectCode.IMPLAUSIBLE}


@pytest.mark.parametrize("what", UNSOUND)
def test_it_counts_as_nothing_seen_and_grows_old(what):
    senses, good = SurroundingsMonitor(), seen()
    assert senses.look(lambda: good, 0.0) is good
    later = senses.look(lambda: UNSOUND[what], 1.0)
    assert later is not None and later.age_s == pytest.approx(1.0)
    assert "are inconsistent" in (senses.fault or "")


def test_sound_surroundings_are_sound():
    assert implausibility(seen()) is None and codes([BORROW], seen()) == set()


@pytest.mark.parametrize("part", ["scene", "surroundings"])
def test_what_the_stack_raises_does_not_get_through_step(part):
    world = World(straight_road(), [thing("lead", 60.0)])

    def broken(*seen):
        raise RuntimeError("a sensor's own fault")

    setattr(world, part, broken)
    told = drive(world, 20.0, ladder=stubborn())
    assert set(told.directives) == {CONTINUE}
    assert any("a sensor's own fault" in e.text for e in told.events)
    assert EventKind.STARTED not in told.kinds()


@pytest.mark.parametrize("given", ["a string", 3, {"frame": 1}])
def test_what_is_no_surroundings_at_all_is_told(given):
    senses = SurroundingsMonitor()
    assert senses.look(lambda: given, 0.0) is None and "returned a" in senses.fault


def test_objects_that_stand_still_under_running_frame_numbers_grow_old():
    senses = SurroundingsMonitor()
    first = with_object()
    senses.look(lambda: first, 0.0)
    for k in range(1, 20):
        aged = senses.look(lambda k=k: first.model_copy(update={"frame": k, "time_s": 0.1 * k}), 0.1 * k)
    assert aged.age_s > 1.5 and "same frame" in senses.fault


class Blind(KeepLane):
    checks = ()


@pytest.mark.parametrize(
    "plan",
    [
        [Blind(distance_m=40.0, speed_mps=5.0)],
        ["keep_lane"],
        [KeepLane.model_construct(name="keep_lane", distance_m=1e9, speed_mps=5.0)],
        [KeepLane.model_construct(name="keep_lane", distance_m=math.nan, speed_mps=5.0)],
        [KeepLane.model_construct(name="keep_lane", distance_m="far", speed_mps=5.0)],
        [KeepLane(distance_m=5.0, speed_mps=5.0)] * 1_000_000,
    ],
    ids=["subclass", "string", "1e9 m", "nan", "words", "a million"],
)
def test_a_plan_that_is_none_is_refused(plan):
    assert codes(plan, World(straight_road()).surroundings()) == {RejectCode.IMPLAUSIBLE}


@pytest.mark.parametrize("change", [{"length_m": 6.0, "width_m": 4.0}, {"vx_mps": 3.0}, {"vy_mps": -3.0}])
def test_only_a_small_bag_that_lies_there_is_driven_over(change):
    bag = thing("bag", 62.0, kind=ObjectKind.BAG, height=0.1, seen_for_s=2.0, kind_confidence=0.9)
    over = DriveOver(object_id="bag")
    assert codes([over], World(straight_road(), [bag]).surroundings()) == set()
    other = World(straight_road(), [bag.model_copy(update=change)])
    assert RejectCode.NOT_PASSABLE in codes([over], other.surroundings())


@pytest.mark.parametrize("field", ["time_s", "speed_mps", "progress_m"])
def test_step_nan_in_status_raises_no_error(field):
    """A NaN in the status raises no error and leads to no contact."""
    world = World(straight_road(), [thing("lead", 60.0)])
    with StuckSolver(world.scene, clock="lockstep", ladder=stubborn()) as solver:
        for k in range(100):
            status = world.status()
            if k > 40:
                status = status.model_copy(update={field: math.nan})
            world.drive(solver.step(status, world.surroundings))
    assert world.clearance() > 0.3


def test_the_type_itself_refuses_what_is_no_number():
    with pytest.raises(ValueError):
        Surroundings(**{**seen().model_dump(), "age_s": math.nan})
