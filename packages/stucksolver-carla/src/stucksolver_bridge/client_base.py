"""What both clients of the solver's process share: passing on a passenger's words and the events, faults, closing.

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
        self._said: list[str] = []

    @property
    def fault(self) -> str | None:
        """Why the solver's process has ended; None while it is running."""
        return self.solver.fault

    def say(self, text: str) -> None:
        """Pass on a passenger's words with the next free tick: one sentence per tick."""
        self._said.append(text)

    def close(self) -> None:
        """End the solver's process."""
        self.solver.close()

    def _with_words(self, tick: dict[str, Any]) -> dict[str, Any]:
        """Return the tick with the next sentence, if one is waiting."""
        if self._said:
            tick["say"] = self._said.pop(0)
        return tick

    def _tell(self, event: dict[str, Any]) -> None:
        if self._on_event is not None:
            self._on_event(event)
