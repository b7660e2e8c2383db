"""Where each car goes: the lanes ahead of it, and their points as rows of arrays."""

from __future__ import annotations

from zlib import crc32

import numpy as np

from carlette.traffic.lane_graph import TrafficLaneGraph
from carlette.traffic.lane_point_grid import Ints

AHEAD_POINTS = 100
"""How far cars look ahead, in lane points of about a meter."""
RENEW_POINTS = 40
"""A car's row is rewritten after this many points."""
ROW_POINTS = AHEAD_POINTS + RENEW_POINTS + 20


class CarRoute:
    """The lanes of one car, from the one it is on, with the distance to the start of each (m)."""

    def __init__(self, graph: TrafficLaneGraph, point: int, chance: str) -> None:
        self.lanes = [int(graph.lane[point])]
        self.starts = [-float(graph.along[point])]
        """Distances on the car's own count, which starts at 0 where it was taken over (m)."""
        self.chance = chance
        self.turns = 0

    def extend(self, graph: TrafficLaneGraph, until_m: float) -> None:
        """Choose lanes by the seed until the route is known up to `until_m`, and to the end of any junction there."""
        while self.starts[-1] < until_m or graph.inside[self.lanes[-1]]:
            last = self.lanes[-1]
            choices = graph.after[last]
            if not choices:
                return
            draw = crc32(f"{self.chance} {self.turns} {last}".encode())
            self.turns += 1
            lane = choices[draw % len(choices)]
            end, begin = graph.first[last + 1] - 1, graph.first[lane]
            joint = float(np.hypot(*(graph.place[begin, :2] - graph.place[end, :2])))
            self.starts.append(self.starts[-1] + float(graph.along[end]) + joint)
            self.lanes.append(lane)

    def forget(self, lane: int) -> None:
        """Drop the lanes before `lane`."""
        while self.lanes[0] != lane:
            del self.lanes[0], self.starts[0]

    def points(self, graph: TrafficLaneGraph, point: int) -> Ints:
        """Return `ROW_POINTS` lane points from `point` of the first lane on; the last one repeats where the route
        ends.
        """
        parts = [np.arange(point, graph.first[self.lanes[0] + 1])]
        parts += [np.arange(graph.first[lane], graph.first[lane + 1]) for lane in self.lanes[1:]]
        row = np.concatenate(parts)[:ROW_POINTS]
        return np.pad(row, (0, ROW_POINTS - len(row)), mode="edge")

    def next_junction(self, graph: TrafficLaneGraph, after_m: float) -> tuple[float, float, tuple[int, ...]]:
        """Return start, end (m) and lanes of the first junction that starts after `after_m`; infinite if there is
        none.
        """
        begin = np.inf
        inside: list[int] = []
        for lane, start in zip(self.lanes, self.starts, strict=True):
            if graph.inside[lane] and (start > after_m or inside):
                begin = begin if inside else start
                inside.append(lane)
            elif inside:
                return begin, start, tuple(inside)
        return (begin, np.inf, tuple(inside)) if inside else (np.inf, np.inf, ())
