"""Denials, dangers, alarms and prohibitions in closed loop: what the vehicle does, not how the words are read."""

from __future__ import annotations

from functools import cache

import pytest

from grids import each_value, sample
from stucksolver.plan import Execute
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.solver import EventKind
from test_claims import at_red, bag
from worlds import World, drive, straight_road, thing

TWO_WAY = straight_road()
ONE_LANE = straight_road(oncoming=None)
BAG_M = 75.0


def reached_m(confidence, words, seconds=15.0):
    """Return how far the vehicle gets in a lane with a bag at 75 m and no way round it (m)."""
    world = World(ONE_LANE, [bag(confidence)], x=64.0, cruise_mps=0.0)
    drive(world, seconds, words=words)
    return world.x


@pytest.mark.integration
def test_bag_is_driven_over_in_silence_or_when_confirmed():
    """Without this, the tests below could not fail."""
    assert reached_m(0.9, {}) > BAG_M
    assert reached_m(0.6, {}) < BAG_M
    assert reached_m(0.6, {2.0: "that's not a rock, it's only a bag"}) > BAG_M


DENIALS = [
    "that is not a bag",
    "It's a body, not a bag!",
    "It's a sleeping dog, not a bag.",
    "There's something alive in it!",
    "I thought it was a bag, but it isn't",
    "somebody is lying under that blanket",
    "that bag is full of bricks",
    "don't drive over that",
    "das ist ein Igel, keine Plastiktüte",
    "¡Hay un gato dentro de la bolsa!",
]


@pytest.mark.parametrize(("words", "confidence"), each_value(DENIALS, [0.6, 0.9]))
def test_denied_bag_is_not_driven_over(words, confidence):
    """Neither as a permission at 0.6 nor where perception alone would allow it."""
    assert reached_m(confidence, {0.05: words}) < BAG_M


@pytest.mark.integration
@pytest.mark.parametrize(
    "order", [("it's a sleeping dog", "that's only a bag"), ("that's only a bag", "it's not a bag")]
)
def test_danger_wins_over_a_claim_in_any_order(order):
    """Of two people who contradict each other about what lies there, the careful one counts."""
    assert reached_m(0.6, {0.05: order[0], 0.1: order[1]}, seconds=45.0) < BAG_M


@pytest.mark.integration
@pytest.mark.parametrize("words", ["that is not a bag", "there's something alive in it!", "STOP! It's a cat!"])
def test_danger_stops_a_plan_that_already_drives_over_it(words):
    silent, at = World(ONE_LANE, [bag(0.9)], x=64.0, cruise_mps=0.0), []
    drive(silent, 20.0, every_tick=lambda w: at.append((w.time_s, w.x)))
    moving_s = next(t for t, x in at if x > 66.0)
    assert reached_m(0.9, {moving_s: words}) + 2.45 < BAG_M


@pytest.mark.integration
def test_bar_ends_once_the_object_is_behind():
    world = World(ONE_LANE, [thing("dog", 300.0, 30.0, kind=ObjectKind.ANIMAL)], x=50.0)
    world.objects.append(bag(0.9).model_copy(update={"x_m": 170.0}))
    drive(world, 60.0, words={1.0: "it's a sleeping dog"})
    assert world.x > 170.0


# ---- alarms and prohibitions


def round_a_car():
    return World(TWO_WAY, [thing("lead", 100.0)], x=60.0)


@cache
def begun_s():
    return next(e.time_s for e in drive(round_a_car(), 30.0).events if e.kind is EventKind.STARTED)


ALARMS = [
    "STOP! You'll hit her!",
    "You're going to hit him!",
    "Hit the brakes!",
    "There's a child running after the ball!",
    "Look out, a bike!",
    "that lorry is coming straight at us",
    "somebody's right behind the van",
    "she's stepping into the road",
    "Vorsicht, ein Kind!",
    "Freine ! Tu vas le renverser !",
    "快刹车！要撞到人了！",
    "the policeman says we can't go through",
    "the warden is holding up his hand",
    "that officer won't let us pass",
]


@pytest.mark.integration
@pytest.mark.parametrize("words", ALARMS)
def test_alarm_ends_running_plan_and_blocks_new_ones(words):
    """An alarm ends the running plan, and no plan starts for a while."""
    said_s = round(begun_s() + 0.1, 2)
    seen = drive(round_a_car(), said_s + 5.0, words={said_s: words})
    ended = [e for e in seen.events if e.kind in (EventKind.ABORTED, EventKind.FINISHED)]
    assert [e.text for e in ended] == ["withdrawn"]
    assert ended[0].time_s < said_s + 3.0
    assert [e.time_s for e in seen.events if e.kind is EventKind.STARTED] == [begun_s()]


