"""What a session asks of the stack at the other end of its wire, whichever kind it is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

from stucksolver.decision.directive import Directive
from stucksolver.scene import Scene, Status, Surroundings


class UnusableError(RuntimeError):
    """What the stack brings cannot be used; the message says what and how to mend it."""


class Side(ABC):
    """One kind of stack. On each tick `begin`, `status` and `perform` are called in this order."""

    def begin(self, tick: Mapping[str, Any]) -> bool:
        """Take in a tick; False while nothing can be decided yet. Raises `UnusableError`."""
        return True

    @abstractmethod
    def status(self, tick: dict[str, Any]) -> Status:
        """How the vehicle gets on."""

    @abstractmethod
    def surroundings(self) -> Surroundings:
        """What is around it."""

    @abstractmethod
    def scene(self, seen: Surroundings) -> Scene | None:
        """For reasoners."""

    @abstractmethod
    def perform(self, directive: Directive) -> list[Any]:
        """Orders for the driver on the other side."""

    @abstractmethod
    def forget(self) -> None:
        """The driver's side does not do what it was told last: tell it all of it."""

    def waiting(self) -> list[Any]:
        """Orders while nothing can be decided yet."""
        return []

    def events(self) -> list[dict[str, Any]]:
        """What the stack has to tell beside the solver's events, since the last call."""
        return []

    def close(self) -> None:  # noqa: B027 (most hold nothing)
        """The drive is over."""
