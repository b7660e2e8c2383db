"""The interface through which a session uses the stack at the other end of its connection, of whichever kind."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

from stucksolver.plan.directive import Directive
from stucksolver.scene import Scene, Status, Surroundings


class UnusableError(RuntimeError):
    """What the stack sent cannot be used. The message says what, and how to fix it."""


class RemoteStack(ABC):
    """One kind of stack. On each tick `begin`, `status` and `perform` are called in this order."""

    def begin(self, tick: Mapping[str, Any]) -> bool:
        """Take a tick; False while nothing can be decided yet. Raises `UnusableError`."""
        return True

    @abstractmethod
    def status(self, tick: dict[str, Any]) -> Status:
        """Return the vehicle's status."""

    @abstractmethod
    def surroundings(self) -> Surroundings:
        """Return its surroundings."""

    @abstractmethod
    def scene(self, seen: Surroundings) -> Scene | None:
        """Return the scene for reasoners."""

    @abstractmethod
    def perform(self, directive: Directive) -> list[Any]:
        """Return the orders for the driver on the other side."""

    @abstractmethod
    def forget(self) -> None:
        """Repeat all orders: the driver's side is not performing the last ones."""

    def waiting(self) -> list[Any]:
        """Return the orders while nothing can be decided yet."""
        return []

    def events(self) -> list[dict[str, Any]]:
        """Return what the stack has to report besides the solver's events, since the last call."""
        return []

    def close(self) -> None:  # noqa: B027 (most hold nothing)
        """End the drive."""
