"""What the car thinks, from its state and what is ahead."""

from __future__ import annotations

import pytest
from sitting import Sitting, parked

from stucksolver.scene import ObjectKind
from stucksolver.solver import StuckSolver
from stucksolver_passenger.status_summary import mind
from worlds import World, red_light, straight_road, thing

ROAD = straight_road()


def thought(world):
    solver = StuckSolver(world.scene, clock="lockstep")
    return mind(solver.state, world.status(), None, world.scene())


def riders(count):
    return [thing(str(i), 70.0 + 6.0 * i, kind=ObjectKind.BICYCLE, speed=3.0) for i in range(count)]


@pytest.mark.parametrize(
    ("world", "told"),
    [
        (World(ROAD, speed=8.0), "I am driving along our route."),
        (World(ROAD), "I am standing."),
        (World(ROAD, riders(2), speed=3.0), "I am driving behind two cyclists."),
        (World(ROAD, riders(1), speed=3.0), "I am driving behind a cyclist."),
        (World(ROAD, [thing("v", 75.0, kind=ObjectKind.VAN)], speed=8.0), "There is a van ahead of me."),
        (
            World(ROAD, [thing(n, x) for n, x in (("a", 75.0), ("b", 82.0))], speed=8.0),
            "There are two cars ahead of me.",
        ),
        (World(ROAD, controls=(red_light(30.0),), speed=8.0), "The light ahead is red."),
        (World(ROAD, controls=(red_light(30.0, applies=False),), speed=8.0), "I am driving along our route."),
    ],
)
def test_what_is_ahead_is_told_as_people_say_it(world, told):
    assert thought(world).thought == told


def test_a_wait_is_told_with_what_ends_it():
    world = World(ROAD, controls=(red_light(4.0),), cruise_mps=0.0)
    sitting = Sitting(world)
    now = sitting.until(lambda now: "waiting" in now.thought, limit_s=10.0)
    assert (now.thought, now.intention) == ("I am waiting for the red light.", "I will drive on when it is green.")


def test_while_a_plan_runs_the_car_says_what_it_does():
    pytest.importorskip("onnxruntime")
    sitting = Sitting(parked())
    sitting.until(lambda now: now.question is not None)
    sitting.answer(True)
    now = sitting.until(lambda now: "executing" in now.state)
    assert now.thought == "I am going round it on the left."
    assert [answer.label for answer in now.answers] == ["Never mind, stop that"]