@pytest.mark.integration
@pytest.mark.parametrize("words", ["stop worrying and go", "no need to brake, carry on", "what a cute dog that was"])
def test_harmless_words_let_a_plan_run_to_its_end(words):
    said_s = round(begun_s() + 0.1, 2)
    seen = drive(round_a_car(), said_s + 25.0, words={said_s: words})
    assert "withdrawn" not in seen.texts(EventKind.ABORTED)
    assert EventKind.FINISHED in seen.kinds()


@cache
def unforbidden():
    """Return when it begins to move in silence, and when somebody waves."""
    return stand_off({}), stand_off({1.5: "he waves us through"})


def stand_off(words):
    """Return when the vehicle begins to move before a car that stands across its lane; None if it does not."""
    world = World(ONE_LANE, [thing("other", 72.0, 0.0, yaw=1.57, stationary_s=5.0)], x=62.0, cruise_mps=0.0)
    seen = drive(world, 20.0, words=words)
    return next((e.time_s for e in seen.events if e.kind is EventKind.STARTED), None)


FORBIDS = [
    "the policeman says we can't go through",
    "the warden is holding up his hand",
    "he's not waving us through",
    "that wave wasn't for us",
    "he's waving us back",
    "er winkt uns nicht durch",
]


@pytest.mark.integration
@pytest.mark.parametrize("words", FORBIDS)
def test_prohibition_ends_no_stand_off_sooner(words):
    (silent, waved), forbidden = unforbidden(), stand_off({1.5: words})
    assert waved is not None and (silent is None or silent > waved)
    assert forbidden is None or (silent is not None and forbidden >= silent)


@pytest.mark.integration
@pytest.mark.parametrize("words", FORBIDS[:3])
def test_prohibition_takes_an_earlier_permission_back(words):
    both = stand_off({0.05: "he waves us through", 0.1: words})
    silent, _ = unforbidden()
    assert both is None or (silent is not None and both >= silent)


@pytest.mark.parametrize(
    "words", ["That light isn't broken.", "the light is working again", "Die Ampel ist nicht kaputt."]
)
def test_denied_broken_light_asks_nobody(words):
    assert at_red({5.0: words})[1] == []


@pytest.mark.integration
@pytest.mark.parametrize("words", ["he is not parked, he's only waiting", "he won't be staying long"])
def test_denied_long_stay_passes_nobody_sooner(words):
    def first(said):
        van = thing("van", 75.0, kind=ObjectKind.VAN, stationary_s=0.0)
        world = World(straight_road(left=LineKind.BROKEN, oncoming=None), [van], x=66.0, cruise_mps=0.0)
        return next((e.time_s for e in drive(world, 20.0, words=said).events if e.kind is EventKind.STARTED), 1e9)

    assert first({2.0: words}) >= first({})


# ---- letting somebody out


def let_out(later=None, seconds=90.0):
    """Let somebody out at 4 s. Returns the drive, and for each second whether the vehicle stood."""
    world, stood = World(TWO_WAY, x=60.0), {}
    seen = drive(
        world,
        seconds,
        words={4.0: "let me out here", **(later or {})},
        every_tick=lambda w: stood.update({round(w.time_s, 2): w.speed < 0.05}),
    )
    return seen, [stands for when, stands in stood.items() if when > 15.0]


@pytest.mark.integration
def test_let_out_vehicle_stays_until_told_to_go():
    _, stood = let_out()
    assert all(stood)


OTHER_WORDS = (
    "wait", "what a lovely day", "thank you, bye", "yes", "pull over", "let me out", "hold the door", "uh",
    "wait a moment", "hold on, she is not out yet", "stop!",
)  # fmt: skip


@pytest.mark.integration
def test_let_out_other_words_do_not_send_it_off():
    """Each is said 6 s after the one before, and the last 40 s before the end of the drive."""
    said = {20.0 + 6.0 * k: words for k, words in enumerate(OTHER_WORDS)}
    _, stood = let_out(said, seconds=120.0)
    left_s = next((15.0 + 0.05 * k for k, stands in enumerate(stood) if not stands), None)
    assert left_s is None, [words for when_s, words in said.items() if when_s <= left_s][-1:]


@pytest.mark.integration
@pytest.mark.parametrize("words", sample(["you can drive on now", "go", "off you go", "fahr los"], 2))
def test_let_out_vehicle_drives_on_when_told(words):
    _, stood = let_out({60.0: words}, seconds=75.0)
    assert all(stood[: 44 * 20])
    assert not all(stood)


@pytest.mark.integration
def test_let_out_holds_by_a_standing_directive():
    seen, _ = let_out(seconds=60.0)
    last = seen.directives[-1]
    assert isinstance(last, Execute) and not last.path
