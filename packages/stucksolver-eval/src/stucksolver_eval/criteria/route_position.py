"""The ego's position along a route's points, for the benchmark's route criteria."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stucksolver_eval.routes.route_line import RouteLine

if TYPE_CHECKING:
    import carla


class RouteWalk:
    """Plain lists of a `RouteLine`, fast for a few points at a time. CARLA's world frame, meters."""

    def __init__(self, line: RouteLine) -> None:
        self.change(line)

    def change(self, line: RouteLine) -> None:
        """Continue on another line. Its passed part must be the same."""
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
        """True if a `carla.Location` is beyond the plane through point `index` across the lane."""
        x, y, z = self._places[index]
        ahead = self._forward[index]
        return bool((location.x - x) * ahead[0] + (location.y - y) * ahead[1] + (location.z - z) * ahead[2] > 0.0)

    def last_passed(self, index: int, location: carla.Location, window: int) -> int:
        """Return the last passed one of the points `index` to `index + window`; `index` if there is none."""
        last = index
        for k in range(index, min(index + window + 1, len(self))):
            if self.passed(k, location):
                last = k
        return last

    def distance_m(self, index: int, location: carla.Location) -> float:
        """Return the straight distance in the plane to a point (m)."""
        x, y, _ = self._places[index]
        return float(((location.x - x) ** 2 + (location.y - y) ** 2) ** 0.5)

    def distance_3d_m(self, index: int, location: carla.Location) -> float:
        """Return the distance of a position to the route's point `index` (m), with the height."""
        x, y, z = self._places[index]
        return float(((location.x - x) ** 2 + (location.y - y) ** 2 + (location.z - z) ** 2) ** 0.5)
