"""What every rung is made of: its numbers, with bounds, and what it asks of the solver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from stucksolver.ladder.moves import Move
from stucksolver.scene.model import Model


class Rung(Model, ABC):
    """One rung of a ladder, as a table of its file."""

    summary: ClassVar[str]
    """One sentence: what it does. Shown by `stucksolver ladder`."""

    kind: str

    @abstractmethod
    def move(self) -> Move:
        """What the solver is to do on this rung."""
