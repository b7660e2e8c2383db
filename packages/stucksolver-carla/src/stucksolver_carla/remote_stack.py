"""Defines the interface through which a session uses the stack at the other end of its connection."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

from stucksolver.plan.directive import Directive
from stucksolver.scene import Scene, Status, Surroundings


class UnusableError(RuntimeError):
    """A message of the stack cannot be used. The message of this error gives the reason and the remedy."""


class RemoteStack(ABC):
    """One kind of stack. On each tick `begin`, `status` and `perform` are called in this order."""

    def begin(self, tick: Mapping[str, Any]) -> bool:
        """Start a tick; return False while the solver cannot decide yet. Raises `UnusableError`."""
        return True

    @abstractmethod
    def status(self, tick: dict[str, Any]) -> Status:
        """Return the vehicle's status."""

    @abstractmethod
    def surroundings(self) -> Surroundings:
        """Return its surroundings."""

    @abstractmethod
    def scene(self, surroundings: Surroundings) -> Scene | None:
        """Return the scene for reasoners."""

    @abstractmethod
    def perform(self, directive: Directive) -> list[Any]:
        """Return the orders for the driver in the stack's process."""

    def in_map_frame(self, directive: Directive) -> Directive:
        """Return a directive with its path in the frame of the stack's process."""
        return directive

    @abstractmethod
    def forget(self) -> None:
        """Send all orders again with the next answer, because the stack has rejected or lost the last ones."""

    def waiting(self) -> list[Any]:
        """Return the orders for the time in which the solver cannot decide yet."""
        return []

    def events(self) -> list[dict[str, Any]]:
        """Return the stack's own events since the last call, in addition to the solver's."""
        return []

    def close(self) -> None:  # noqa: B027 (most stacks have no resources)
        """Release the resources."""
