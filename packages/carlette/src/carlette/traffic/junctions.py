"""Who may enter a junction: one car at a time on lanes that cross, in the order of arrival."""

from __future__ import annotations

from dataclasses import dataclass, field

from carlette.traffic.lanes import LaneGraph

PATIENCE_TICKS = 60
"""Who has waited so long keeps others, who come later, from crossing its way."""

Lanes = tuple[int, ...]


@dataclass
class Junctions:
    """The lanes inside junctions that cars (by their number in `Traffic`) have for themselves."""

    held: dict[int, Lanes] = field(default_factory=dict)
    waiting: dict[int, int] = field(default_factory=dict)
    """For how many ticks each car has been asking."""

    def grant(self, graph: LaneGraph, wishes: dict[int, Lanes]) -> set[int]:
        """Gives junction lanes to those who may go; who has asked longest is first. Returns the cars that got them."""
        self.waiting = {car: self.waiting.get(car, 0) + 1 for car in wishes}
        reserved: list[Lanes] = []
        granted = set()
        for car in sorted(wishes, key=lambda one: (-self.waiting[one], one)):
            lanes = wishes[car]
            others = [held for holder, held in self.held.items() if holder != car]
            if not any(_cross(graph, lanes, other) for other in (*others, *reserved)):
                self.held[car] = lanes
                granted.add(car)
            elif self.waiting[car] > PATIENCE_TICKS:
                reserved.append(lanes)
        return granted

    def take(self, car: int, lanes: Lanes) -> None:
        """For a car that is inside already."""
        self.held[car] = lanes

    def leave(self, car: int) -> None:
        """The car is out."""
        self.held.pop(car, None)


def _cross(graph: LaneGraph, lanes: Lanes, others: Lanes) -> bool:
    return any(not graph.crossing[lane].isdisjoint(others) for lane in lanes)
