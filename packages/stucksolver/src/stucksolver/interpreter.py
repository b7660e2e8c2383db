"""Interface of interpreters of a passenger's words, and the selection of an installed one."""

from __future__ import annotations

from typing import Protocol

from stucksolver.plugins import PluginError, plugins
from stucksolver.scene.interpretation import GuidanceIntent, Reading

MISSING = "no interpreter of words is installed; add the extra [language] (README, Install)"


class WordsReader(Protocol):
    """Reads words outside the control loop, in tens of milliseconds. Called from one thread at a time."""

    @property
    def name(self) -> str:
        """Name and version of the reader, for the record."""

    def read(self, text: str, situation: str) -> Reading:
        """Return what `text` asks for.

        Args:
            text: The passenger's words.
            situation: What the vehicle is doing, with its open yes-or-no question, if any.
        """


class NoReader:
    """Understands nothing: the passenger is asked again instead of guessing."""

    name = "none"

    def __init__(self, why: str = MISSING) -> None:
        self.why = why

    def read(self, text: str, situation: str) -> Reading:
        """Return an unclear reading, whatever is said."""
        return Reading(intent=GuidanceIntent.UNCLEAR, likely=GuidanceIntent.UNCLEAR, confidence=0.0, reader=self.name)


class ScriptedReader:
    """Knows fixed sentences, for tests without the network; everything else is unclear."""

    name = "scripted"

    def __init__(self, readings: dict[str, Reading]) -> None:
        self._readings = dict(readings)

    def read(self, text: str, situation: str) -> Reading:
        """Return the reading given for the text."""
        return self._readings.get(text) or NoReader().read(text, situation)


def find_reader() -> WordsReader:
    """Return the interpreter that an installed distribution provides, or a `NoReader` that says what is missing."""
    for plugin in plugins("interpreters"):
        try:
            reader: WordsReader = plugin.load()()
        except PluginError as error:
            return NoReader(str(error))
        return reader
    return NoReader()
