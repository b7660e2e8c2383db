"""Reservations of paths through junctions: conflicting paths are granted one at a time, first come, first served."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stucksolver_eval.actors.lane_path import JunctionSpan

if TYPE_CHECKING:
    from stucksolver_eval.actors.cars import Car

_APART_M = 3.0
"""Distance below which two paths conflict (m). Ours."""
_SAME_ENTRY_M = 2.0
"""Distance of two entries below which the cars follow each other (m). Ours."""

Way = NDArray[np.float64]


class JunctionReservations:
    """The reserved paths through junctions. The hero's path has priority while it is in the junction."""

    def __init__(self) -> None:
        self._claimed: dict[int, dict[int, Way]] = {}
        self._hero: tuple[int, Way] | None = None

    def hero(self, junction: int | None, way: Way | None) -> None:
        """Set the hero's path through the junction that it is in or about to enter, shape (n, 2) in m, or None."""
        self._hero = None if junction is None or way is None else (junction, way)

    def claim(self, car: Car, crossing: JunctionSpan) -> bool:
        """Reserve or keep a path through a junction. Returns False while it conflicts with another reservation."""
        taken = self._claimed.setdefault(crossing.junction, {})
        if car.member.id in taken:
            return True
        way = _way(car, crossing)
        others = list(taken.values())
        if self._hero is not None and self._hero[0] == crossing.junction:
            others.append(self._hero[1])
        if any(_meet(way, other) for other in others):
            return False
        taken[car.member.id] = way
        return True

    def insist(self, car: Car, crossing: JunctionSpan) -> None:
        """Reserve a path through a junction regardless of conflicts, for a car that does not brake."""
        taken = self._claimed.setdefault(crossing.junction, {})
        if car.member.id not in taken:
            taken[car.member.id] = _way(car, crossing)

    def release(self, car: Car, crossing: JunctionSpan) -> None:
        """Release a reservation after the car has left the junction."""
        self._claimed.get(crossing.junction, {}).pop(car.member.id, None)

    def drop(self, car: Car) -> None:
        """Release all reservations of a car that is removed or takes another path."""
        for taken in self._claimed.values():
            taken.pop(car.member.id, None)


def _way(car: Car, crossing: JunctionSpan) -> Way:
    path = car.path
    path.grow(crossing.leave_s + 4.0)
    inside = [i for i, s in enumerate(path.s) if crossing.enter_s <= s <= crossing.leave_s]
    return np.array([(path.x[i], path.y[i]) for i in inside], dtype=np.float64).reshape(-1, 2)


def _meet(first: Way, second: Way) -> bool:
    if not len(first) or not len(second):
        return False
    if float(np.hypot(*(first[0] - second[0]))) < _SAME_ENTRY_M:
        return False  # the cars follow each other
    apart = first[:, None, :] - second[None, :, :]
    return bool((apart[..., 0] ** 2 + apart[..., 1] ** 2).min() < _APART_M**2)
