"""What every reasoner is: a scene in, a decision out. Untrusted; the guard decides."""

from __future__ import annotations

from typing import Protocol

from stucksolver.decision import Decision
from stucksolver.scene import Scene


class Reasoner(Protocol):
    """Called off the control loop, one scene at a time."""

    @property
    def name(self) -> str:
        """Shown in every result."""

    def decide(self, scene: Scene) -> Decision:
        """Observe, analyse, decide. Raises `ReasonerError` when it has no answer."""


class ReasonerError(Exception):
    """A reasoner could not answer; the message says why and what to do."""
