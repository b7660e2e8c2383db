"""Grants junction entry first come, first served: one car on crossing lanes at a time."""

from __future__ import annotations

from dataclasses import dataclass, field

from carlette.traffic.lane_graph import TrafficLaneGraph

PATIENCE_TICKS = 60
"""Waiting time after which a car keeps later ones from crossing its path (ticks). Ours."""

Lanes = tuple[int, ...]


@dataclass
class Junctions:
    """The lanes inside junctions that are reserved for cars (by their number in `Traffic`)."""

    held: dict[int, Lanes] = field(default_factory=dict)
    waiting: dict[int, int] = field(default_factory=dict)
    """Number of ticks for which each car has requested entry."""

    def grant(self, graph: TrafficLaneGraph, wishes: dict[int, Lanes]) -> set[int]:
        """Reserve junction lanes for the cars that may enter, longest wait first; return those cars."""
        self.waiting = {car: self.waiting.get(car, 0) + 1 for car in wishes}
        reserved: list[Lanes] = []
        granted = set()
        for car in sorted(wishes, key=lambda wish: (-self.waiting[wish], wish)):
            lanes = wishes[car]
            others = [held for holder, held in self.held.items() if holder != car]
            if not any(_cross(graph, lanes, other) for other in (*others, *reserved)):
                self.held[car] = lanes
                granted.add(car)
            elif self.waiting[car] > PATIENCE_TICKS:
                reserved.append(lanes)
        return granted

    def take(self, car: int, lanes: Lanes) -> None:
        """Reserve lanes for a car that is already inside."""
        self.held[car] = lanes

    def leave(self, car: int) -> None:
        """Release the lanes of a car that has left."""
        self.held.pop(car, None)


def _cross(graph: TrafficLaneGraph, lanes: Lanes, others: Lanes) -> bool:
    return any(not graph.crossing[lane].isdisjoint(others) for lane in lanes)
