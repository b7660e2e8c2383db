"""The shipped network, as it is used: promises that hold whatever is said, and the blind sets as a floor."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tokenizers import Tokenizer

from stucksolver.interpreter import NoInterpreter, ScriptedInterpreter, find_reader
from stucksolver.scene import GuidanceIntent
from stucksolver.scene.interpretation import MOVES, STAYS
from stucksolver_language.intent.intent_decoder import INTENT, INTENTS, LOGITS, ConfidenceThresholds, read_fields
from stucksolver_language.intent.network import DATA, InterpreterError, NetworkInterpreter, unpacked
from stucksolver_language.intent.tokenization import MAX_TOKENS, encoded

READER = find_reader()
DOUBT = ConfidenceThresholds(temperature=1.0, move=0.7, against=0.15, stay=0.3, reroute=0.7)
BLIND = Path(__file__).parents[4] / "results" / "words"


def numbers(**logits):
    out = np.full(LOGITS, -5.0, np.float32)
    for name, value in logits.items():
        out[INTENTS.index(GuidanceIntent(name))] = value
    return out


@given(st.lists(st.floats(-8, 8), min_size=LOGITS, max_size=LOGITS))
def test_doubt_never_moves_the_vehicle(values):
    reading = read_fields(np.array(values, np.float32), DOUBT, "test")
    if reading.intent in MOVES:
        assert reading.confidence >= DOUBT.move - 1e-3
        assert reading.intent is reading.likely


def test_what_may_also_mean_to_stay_is_asked_back():
    assert read_fields(numbers(overtake=2.0, wait=1.8), DOUBT, "test").intent is GuidanceIntent.UNCLEAR
    assert read_fields(numbers(wait=2.0, overtake=1.8), DOUBT, "test").intent is GuidanceIntent.WAIT
    assert read_fields(numbers(overtake=5.0), DOUBT, "test").intent is GuidanceIntent.OVERTAKE


def test_interpretation_reroute_has_own_threshold():
    """A reroute needs less confidence than other requests, and stays unclear when a no is nearly as likely."""
    doubt = ConfidenceThresholds(temperature=1.0, move=0.9, against=0.15, stay=0.3, reroute=0.5)
    assert read_fields(numbers(reroute=2.0, go=1.0), doubt, "test").intent is GuidanceIntent.REROUTE
    assert read_fields(numbers(turn_round=2.0, go=1.0), doubt, "test").intent is GuidanceIntent.UNCLEAR
    assert read_fields(numbers(reroute=2.0, no=1.5), doubt, "test").intent is GuidanceIntent.UNCLEAR


@pytest.mark.parametrize(
    "text",
    [
        "You will not get past there, find a different route.",
        "the barrier stays shut, take the other way",
        "That way is blocked off, you had better use another road",
    ],
)
def test_interpreter_no_way_past_is_reroute_intent(text):
    """An utterance that says there is no way past is interpreted as a request for another route."""
    assert READER.read(text, "Standing behind a parked car and a rock.").intent is GuidanceIntent.REROUTE


@pytest.mark.parametrize("text", ["Sign says road closed beyond the church.", "We came by another road yesterday."])
def test_who_speaks_of_other_roads_asks_for_none(text):
    assert READER.read(text, "Standing behind a parked car and a rock.").intent is not GuidanceIntent.REROUTE


@pytest.mark.parametrize(
    "text",
    ["wait, the driver is just coming back", "Wait, the driver is just coming back.", "wait, here he comes again"],
)
def test_interpreter_driver_returns_defers_question(text):
    """When the other driver is about to return, the reply to an open question is to wait, not no."""
    asked = "Standing behind a parked van. The car asks: May I overtake?"
    assert READER.read(text, asked).intent is GuidanceIntent.WAIT


def test_interpreter_no_because_driver_returns_is_no():
    """A no stays a no when its reason is that the other driver is about to return."""
    asked = "Standing behind a parked van. The car asks: May I overtake it?"
    assert READER.read("No, you may not, he is just coming back.", asked).intent is GuidanceIntent.NO


def test_moving_and_staying_have_nothing_in_common():
    assert not MOVES & STAYS
    assert len(INTENTS[INTENT]) == len(GuidanceIntent)


SHOUTS = (
    "no, stop, wait", "wait wait wait", "Wait, WAIT!", "no no no stop", "stop stop", "whoa whoa", "hold on hold on",
    "espera, espera", "¡no, para!", "para para para", "nein nein, warte", "stopp, halt!", "warte warte",
    "non non, attends", "arrête, arrête", "停停停", "别别别", "等等等等",
)  # fmt: skip


@pytest.mark.parametrize("situation", ["Driving round a parked bus in the oncoming lane.", "Driving."])
@pytest.mark.parametrize("text", SHOUTS)
def test_interpreter_shout_to_hold_back_is_never_unclear(text, situation):
    """A shout to hold back is interpreted as an intent to stay in every situation, never as unclear."""
    assert READER.read(text, situation).intent in STAYS


@pytest.mark.integration
@settings(max_examples=12, deadline=None)
@given(text=st.text(max_size=600), situation=st.text(max_size=300))
def test_any_text_gets_a_reading_and_the_same_one_again(text, situation):
    assert READER.read(text, situation) == READER.read(text, situation)


@pytest.mark.slow
@pytest.mark.integration
@pytest.mark.parametrize("name", ["blind-1", "blind-2", "blind-3"])
def test_a_blind_set_is_read_about_as_well_as_published(name):
    """Every tenth sentence; results/words.md has them all."""
    said = [json.loads(line) for line in (BLIND / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()][::10]
    readings = [READER.read(s["text"], s["situation"]) for s in said]
    right = sum(r.likely.value == s["intent"] for r, s in zip(readings, said, strict=True))
    assert right / len(said) > 0.8


def test_encoding_contains_only_situation_and_utterance():
    """The network receives the situation and the utterance, and nothing else."""
    tokenizer = Tokenizer.from_file(str(DATA / "tokenizer.json"))
    situation, text = "Standing behind a van. The car asks: May I overtake?", "yes, pass it"
    ids, kinds = encoded(tokenizer, situation, text)
    pieces = [tokenizer.id_to_token(i) for i in ids]
    middle = pieces.index("[SEP]")
    assert "".join(pieces[1:middle]).replace("##", "") == situation.replace(" ", "").lower()
    assert "".join(pieces[middle + 1 : -1]).replace("##", "") == text.replace(" ", "")
    assert kinds == [0] * (middle + 1) + [1] * (len(pieces) - middle - 1)


def test_encoding_long_utterance_keeps_end_of_situation():
    """A long utterance leaves the end of the situation in the input, because the open question stands there."""
    tokenizer = Tokenizer.from_file(str(DATA / "tokenizer.json"))
    ids, _ = encoded(tokenizer, "It rains. " * 99 + "May I overtake?", "well " * 400)
    pieces = [tokenizer.id_to_token(i) for i in ids]
    assert len(pieces) == MAX_TOKENS
    assert pieces[pieces.index("[SEP]") - 1] == "?"


def test_the_same_words_mean_another_thing_in_another_situation():
    asked = READER.read("Go on.", "Standing behind a parked van. The car asks: May I overtake?")
    told = READER.read("Go on.", "Standing at a green light.")
    assert asked.likely is GuidanceIntent.YES
    assert told.likely is GuidanceIntent.GO


@pytest.mark.parametrize("text", ["hrmpf grmbl", "xxxxx xxxxx xxxxx", "blub", "asdf jklo qwer", "x" * 400])
def test_sounds_without_meaning_are_no_yes_to_an_open_question(text):
    assert READER.read(text, "Standing behind a parked van. The car asks: May I overtake?").intent not in MOVES


@pytest.mark.parametrize(
    "text", ["yes", "sure, why not", "okay then", "ja, gerne", "oui, vas-y", "by all means, do it"]
)
def test_an_everyday_yes_is_one(text):
    asked = READER.read(text, "Standing behind a parked van. The car asks: May I overtake?")
    assert asked.intent in (GuidanceIntent.YES, GuidanceIntent.UNCLEAR)
    assert asked.likely is not GuidanceIntent.YES or asked.intent is GuidanceIntent.YES or asked.confidence < 0.9


def test_four_bits_hold_numbers_from_minus_eight_to_seven():
    table = np.array([[0x10, 0x87, 0xF9], [0x00, 0x00, 0x00]], np.uint8)
    scale = np.array([[0.5, 2.0], [1.0, 1.0]], np.float32)
    assert unpacked(table, scale, [1, 0]).tolist() == [[0.0] * 6, [0.0, 0.5, 3.5, -16.0, -14.0, -2.0]]


def test_without_its_packages_nothing_is_understood():
    assert NoInterpreter().read("overtake", "").intent is GuidanceIntent.UNCLEAR
    assert "[language]" in NoInterpreter().why


def test_the_scripted_reader_knows_its_sentences_only():
    reader = ScriptedInterpreter({"go": READER.read("go", "")})
    assert reader.read("go", "").intent is GuidanceIntent.GO
    assert reader.read("go on", "").intent is GuidanceIntent.UNCLEAR


def test_broken_weights_are_named(tmp_path):
    with pytest.raises(InterpreterError, match="weights cannot be loaded"):
        NetworkInterpreter(tmp_path).read("go", "")
    with pytest.raises(InterpreterError, match=r"card\.json"):
        _ = NetworkInterpreter(tmp_path).name


STANDING = "Standing behind a stopped van, hazard lights on."


@pytest.mark.parametrize(
    ("text", "intent"),
    [
        ("overtake the delivery van, but mind the man beside it", "overtake"),
        ("Go round it. Careful though.", "overtake"),
        ("squeeze past, careful with the mirror", "overtake"),
        ("You can pass, just look out for the door", "overtake"),
        ("Drive on, but keep an eye on the kids", "go"),
        ("back up, watch the post behind", "back_up"),
        ("pull over and watch out for the bikes", "pull_over"),
    ],
)
def test_a_call_for_care_does_not_take_a_request_back(text, intent):
    assert READER.read(text, STANDING).intent.value == intent


@pytest.mark.parametrize(
    "text",
    [
        "Pass him, careful, there is somebody coming",
        "Go round. Careful, no, stop!",
        "Don't overtake, mind the man beside it",
        "You mustn't pass, be careful",
        "overtake, but watch out, he isn't finished",
        "go round but mind that they come first",
        "mind the man beside it",
        "I told her to pass, and to watch her back",
    ],
)
def test_interpreter_call_for_care_is_no_request_to_move(text):
    """A call for care does not turn an utterance into a request to move."""
    assert READER.read(text, STANDING).intent not in MOVES
