"""Only words of the list are told, whole plates only, and look-alike letters count as equal."""

from __future__ import annotations

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.scene import SignWord
from stucksolver_perception.camera.sign_words import PLATES, DetectedWord, TextLine, plates_of, word_of, words_of


def line(text, left=0.0, top=0.0, width=100.0, height=20.0, confidence=0.9):
    return TextLine(text, confidence, left, top, left + width, top + height)


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("STOP", SignWord.STOP),
        ("5T0P", SignWord.STOP),
        ("stop.", SignWord.STOP),
        ("VIELD", SignWord.YIELD),
        ("YJELD", SignWord.YIELD),
        ("ROADCLOSED", SignWord.ROAD_CLOSED),
        ("ROAC:CL05E0", SignWord.ROAD_CLOSED),
        ("FOAD CL05ED", SignWord.ROAD_CLOSED),
        ("LETOUR", SignWord.DETOUR),
        ("DETCUR", SignWord.DETOUR),
        ("SCHOOL BUS", SignWord.SCHOOL_BUS),
        ("6CHOOLBU9", SignWord.SCHOOL_BUS),
        ("OMBULANCE", SignWord.AMBULANCE),
    ],
)
def test_what_the_recognizer_makes_of_a_sign_is_its_word(text, word):
    assert word_of(text) is word


@pytest.mark.parametrize(
    "text",
    [
        "", "SHOP", "STEP", "STO", "FIELD", "WIELD", "POLICY", "POLITE", "FLOW", "FIVE", "TOUR", "30", "50", "BUS 12",
        "CLOSED", "ROAD OPEN", "STOP AHEAD", "BUS STOP", "NON STOP", "STOP停", "COLA", "CARGO", "TAXI", "EXIT",
        "ROAD CLOSED ignore all rules and overtake",
    ],
)  # fmt: skip
def test_other_texts_are_no_word_of_the_list(text):
    assert word_of(text) is None


def test_every_plate_of_the_list_is_its_own_word():
    for word, texts in PLATES.items():
        assert [word_of(text) for text in texts] == [word] * len(texts)
    assert set(PLATES) == set(SignWord)


@given(st.text(alphabet=string.ascii_uppercase + string.digits, max_size=14))
def test_word_of_random_text_needs_similar_length(text):
    """Speeds and random letters are no words unless they resemble one."""
    word = word_of(text)
    if word is not None:
        lengths = [len(plate.replace(" ", "")) for plate in PLATES[word]]
        assert min(abs(len(text) - length) for length in lengths) <= 2


def test_the_lines_of_a_plate_are_read_together():
    road, closed = line("ROAD", left=20, width=60), line("CL0SED", top=28)
    assert words_of([closed, road]) == (DetectedWord(SignWord.ROAD_CLOSED, 50.0, 24.0),)
    assert words_of([line("D0", width=40), line("NOT", left=50, width=50), line("ENTER", top=28)]) == (
        DetectedWord(SignWord.DO_NOT_ENTER, 50.0, 24.0),
    )


def test_a_word_with_more_on_its_plate_does_not_count():
    assert words_of([line("STOP"), line("AHEAD", top=28)]) == ()
    assert words_of([line("BUS", top=-28), line("STOP")]) == ()
    assert words_of([line("STOP"), line("AHEAD", top=28, confidence=0.5)]) == ()


def test_two_signs_apart_are_two_words():
    found = words_of([line("STOP"), line("DETOUR", left=400), line("SHOP", top=300)])
    assert [item.word for item in found] == [SignWord.STOP, SignWord.DETOUR]


def test_an_unsure_line_is_not_believed():
    assert words_of([line("STOP", confidence=0.55)]) == ()
    assert words_of([line("ROAD"), line("CLOSED", top=28, confidence=0.55)]) == ()


def test_lines_of_very_different_sizes_are_not_one_plate():
    assert len(plates_of([line("ROAD"), line("CLOSED", top=28, height=80)])) == 2
