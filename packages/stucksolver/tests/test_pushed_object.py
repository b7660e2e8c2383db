"""An ego that pushes something stops before anything else, and then does what it would do at a standstill."""

from __future__ import annotations

from stucksolver.immobilization import Detector, Trigger
from stucksolver.scene import Status
from test_duties import behaviors_of
from worlds import World, red_light, searched, straight_road, thing

TWO_WAY = straight_road()


def pushing(*, stood_s=30.0, speed=4.0, controls=(), offers=None):
    """Bumper to bumper with a car that stood for so long until it was pushed."""
    car = thing("car", 50.0 + 2.45 + 2.3, speed=speed, stationary_s=stood_s, pushed=True)
    world = World(TWO_WAY, [car], controls=controls, speed=speed, **({} if offers is None else {"offers": offers}))
    return searched(world)


def names(decision):
    return [behavior.name for behavior in behaviors_of(decision)]


def test_pushing_ego_stops_first():
    """What follows is decided after the stop: the guard cannot check it in surroundings that move."""
    decision = pushing()
    assert names(decision) == ["wait"]
    assert decision.analysis.immobilized
    assert "pushed along" in decision.rationale


def test_at_a_red_light_it_stops_and_does_nothing_more():
    assert names(pushing(controls=(red_light(6.0),))) == ["wait"]


def test_pushing_at_rest_is_decided_like_parked_car():
    """At rest, the search decides as behind a parked car, and waits for one that has just stopped."""
    assert names(pushing(speed=0.0)) == ["back_up", "borrow_oncoming_lane"]
    assert pushing(speed=0.0, stood_s=1.0).plan is None


def test_pushing_without_offered_wait_plans_no_wait():
    """A stack that offers no wait gets none."""
    plan = pushing(offers=("back_up", "borrow_oncoming_lane")).plan
    assert plan is None or "wait" not in [b.name for b in plan.behaviors]


def status(time_s, speed_mps, pushes):
    return Status(time_s=time_s, speed_mps=speed_mps, progress_m=0.0, pushes=pushes)


def test_pushing_for_a_second_is_being_immobilized_at_any_speed():
    for speed in (0.0, 3.0, 12.0):
        detector = Detector()
        triggers = [detector.update(status(0.05 * k, speed, pushes=True)) for k in range(25)]
        assert triggers[:19] == [None] * 19
        assert triggers[-1] is Trigger.CONTACT


def test_a_touch_in_passing_is_not():
    detector = Detector()
    assert not any(detector.update(status(0.05 * k, 6.0, pushes=k % 10 < 5)) for k in range(200))
