"""Routes of cars: the lanes ahead of each car, and their points as rows of arrays."""

from __future__ import annotations

from zlib import crc32

import numpy as np

from carlette.traffic.lane_graph import TrafficLaneGraph
from carlette.traffic.lane_point_grid import Ints

AHEAD_POINTS = 100
"""Number of lane points that cars look ahead, about one per meter. Ours."""
RENEW_POINTS = 40
"""Number of points after which a car's row is rewritten. Ours."""
ROW_POINTS = AHEAD_POINTS + RENEW_POINTS + 20
"""Number of points in a row, with some reserve."""


class CarRoute:
    """The lanes of one car from its present one on, with the distance to the start of each (m)."""

    def __init__(self, graph: TrafficLaneGraph, point: int, chance: str) -> None:
        self.lanes = [int(graph.lane[point])]
        self.starts = [-float(graph.along[point])]
        """Starts of the lanes (m), from the position at which the car was taken over."""
        self.chance = chance
        self.turns = 0

    def extend(self, graph: TrafficLaneGraph, until_m: float) -> None:
        """Choose lanes with the seed up to `until_m`, and up to the end of any junction there."""
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
        """Return `ROW_POINTS` lane points from `point` of the first lane on.

        The last one repeats after the route's end.
        """
        parts = [np.arange(point, graph.first[self.lanes[0] + 1])]
        parts += [np.arange(graph.first[lane], graph.first[lane + 1]) for lane in self.lanes[1:]]
        row = np.concatenate(parts)[:ROW_POINTS]
        return np.pad(row, (0, ROW_POINTS - len(row)), mode="edge")

    def next_junction(self, graph: TrafficLaneGraph, after_m: float) -> tuple[float, float, tuple[int, ...]]:
        """Return start, end (m) and lanes of the first junction that starts after `after_m`; infinite without one."""
        begin = np.inf
        inside: list[int] = []
        for lane, start in zip(self.lanes, self.starts, strict=True):
            if graph.inside[lane] and (start > after_m or inside):
                begin = begin if inside else start
                inside.append(lane)
            elif inside:
                return begin, start, tuple(inside)
        return (begin, np.inf, tuple(inside)) if inside else (np.inf, np.inf, ())
