"""A word counts after two looks that agree; what is unconfirmed is read again soon, and nothing is kept for long."""

from __future__ import annotations

from stucksolver.scene import ObservedSign, SignWord
from stucksolver_perception.camera.sign_filter import FORGET_S, SignFilter, SignReadout, WordLocation
from stucksolver_perception.camera.sign_targets import SignTarget

BARRIER = SignTarget("track-7", 0, 0, 100, 100, track_id=7, distance_m=12.0)
CAR = SignTarget("track-9", 0, 0, 100, 100, track_id=9, is_vehicle=True, distance_m=8.0)
POST = SignTarget("post-0", 0, 0, 100, 100, distance_m=15.3)
AHEAD = SignTarget("ahead-1", 0, 0, 640, 300, single=False)


def after(*looks):
    memory = SignFilter()
    for time_s, (target, *words) in enumerate(looks):
        memory.add(SignReadout(float(time_s), target, dict(words)))
    return memory, float(len(looks))


def signs(*looks):
    memory, time_s = after(*looks)
    return memory.signs(time_s)


STOP, SLOW = (SignWord.STOP, WordLocation(0.1, 7)), (SignWord.SLOW, WordLocation(0.1, 7))
ALONE = (SignWord.STOP, WordLocation(0.1))


def test_one_look_proves_nothing_and_two_that_agree_count():
    assert signs((BARRIER, STOP)) == ()
    assert signs((BARRIER, STOP), (BARRIER, STOP)) == (ObservedSign(word=SignWord.STOP, object_id="7"),)
    assert signs((BARRIER, STOP), (AHEAD, STOP)) == ()


def test_sign_filter_one_failed_look_keeps_word():
    """One failed look in between changes nothing, but two of them do."""
    assert len(signs((BARRIER, STOP), (BARRIER,), (BARRIER, STOP))) == 1
    assert len(signs((BARRIER, STOP), (BARRIER, STOP), (BARRIER,))) == 1
    assert signs((BARRIER, STOP), (BARRIER, STOP), (BARRIER,), (BARRIER,)) == ()


def test_sign_filter_turned_paddle_needs_two_new_looks():
    """A paddle that is turned has no word until its new side is read twice."""
    assert signs((BARRIER, STOP), (BARRIER, STOP), (BARRIER, SLOW)) == ()
    told = signs((BARRIER, STOP), (BARRIER, STOP), (BARRIER, SLOW), (BARRIER, SLOW))
    assert [item.word for item in told] == [SignWord.SLOW]


def test_an_old_word_is_forgotten_and_a_departure_forgets_all():
    memory, time_s = after((BARRIER, STOP), (BARRIER, STOP))
    assert memory.signs(1.0 + FORGET_S) != ()
    assert memory.signs(1.1 + FORGET_S) == ()
    memory.clear()
    assert memory.signs(time_s) == ()


def test_sign_without_object_has_bearing_and_known_distance():
    """A sign on no object has its bearing, and its distance if the map has its place."""
    assert signs((POST, ALONE), (POST, ALONE)) == (ObservedSign(word=SignWord.STOP, distance_m=15.3, bearing_rad=0.1),)
    assert signs((AHEAD, ALONE), (AHEAD, ALONE)) == (ObservedSign(word=SignWord.STOP, bearing_rad=0.1),)
    assert signs((CAR, ALONE), (CAR, ALONE)) == (ObservedSign(word=SignWord.STOP, bearing_rad=0.1),)


def test_sign_in_two_crops_is_reported_once_with_object():
    """The same sign in two crops is reported once, with its object."""
    looks = [(AHEAD, (SignWord.STOP, WordLocation(0.12))), (BARRIER, STOP), (POST, ALONE)]
    assert signs(*looks, *looks) == (ObservedSign(word=SignWord.STOP, object_id="7"),)
    elsewhere = (AHEAD, (SignWord.STOP, WordLocation(-0.3)))
    assert len(signs(elsewhere, elsewhere, (BARRIER, STOP), (BARRIER, STOP))) == 2


def test_sign_filter_next_alternates_and_repeats_found_words():
    """All targets have their turn, and a target with one reading is read again soon."""
    memory = SignFilter()
    places = [BARRIER, AHEAD, CAR, POST]
    order = []
    for time_s in range(8):
        target = memory.next_of(places, float(time_s))
        order.append(target.key)
        memory.add(SignReadout(float(time_s), target, dict([STOP]) if target is BARRIER else {}))
    assert order[:2] == ["track-7", "track-7"]
    assert set(order) == {"track-7", "ahead-1", "track-9", "post-0"}
    assert order.count("track-7") <= 4
    assert memory.next_of([], 9.0) is None
