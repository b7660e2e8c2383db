"""The base of every rung: its parameters with bounds, and what it asks of the solver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from stucksolver.ladder.rung_actions import Move
from stucksolver.scene.base_model import FrozenModel


class Rung(FrozenModel, ABC):
    """One rung of a ladder: a table in its file."""

    summary: ClassVar[str]
    """One sentence that says what it does. Shown by `stucksolver ladder`."""

    kind: str

    @abstractmethod
    def move(self) -> Move:
        """Return what the solver must do on this rung."""
