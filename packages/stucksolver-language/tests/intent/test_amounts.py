"""Amounts in words. Most sentences are from the sets and the corpus of other authors, who did not know this grammar."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.interpreter import find_reader
from stucksolver.scene import GuidanceIntent, GuidanceLimits
from stucksolver_language.intent.quantities import LARGEST, read_amounts

READER = find_reader()
SAID = {
    "Retreat. Two metres back, then we see.": {"distance_m": 2.0},
    "Not here, there's no dropped kerb; pull up ten metres further on.": {"distance_m": 10.0},
    "BACK HER UP TEN METRES BACK BACK BACK": {"distance_m": 10.0},
    "Give him a little more elbow room, dear, back off a yard or so.": {"distance_m": 0.91},
    "A metre forward, please, so the fire brigade can get at it.": {"distance_m": 1.0},
    "We're offside 'ere, drop back ten yards.": {"distance_m": 9.14},
    "The appliance needs this space; move back ten metres or so.": {"distance_m": 10.0},
    "fahr mal zwei meter nach hinten, der stapler braucht platz": {"distance_m": 2.0},
    "On recule de vingt mètres et on laisse sortir le voisin.": {"distance_m": 20.0},
    "Retrocede dos metros y le dejas la parada.": {"distance_m": 2.0},
    "please reverse two and a half metres": {"distance_m": 2.5},
    "后退三米": {"distance_m": 3.0},
    "I draw the line at five miles an hour, out to the right and by.": {"speed_mps": 2.24},
    "go round it, but not faster than 10 km/h": {"speed_mps": 2.78},
    "go past at no more than twenty-five kilometres an hour": {"speed_mps": 6.94},
    "Give them a wide berth and come past dead slow, there's a good chap.": {"speed_mps": 1.5},
    "Creep round his cart gently so you don't spook the pony.": {"speed_mps": 2.8},
    "links an der rettung is platz, schrittgeschwindigkeit": {"speed_mps": 1.5},
    "慢慢从献血车边上绕行。": {"speed_mps": 2.8},
    "Girl, get over to the side for two minutes, I cannot do liner like this.": {"wait_s": 120.0},
    "HE S ONLY DROPPING OFF GIVE HIM TEN SECONDS DRIVER": {"wait_s": 10.0},
    "wait half a minute": {"wait_s": 30.0},
    "人上车快得很，等三秒。": {"wait_s": 3.0},
    "creep forward two metres at walking pace": {"distance_m": 2.0, "speed_mps": 1.5},
}
NOT_SAID = (
    "Go the wrong way up the one-way, it's only fifty yards.",
    "Leave me at the corner, my knees can do fifty metres.",
    "Keep left of the branch and you'll clear it by a yard.",
    "Now the road is wide and empty, so take them with two metres between.",
    "go round the lorry 50 metres ahead",
    "Bro, my heat goes off in twenty minutes and there's nobody coming, swing around this dude.",
    "It's had the same colour for twenty-six minutes by my chronometer. I conclude that it's dead and we move.",
    "Give her a sec, she's only getting out of her drive.",
    "wait a minute",
    "pass him, he's only doing 20 km/h",
    "the limit is 30 km/h here, go",
    "We can hardly not overtake somebody doing four miles an hour.",
    "go faster than 20 km/h",
    "only go if they drive slower than 10 km/h",
    "that tractor is going so slowly, overtake it",
    "why are we going so slowly",
    "back up 4000 metres",
    "wait 0 seconds",
)


@pytest.mark.parametrize("text", SAID)
def test_amounts_that_are_meant_for_the_vehicle_are_read(text):
    assert read_amounts(text).limits == GuidanceLimits(**SAID[text])


@pytest.mark.parametrize("text", NOT_SAID)
def test_quantities_speeds_of_others_and_sizes_are_ignored(text):
    """Speeds of other road users, sizes, and idioms with numbers set no limit."""
    assert read_amounts(text).limits is None


@given(st.text(max_size=80))
def test_words_without_an_amount_reach_the_network_unchanged(text):
    amounts = read_amounts(text)
    if amounts.limits is None:
        assert amounts.rest == text


@given(st.integers(0, 9999), st.sampled_from(["m", "feet", "km/h", "mph", "seconds", "minutes"]))
def test_no_amount_is_beyond_belief(number, unit):
    limits = read_amounts(f"go, wait, reverse {number} {unit}").limits or GuidanceLimits()
    assert (limits.distance_m or 0.0) <= LARGEST["distance"]
    assert (limits.speed_mps or 0.0) <= LARGEST["speed"]
    assert (limits.wait_s or 0.0) <= LARGEST["time"]


@pytest.mark.parametrize(
    ("text", "intent", "limits"),
    [
        ("overtake them at 20 km/h", GuidanceIntent.OVERTAKE, GuidanceLimits(speed_mps=5.56)),
        ("go round it, but not faster than 10 km/h", GuidanceIntent.OVERTAKE, GuidanceLimits(speed_mps=2.78)),
        ("back up three metres", GuidanceIntent.BACK_UP, GuidanceLimits(distance_m=3.0)),
        ("hang on for 20 seconds", GuidanceIntent.WAIT, GuidanceLimits(wait_s=20.0)),
    ],
)
def test_the_reader_carries_them_beside_the_intent(text, intent, limits):
    reading = READER.read(text, "Standing behind a stopped car.")
    assert (reading.intent, reading.limits) == (intent, limits)


def test_small_talk_with_an_amount_carries_none():
    reading = READER.read("My brother ran back ten metres to get his hat.", "Driving, nothing in the way.")
    assert reading.intent is GuidanceIntent.NONE and reading.limits is None


def test_a_reading_without_amounts_is_written_as_before():
    assert "limits" not in READER.read("go round it", "").model_dump_json()
