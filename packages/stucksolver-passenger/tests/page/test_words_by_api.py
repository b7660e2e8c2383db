"""The blind sentences go through the page's HTTP API, the seat and the solver, and are understood as by the reader."""

from __future__ import annotations

import json
import os
from functools import cache
from pathlib import Path

import pytest

pytest.importorskip("fastapi")
pytest.importorskip("onnxruntime")
from page_serving import Serving
from sitting import Sitting

from stucksolver_language.intent.lexical_safeguards import is_stop_phrase
from stucksolver_passenger.api_types import PersonCommand
from stucksolver_passenger.server import rate_limits
from stucksolver_passenger.socket_frames import LENGTH_BYTES, SocketMessage, Topic, unpacked
from worlds import READER, World, straight_road

BLIND = Path(__file__).parents[4] / "results" / "words"
EVERY = int(os.environ.get("STUCKSOLVER_BLIND_EVERY", "30"))
"""One in so many of the 1,500 is sent; with 1 all of them are, in some five minutes."""


def blind(every=EVERY):
    names = ("blind-1", "blind-2", "blind-3")
    lines = [line for name in names for line in (BLIND / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()]
    return [json.loads(line) for line in lines][::every]


class InItsSituation:
    """The shipped reader, told the situation for which a sentence was written."""

    name = READER.name

    def __init__(self, said):
        self._situations = {item["text"]: item["situation"] for item in said}

    def read(self, text, situation):
        return alone_read(text, self._situations.get(text, situation))


@cache
def alone_read(text, situation):
    """The shipped reader gives the same reading for the same words again, so each is read once."""
    return READER.read(text, situation)


class Riding(Serving):
    """The server of the page with a car behind it, whose solver hears what is said."""

    def __init__(self, reader):
        self.sitting = Sitting(World(straight_road()), reader=reader)
        super().__init__()

    def _deliver(self, data):
        frame = unpacked(data[LENGTH_BYTES:])
        outcome = self.sitting.seat.take(PersonCommand.model_validate_json(frame.payload))
        self.board.take(SocketMessage(Topic.OUTCOME, frame.vehicle, outcome.model_dump_json().encode()), self._deliver)

    def drive(self):
        self.sitting.drive(0.3)
        told = self.sitting.now.model_dump_json().encode()
        self.board.take(SocketMessage(Topic.NOW, "car-1", told), self._deliver)


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_api_blind_sentences_are_interpreted_as_by_interpreter_alone(monkeypatch):
    """Through the API, the blind sentences are interpreted as by the interpreter alone, more than 85 % correctly."""
    monkeypatch.setattr(rate_limits.Limiter, "allows", lambda *_, **__: True)  # nobody speaks as fast as this
    said = blind()
    riding = Riding(InItsSituation(said))
    right = alone = 0
    for item in said:
        assert riding.say(item["text"]).json()["taken"], item["text"]
        riding.drive()
        lines = riding.get("/api/vehicles/car-1").json()["lines"]
        line = next(line for line in reversed(lines) if line["text"] == item["text"].strip())
        reading = alone_read(item["text"], item["situation"])
        # A plain call to stop acts at once, without the network.
        expected = line["understood"] if is_stop_phrase(item["text"]) else reading.description
        assert line["understood"] == expected and (expected == reading.description or expected == "wait (100 %)"), item[
            "text"
        ]
        alone += reading.likely.value == item["intent"]
        right += _likely(line["understood"]) == item["intent"]
    print(f"{len(said)} sentences: {right} understood through the API, {alone} by the reader alone")
    assert right >= alone
    assert right / len(said) > 0.85


def _likely(understood):
    """The intent that a line of the conversation tells of."""
    taken_for, _, likely = understood.partition(" (")
    told = likely.partition("?")[0] if "?" in likely else taken_for.partition(" on the ")[0]
    return "none" if told.startswith("nothing to do") else told.replace(" ", "_")
