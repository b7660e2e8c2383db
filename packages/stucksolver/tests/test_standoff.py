"""Two vehicles with the add-on face each other: a drawn number decides who yields."""

from __future__ import annotations

import math
from contextlib import ExitStack

import pytest

from stucksolver.plan import RecoveryPlan, WaitReason
from stucksolver.plan.behaviors import BackUp, Wait
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import SceneEgo
from stucksolver.solver import StuckSolver
from worlds import World, drive, noticed, straight_road, stubborn, thing

pytestmark = pytest.mark.integration
LENGTH_M, GAP_M, OUT_M = 160.0, 8.0, 6.0
"""Length of the street, gap between the noses, and distance from there to a vehicle's side street (m)."""


class DrawsLots:
    """Backs up if the drawn number is small, otherwise waits for the other one to do so."""

    name = "draws lots"

    def __init__(self):
        self.draws = []

    def decide(self, request):
        noted = noticed(request.scene)
        draw = request.scene.ego.yield_draw
        self.draws.append(draw)
        backs = draw is not None and draw < 0.5
        plan = RecoveryPlan(behaviors=(BackUp(distance_m=8.0, speed_mps=2.0), Wait(duration_s=10.0))) if backs else None
        changes = {"wait": None if backs else WaitReason.YIELD, "immobilized": backs}
        analysis = noted.analysis.model_copy(update=changes)
        decision = noted.model_copy(update={"plan": plan, "analysis": analysis})
        return ReasonerAnswer(decision, self.name)


def as_seen_from_the_other_end(world, stood_s):
    """The ego of a world as an object of the same street, measured from its other end."""
    car = thing("other", LENGTH_M - world.x, -world.y, length=4.9, width=1.85, stationary_s=stood_s)
    turned = {"yaw_rad": math.remainder(math.pi + world.yaw, math.tau), "vx_mps": -world.speed}
    return car.model_copy(update=turned)


def nose_to_nose(ids, seconds=90.0):
    """Time until a vehicle has reached its side street (s), and the smallest gap; None if neither does."""
    start_m = (LENGTH_M - GAP_M) / 2 - 2.45
    worlds = [World(straight_road(oncoming=None), x=start_m) for _ in ids]
    stood_s, nearest_m = [0.0, 0.0], math.inf
    with ExitStack() as stack:
        solvers = [
            stack.enter_context(
                StuckSolver(w.scene, clock="lockstep", ladder=stubborn(), reasoner=DrawsLots(), vehicle_id=name)
            )
            for w, name in zip(worlds, ids, strict=True)
        ]
        while worlds[0].time_s < seconds:
            for k in (0, 1):
                stood_s[k] = 0.0 if abs(worlds[k].speed) > 0.1 else stood_s[k] + worlds[k].dt
            cars = [as_seen_from_the_other_end(w, s) for w, s in zip(worlds, stood_s, strict=True)]
            for k in (0, 1):
                worlds[k].objects = [cars[1 - k]]
            nearest_m = min(nearest_m, worlds[0].clearance())
            told = [s.step(w.status(), w.surroundings) for s, w in zip(solvers, worlds, strict=True)]
            for world, directive in zip(worlds, told, strict=True):
                world.drive(directive)
            if max(w.x for w in worlds) > start_m + OUT_M:
                return worlds[0].time_s, nearest_m
    return None, nearest_m


def test_standoff_of_two_vehicles_ends():
    when_s, nearest_m = nose_to_nose(("north", "south"))
    assert when_s is not None
    assert nearest_m > 0.5


def test_standoff_of_vehicles_that_draw_alike_lasts():
    """Without different ids nothing breaks the symmetry: this is the fault that the draw mends."""
    when_s, nearest_m = nose_to_nose(("one", "one"))
    assert when_s is None
    assert nearest_m > 0.5


def faced(vehicle_id, seconds=40.0, other=None):
    """The numbers that a vehicle draws in front of one that faces it."""
    reasoner = DrawsLots()
    other = other or thing("other", 60.0, yaw=math.pi, stationary_s=60.0)
    world = World(straight_road(oncoming=None), [other], cruise_mps=0.0)
    drive(world, seconds, ladder=stubborn(), reasoner=reasoner, vehicle_id=vehicle_id)
    return list(dict.fromkeys(reasoner.draws))


def test_draw_is_same_for_same_vehicle_and_another_for_another():
    assert faced("a", 20.0) == faced("a", 20.0)
    assert faced("a", 20.0) != faced("b", 20.0)


def test_draw_begins_after_8_s_and_changes():
    draws = faced("a")
    assert draws[0] is None and len(draws) >= 3
    assert all(0.0 <= draw < 1.0 for draw in draws[1:])


@pytest.mark.parametrize(
    "other",
    [thing("ahead", 60.0), thing("far", 150.0, yaw=math.pi), thing("cone", 60.0, kind="cone", yaw=math.pi)],
    ids=lambda o: o.id,
)
def test_nothing_is_drawn_without_a_facing_vehicle(other):
    assert faced("a", 20.0, other) == [None]


def test_ego_of_former_record_has_no_draw():
    fields = {"speed_mps": 0.0, "lane_id": None, "lateral_offset_m": 0.0, "distance_to_destination_m": None}
    assert SceneEgo(**fields, at_destination=False, length_m=4.9, width_m=1.9).yield_draw is None
