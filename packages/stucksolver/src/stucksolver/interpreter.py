"""Interface of interpreters of a passenger's words, and the selection of an installed one."""

from __future__ import annotations

from typing import Protocol

from stucksolver.plugins import PluginError, plugins
from stucksolver.scene.interpretation import GuidanceIntent, Interpretation

MISSING = "no interpreter of words is installed; add the extra [language] (README, Install)"


class Interpreter(Protocol):
    """Reads words outside the control loop, in tens of milliseconds. Called from one thread at a time."""

    @property
    def name(self) -> str:
        """Name and version of the reader, for the record."""

    def read(self, text: str, situation: str) -> Interpretation:
        """Return what `text` asks for.

        Args:
            text: The passenger's words.
            situation: What the vehicle is doing, with its open yes-or-no question, if any.
        """


class NoInterpreter:
    """Understands nothing: the passenger is asked again instead of guessing."""

    name = "none"

    def __init__(self, why: str = MISSING) -> None:
        self.why = why

    def read(self, text: str, situation: str) -> Interpretation:
        """Return an unclear reading, whatever is said."""
        return Interpretation(
            intent=GuidanceIntent.UNCLEAR, likely=GuidanceIntent.UNCLEAR, confidence=0.0, reader=self.name
        )


class ScriptedInterpreter:
    """Knows fixed sentences, for tests without the network; everything else is unclear."""

    name = "scripted"

    def __init__(self, readings: dict[str, Interpretation]) -> None:
        self._readings = dict(readings)

    def read(self, text: str, situation: str) -> Interpretation:
        """Return the reading given for the text."""
        return self._readings.get(text) or NoInterpreter().read(text, situation)


def find_reader() -> Interpreter:
    """Return the interpreter of an installed distribution, or a `NoInterpreter` that says what is missing."""
    for plugin in plugins("interpreters"):
        try:
            reader: Interpreter = plugin.load()()
        except PluginError as error:
            return NoInterpreter(str(error))
        return reader
    return NoInterpreter()
