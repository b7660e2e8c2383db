"""The interface of a criterion, and its input at a tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    import carla

STANDING_MPS = 0.1
"""Speed below which the ego counts as stopped (m/s). As in scenario_runner."""


@dataclass(frozen=True)
class EgoTick:
    """The ego at one tick. `transform` and `velocity` are of the `carla` client; times count from the route's
    start (s).
    """

    frame: int
    time_s: float
    transform: carla.Transform
    velocity: carla.Vector3D
    suspended: frozenset[str] = frozenset()
    """Criteria that are suspended now, by their short names (`blocked`, `wrong_lane`, `route_deviation`)."""
    background_mps: tuple[float, ...] = ()
    """Speeds of the background traffic's cars (m/s)."""

    @property
    def location(self) -> carla.Location:
        """The vehicle's `carla.Location`."""
        return self.transform.location

    @property
    def speed_mps(self) -> float:
        """Speed in the plane, as in scenario_runner (m/s)."""
        return float((self.velocity.x**2 + self.velocity.y**2) ** 0.5)


@dataclass(frozen=True)
class Infraction:
    """One entry of a route's infractions. `kind` is a key of the leaderboard's record."""

    kind: str
    time_s: float
    text: str
    percentage: float | None = None


class Criterion(ABC):
    """Judges one aspect from tick to tick. `ends_route` names the failure that ends the route, after it occurred."""

    kind: ClassVar[str]

    def __init__(self) -> None:
        self.infractions: list[Infraction] = []
        self.ends_route: str | None = None

    @abstractmethod
    def update(self, moment: EgoTick) -> None:
        """Judge one tick."""

    def finish(self) -> None:  # noqa: B027 (most criteria do nothing here)
        """Judge the aspects that need the whole route, at its end."""

    def close(self) -> None:  # noqa: B027
        """Destroy sensors, if there are any."""

    def note(self, time_s: float, text: str, percentage: float | None = None) -> None:
        """Add an infraction. `percentage` is the affected part of the route, if the penalty depends on that."""
        self.infractions.append(Infraction(self.kind, time_s, text, percentage))


def place_text(location: carla.Location) -> str:
    """Return a location in the form of the texts of infractions."""
    return f"(x={location.x:.3f}, y={location.y:.3f}, z={location.z:.3f})"
