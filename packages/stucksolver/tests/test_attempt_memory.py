"""Failed plans stay in memory while the object they failed at is still ahead, whatever progress it allows."""

from __future__ import annotations

import pytest

from stucksolver.record import Recorder, replay
from stucksolver.scene import ObjectKind
from stucksolver.solver import EventKind
from stucksolver.solver.state_machine.blockers import REMEMBERED_M, Blocker
from test_between_steps import Refuses, Stubborn
from worlds import World, drive, ladder, straight_road, stubborn, thing

pytestmark = pytest.mark.integration
STANDS_S, MOVES_M, MOVES_MPS = 15.0, 12.0, 3.0


class Collects:
    """A collection vehicle: stands, drives 12 m, and stands again; at `until_s` it turns off."""

    def __init__(self, until_s=1e9):
        self.until_s = until_s

    def __call__(self, world):
        period = STANDS_S + MOVES_M / MOVES_MPS
        speed = MOVES_MPS if world.time_s % period > STANDS_S else 0.0
        world.objects = [
            o.model_copy(update={"vx_mps": speed, "stationary_s": 0.0 if speed else o.stationary_s})
            for o in world.objects
            if world.time_s < self.until_s
        ]


def behind_truck(seconds, moves, **options):
    truck = thing("lead", 62.0, kind=ObjectKind.TRUCK, hazard=True, length=8.0, width=2.5)
    world = World(straight_road(), [truck])
    usual = {"guard": Refuses(None, "oncoming_sight"), "reasoner": Stubborn(), "ladder": stubborn(repair_rounds=0)}
    return drive(world, seconds, every_tick=moves, **usual | options), world


def test_queue_progress_does_not_forget_failed_plans():
    """The same back-up failed ten times, since each 15 m behind the truck counted as a recovery."""
    seen, world = behind_truck(200.0, Collects())
    assert world.x > 50.0 + 100.0, "the ego follows the truck"
    assert seen.kinds().count(EventKind.STARTED) <= 2
    assert EventKind.RECOVERED not in seen.kinds()
    assert EventKind.QUEUE_MOVED in seen.kinds()


def test_ladder_is_not_climbed_behind_vehicle_that_moves_on():
    """Nobody is called for a vehicle that moves on every 20 s."""
    two = ladder(rungs={"model": None, "passenger": None, "reasoner": {"tries": 10, "repair_rounds": 0}})
    seen, _ = behind_truck(200.0, Collects(), ladder=two)
    assert not {EventKind.ESCALATED, EventKind.ASKED, EventKind.STOPPED} & set(seen.kinds())


def test_ladder_is_climbed_once_vehicle_has_stopped_for_good():
    two = ladder(rungs={"model": None, "passenger": None, "reasoner": {"tries": 10, "repair_rounds": 0}})
    seen, _ = behind_truck(190.0, lambda w: Collects()(w) if w.time_s < 85.0 else None, ladder=two)
    asked = [e for e in seen.events if e.kind is EventKind.ASKED]
    assert asked and asked[0].time_s < 85.0 + 60.0 + 40.0
    assert "repeated" not in asked[0].text


def test_progress_after_blocker_turned_off_is_a_recovery():
    seen, _ = behind_truck(45.0, Collects(until_s=25.0))
    assert EventKind.RECOVERED in seen.kinds()
    assert EventKind.QUEUE_MOVED not in seen.kinds()


def test_progress_past_blocker_is_a_recovery():
    world = World(straight_road(), [thing("lead", 62.0, hazard=True)])
    seen = drive(world, 40.0, ladder=stubborn())
    assert EventKind.RECOVERED in seen.kinds()
    assert EventKind.QUEUE_MOVED not in seen.kinds()


def test_plans_are_forgotten_with_their_blocker():
    """Behind another vehicle the same kind of plan may be tried again."""

    def other_truck(world):
        if world.time_s < 30.0:
            Collects(until_s=25.0)(world)
        elif not world.objects:
            world.objects = [thing("lead", world.x + 30.0, kind=ObjectKind.TRUCK, hazard=True, length=8.0, width=2.5)]

    seen, _ = behind_truck(60.0, other_truck)
    assert [e.time_s > 30.0 for e in seen.events if e.kind is EventKind.STARTED][-1]


def test_record_that_begins_with_remembered_plans_is_derived_again(tmp_path):
    with Recorder(tmp_path) as recorder:
        seen, _ = behind_truck(90.0, Collects(), record=recorder, guard=None)
    assert EventKind.CLOSED in seen.kinds()
    for file in recorder.files:
        assert replay(file).findings == []


@pytest.mark.parametrize(("sensed", "same"), [(True, True), (False, False)])
def test_blocker_found_again_by_sensors_keeps_its_kind(sensed, same):
    blocker = Blocker("track 7", ObjectKind.TRUCK, 100.0)
    assert blocker.is_same("track 9", ObjectKind.TRUCK, sensed=sensed) is same


def test_blocker_followed_for_long_is_forgotten():
    world = World(straight_road(), [thing("lead", 62.0)])
    blocker = Blocker("lead", ObjectKind.CAR, 100.0)
    assert blocker.still_blocks(world.scene(), 110.0, 30.0)
    assert not blocker.still_blocks(world.scene(), 100.0 + REMEMBERED_M + 1.0, 30.0)
