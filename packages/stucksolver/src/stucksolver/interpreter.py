"""Interface of interpreters of a passenger's utterances, and the selection of an installed one."""

from __future__ import annotations

from typing import Protocol

from stucksolver.plugins import PluginError, plugins
from stucksolver.scene.interpretation import GuidanceIntent, Interpretation

MISSING = "no interpreter of utterances is installed; add the extra [language] (README, Install)"
"""Message without an installed interpreter."""


class Interpreter(Protocol):
    """Interpreter of utterances outside the control loop, in tens of milliseconds. One thread at a time calls it."""

    @property
    def name(self) -> str:
        """Name and version of the interpreter, for the record."""

    def read(self, text: str, situation: str) -> Interpretation:
        """Return the interpretation of an utterance.

        Args:
            text: Utterance of the passenger.
            situation: Current action of the vehicle, with its open yes-or-no question, if any.
        """


class NoInterpreter:
    """Interpreter that understands nothing, so the solver asks the passenger again instead of guessing."""

    name = "none"

    def __init__(self, why: str = MISSING) -> None:
        self.why = why

    def read(self, text: str, situation: str) -> Interpretation:
        """Return an unclear interpretation for any text."""
        return Interpretation(
            intent=GuidanceIntent.UNCLEAR, likely=GuidanceIntent.UNCLEAR, confidence=0.0, reader=self.name
        )


class ScriptedInterpreter:
    """Interpreter of fixed sentences, for tests without the network; every other text is unclear."""

    name = "scripted"

    def __init__(self, readings: dict[str, Interpretation]) -> None:
        self._readings = dict(readings)

    def read(self, text: str, situation: str) -> Interpretation:
        """Return the interpretation stored for the text."""
        return self._readings.get(text) or NoInterpreter().read(text, situation)


def find_reader() -> Interpreter:
    """Return the interpreter of an installed distribution, or a `NoInterpreter` with the reason."""
    for plugin in plugins("interpreters"):
        try:
            reader: Interpreter = plugin.load()()
        except PluginError as error:  # The solver runs without one; `why` has the reason.
            return NoInterpreter(str(error))
        return reader
    return NoInterpreter()
