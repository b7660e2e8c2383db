"""How far along its points an ego is, as all route criteria of the benchmark ask it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stucksolver_eval.routes.line import RouteLine

if TYPE_CHECKING:
    import carla


class RouteWalk:
    """Plain lists of a `RouteLine`, quick to ask a few points at a time. CARLA's world frame, metres."""

    def __init__(self, line: RouteLine) -> None:
        self.change(line)

    def change(self, line: RouteLine) -> None:
        """Walk another line from now on; what was passed of this one must be the same there."""
        self._places: list[list[float]] = line.xyz.tolist()
        self._forward: list[list[float]] = line.forward.tolist()
        self.s_m: list[float] = line.s_m.tolist()

    def __len__(self) -> int:
        return len(self.s_m)

    @property
    def length_m(self) -> float:
        """Length of the route (m)."""
        return self.s_m[-1]

    def passed(self, index: int, location: carla.Location) -> bool:
        """Is a `carla.Location` beyond the plane through point `index` across the lane?"""
        x, y, z = self._places[index]
        ahead = self._forward[index]
        return bool((location.x - x) * ahead[0] + (location.y - y) * ahead[1] + (location.z - z) * ahead[2] > 0.0)

    def last_passed(self, index: int, location: carla.Location, window: int) -> int:
        """The last passed one of the points `index` to `index + window`; `index` where none is."""
        last = index
        for k in range(index, min(index + window + 1, len(self))):
            if self.passed(k, location):
                last = k
        return last

    def distance_m(self, index: int, location: carla.Location) -> float:
        """Straight distance in the plane to a point."""
        x, y, _ = self._places[index]
        return float(((location.x - x) ** 2 + (location.y - y) ** 2) ** 0.5)

    def distance_3d_m(self, index: int, location: carla.Location) -> float:
        """Distance of a place to the route's point `index` (m), height included."""
        x, y, z = self._places[index]
        return float(((location.x - x) ** 2 + (location.y - y) ** 2 + (location.z - z) ** 2) ** 0.5)
