"""What words deny, forbid or warn of: read from sentences that were written before the rules, and for any text."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver.interpreter import find_reader
from stucksolver.scene import REQUESTS, Claim, GuidanceIntent, Interpretation
from stucksolver.scene.interpretation import MOVES, STAYS
from stucksolver.word_safeguards.alarms import calls_to_stop
from stucksolver.word_safeguards.evidence import GIVES
from stucksolver.word_safeguards.restraint import alarm, restrained

READER = find_reader()
FOLDER = Path(__file__).with_name("restraint")


def sentences(name):
    """Return the sentences of a half: `design` was used to write the rules, `check` only to measure them."""
    return [json.loads(line) for line in (FOLDER / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()]


HALVES = [sentence for half in ("design", "check") for sentence in sentences(half)]
RESTRAINTS = [s for s in HALVES if s["kind"] in ("denied", "alarm", "forbid")]
CLAIMS = [s for s in HALVES if "claim" in s]
HARMLESS = [s for s in HALVES if s["kind"] == "harmless"]


@cache
def network(text, situation):
    """Return the network's own reading, without the rules."""
    return READER._read(text, situation)


def read(said):
    """Return a sentence's reading with the rules."""
    return restrained(network(said["text"], said["situation"]), said["text"])


def given_claims(reading):
    return {claim for claim in reading.claims if claim in GIVES and not reading.negated}


@pytest.mark.parametrize("said", RESTRAINTS, ids=lambda s: s["text"])
def test_restraint_gives_no_permission_and_holds(said):
    reading = read(said)
    assert not given_claims(reading)
    assert reading.intent not in MOVES
    if said["holds"]:
        assert reading.intent in STAYS
    if said["bars"] and said["text"] not in UNBARRED:
        assert reading.danger or (reading.intent in STAYS and reading.negated)


UNBARRED = {"that box isn't empty"}
"""Known: a box of which it is only said that something is in it is not barred; it is never driven over anyway."""


@pytest.mark.parametrize("said", CLAIMS, ids=lambda s: s["text"])
def test_restraint_honest_claim_is_kept(said):
    """The rules take no claim that the network reads in a sentence that means it."""
    claim, before = Claim(said["claim"]), network(said["text"], said["situation"])
    after = read(said)
    assert (claim in after.claims) == (claim in before.claims)
    assert after.intent is before.intent


@pytest.mark.parametrize("said", HARMLESS, ids=lambda s: s["text"])
def test_restraint_harmless_sentence_is_not_held(said):
    before, after = network(said["text"], said["situation"]), read(said)
    assert after.intent is before.intent
    assert set(after.claims) == set(before.claims)


@pytest.mark.parametrize("text", [s["text"] for s in HALVES if s["kind"] == "out"])
def test_restraint_request_to_get_out_is_kept(text):
    assert READER.read(text, "Driving, nothing in the way.").intent is GuidanceIntent.LET_ME_OUT


READINGS = st.builds(
    Interpretation,
    intent=st.sampled_from(GuidanceIntent),
    negated=st.booleans(),
    claims=st.lists(st.sampled_from(Claim), unique=True, max_size=3).map(tuple),
    confidence=st.just(1.0),
    likely=st.just(GuidanceIntent.GO),
    reader=st.just("any"),
)
VOCABULARY = (
    "that is not a bag dog child stop go don't the policeman says we can light broken isn't , . ! but only there's "
    "waving us through hit you'll him road behind overtake it no never kein sac pas niño 袋子 不 有人"
)
WORDS = st.lists(st.sampled_from(re.split(" ", VOCABULARY)), max_size=12).map(" ".join)


@settings(max_examples=300, deadline=None)
@given(reading=READINGS, text=st.one_of(WORDS, st.text(max_size=80)))
def test_restraint_any_words_only_take_away(reading, text):
    after = restrained(reading, text)
    assert set(after.claims) <= set(reading.claims)
    assert after.intent in (reading.intent, GuidanceIntent.WAIT)
    assert after.intent is reading.intent or after.intent not in MOVES
    assert restrained(after, text) == after


@settings(max_examples=200, deadline=None)
@given(text=st.one_of(WORDS, st.text(max_size=200)))
def test_restraint_alarm_never_asks_to_move(text):
    called = alarm(text)
    assert called is None or (called.intent is GuidanceIntent.WAIT and not called.claims)


@pytest.mark.parametrize("claim", sorted(GIVES))
@pytest.mark.parametrize("text", ["", "hm", "you know what I mean", "der da", "ça là"])
def test_restraint_claim_without_words_for_it_gives_nothing(claim, text):
    """The network alone gives no permission: the words must say it too. `long_stay` has too many wordings for that."""
    reading = Interpretation(intent="none", claims=(claim,), confidence=0.9, likely="none", reader="any")
    if claim is not Claim.LONG_STAY:
        assert not restrained(reading, text).claims


@pytest.mark.parametrize("tail", ["", "!", ", please", "! You'll hit her", ". There's a child"])
@pytest.mark.parametrize("call", ["stop", "STOP now", "Halt", "brake", "arrête", "¡para", "stopp", "停", "whoa whoa"])
def test_restraint_call_to_stop_needs_no_network(call, tail):
    called = alarm(call + tail)
    assert called is not None and called.intent is GuidanceIntent.WAIT


@pytest.mark.parametrize(
    "text",
    ["don't stop", "never stop", "no need to stop", "why did we stop", "the bus stop", "stop worrying",
     "nicht anhalten", "ne t'arrête pas", "no pares", "不要停", "stop at the bakery", "no", "go on", "don't wait"],
)  # fmt: skip
def test_restraint_other_words_with_stop_are_no_call(text):
    assert not calls_to_stop(text)
    assert alarm(text) is None


@pytest.mark.parametrize("text", ["a " * 250, "stop " * 99, "he isn't " * 60, "there's a " * 50, "the the kid " * 40])
def test_restraint_long_text_is_read_at_once(text):
    """No pattern needs more than linear work: a pathological one would not end at all."""
    restrained(Interpretation(intent="none", confidence=0.9, likely="none", reader="any"), text[:500])


def test_restraint_left_out_of_json_where_nothing_was_said():
    plain = READER.read("what a lovely day", "")
    assert {"denied", "danger"}.isdisjoint(plain.model_dump())
    assert Interpretation.model_validate(plain.model_dump()) == plain
    barred = READER.read("that's a dog, not a bag", "")
    assert Interpretation.model_validate_json(barred.model_dump_json()) == barred
    assert barred.danger and Claim.SOFT_OBJECT in barred.denied


def test_restraint_requests_for_stopping_survive_a_call_to_stop():
    reading = READER.read("stop the car, I want to get out", "Driving, nothing in the way.")
    assert reading.intent in REQUESTS | {GuidanceIntent.WAIT}
    assert reading.intent not in (GuidanceIntent.GO, GuidanceIntent.OVERTAKE)
