"""What a button says is what the car understands, whatever goes on."""

from __future__ import annotations

import pytest

from stucksolver.interpreter import NoInterpreter, find_reader
from stucksolver.scene import GuidanceIntent as Intent
from stucksolver.scene.interpretation import STAYS
from stucksolver_passenger.quick_replies import (
    ALL,
    BEHIND,
    DRIVE_ON,
    NEVER_MIND,
    OTHER_WAY,
    OVERTAKE,
    PULL_OVER,
    ROUND,
    STOP_WORDS,
    WAIT,
)

MEANS = {
    WAIT: {Intent.WAIT},
    ROUND: {Intent.OVERTAKE},
    OVERTAKE: {Intent.OVERTAKE},
    BEHIND: {Intent.FOLLOW},
    OTHER_WAY: {Intent.REROUTE},
    PULL_OVER: {Intent.PULL_OVER},
    DRIVE_ON: {Intent.GO},
    NEVER_MIND: {Intent.CANCEL, Intent.WAIT},
}
SITUATIONS = (
    "",
    "Standing behind a stopped car.",
    "Driving behind a slow bicycle.",
    "Standing, nothing in the way.",
    "Standing behind a stopped van, hazard lights on. The light is red.",
)
QUESTION = " The car asks: May I? It needs your yes for: borrow oncoming lane"


@pytest.fixture(scope="module")
def reader():
    found = find_reader()
    if isinstance(found, NoInterpreter):
        pytest.skip(found.why)
    return found


@pytest.mark.parametrize("situation", [*SITUATIONS, SITUATIONS[1] + QUESTION])
def test_quick_reply_stop_is_stay_intent_in_every_situation(reader, situation):
    """The words of the stop button are interpreted as an intent to stay in every situation."""
    reading = reader.read(STOP_WORDS, situation)
    assert reading.intent in STAYS


def test_each_ready_answer_says_what_it_means(reader):
    assert set(MEANS) == set(ALL)
    fits = {OVERTAKE: SITUATIONS[2:3], BEHIND: SITUATIONS[2:3], PULL_OVER: SITUATIONS[3:4]}
    for answer, meant in MEANS.items():
        for situation in fits.get(answer, SITUATIONS[1:2]):
            assert reader.read(answer.says, situation).intent in meant, (answer.label, situation)
