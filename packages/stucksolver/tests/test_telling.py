"""People are informed why the vehicle stands: the passenger within 10 s, the operator within 30 s, once per reason."""

from __future__ import annotations

import itertools

import pytest

from stucksolver.plan import WaitReason
from stucksolver.reasoners import ReasonerError
from stucksolver.scene import LightState, ObjectKind
from stucksolver.solver import EventKind
from worlds import LANE_M, World, drive, ladder, red_light, straight_road, stubborn, thing

ROAD = straight_road(oncoming=None)


def told(seen, to):
    """Times and notices to a person."""
    return [(e.time_s, e.notice) for e in seen.events if e.kind is EventKind.WAITING and e.notice.to == to]


def standing(*objects, **more):
    """The ego stands from the first tick on, and its driver does not go."""
    return World(ROAD, list(objects), cruise_mps=0.0, **more)


def crossing_people(x):
    """People who never stop crossing, each after the other."""
    return [thing(f"p{k}", x, -3.0 - 1.2 * k, kind=ObjectKind.PEDESTRIAN, sideways=0.6) for k in range(40)]


class Silent:
    """Never has an idea."""

    name = "silent"

    def decide(self, request):
        raise ReasonerError("no idea")


CASES = {
    "people": lambda: (standing(*crossing_people(60.0)), {}),
    "a person stands in the lane": lambda: (standing(thing("p", 60.0, 0.4, kind=ObjectKind.PEDESTRIAN)), {}),
    "gate": lambda: (standing(thing("g", 60.0, kind=ObjectKind.CROSSING_GATE, length=0.3, width=5.0)), {}),
    "queue": lambda: (standing(thing("lead", 60.0, stationary_s=20.0, moved_s_ago=20.0)), {}),
    "unknown vehicle": lambda: (standing(thing("lead", 60.0, stationary_s=0.0)), {}),
    "a wall": lambda: (standing(thing("wall", 62.0, kind=ObjectKind.BARRIER, width=6.0, length=1.0)), {}),
    "no answer": lambda: (standing(thing("lead", 60.0)), {"reasoner": Silent()}),
}


@pytest.mark.parametrize("make", CASES.values(), ids=CASES)
def test_standstill_informs_passenger_and_operator_in_time(make):
    world, more = make()
    seen = drive(world, 40.0, **{"ladder": stubborn(), **more})
    passenger, operator = told(seen, "passenger"), told(seen, "operator")
    assert passenger and passenger[0][0] <= 10.0
    assert operator and operator[0][0] <= 30.0
    assert all(notice.reason.text for _, notice in passenger + operator)


@pytest.mark.parametrize("make", CASES.values(), ids=CASES)
def test_notice_is_not_repeated_for_same_reason(make):
    world, more = make()
    seen = drive(world, 60.0, **{"ladder": stubborn(), **more})
    for to in ("passenger", "operator"):
        keys = [notice.reason.key for _, notice in told(seen, to)]
        assert all(a != b for a, b in itertools.pairwise(keys))
        assert len(keys) <= 4


def test_notice_leaves_ladder_and_questions_alone():
    seen = drive(standing(*crossing_people(60.0)), 45.0)
    assert told(seen, "operator")
    assert not {EventKind.ESCALATED, EventKind.ASKED, EventKind.STOPPED} & set(seen.kinds())
    assert told(seen, "passenger")[0][1].reason.wait is WaitReason.PEOPLE


def test_notice_is_withdrawn_when_vehicle_moves_on():
    def clear(world):
        if world.time_s > 35.0:
            world.objects, world.cruise_mps = [], 8.0

    seen = drive(standing(*crossing_people(60.0)), 45.0, every_tick=clear)
    ended = [e for e in seen.events if e.kind is EventKind.WAITING_ENDED]
    assert {e.notice.to for e in ended} == {"passenger", "operator"}
    assert all(35.0 < e.time_s < 39.0 for e in ended)
    assert all(e.kind is not EventKind.WAITING for e in seen.events if e.time_s > 36.0)


def test_red_light_is_reported_to_both_after_50_s():
    """No notice at each light, but one that stays red is known before anybody asks."""
    seen = drive(standing(thing("far", 300.0), controls=(red_light(6.0),)), 60.0, ladder=stubborn())
    told = [(e.notice.to, round(e.time_s)) for e in seen.events if e.kind is EventKind.WAITING]
    assert told == [("passenger", 50), ("operator", 50)]


def test_queue_before_red_light_is_not_reported():
    lead = thing("lead", 60.0, stationary_s=20.0, moved_s_ago=20.0)
    seen = drive(standing(lead, controls=(red_light(25.0),)), 40.0, ladder=stubborn())
    assert EventKind.WAITING not in seen.kinds()


def test_queue_after_light_turned_green_is_reported():
    lead = thing("lead", 60.0, stationary_s=20.0, moved_s_ago=20.0)
    seen = drive(standing(lead, controls=(red_light(25.0, LightState.GREEN),)), 15.0, ladder=stubborn())
    assert told(seen, "passenger")[0][1].reason.wait is WaitReason.QUEUE


def test_observer_informs_nobody():
    seen = drive(standing(*crossing_people(60.0)), 40.0, observe_only=True)
    assert EventKind.WAITING not in seen.kinds()


def test_tell_settings_are_those_of_the_ladder():
    quick = ladder().model_copy(update={"tell": ladder().tell.model_copy(update={"passenger_s": 3.0})})
    seen = drive(standing(*crossing_people(60.0)), 12.0, ladder=quick)
    assert told(seen, "passenger")[0][0] <= 3.0


def test_reason_names_binding_object_and_no_bystander():
    """A pass is refused for the narrow gap beside a person. The car far ahead holds up nobody."""
    world = World(
        straight_road(),
        [thing("lead", 62.0), thing("far", 120.0), thing("walker", 63.0, LANE_M, kind=ObjectKind.PEDESTRIAN)],
        cruise_mps=0.0,
    )
    seen = drive(world, 100.0, ladder=ladder(rungs={"model": None, "passenger": None, "reasoner": {"tries": 2}}))
    texts = [n.reason.text for _, n in told(seen, "passenger")] + seen.texts(EventKind.ASKED)
    assert texts
    assert not any("far" in text for text in texts)
