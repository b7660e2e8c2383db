"""Holds the common part of both clients of the solver's process: utterances, events, faults, closing.

Python 3.7, standard library only.
"""

from __future__ import annotations

from typing import Any, Callable

from stucksolver_bridge.solver_process import SolverProcess

Listener = Callable[[dict], None]  # type: ignore[type-arg]


class SolverClient:
    """Base of a client. The subclass sets `solver` once its process has started.

    Args:
        on_event: Called with every event of the solver.
    """

    solver: SolverProcess
    """The solver's process."""

    def __init__(self, on_event: Listener | None) -> None:
        self._on_event = on_event
        self._utterances: list[str] = []

    @property
    def fault(self) -> str | None:
        """Reason why the solver's process has ended; None while it is running."""
        return self.solver.fault

    def say(self, text: str) -> None:
        """Send a passenger's utterance with the next free tick. Each tick carries one utterance."""
        self._utterances.append(text)

    def close(self) -> None:
        """End the solver's process."""
        self.solver.close()

    def _with_utterance(self, tick: dict[str, Any]) -> dict[str, Any]:
        """Return the tick with the next utterance, if one is waiting."""
        if self._utterances:
            tick["say"] = self._utterances.pop(0)
        return tick

    def _emit(self, event: dict[str, Any]) -> None:
        if self._on_event is not None:
            self._on_event(event)
